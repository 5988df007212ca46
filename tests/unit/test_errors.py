"""Errors say what was wrong, what was got and what would work, and are the builtin that a caller expects."""

from __future__ import annotations

import math

import pytest

from simcore import errors
from simcore.errors import ConfigError, SimcoreError, UnknownNameError


def test_an_unknown_name_offers_the_nearest():
    error = UnknownNameError("auto", "centre", ["left", "depot", "center"])
    assert str(error) == "no auto named 'centre'. Did you mean 'center'? Known: ['center', 'depot', 'left']"
    assert error.nearest == ["center"]
    assert (error.kind, error.name, error.known) == ("auto", "centre", ["center", "depot", "left"])


def test_a_name_that_resembles_nothing_lists_what_there_is():
    assert str(UnknownNameError("auto", "xyz", ["depot"])) == "no auto named 'xyz'. Known: ['depot']"
    assert str(UnknownNameError("auto", "xyz", [])) == "no auto named 'xyz'. Known: []"


@pytest.mark.parametrize(
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


@pytest.mark.parametrize(
    ("check", "good", "bad"),
    [
        (errors.require_finite, [0.0, -1.0, 1e300], [math.nan, math.inf, -math.inf]),
        (errors.require_positive, [1e-12, 3.0], [0.0, -1.0, math.nan, math.inf]),
        (errors.require_non_negative, [0.0, 3.0], [-1e-12, math.nan, math.inf]),
    ],
)
def test_checks_pass_what_works_and_name_owner_field_unit_and_value(check, good, bad):
    for value in good:
        check("Fuel", "mass", value, "kg")
    for value in bad:
        with pytest.raises(ConfigError) as caught:
            check("Fuel", "mass", value, "kg")
        for word in ("Fuel", "mass", "kg", str(value)):
            assert word in str(caught.value)
