"""The command that installs an extra names the origin of the installed simcore."""

import importlib.util
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from simcore.install_text import install_command, shared_requirement

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def installed(tmp_path):
    """Return a function that records an origin in direct_url.json and returns the install command."""
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


def test_the_install_command_names_the_folder_of_a_checkout():
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
def test_the_install_command_repeats_a_git_address_or_the_url_of_a_file(installed, origin, wanted):
    assert installed(origin, "view") == f'`python -m pip install "{wanted}"`'


def test_the_install_command_names_the_source_folder_or_file_only_while_it_exists(installed, tmp_path):
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


def test_the_install_command_names_only_the_package_if_it_came_from_an_index(tmp_path):
    package = tmp_path / "simcore"
    (tmp_path / "simcore-1.2.0.dist-info").mkdir(parents=True)
    assert install_command("view", package=package) == '`python -m pip install "simcore[view]"`'
    assert shared_requirement("view", package=package) == "simcore[view]==1.2.0"
    assert shared_requirement("view", package=package, source="git+https://h/s") == "simcore[view] @ git+https://h/s"


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
@pytest.mark.parametrize(
    ("remote", "told"),
    [
        ("https://host/o/simcore.git", "git+https://host/o/simcore.git"),
        ("https://me:secret@host:8443/o/simcore", "git+https://host:8443/o/simcore"),
        ("git@host:o/simcore.git", "git+https://host/o/simcore.git"),
        ("ssh://git@host/o/simcore.git", "git+https://host/o/simcore.git"),
        ("/home/me/simcore", ""),
        (None, ""),
    ],
)
def test_the_shared_requirement_names_the_origin_and_the_commit_of_the_clone(tmp_path, remote, told):
    (tmp_path / "simcore").mkdir()
    (tmp_path / "simcore" / "install_text.py").touch()
    (tmp_path / "pyproject.toml").touch()

    def git(*words):
        who = ("-c", "user.name=me", "-c", "user.email=me@host")
        return subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    git("init", "-q")
    git("add", ".")
    git("commit", "-q", "-m", "x")
    if remote:
        git("remote", "add", "origin", remote)
    wanted = f"simcore[rev] @ {told}@{git('rev-parse', 'HEAD').strip()}" if told else ""
    assert shared_requirement("rev", package=tmp_path / "simcore") == wanted


def test_the_release_script_replaces_the_only_repository_address(tmp_path):
    """The page on a package index must have no broken link."""
    told = [path for path in (*ROOT.glob("*.*"), *ROOT.glob("docs/*.md")) if path.is_file()]
    assert [path.name for path in told if "ADDRESS" in path.read_text(encoding="utf-8")] == ["pyproject.toml"]
    spec = importlib.util.spec_from_file_location("name_repository", ROOT / "scripts" / "name_repository.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, tmp_path)
    with pytest.raises(SystemExit, match="got 'me/simcore'"):
        script.name_repository(tmp_path, "me/simcore", "v1")
    script.name_repository(tmp_path, "https://host/me/simcore", "v1")
    assert 'Source = "https://host/me/simcore"' in (tmp_path / "pyproject.toml").read_text(encoding="utf-8")
    readme = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "(https://host/me/simcore/raw/v1/docs/images/page.png)" in readme
    links = re.findall(r"\]\(([^)]*)\)", readme)
    assert links and all(link.startswith("https://host/me/simcore/") for link in links)


def test_no_text_tells_users_to_install_a_bare_name_from_the_index():
    """`pip install simcore` would install whatever a stranger has published under that name."""
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
