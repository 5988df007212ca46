"""Rankings of functions whose indices are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.sweep.results import Results
from simcore.sweep.sensitivity import morris_points, saltelli_points

from .made_sweep import described, runs_of

A, B = 7.0, 0.1
VARIANCE = A**2 / 8 + B * math.pi**4 / 5 + B**2 * math.pi**8 / 18 + 0.5
FIRST = {
    "x1": 0.5 * (1 + B * math.pi**4 / 5) ** 2 / VARIANCE,
    "x2": A**2 / 8 / VARIANCE,
    "x3": 0.0,
}
TOTAL = {"x1": FIRST["x1"] + 8 * B**2 * math.pi**8 / 225 / VARIANCE, "x2": FIRST["x2"]}
TOTAL["x3"] = TOTAL["x1"] - FIRST["x1"]
"""Sobol indices of Ishigami's function. Source: T. Ishigami, T. Homma (1990); closed form in A. Saltelli et al.,
Sensitivity Analysis, Wiley 2000."""


def ishigami(values, seed=0):
    x1, x2, x3 = (values[name] for name in ("x1", "x2", "x3"))
    return {"score": math.sin(x1) + A * math.sin(x2) ** 2 + B * x3**4 * math.sin(x1)}


def results(unit, design, function=ishigami, seeds=1):
    points = dict(zip(("x1", "x2", "x3"), (2 * unit - 1).T * math.pi, strict=True))
    return Results(runs_of(points, function, seeds=seeds), described("x1", "x2", "x3", design=design))


def test_the_closed_form_is_the_published_one():
    assert FIRST == pytest.approx({"x1": 0.3139, "x2": 0.4424, "x3": 0.0}, abs=1e-4)
    assert TOTAL == pytest.approx({"x1": 0.5576, "x2": 0.4424, "x3": 0.2437}, abs=1e-4)


def test_saltellis_design_finds_the_known_indices():
    """Within their own margins; ranked by the total ones: x1, x2, x3."""
    found = results(saltelli_points(1024, 3, seed=2), "saltelli").sensitivity("score")
    assert [effect.factor for effect in found] == ["x1", "x2", "x3"]
    for effect in found:
        assert effect.index == pytest.approx(FIRST[effect.factor], abs=1.5 * effect.margin)
        assert effect.total == pytest.approx(TOTAL[effect.factor], abs=0.05)


@pytest.mark.parametrize("design", ["random", "latin", "sobol"])
def test_scattered_points_find_the_first_order_indices(design):
    unit = np.random.default_rng(4).random((800, 3))
    found = results(unit, design).sensitivity("score")
    assert [effect.factor for effect in found] == ["x2", "x1", "x3"]
    assert {effect.factor: effect.index for effect in found} == pytest.approx(FIRST, abs=0.08)
    assert all(math.isnan(effect.total) for effect in found)


@pytest.mark.parametrize("count", [40, 41])
def test_the_fewest_scattered_points_that_are_allowed_rank_a_plane(count):
    unit = np.random.default_rng(3).random((count, 3))
    found = results(unit, "sobol", lambda values, seed: {"score": 3 * values["x1"] - values["x2"]}).sensitivity("score")
    assert found[0].factor == "x1" and found[0].index > 0.6
    assert all(math.isfinite(effect.index) and math.isfinite(effect.margin) for effect in found)


def test_a_grid_finds_the_first_order_indices_of_its_values():
    """On 24 middles of equal parts a factor, the sums are the integrals within 3 %."""
    middles = (np.arange(24) + 0.5) / 24
    unit = np.stack(np.meshgrid(*[middles] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[::2]
    found = results(unit, "grid").sensitivity("score")
    assert {effect.factor: effect.index for effect in found} == pytest.approx(FIRST, abs=0.03)


def test_a_factor_that_does_nothing_has_no_share_of_what_seeds_do():
    """Two values of each of two factors and three seeds: between means of six runs there is always some difference."""
    unit = np.array([(x, y, 0.5) for x in (0.1, 0.9) for y in (0.1, 0.9)])

    def luck(values, seed):
        return {"score": 57 + [0, 1, 1][seed] * (values["x1"] > 0) + [1, 0, 0][seed] * (values["x1"] < 0)}

    def moved(values, seed):
        return {"score": luck(values, seed)["score"] + 10 * (values["x2"] > 0)}

    shares = {effect.factor: effect.index for effect in results(unit, "grid", luck, seeds=3).sensitivity("score")}
    assert shares["x1"] < 0.05 and shares["x2"] == 0.0
    first, *_ = results(unit, "grid", moved, seeds=3).sensitivity("score")
    assert first.factor == "x2" and first.index > 0.98


def test_the_luck_of_seeds_hides_no_factor():
    """One more in each of ten pairs, and seeds that scatter by 100: all that happens within seeds is the factor."""
    table = runs_of({"x": np.array([0.0, 1.0])}, lambda v, seed: {"score": 100 * math.sin(seed) + v["x"]}, seeds=10)
    (effect,) = Results(table, described("x")).sensitivity("score")
    assert effect.index == pytest.approx(1.0) and effect.swing == pytest.approx(1.0)


def test_morris_finds_the_slopes_of_a_plane_exactly_and_seeds_are_averaged():
    """mu* of 3 x1 - 2 x2 is 3 and 2 times the whole range of a factor, whatever the points."""

    def plane(values, seed):
        return {"score": 3 * values["x1"] - 2 * values["x2"] + (1 if seed else -1)}

    found = results(morris_points(6, 3, seed=1), "morris", plane, seeds=2).sensitivity("score")
    way = 2 * math.pi
    assert [effect.factor for effect in found] == ["x1", "x2", "x3"]
    assert [effect.index for effect in found] == pytest.approx([3 * way, 2 * way, 0.0])
    assert found[0].swing > 0 > found[1].swing and found[2].margin == pytest.approx(0.0, abs=1e-9)


def test_points_without_a_value_cost_their_block_and_no_more():
    whole = results(saltelli_points(256, 3, seed=2), "saltelli")
    table = whole.table.copy()
    table.loc[[0, 7, 400], ["score", "error"]] = [np.nan, "TimeoutError: the run took more than 60 s"]
    found = Results(table, whole.experiment).sensitivity("score")
    assert [effect.factor for effect in found] == ["x1", "x2", "x3"]
    table["error"] = "crashed"
    with pytest.raises(ConfigError, match="0 whole blocks of 5 runs"):
        Results(table, whole.experiment).sensitivity("score")


def test_words_count_as_values_of_a_list_only():
    points = {"auto": np.array(["depot", "neutral", "depot", "neutral"]), "x": np.array([1.0, 1.0, 2.0, 2.0])}
    table = runs_of(points, lambda values, seed: {"score": 10 * (values["auto"] == "neutral") + values["x"]})
    first, second = Results(table, described("auto", "x", design="list")).sensitivity("score")
    assert (first.factor, first.low, first.high, first.swing) == ("auto", "depot", "neutral", 10.0)
    assert first.index == pytest.approx(25 / 25.25) and second.index == pytest.approx(0.25 / 25.25)
    many = {"auto": np.array(["depot", "neutral"] * 30), "x": np.arange(60.0)}
    table = runs_of(many, lambda values, seed: {"score": values["x"]})
    with pytest.raises(ConfigError, match="auto has words for values"):
        Results(table, described("auto", "x", design="random")).sensitivity("score")


def test_designs_that_cannot_tell_are_refused():
    with pytest.raises(ConfigError, match="power of two"):
        saltelli_points(100, 3)
    with pytest.raises(ConfigError, match="2 factors or more, got 8 and 1"):
        morris_points(8, 1)
    with pytest.raises(ConfigError, match="12 scattered points cannot tell"):
        results(np.random.default_rng(1).random((12, 3)), "latin").sensitivity("score")
    with pytest.raises(ConfigError, match="nothing was varied"):
        Results(runs_of({"x": np.zeros(3)}, lambda v, s: {"score": 1}), described()).sensitivity("score")
