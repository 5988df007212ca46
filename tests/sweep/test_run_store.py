"""File of rows: failed writes are repeated; a damaged file or another version is reported in one sentence."""

import json
import sqlite3
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from simcore import cli
from simcore.errors import OutputError
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.run_store import FILE_NAME, VERSION, RunStore

FOLDER = str(Path(__file__).parent)


@pytest.mark.parametrize("more", [0, 1], ids=["as it is closed", "with the next one"])
def test_rows_that_could_not_be_written_are_tried_again(tmp_path, caplog, more):
    """For a while, no page can be added to the file."""
    rest = {"run": 0, "point": 0, "seed": 0, "version": "1", "error": "", "cpu_seconds": 1.0}
    with closing(RunStore(tmp_path)) as store:
        ((pages,),) = store._base.execute("PRAGMA page_count").fetchall()
        store._base.execute(f"PRAGMA max_page_count = {pages}")
        store.add("large", {**rest, "score": "7" * 50_000})
        store.add("small", rest)
        assert store.rows(["large", "small"]) == {}
        store._base.execute("PRAGMA max_page_count = 1000")
        for number in range(more):
            store.add(f"new {number}", rest)
            assert set(store.rows(["large", "small", "new 0"])) == {"large", "small", "new 0"}
    assert len(caplog.messages) == 1 and caplog.messages[0].endswith("kept in memory")
    with closing(RunStore(tmp_path)) as store:
        assert set(store.rows(["large", "small"])) == {"large", "small"}


def test_the_last_experiment_is_restored(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(FOLDER)
    few, many = (Experiment(game="sweep_game:SMALL", seconds=0.04, seeds=range(n)) for n in (2, 3))
    sweep(many, workers=0, out=tmp_path)
    sweep(few, workers=0, out=tmp_path)
    with closing(RunStore(tmp_path, must_exist=True)) as store:
        assert store.experiment() == few
    with pytest.raises(OutputError, match="no runs in it"):
        RunStore(tmp_path / "nowhere", must_exist=True)


# --- another version, or damaged --------------------------------------------------------------------------------------


def sql(*commands):
    """Return a function that runs SQL commands on a file."""

    def change(path):
        with closing(sqlite3.connect(path)) as base:
            for command in commands:
                base.execute(command)
            base.commit()

    return change


def told(table, column, **changes):
    """Return a function that changes fields in a column of a file; the value `gone` removes a field."""

    def change(path):
        with closing(sqlite3.connect(path)) as base:
            ((text,),) = base.execute(f"SELECT {column} FROM {table}").fetchall()
            fields = {name: value for name, value in {**json.loads(text), **changes}.items() if value != "gone"}
            base.execute(f"UPDATE {table} SET {column} = ?", [json.dumps(fields)])
            base.commit()

    return change


described = partial(told, "experiment", "description")
rowed = partial(told, "runs", "row")


def bytes_of(change):
    return lambda path: path.write_bytes(change(path.read_bytes()))


def folder(path):
    path.unlink()
    path.mkdir()


def other_database(path):
    path.unlink()
    sql("CREATE TABLE other (a)")(path)


BOTH = {
    "a newer version": sql(f"PRAGMA user_version = {VERSION + 1}"),
    "an older version": sql("PRAGMA user_version = 0"),
    "no table of runs": sql("DROP TABLE runs"),
    "no table of the experiment": sql("DROP TABLE experiment"),
    "another table": sql("DROP TABLE runs", "CREATE TABLE runs (a)"),
    "a column less": sql("ALTER TABLE runs DROP COLUMN row"),
    "another column": sql("ALTER TABLE experiment RENAME COLUMN description TO names"),
    "no database": bytes_of(lambda data: b"x" * len(data)),
    "a text": bytes_of(lambda data: b"run,seed\n0,1\n"),
    "half of it": bytes_of(lambda data: data[: len(data) // 2]),
    "its first page alone": bytes_of(lambda data: data[:4096]),
    "pages of noise": bytes_of(lambda data: data[:4096] + b"\xa5" * (len(data) - 4096)),
    "a folder": folder,
    "another database": other_database,
}
REPEATED = {
    "no experiment": sql("DELETE FROM experiment"),
    "no JSON": sql("UPDATE experiment SET description = 'x'"),
    "a list": sql("UPDATE experiment SET description = '[]'"),
    "a number": sql("UPDATE experiment SET description = '3'"),
    "bytes": sql("UPDATE experiment SET description = x'ff00'"),
    "a field more": described(later=1),
    "a field less": described(factors="gone"),
    "seeds that are words": described(seeds=["a"]),
    "factors that are words": described(factors=["robot.mass"]),
    "a factor without values": described(factors=[{"name": "robot.mass"}]),
    "a scatter that is none": described(scatter="much"),
    "a metric that is none": described(metrics=["scor"]),
    "a metric of nowhere": described(metrics=["nowhere:hits"]),
    "nested without end": sql(f"UPDATE experiment SET description = '{'[' * 5000}'"),
}
RESUMED = {
    "a row that is no JSON": sql("UPDATE runs SET row = 'x'"),
    "a row that is a list": sql("UPDATE runs SET row = '[1]'"),
    "bytes": sql("UPDATE runs SET row = x'ff00'"),
    "a row without error": rowed(error="gone"),
    "a row without seed": rowed(seed="gone"),
    "a run that is a word": rowed(run="one"),
    "a value that is a list": rowed(score=[1]),
}
SHORT = ["sweep_game:SMALL", "--seeds", "1", "--seconds", "0.04", "-j", "1"]


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Return the bytes of the store of a sweep with one run."""
    folder = tmp_path_factory.mktemp("store")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FOLDER)
        assert cli.main(["sweep", *SHORT, "--out", str(folder)]) == 0
    return (folder / FILE_NAME).read_bytes()


@pytest.mark.parametrize(
    ("words", "change"),
    [
        pytest.param(words, change, id=f"{way}: {name}")
        for way, words, changes in (
            ("resume", SHORT, BOTH | RESUMED),
            ("repeat", ["--repeat", "0"], BOTH | REPEATED),
        )
        for name, change in changes.items()
    ],
)
def test_a_damaged_store_or_a_store_of_another_version_is_reported_in_one_sentence(
    store, tmp_path, monkeypatch, capsys, words, change
):
    monkeypatch.syspath_prepend(FOLDER)
    path = tmp_path / "runs" / FILE_NAME
    path.parent.mkdir()
    path.write_bytes(store)
    change(path)
    before = path.read_bytes() if path.is_file() else None
    assert cli.main(["sweep", *words, "--out", str(path.parent)]) == 1
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1 and str(path.parent) in said[0], said
    assert (path.read_bytes() if path.is_file() else None) == before, "it is left as it is"


def test_a_repeated_run_first_warns_of_code_outside_the_current_folder(store, tmp_path, monkeypatch, caplog):
    project = tmp_path / "elsewhere"
    project.mkdir()
    (project / "robot.py").write_text("raise SystemExit\n")
    (project / "evil_metric.py").write_text("raise ImportError('it has run')\n")
    monkeypatch.syspath_prepend(str(project))
    monkeypatch.syspath_prepend(FOLDER)
    path = tmp_path / "here" / "runs" / FILE_NAME
    path.parent.mkdir(parents=True)
    path.write_bytes(store)
    described(project=str(project), metrics=["evil_metric:score"], game=None)(path)
    monkeypatch.chdir(tmp_path / "here")
    assert cli.main(["sweep", "--out", "runs", "--repeat", "0"]) == 1
    (named,) = caplog.messages
    assert str(project / "robot.py") in named and str(project / "evil_metric.py") in named
