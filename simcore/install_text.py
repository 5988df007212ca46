"""Commands for installing simcore again from its origin, on this or another computer, for error messages and CI.

A command contains only the distribution's name if pip installed simcore from an index under that name. On another
index, the name may be unused or belong to another project.
"""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["install_command", "is_source", "shared_requirement"]

_PIP = "python -m pip install"
_PACKAGE = Path(__file__).resolve().parent


def install_command(*extras: str, upgrade: bool = False, package: Path = _PACKAGE) -> str:
    """Return the command that installs extras, including the folder in which to run the command if necessary.

    The command names a checkout by its folder and an installed package by the origin that pip recorded (PEP 610): a
    folder, a git address, a file, or an index. If the origin is unknown or missing, the command refers to the folder of
    simcore's source, which the user has to find.

    >>> print(install_command("view", package=Path("/home/me/env/site-packages/simcore")))
    `python -m pip install ".[view]"` in the folder of simcore's source

    Args:
        extras: Names of extras; empty for simcore with only its required packages.
        upgrade: Whether to upgrade installed packages.
        package: Folder of the simcore package.
    """
    pip = f"{_PIP} --upgrade" if upgrade else _PIP
    names = f"[{','.join(extras)}]" if extras else ""
    if is_source(package.parent):
        return f'`{pip} -e "{package.parent}{names}"`'
    if _index_version(package):
        return f'`{pip} "simcore{names}"`'
    origin = _origin(package)
    url = str(origin.get("url", ""))
    if version_control := origin.get("vcs_info"):
        revision = version_control.get("requested_revision") or version_control.get("commit_id", "")
        return f'`{pip} "simcore{names} @ {version_control.get("vcs", "git")}+{url}@{revision}"`'
    folder = _folder(url)
    if "dir_info" in origin and is_source(folder):
        return f'`{pip} "{folder}{names}"`'
    if "archive_info" in origin and (not url.startswith("file:") or folder.is_file()):
        return f'`{pip} "simcore{names} @ {url}"`'
    return f'`{pip} ".{names}"` in the folder of simcore\'s source'


def shared_requirement(*extras: str, source: str = "", package: Path = _PACKAGE) -> str:
    """Return pip's requirement for installing this version of simcore elsewhere; empty if the origin is unknown.

    >>> shared_requirement("robotpy", package=Path("/home/me/env/site-packages/simcore"))
    ''

    Args:
        extras: Names of extras.
        source: Address for pip, `git+https://...`; empty for the origin of the installed simcore.
        package: Folder of the simcore package.
    """
    name = f"simcore[{','.join(extras)}]"
    if not source and (version := _index_version(package)):
        return f"{name}=={version}"
    source = source or _address(package)
    return f"{name} @ {source}" if source else ""


def _address(package: Path) -> str:
    """Return pip's address of the installed commit; empty if the commit exists only on this computer."""
    origin = _origin(package)
    url, version_control = str(origin.get("url", "")), origin.get("vcs_info")
    if version_control:
        return f"{version_control.get('vcs', 'git')}+{url}@{version_control.get('commit_id', '')}"
    if url.startswith("https:"):
        return url
    folder = package.parent if is_source(package.parent) else _folder(url)
    return _clone_address(folder) if (folder / ".git").exists() else ""


def _clone_address(folder: Path) -> str:
    """Return pip's address of a clone's origin at the checked-out commit, without user name and password."""
    output = []
    for words in (["remote", "get-url", "origin"], ["rev-parse", "HEAD"]):
        try:
            output.append(
                subprocess.run(["git", "-C", folder, *words], capture_output=True, text=True, check=True).stdout
            )
        except (OSError, subprocess.CalledProcessError):
            return ""
    url, commit = (text.strip() for text in output)
    url = re.sub(r"^https://[^/@]*@", "https://", url)
    url = re.sub(r"^(?:ssh://)?[\w.-]+@([^/:]+)[:/]", r"https://\1/", url)
    return f"git+{url}@{commit}" if url.startswith("https://") else ""


def is_source(folder: Path) -> bool:
    """Return whether a folder contains simcore's source, so that pip can install simcore from the folder."""
    return (folder / "pyproject.toml").is_file() and (folder / "simcore" / "install_text.py").is_file()


def _index_version(package: Path) -> str:
    """Return the version that pip installed from an index; empty if simcore comes from any other origin."""
    found = [] if is_source(package.parent) else sorted(package.parent.glob("simcore-*.dist-info"))
    is_named = found and not (found[-1] / "direct_url.json").exists()
    return found[-1].name.removeprefix("simcore-").removesuffix(".dist-info") if is_named else ""


def _origin(package: Path) -> Mapping[str, Any]:
    """Return pip's record of the origin, `direct_url.json` next to the metadata; empty without a readable record."""
    notes = sorted(package.parent.glob("simcore-*.dist-info/direct_url.json"))
    try:
        found = json.loads(notes[-1].read_text(encoding="utf-8")) if notes else {}
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _folder(url: str) -> Path:
    """Return the path of a `file:` address, or an empty path for any other address."""
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    parts = urlsplit(url)
    return Path(url2pathname(parts.path)) if parts.scheme == "file" else Path()
