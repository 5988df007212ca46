"""Factors as people write them."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest

from simcore.errors import ConfigError
from simcore.sweep.factors import Distribution, Factor, parse_factor


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("robot.mass=45:60:5", (45.0, 50.0, 55.0, 60.0)),
        ("robot.mass=60:45:-5", (60.0, 55.0, 50.0, 45.0)),
        ("a=0.1:0.3:0.1", (0.1, 0.2, 0.3)),
        ("a=1:2:0.4", (1.0, 1.4, 1.8)),
        ("battery.charge = 0.3, 1", (0.3, 1.0)),
        ("auto=left,two pieces", ("left", "two pieces")),
        ("red=collector:3,collector:2+idle", ("collector:3", "collector:2+idle")),
    ],
)
def test_lists_and_ranges_with_their_end(text, values):
    assert parse_factor(text).values == values


def test_distributions_give_quantiles():
    uniform, normal = parse_factor("e=uniform(0.4,0.5)"), parse_factor("m=normal(55,2)")
    assert uniform.at(0.5) == pytest.approx(0.45) and normal.at(0.5) == pytest.approx(55.0)
    assert normal.at(0.8413447) == pytest.approx(57.0, abs=1e-4)  # one standard deviation above


@pytest.mark.parametrize("text", ["robot.mass", "=3", "a=", "a=1:2", "a=1:2:0", "a=2:1:1", "a=1,,2", "a=1,1",
                                  "a=uniform(2,1)", "a=normal(1)", "a=normal(1,0)", "a=gauss(1,2)", "a..b=1",
                                  "a=45-60", "a=45..60", "a=uniform 1,2",
                                  "a=0:1e9:0.001", "a=1e300,2"])  # fmt: skip
def test_what_cannot_be_read_is_said(text):
    with pytest.raises(ConfigError):
        parse_factor(text)


def test_a_factor_survives_json():
    for factor in (parse_factor("a=1,b"), Factor("m", distribution=Distribution("normal", 55.0, 2.0))):
        assert Factor.from_json(json.loads(json.dumps(asdict(factor)))) == factor
