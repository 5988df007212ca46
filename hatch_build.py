"""Puts simcore's hot modules into the wheel as native code, if `SIMCORE_COMPILE=1` asks for it; else the wheel is pure.

The modules are listed in pyproject.toml. They are compiled from copies in a temporary folder, so nothing is left beside
the sources, where it would be used in their place after the next edit. Compiled and plain give the same results to the
last bit; the sources come into the wheel, too, for tracebacks.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "SIMCORE_COMPILE"
GROUP = "simcore_native"
"""Of the shared library that holds the code of all modules, as `simcore_native__mypyc`. It lies beside the package
simcore, not in it: mypyc derives `__file__` of the modules from its place."""

TOOLS = ("mypy[mypyc]>=2.4,<3", "setuptools>=75")
OURS = ("simcore", "games")
COMPILER = {
    "win32": 'install "Build Tools for Visual Studio" with "Desktop development with C++", then open a new terminal',
    "darwin": "`xcode-select --install`",
    "linux": "install gcc and the headers of Python (Debian, Ubuntu: `apt install gcc python3-dev`)",
}
NO_COMPILER = re.compile(
    r"microsoft visual c\+\+|unable to find vcvarsall|xcrun: error|command '[^']*(cc|clang)[^']*' failed: no such"
    r"|no such file or directory: '[^']*(cc|clang)[^']*'|python\.h"
)
LAST_LINES = 12
SETTINGS = """\
[mypy]
ignore_missing_imports = True
disable_error_code = var-annotated
"""


class CompileHook(BuildHookInterface):  # type: ignore[type-arg]
    """The build hook of hatchling."""

    def dependencies(self) -> list[str]:
        """What compiling needs in the environment of the build: nothing for a pure wheel."""
        return list(TOOLS) if is_asked() else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and name the libraries to the wheel.

        Args:
            version: Of the wheel: "standard" or "editable".
            build_data: What hatchling makes the wheel of.
        """
        self.work = Path(tempfile.mkdtemp(prefix="simcore-"))
        if not is_asked():
            return
        if version == "editable":
            raise SystemExit(
                f"{VARIABLE}=1: an editable install (-e) runs the sources as they are and holds no compiled parts; "
                "install without -e, or unset the variable"
            )
        out = compile_copies(Path(self.root), self.work, self.config["modules"])
        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        for library in sorted(path for path in out.rglob("*") if path.is_file()):
            build_data["force_include"][str(library)] = library.relative_to(out).as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Delete the temporary folder, once the wheel is written."""
        shutil.rmtree(self.work, ignore_errors=True)


def is_asked() -> bool:
    """Whether the environment asks for compiled parts."""
    value = os.environ.get(VARIABLE, "")
    if value not in ("", "0", "1"):
        raise SystemExit(f"{VARIABLE} is 1 (compile) or 0 (pure Python), got {value!r}")
    return value == "1"


def compile_copies(root: Path, work: Path, modules: list[str]) -> Path:
    """Compile a copy of the sources in a process of its own.

    Args:
        root: Folder of the project.
        work: An empty folder.
        modules: Dotted names of what is compiled.

    Returns:
        Folder of the libraries, laid out like packages.
    """
    copies, out = work / "sources", work / "out"
    for top in OURS:
        for path in sorted((root / top).rglob("*.py")):
            copy = copies / path.relative_to(root)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
    done = subprocess.run(
        [sys.executable, str(Path(__file__).resolve()), str(out), *modules],
        cwd=copies,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode:
        raise SystemExit(reason(done.stdout))
    built = {path.relative_to(out).as_posix().partition(".")[0] for path in out.rglob("*") if path.is_file()}
    missing = [name for name in (f"{GROUP}__mypyc", *modules) if name.replace(".", "/") not in built]
    if missing:
        raise SystemExit(f"the compiler left out {missing}; without {VARIABLE} simcore is installed as plain Python")
    return out


def reason(output: str) -> str:
    """Why compiling failed, from what was printed."""
    plain = f"without {VARIABLE} simcore is installed as plain Python"
    if NO_COMPILER.search(output.lower()):
        return f"no C compiler, or no headers of Python: {COMPILER.get(sys.platform, COMPILER['linux'])}; {plain}"
    last = "\n  ".join([line for line in output.splitlines() if line.strip()][-LAST_LINES:])
    return f"simcore does not compile; {plain}. The last lines of the compiler:\n  {last}"


def compile_here(out: str, modules: list[str]) -> None:
    """Compile modules of the present folder; this is what the process of its own does.

    Args:
        out: Where the libraries go.
        modules: Dotted names.
    """
    from mypyc.build import mypycify
    from setuptools import setup

    # Packages from outside count as plain objects, typed or not, so that the code does not depend on their version.
    settings = Path("mypy.ini")
    settings.write_text(SETTINGS + "".join(f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in others()))
    extensions = mypycify(
        [f"--config-file={settings}", *(f"{module.replace('.', '/')}.py" for module in modules)],
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
        name="simcore",
        packages=[],
        py_modules=[],
        ext_modules=extensions,
        script_args=["--quiet", "build_ext", f"--build-lib={out}", "--build-temp=temp"],
    )


def others() -> list[str]:
    """Top-level packages of other people that the sources of the present folder import."""
    names: set[str] = set()
    for top in OURS:
        for path in Path(top).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    names |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module:
                    names.add(node.module.partition(".")[0])
    return sorted(names - set(OURS) - set(sys.stdlib_module_names) - {"__future__"})


if __name__ == "__main__":
    compile_here(sys.argv[1], sys.argv[2:])
