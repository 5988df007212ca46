"""What installs simcore again from where it came, here and on another computer: for errors, and CI.

The bare name of the distribution stands in a command only where pip took simcore from an index by that name: on an
index where it is not, the name is nobody's, or a stranger's.
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
    """What to type to have extras, with where to type it when that matters.

    A checkout is named by its folder, an install by what pip noted of its origin (PEP 610): a folder, a git address or
    a file, or nothing, if it is of an index. If that is unknown or gone, the folder of simcore's source has to be found
    by the reader.

    >>> print(install_command("view", package=Path("/home/me/env/site-packages/simcore")))
    `python -m pip install ".[view]"` in the folder of simcore's source

    Args:
        extras: Names of extras; none: simcore with what it always needs.
        upgrade: Whether what is there may be too old.
        package: Folder of the package simcore.
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
    """The line by which pip of another computer installs the simcore that is here; empty: from nowhere that is known.

    >>> shared_requirement("robotpy", package=Path("/home/me/env/site-packages/simcore"))
    ''

    Args:
        extras: Names of extras.
        source: Address for pip, `git+https://...`; empty: the index, address or clone that simcore here is from.
        package: Folder of the package simcore.
    """
    name = f"simcore[{','.join(extras)}]"
    if not source and (version := _index_version(package)):
        return f"{name}=={version}"
    source = source or _address(package)
    return f"{name} @ {source}" if source else ""


def _address(package: Path) -> str:
    """Of the commit that was installed, for pip; empty if that is on this computer alone."""
    origin = _origin(package)
    url, version_control = str(origin.get("url", "")), origin.get("vcs_info")
    if version_control:
        return f"{version_control.get('vcs', 'git')}+{url}@{version_control.get('commit_id', '')}"
    if url.startswith("https:"):
        return url
    folder = package.parent if is_source(package.parent) else _folder(url)
    return _clone_address(folder) if (folder / ".git").exists() else ""


def _clone_address(folder: Path) -> str:
    """Where a clone is from, at its commit, without names and passwords of who cloned it."""
    told = []
    for words in (["remote", "get-url", "origin"], ["rev-parse", "HEAD"]):
        try:
            told.append(
                subprocess.run(["git", "-C", folder, *words], capture_output=True, text=True, check=True).stdout
            )
        except (OSError, subprocess.CalledProcessError):
            return ""
    url, commit = (text.strip() for text in told)
    url = re.sub(r"^https://[^/@]*@", "https://", url)
    url = re.sub(r"^(?:ssh://)?[\w.-]+@([^/:]+)[:/]", r"https://\1/", url)
    return f"git+{url}@{commit}" if url.startswith("https://") else ""


def is_source(folder: Path) -> bool:
    """Return whether a folder is one that pip can install simcore from."""
    return (folder / "pyproject.toml").is_file() and (folder / "simcore" / "install_text.py").is_file()


def _index_version(package: Path) -> str:
    """Which version pip took from an index by its name, which leaves no note of an origin; empty: it did not."""
    found = [] if is_source(package.parent) else sorted(package.parent.glob("simcore-*.dist-info"))
    is_named = found and not (found[-1] / "direct_url.json").exists()
    return found[-1].name.removeprefix("simcore-").removesuffix(".dist-info") if is_named else ""


def _origin(package: Path) -> Mapping[str, Any]:
    """What pip noted when it installed a package: `direct_url.json` beside the metadata; empty if there is none."""
    notes = sorted(package.parent.glob("simcore-*.dist-info/direct_url.json"))
    try:
        found = json.loads(notes[-1].read_text(encoding="utf-8")) if notes else {}
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _folder(url: str) -> Path:
    """The path of a `file:` address."""
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    parts = urlsplit(url)
    return Path(url2pathname(parts.path)) if parts.scheme == "file" else Path()
