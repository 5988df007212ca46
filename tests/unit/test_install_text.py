"""How simcore says that an extra is to be installed: by where simcore came from."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from simcore.install_text import install_command

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def installed(tmp_path):
    """A package in a site-packages, with a note of its origin, and the folder of a source."""
    package = tmp_path / "site-packages" / "simcore"
    note = package.parent / "simcore-1.0.0.dist-info" / "direct_url.json"
    note.parent.mkdir(parents=True)
    source = tmp_path / "the source"
    (source / "simcore").mkdir(parents=True)
    (source / "simcore" / "install_text.py").touch()
    (source / "pyproject.toml").touch()
    (tmp_path / "simcore.whl").touch()

    def ask(origin, *extras, **options):
        note.write_text(json.dumps(origin) if isinstance(origin, dict) else origin, encoding="utf-8")
        return install_command(*extras, package=package, **options)

    return ask


def test_a_checkout_is_named_by_its_folder():
    assert (
        install_command("view", "robotpy", package=ROOT / "simcore")
        == f'`python -m pip install -e "{ROOT}[view,robotpy]"`'
    )


@pytest.mark.parametrize(
    ("origin", "wanted"),
    [
        (
            {
                "url": "https://host/simcore.git",
                "vcs_info": {"vcs": "git", "requested_revision": "v1", "commit_id": "c0"},
            },
            "simcore[view] @ git+https://host/simcore.git@v1",
        ),
        (
            {"url": "ssh://git@host/simcore.git", "vcs_info": {"vcs": "git", "commit_id": "c0"}},
            "simcore[view] @ git+ssh://git@host/simcore.git@c0",
        ),
        (
            {"url": "https://host/simcore.whl", "archive_info": {}},
            "simcore[view] @ https://host/simcore.whl",
        ),
    ],
)
def test_a_git_address_and_a_file_of_the_network_are_named_as_they_were(installed, origin, wanted):
    assert installed(origin, "view") == f'`python -m pip install "{wanted}"`'


def test_a_folder_and_a_file_are_named_while_they_are_there(installed, tmp_path):
    source, wheel = tmp_path / "the source", tmp_path / "simcore.whl"
    from_folder = {"url": source.as_uri(), "dir_info": {}}
    from_file = {"url": wheel.as_uri(), "archive_info": {}}
    assert installed(from_folder, "view") == f'`python -m pip install "{source}[view]"`'
    assert installed(from_folder, upgrade=True) == f'`python -m pip install --upgrade "{source}"`'
    assert installed(from_file, "view") == f'`python -m pip install "simcore[view] @ {wheel.as_uri()}"`'
    (source / "pyproject.toml").unlink()
    wheel.unlink()
    somewhere = '`python -m pip install ".[view]"` in the folder of simcore\'s source'
    for origin in (from_folder, from_file, {}, "no JSON", "[]"):
        assert installed(origin, "view") == somewhere


def test_nobody_is_told_to_install_a_bare_name_from_the_index():
    """`pip install simcore` takes what a stranger may have put on the package index under that name."""
    bare = re.compile(r"""pip install (?:--?[\w-]+ )*["'`]*simcore\b(?!\S* @)""")
    texts = [
        path
        for folder in ("simcore", "games", "docs", "examples", "scripts", "tests", ".ci", ".github")
        for path in (ROOT / folder).rglob("*")
        if path.is_file()
        and path.suffix in (".py", ".md", ".txt", ".toml", ".yml", "")
        and "__pycache__" not in path.parts
    ] + [path for path in ROOT.glob("*") if path.suffix in (".md", ".toml", ".yml", ".py")]
    assert len(texts) > 400
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in texts
        if path != Path(__file__)
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines()
        if bare.search(line)
    ]
    assert found == []
