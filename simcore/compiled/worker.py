"""Compiles copied sources: runs in a process and a folder of its own, the folder that holds the copies.

    python -m simcore.compiled.worker OUT

The shared libraries come to OUT, laid out like packages. It knows no path of the real sources, so it cannot touch them.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

from simcore.compiled.modules import GROUP, MODULES, source_of

__all__ = ["compile_to"]

_MYPY = """\
[mypy]
ignore_missing_imports = True
disable_error_code = var-annotated
"""
_OURS = ("simcore", "games")


def compile_to(out: Path) -> None:
    """Compile the sources of the present folder.

    Args:
        out: Where the libraries go.
    """
    from mypyc.build import mypycify
    from setuptools import setup

    # Packages from outside count as plain objects, typed or not, so that the code does not depend on their version.
    settings = Path("mypy.ini")
    settings.write_text(_MYPY + "".join(f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in _others()))
    extensions = mypycify(
        [f"--config-file={settings}", *map(source_of, MODULES)],
        opt_level="1",  # 3 takes three times as long and runs no faster
        debug_level="0",
        group_name=GROUP,
    )
    if sys.platform != "win32":
        for extension in extensions:
            # A compiler may make a * b + c one instruction with one rounding (gcc does, on arm64): other last bits.
            # -Wno-all: looking for warnings in half a million lines takes it two minutes.
            extension.extra_compile_args += ["-ffp-contract=off", "-Wno-all"]
    setup(
        name=GROUP,
        packages=[],
        py_modules=[],
        ext_modules=extensions,
        script_args=["--quiet", "build_ext", f"--build-lib={out}", "--build-temp=temp"],
    )


def _others() -> list[str]:
    """Top-level packages that our sources import, of other people."""
    names: set[str] = set()
    for top in _OURS:
        for path in Path(top).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    names |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module:
                    names.add(node.module.partition(".")[0])
    return sorted(names - set(_OURS) - set(sys.stdlib_module_names) - {"__future__"})


if __name__ == "__main__":
    compile_to(Path(sys.argv[1]))
