"""Commands that install simcore from the origin of the current installation, for error messages and CI.

If pip installed simcore from a package index, a command contains only the name `simcore`. Otherwise, a command contains
the address of the origin, because the name may be unused or refer to another project on the index.
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
    """Return the pip command that installs extras, with the folder in which to run the command if necessary.

    For a source checkout, the command contains the path of the checkout. For an installed package, the command contains
    the origin that pip recorded (PEP 610): a folder, a git address, a file, or an index. If the origin is unknown or
    no longer exists, the user has to find the folder of simcore's source and run the command in that folder.

    >>> print(install_command("view", package=Path("/home/me/env/site-packages/simcore")))
    `python -m pip install ".[view]"` in the folder of simcore's source

    Args:
        extras: Names of extras; empty to install simcore with only the required packages.
        upgrade: Whether pip upgrades packages that are already installed.
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
    """Return the pip requirement that installs this version of simcore on another computer.

    The result is empty if the origin of the installed simcore is unknown or not public.

    >>> shared_requirement("robotpy", package=Path("/home/me/env/site-packages/simcore"))
    ''

    Args:
        extras: Names of extras.
        source: pip address of simcore, e.g. `git+https://...`; empty for the origin of the installed simcore.
        package: Folder of the simcore package.
    """
    name = f"simcore[{','.join(extras)}]"
    if not source and (version := _index_version(package)):
        return f"{name}=={version}"
    source = source or _address(package)
    return f"{name} @ {source}" if source else ""


def _address(package: Path) -> str:
    """Return the pip address of the installed commit or archive; empty if the origin has no public address."""
    origin = _origin(package)
    url, version_control = str(origin.get("url", "")), origin.get("vcs_info")
    if version_control:
        return f"{version_control.get('vcs', 'git')}+{url}@{version_control.get('commit_id', '')}"
    if url.startswith("https:"):
        return url
    folder = package.parent if is_source(package.parent) else _folder(url)
    return _clone_address(folder) if (folder / ".git").exists() else ""


def _clone_address(folder: Path) -> str:
    """Return the pip address of a git clone: https address of the remote `origin`, and the checked-out commit.

    The address contains neither user name nor password. The result is empty if git fails or if the remote has no such
    address.
    """
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
    """Return whether a folder contains simcore's source, from which pip can install simcore."""
    return (folder / "pyproject.toml").is_file() and (folder / "simcore" / "install_text.py").is_file()


def _index_version(package: Path) -> str:
    """Return the version of simcore that pip installed from a package index; empty for any other origin."""
    found = [] if is_source(package.parent) else sorted(package.parent.glob("simcore-*.dist-info"))
    is_named = found and not (found[-1] / "direct_url.json").exists()
    return found[-1].name.removeprefix("simcore-").removesuffix(".dist-info") if is_named else ""


def _origin(package: Path) -> Mapping[str, Any]:
    """Return the origin that pip recorded in `direct_url.json` of the metadata; empty without a readable record."""
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
