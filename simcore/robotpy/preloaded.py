"""What each process of robot code needs, imported once: `simcore.sweep.child_process` forks from a process that has it.

Nothing is built here and no thread is started: what has threads must not be forked. WPILib of 2027 starts one as it is
imported, so that of 2026 alone is here.
"""

from __future__ import annotations

import contextlib
import gc
from importlib import import_module, metadata

from simcore.errors import EngineError
from simcore.loop.step import prepare
from simcore.physics.bullet import load_pybullet

_ALWAYS = ("scipy.spatial", "mujoco", "hypothesis")
"""hypothesis: its plugin of pytest imports it in any case."""
_BEFORE_2027 = (
    *("wpilib.simulation", "ntcore", "pyfrc.test_support", "phoenix6.hardware", "phoenix6.swerve"),
    *("simcore.robotpy.robot_physics", "simcore.robotpy.simulated_phoenix"),
)

for _name in (*_ALWAYS, *(_BEFORE_2027 if metadata.version("robotpy-hal") < "2027" else ())):
    with contextlib.suppress(ImportError):  # an extra that this project does without
        import_module(_name)
with contextlib.suppress(EngineError):
    load_pybullet()
prepare()  # compiled or loaded once for all
gc.collect()
gc.freeze()  # children copy no page because something in it was counted
