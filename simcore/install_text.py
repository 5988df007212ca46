"""The command that installs simcore again from where it came, with extras: for errors and for the doctor.

simcore is installed from its source or from a git address, so the bare name of the distribution is never in a command:
on the package index it is nobody's, or a stranger's.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["install_command", "source_address"]

_PIP = "python -m pip install"
_PACKAGE = Path(__file__).resolve().parent


def install_command(*extras: str, upgrade: bool = False, package: Path = _PACKAGE) -> str:
    """What to type to have extras, with where to type it when that matters.

    A checkout is named by its folder, an install by what pip noted of its origin (PEP 610): a folder, a git address or
    a file. If that is unknown or gone, the folder of simcore's source has to be found by the reader.

    >>> print(install_command("view", package=Path("/home/me/env/site-packages/simcore")))
    `python -m pip install ".[view]"` in the folder of simcore's source

    Args:
        extras: Names of extras; none: simcore with what it always needs.
        upgrade: Whether what is there may be too old.
        package: Folder of the package simcore.
    """
    pip = f"{_PIP} --upgrade" if upgrade else _PIP
    names = f"[{','.join(extras)}]" if extras else ""
    if _is_source(package.parent):
        return f'`{pip} -e "{package.parent}{names}"`'
    origin = _origin(package)
    url = str(origin.get("url", ""))
    if version_control := origin.get("vcs_info"):
        revision = version_control.get("requested_revision") or version_control.get("commit_id", "")
        return f'`{pip} "simcore{names} @ {version_control.get("vcs", "git")}+{url}@{revision}"`'
    folder = _folder(url)
    if "dir_info" in origin and _is_source(folder):
        return f'`{pip} "{folder}{names}"`'
    if "archive_info" in origin and (not url.startswith("file:") or folder.is_file()):
        return f'`{pip} "simcore{names} @ {url}"`'
    return f'`{pip} ".{names}"` in the folder of simcore\'s source'


def source_address(package: Path = _PACKAGE) -> str:
    """From where pip of another computer can install the simcore that is here; empty: from nowhere that is known.

    >>> source_address(Path("/home/me/env/site-packages/simcore"))
    ''

    Args:
        package: Folder of the package simcore.
    """
    origin = _origin(package)
    url, version_control = str(origin.get("url", "")), origin.get("vcs_info")
    if version_control:
        return f"{version_control.get('vcs', 'git')}+{url}@{version_control.get('commit_id', '')}"
    return url if url.startswith("https:") else ""


def _is_source(folder: Path) -> bool:
    """Whether a folder is one that pip can install simcore from."""
    return (folder / "pyproject.toml").is_file() and (folder / "simcore" / "install_text.py").is_file()


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
