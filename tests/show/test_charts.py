from dataclasses import replace

import numpy as np
from made_up_run import SCENE, recorded

from simcore.show.charts import Curve, charts_of, thinned
from simcore.show.run_track import RunTrack
from simcore.show.scene import RobotLook
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot


def curve(values: np.ndarray) -> Curve:
    return Curve(label="x", color="#000000", times=np.arange(len(values)) * 0.02, values=values)


def test_curves_that_were_not_published_are_left_out() -> None:
    charts = {chart.title: [curve.label for curve in chart.curves] for chart in charts_of(RunTrack(recorded(), SCENE))}
    assert charts == {
        "Score": ["blue", "red"],
        "Battery": ["at its terminals"],
        "Fuel held": ["in the robot"],
        "Current": ["battery"],
        "Pose estimate off by": ["estimate to truth"],
    }


def test_a_set_point_is_drawn_with_the_measured_value() -> None:
    recording = Recording()
    for tick in range(3):
        doubles = {"ArmPositionRot": 0.1 * tick, "ArmPositionRotSetpoint": 0.5, "ArmCurrentA": 7.0}
        numbers = {f"Sim/Debug/{key}": value for key, value in doubles.items()}
        recording.write(Snapshot(time=0.02 * tick, tick=tick, doubles=numbers))
    arm, currents = charts_of(RunTrack(recording, SCENE))
    assert (arm.title, arm.unit) == ("Arm position", "turns")
    assert [(curve.label, curve.values[-1]) for curve in arm.curves] == [("is", 0.2), ("set-point", 0.5)]
    assert (currents.title, [curve.label for curve in currents.curves]) == ("Mechanism currents", ["arm"])


def test_several_robots_are_distinguished_by_number() -> None:
    scene = replace(
        SCENE, robots=(SCENE.robots[0], RobotLook(prefix="Sim/Robots/1", alliance="red", bumpers=(0.7, 0.9)))
    )
    battery = next(chart for chart in charts_of(RunTrack(recorded(), scene)) if chart.title == "Battery, by robot")
    assert [curve.label for curve in battery.curves] == ["0"], "the second published none"


def test_a_spike_is_kept_when_a_curve_is_thinned() -> None:
    values = np.zeros(10_000)
    values[7777], values[123] = 9.0, -3.0
    thin = thinned(curve(values))
    assert len(thin.times) <= 802
    assert (thin.values.max(), thin.values.min()) == (9.0, -3.0)
    assert thin.times[thin.values == 9.0] == 7777 * 0.02
    assert (thin.times[0], thin.times[-1]) == (0.0, 9999 * 0.02)
    assert (np.diff(thin.times) > 0.0).all()
