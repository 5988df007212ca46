"""Errors say what was wrong, what was got and what would work, and are the builtin that a caller expects."""

from each_case import each

from simcore import errors
from simcore.errors import SimcoreError, UnknownNameError


def test_an_unknown_name_offers_the_nearest():
    error = UnknownNameError("auto", "centre", ["left", "depot", "center"])
    assert str(error) == "no auto named 'centre'. Did you mean 'center'? Known: ['center', 'depot', 'left']"
    assert error.nearest == ["center"]
    assert (error.kind, error.name, error.known) == ("auto", "centre", ["center", "depot", "left"])


def test_a_name_that_resembles_nothing_lists_what_there_is():
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
def test_every_error_is_ours_and_the_builtin_that_callers_expect(error, builtin):
    assert issubclass(getattr(errors, error), SimcoreError)
    assert issubclass(getattr(errors, error), builtin)
