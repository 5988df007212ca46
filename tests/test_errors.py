"""Errors state the problem, the value and valid values, and derive from the built-in exception that callers expect."""

from __future__ import annotations

import linecache

import pytest
from each_case import each

from simcore import errors
from simcore.errors import SimcoreError, UnknownNameError, start_sentence


def test_the_error_for_an_unknown_name_suggests_the_nearest_known_name():
    error = UnknownNameError("auto", "centre", ["left", "depot", "center"])
    assert str(error) == "no auto named 'centre'. Did you mean 'center'? Known: ['center', 'depot', 'left']"
    assert error.nearest == ["center"]
    assert (error.kind, error.name, error.known) == ("auto", "centre", ["center", "depot", "left"])


def test_the_error_for_a_name_unlike_any_known_name_lists_the_known_names():
    assert str(UnknownNameError("auto", "xyz", ["depot"])) == "no auto named 'xyz'. Known: ['depot']"
    assert str(UnknownNameError("auto", None, ["depot"])) == "no auto named None. Known: ['depot']"
    assert str(UnknownNameError("auto", "xyz", [])) == "no auto named 'xyz'. Known: []"


@each(
    ("error", "builtin"),
    [
        ("ConfigError", ValueError),
        ("NonFiniteError", ValueError),
        ("CapacityError", RuntimeError),
        ("EngineError", RuntimeError),
        ("FieldMeshError", ValueError),
        ("OutputError", OSError),
        ("UnknownNameError", KeyError),
    ],
)
def test_every_error_derives_from_simcore_error_and_a_builtin_exception(error, builtin):
    assert issubclass(getattr(errors, error), SimcoreError)
    assert issubclass(getattr(errors, error), builtin)


def test_the_import_error_for_a_moved_name_states_its_new_module(tmp_path):
    """The cases are a removed module, a moved name and an unknown name, which keeps Python's message."""
    file = tmp_path / "old.py"
    for line, said in {
        "from simcore.gamepiece.config import GamePieceConfig": "pieces.kinds import GamePieceConfig",
        "from simcore.match.motion import Match": "; now from simcore.match.match import Match",
        "from simcore.match.motion import Nothing": "motion.py)",
    }.items():
        file.write_text(line, encoding="utf-8")
        linecache.checkcache(str(file))
        with pytest.raises(ImportError) as caught:
            exec(compile(line, str(file), "exec"), {})
        sentence = start_sentence(caught.value, tmp_path)
        assert sentence.startswith("old.py, line 1: ") and sentence.endswith(said), sentence
