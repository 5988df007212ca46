"""Python, and what is installed in it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.version import Version

from simcore.install_text import install_command
from simcore.robotpy.checks.findings import Finding, fail, ok, warn
from simcore.season import installed_seasons, mixed_seasons

__all__ = [
    "check_engine",
    "check_python",
    "check_requirements",
    "check_wheels",
    "check_year",
    "engine_of",
]

OLDEST, NEWEST = (3, 10), (3, 14)
_ADVISED = "3.13"  # the newest for which both engines have wheels
PYBULLET = ("pybullet", "pybullet-arm64")
"""The same module from two projects: upstream, and the fork that has wheels."""
ENGINES = (*PYBULLET, "mujoco", "mujoco-core")
"""Distributions of which one must be there. From 4 on, mujoco is a viewer around mujoco-core; before, it is whole."""


def check_python(version: tuple[int, int, int]) -> Finding:
    """Whether simcore runs on this Python."""
    shown = ".".join(map(str, version))
    if version[:2] < OLDEST:
        return fail("Python", shown, f"install Python {_ADVISED} and make a new environment with it")
    if version[:2] > NEWEST:
        return fail(
            "Python",
            f"{shown}: newer than what simcore is tested with",
            f"install Python {_ADVISED} beside it; `py -{_ADVISED} -m venv .venv` on Windows, "
            f"`python{_ADVISED} -m venv .venv` elsewhere, then install again in there",
        )
    return ok("Python", shown)


def engine_of(system: str, machine: str, version: tuple[int, int]) -> str:
    """Name of the physics engine that installing simcore brings on a computer; empty if none has a wheel.

    Args:
        system: As `platform.system()` says.
        machine: As `platform.machine()` says.
        version: Of Python.
    """
    where = (system, {"amd64": "x86_64", "aarch64": "arm64"}.get(machine.lower(), machine.lower()))
    if not OLDEST <= version <= NEWEST:
        return ""
    if where == ("Darwin", "x86_64"):
        return "PyBullet" if version in ((3, 11), (3, 12)) else "MuJoCo"
    if where in (("Windows", "x86_64"), ("Linux", "x86_64"), ("Darwin", "arm64")):
        return "PyBullet" if version <= (3, 13) else "MuJoCo"
    return "MuJoCo" if where == ("Linux", "arm64") and version >= (3, 11) else ""  # 3.10: nor is there one of WPILib


def check_wheels(system: str, machine: str, version: tuple[int, int, int], glibc: tuple[int, int] | None) -> Finding:
    """Whether a wheel of a physics engine exists for this computer.

    Args:
        system: As `platform.system()` says.
        machine: As `platform.machine()` says.
        version: Of Python.
        glibc: Of Linux; None: another system, or another C library.
    """
    where = f"{system} {machine}"
    engine = engine_of(system, machine, version[:2])
    if engine and system == "Linux" and (glibc is None or glibc < (2, 28)):
        return warn(
            "platform",
            f"{where}, {'no glibc' if glibc is None else f'glibc {glibc[0]}.{glibc[1]}'}",
            "wheels of the engine need glibc 2.28 (Debian 10, Ubuntu 18.10, or newer); else pip compiles it",
        )
    if engine:
        return ok("platform", f"{where}; {engine} has a wheel")
    return warn(
        "platform",
        f"{where}: no wheel of a physics engine",
        f"try Python {_ADVISED}; else `python -m pip install pybullet`"
        " compiles it in 5 minutes and needs a C++ compiler",
    )


def check_engine(installed: Mapping[str, str], load: Callable[[], object], wanted: str) -> Finding:
    """Whether a physics engine is installed, none of them twice, and it loads.

    Args:
        installed: Version by name of everything installed.
        load: Makes and closes the default engine.
        wanted: What `engine_of` says of this computer.
    """
    found = {name: installed[name] for name in ENGINES if name in installed}
    shown = ", ".join(f"{name} {version}" for name, version in found.items())
    if all(name in found for name in PYBULLET):
        return fail(
            "engine",
            f"{shown}: the same files twice",
            "`python -m pip uninstall -y pybullet pybullet-arm64`, then `python -m pip install pybullet-arm64`",
        )
    if "mujoco-core" in found and "mujoco" in found and Version(found["mujoco"]).major < 4:
        return fail(
            "engine",
            f"{shown}: the same files twice",
            "`python -m pip uninstall -y mujoco mujoco-core`, then `python -m pip install mujoco-core`",
        )
    if not found:
        name = "mujoco" if wanted == "MuJoCo" else "pybullet-arm64"
        also = "" if wanted == "MuJoCo" else " (on Intel and AMD, too)"
        return fail("engine", "no physics engine is installed", f"`python -m pip install {name}`{also}")
    try:
        load()
    except Exception as error:
        reinstall = f"`python -m pip install --force-reinstall --no-deps {' '.join(found)}`"
        return fail("engine", f"{shown} does not load: {error}", reinstall)
    return ok("engine", shown)


def check_requirements(
    installed: Mapping[str, str], requires: Sequence[str] | None, environment: Mapping[str, str] | None = None
) -> list[Finding]:
    """Whether everything that simcore asks for is there, in a version that it knows.

    Args:
        installed: Version by name of everything installed.
        requires: Of simcore, as its metadata says; None: simcore itself is not installed.
        environment: What markers are compared with; None: this Python.
    """
    if requires is None:
        return [
            warn(
                "simcore",
                "runs from a folder and is not installed: `robotpy sim --simcore` and other programs do not find it",
                install_command(),
            )
        ]
    findings = [ok("simcore", installed.get("simcore", ""))]
    around = {**{key: str(value) for key, value in default_environment().items()}, **(environment or {})}
    wanted = [Requirement(text) for text in requires]
    of_wpilib = [(name, installed[name]) for name in ("wpilib", "pyntcore") if name in installed]
    known = sorted(int(year) for text in requires for year in re.findall(r"'robotpy(\d+)'", text.replace('"', "'")))
    year = max(installed_seasons(of_wpilib), default=min(known, default=0))
    devices = {"phoenix6": "your robot's devices"} if year == min(known, default=0) else {}  # of the first season
    extras = {"": "", **devices, **({f"robotpy{year}": "`robotpy sim` and `robotpy test`"} if year in known else {})}
    for extra, purpose in extras.items():
        wrong: list[tuple[str, bool]] = []
        good: list[str] = []
        for requirement in wanted:
            if requirement.name.lower() in ENGINES or not _is_of(requirement, extra, around):
                continue
            version = installed.get(requirement.name.lower())
            if version is None:
                wrong.append((f"{requirement.name} is missing", True))
            elif not requirement.specifier.contains(version, prereleases=True):
                wrong.append((f"{requirement.name} {version} is not {requirement.specifier}", False))
            else:
                good.append(f"{requirement.name} {version}")
        findings.append(_of_extra(extra, purpose, wrong, good))
    return findings


def _is_of(requirement: Requirement, extra: str, environment: Mapping[str, str]) -> bool:
    """Whether a requirement belongs to an extra (empty: to simcore itself) on this computer."""
    marker = requirement.marker
    if marker is None:
        return not extra
    is_base = marker.evaluate({**environment, "extra": ""})
    return not is_base and marker.evaluate({**environment, "extra": extra}) if extra else is_base


def _of_extra(extra: str, purpose: str, wrong: list[tuple[str, bool]], good: list[str]) -> Finding:
    check = f"extra [{extra}]" if extra else "packages"
    if not wrong:
        return ok(check, ", ".join(good))
    said = "; ".join(text for text, _ in wrong)
    extras = (extra,) if extra else ()
    if extra and not good and all(is_missing for _, is_missing in wrong):
        return warn(check, f"not installed ({purpose})", f"{install_command(*extras)}, if you want those")
    return fail(check, said, install_command(*extras, upgrade=True))


def check_loop(prepare: Callable[[], Path | None]) -> Finding:
    """Whether the physics' loop is compiled, and where that is kept.

    Args:
        prepare: Compiles it or loads it; returns the folder that keeps it, None for none.
    """
    try:
        folder = prepare()
    except Exception as error:  # Numba's own errors are many
        return fail("loop", f"the physics cannot be compiled: {error}", "python -m pip install --upgrade numba")
    if folder is None:
        return warn(
            "loop",
            "the physics is compiled anew in every run, for half a minute: no folder to keep it in can be written",
            "let your user write the folder .cache in its home, or set XDG_CACHE_HOME to one that it can",
        )
    return ok("loop", f"the physics is compiled, and kept in {folder}")


def check_year(installed: Mapping[str, str]) -> Finding:
    """Which season is installed, and what of it is not final. Its libraries share binaries: they are of one release."""
    seasons = installed_seasons(installed.items())
    mixed = mixed_seasons(seasons)
    if mixed:
        said, _, advice = mixed.rpartition(": ")
        return fail("WPILib", said, advice)
    if not seasons:
        return fail("WPILib", "nothing of WPILib is installed", install_command("robotpy"))
    ((year, found),) = seasons.items()
    ours = {name: Version(version) for name, version in (text.split() for text in found) if _is_of_wpilib(name)}
    releases = {(version.major, version.minor) for version in ours.values()}
    if not ours:
        return fail("WPILib", f"{', '.join(found)} without WPILib of {year}", install_command(f"robotpy{year}"))
    newest = max(releases)
    behind = [f"{name} {version}" for name, version in ours.items() if (version.major, version.minor) != newest]
    if behind:
        return warn(
            "WPILib",
            f"two releases: {', '.join(behind)} beside {newest[0]}.{newest[1]}",
            f"`python -m pip install --upgrade {' '.join(text.split()[0] for text in behind)}`",
        )
    unready = [text for text in found if Version(text.split()[1]).is_prerelease and not _is_native(text)]
    alpha = f"; not final yet: {', '.join(unready)}" if unready else ""
    return ok("WPILib", f"season {year}: {newest[0]}.{newest[1]} ({len(ours)} packages){alpha}")


def _is_of_wpilib(name: str) -> bool:
    parts = ("hal", "wpimath", "wpinet", "wpiutil", "apriltag", "cscore", "fields", "commands-v2")
    return name in ("wpilib", "pyntcore", *(f"robotpy-{part}" for part in parts)) or _is_native(name)


def _is_native(name: str) -> bool:
    return name.startswith("robotpy-native-")
