"""Seed and scatter of a robot test from pytest's options, for workers of a sweep and for people."""

from __future__ import annotations

import pytest

from simcore.errors import SimcoreError
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.robotcode.sim.run_variation import RunVariation, require_varied, run_variation, set_run_variation

pytestmark = pytest.mark.slow

RUN = """
def test_run(sim):
    sim.start()
    print("RUN", sim.match.seed, sim.match.scatter.text)
"""


def test_seed_and_scatter_change_the_match_of_a_robot_program(project):
    code, said = project(RUN, "-rP", "--sim-seed=3", "--sim-scatter=0,exit_speed=0.03")
    assert code == 0, said
    assert "RUN 3 0,exit_speed=0.03" in said
    code, said = project(RUN, "--sim-scatter=exit_sped=1")
    assert code == 4 and "--sim-scatter: no spread named 'exit_sped'. Did you mean 'exit_speed'" in said, said


def test_a_physics_py_that_ignores_run_variation_is_refused():
    """If a physics.py builds a match with other values than requested, all runs would be equal."""
    with Match.bare(seed=3, scatter=Scatter.parse("0,drag=0.1")) as match:
        try:
            for wanted, problem in (
                (RunVariation(seed=3), None),
                (RunVariation(seed=3, scatter=Scatter.parse("0,drag=0.1")), None),
                (RunVariation(seed=4), "this run has seed 4 .* builds its match with seed 3 and scatter '0,drag=0.1'"),
                (RunVariation(seed=3, scatter=Scatter()), r"give it Match\(..., seed=run_variation\(\).seed"),
            ):
                set_run_variation(wanted)
                assert run_variation() is wanted
                if problem is None:
                    require_varied(match)
                else:
                    with pytest.raises(SimcoreError, match=problem):
                        require_varied(match)
        finally:
            set_run_variation(RunVariation())
