"""Build the bridge's extension for every system, with the package ziglang: `python scripts/build_bridge.py`.

The files are the same on every computer that builds them with the same ziglang; `built/hashes.json` says of which
source they are, and a test compares. `--check` builds into a folder of its own and says which files differ.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from simcore.bridge.built_extension import BUILT, SOURCE, TARGETS

FLAGS = ("-shared", "-fPIC", "-std=gnu11", "-Os", "-s", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror")
LIBRARIES = {"win32": ("-lws2_32",), "linux": ("-Wl,--build-id=none", "-lpthread", "-ldl"), "darwin": ()}


def build(folder: Path) -> None:
    """Build all files and their hashes into a folder."""
    folder.mkdir(exist_ok=True)
    for (system, _), (target, name) in TARGETS.items():
        command = ["zig", "cc", "-target", target, *FLAGS, "-o", name, SOURCE.name, *LIBRARIES[system]]
        with tempfile.TemporaryDirectory() as made:  # names of paths would be in the files
            (Path(made) / SOURCE.name).write_bytes(SOURCE.read_bytes())
            subprocess.run([sys.executable, "-m", "ziglang", *command[1:]], cwd=made, check=True)
            (folder / name).write_bytes((Path(made) / name).read_bytes())
        print(f"{(folder / name).stat().st_size:7} bytes  {name}")
    hashes = {path.name: digest(path) for path in [SOURCE, *sorted(folder.glob("simcore_*"))]}
    (folder / "hashes.json").write_text(json.dumps({"ziglang": version("ziglang"), **hashes}, indent=2) + "\n")


def digest(path: Path) -> str:
    """Return the SHA-256 of a file, of text with the same line ends everywhere."""
    content = path.read_bytes()
    return hashlib.sha256(content.replace(b"\r\n", b"\n") if path.suffix == ".c" else content).hexdigest()


def main() -> int:
    """Build; returns 1 where `--check` finds a file that differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare with the files that are there, and leave them")
    options = parser.parse_args()
    if not options.check:
        build(BUILT)
        return 0
    with tempfile.TemporaryDirectory() as made:
        build(Path(made) / "built")
        there = {path.name: path.read_bytes() for path in BUILT.iterdir()}
        differ = [p.name for p in sorted((Path(made) / "built").iterdir()) if there.get(p.name) != p.read_bytes()]
    print(f"differ: {', '.join(differ) or 'none'}")
    return 1 if differ else 0


if __name__ == "__main__":
    raise SystemExit(main())
