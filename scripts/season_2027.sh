#!/usr/bin/env bash
# The tests that need no vendor, and those of the Phoenix 6 emulator, with WPILib and Phoenix 6 of 2027 on Python 3.14.
# Their wheels want glibc 2.41 (Debian 13, Ubuntu 26.04): where it is older, this makes a Debian root of its own and runs
# in there, for which it must be root and have debootstrap.
#
#     scripts/season_2027.sh [folder]
#
# The environment is made in `folder` (default: a new one, deleted afterwards) and used again if it is there.
set -euo pipefail
cd "$(dirname "$0")/.."
source_folder="$PWD"
needed="2.41"
mirror="http://deb.debian.org/debian"
phoenix6="phoenix6>=26.70.0a2,<27"

skip() { echo "season 2027: not run, $*"; exit 0; }
[ "$(uname -sm)" = "Linux x86_64" ] || skip "this is not Linux x86_64"

folder="${1:-}"
mounted=()
clean_up() {
  for place in "${mounted[@]}"; do umount "$place" || echo "still mounted: $place, in a folder that is not deleted" >&2; done
  if [ -z "${1:-}" ] && ! grep -q " $folder/" /proc/mounts; then rm -rf --one-file-system "$folder"; fi
}
[ -n "$folder" ] || { folder="$(mktemp -d)"; trap clean_up EXIT; }
[ $# = 0 ] || trap 'clean_up keep' EXIT
mkdir -p "$folder"
folder="$(cd "$folder" && pwd -P)"  # as /proc/mounts names it

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
  for place in proc dev; do
    mount --bind "/$place" "$folder/$place" && mounted=("$folder/$place" ${mounted[@]+"${mounted[@]}"})
  done
  mkdir -p "$folder/source"
  mount --bind "$source_folder" "$folder/source" && mounted=("$folder/source" "${mounted[@]}")
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
run "$venv/bin/pip" install -q --disable-pip-version-check -e "$here[robotpy2027,mujoco,sweep]" "$phoenix6" \
  "pytest>=8" "hypothesis>=6.100" "pytest-benchmark>=4" "pytest-xdist>=3.5" "fast-simplification>=0.1.7" "hatchling>=1.24"
run sh -c "cd '$here' && '$venv/bin/simcore' doctor --no-physics"
run sh -c "cd '$here' && '$venv/bin/python' -m pytest -q -p no:cacheprovider -n 2 --dist=worksteal -m 'not slow and not realtime and not compiled' \
  tests/unit tests/physics tests/property tests/adapters/emulator simcore/phoenix6_emulator"
