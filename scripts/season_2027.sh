#!/usr/bin/env bash
# With WPILib, Phoenix 6 and REVLib of 2027 on Python 3.14: robot programs of 2027, then the tests that need no vendor.
# Their wheels want glibc 2.41 (Debian 13, Ubuntu 26.04): where it is older, this makes a Debian root of its own and runs
# in there, for which it must be root and have debootstrap.
#
#     scripts/season_2027.sh [folder]
#
# The environment is made in `folder` (default: a new one, deleted afterwards) and used again if it is there.
set -euo pipefail
case "${1:-}" in ""|/*) ;; *) set -- "$PWD/$1" ;; esac
cd "$(dirname "$0")/.."
source_folder="$PWD"
needed="2.41"
mirror="http://deb.debian.org/debian"
of_2027=("wpilib>=2027.0.0a7,<2028" "pyntcore>=2027.0.0a7,<2028" "robotpy-hal>=2027.0.0a7,<2028"
  "robotpy-commands-v2>=2027.0.0a7,<2028" "robotpy-cli>=2027.0.1b2,<2028" "phoenix6>=26.70.0a2,<27"
  "robotpy-rev>=2027.0.0a7.post1,<2028")  # as docs/install.md has them

skip() { echo "season 2027: not run, $*"; exit 0; }
[ "$(uname -sm)" = "Linux x86_64" ] || skip "this is not Linux x86_64"

# As root it mounts: in a namespace of its own, so that nothing stays mounted.
if [ "$(id -u)" = 0 ] && [ -z "${OWN_MOUNTS:-}" ] && unshare --mount true 2>/dev/null; then
  given="${1:-}"
  folder="${given:-$(mktemp -d)}"
  OWN_MOUNTS=1 unshare --mount "$source_folder/scripts/season_2027.sh" "$folder" && result=0 || result=$?
  [ -n "$given" ] || rm -rf --one-file-system "$folder"
  exit "$result"
fi
folder="${1:-}"
[ -n "$folder" ] || { folder="$(mktemp -d)"; trap 'rm -rf --one-file-system "$folder"' EXIT; }
mkdir -p "$folder"
folder="$(cd "$folder" && pwd -P)"

glibc="$(getconf GNU_LIBC_VERSION | cut -d ' ' -f 2)"
if [ "$(printf '%s\n' "$needed" "$glibc" | sort -V | head -n 1)" = "$needed" ] && command -v python3.14 >/dev/null; then
  run() { "$@"; }
  python=python3.14
  venv="$folder/venv"
  here="$source_folder"
else
  [ "$(id -u)" = 0 ] || skip "glibc $glibc is older than $needed or there is no python3.14, and only root can make another root"
  command -v debootstrap >/dev/null || skip "glibc $glibc is older than $needed or there is no python3.14, and debootstrap is not installed"
  if [ ! -x "$folder/usr/bin/python3" ]; then
    scripts="/usr/share/debootstrap/scripts"
    script="$scripts/forky"
    [ -e "$script" ] || script="$scripts/sid"  # an older debootstrap does not know the name; the steps are the same
    debootstrap --variant=minbase --include=python3,python3-venv,python3-pip,ca-certificates \
      forky "$folder" "$mirror" "$script" >"$folder.log" 2>&1 || { tail -n 5 "$folder.log"; skip "debootstrap fails"; }
    rm -f "$folder.log"
  fi
  [ -n "${OWN_MOUNTS:-}" ] || skip "mounts cannot be made in a namespace of their own (unshare)"
  mkdir -p "$folder/source"
  for place in proc dev; do mount --bind "/$place" "$folder/$place"; done
  mount --bind "$source_folder" "$folder/source"
  cp /etc/resolv.conf /etc/hosts "$folder/etc/"
  [ ! -e /etc/pip.conf ] || cp /etc/pip.conf "$folder/etc/"
  [ ! -e /etc/ssl/certs/ca-certificates.crt ] || cp /etc/ssl/certs/ca-certificates.crt "$folder/etc/ssl/certs/"
  run() { chroot "$folder" env PIP_CERT=/etc/ssl/certs/ca-certificates.crt TMPDIR=/tmp "$@"; }
  python=python3
  venv=/venv
  here=/source
fi

run "$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 14))' || skip "$(run "$python" --version) is not 3.14"
run "$python" -m venv "$venv"
run "$venv/bin/pip" install -q --disable-pip-version-check -e "$here[cluster]" "${of_2027[@]}" "mujoco-core>=4.0.1,<5" \
  "pandas>=2.2,<4" "pytest>=8" "hypothesis>=6.100" "pytest-benchmark>=4" "pytest-xdist>=3.5" "fast-simplification>=0.1.7" \
  "robotpy-wpilib-utilities>=2027.0.0a7,<2028"
run sh -c "cd '$here' && '$venv/bin/simcore' doctor --no-physics"

failed=0
tests() { run sh -c "cd '$here' && '$venv/bin/python' -m pytest -q -p no:cacheprovider -n 2 --dist=worksteal $1" || failed=1; }
# Robot programs that are written for 2027: swerve by CTRE in op modes, tank and swerve on SPARKs.
tests "tests/adapters/test_op_modes.py tests/adapters/test_rev_2027.py"
tests "-m 'not slow and not realtime' --ignore=tests/adapters tests"
exit "$failed"
