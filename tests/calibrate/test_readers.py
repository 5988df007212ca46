"""Readers of SysId, DataLogManager, AdvantageKit, URCL and CSV logs return the runs that were written."""

import math
from pathlib import Path

import numpy as np
import pytest
from each_case import each
from made_logs import advantagekit_log, csv_text, driven, status_frame, sysid_json, sysid_log, urcl_log

from simcore.calibrate.assembling import assembled
from simcore.calibrate.drive_fit import fit_battery
from simcore.calibrate.logs import open_log
from simcore.calibrate.signals import quantity_of
from simcore.calibrate.urcl import urcl_signals
from simcore.errors import LogError
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.telemetry.wpilog import read_log

TANK = TankConfig()
TURN = math.tau * TANK.wheel_radius
NEEDS = {"sided": True, "radius": TANK.wheel_radius, "gearing": TANK.gearing,
         "volts_per_speed": TANK.gearing / TANK.motor.kv / TANK.wheel_radius}  # fmt: skip


@pytest.fixture(scope="module")
def runs():
    return driven(TANK)


def runs_of(path, **more):
    return assembled(open_log(path), **(NEEDS | more))


def write(folder: Path, kind: str, runs) -> Path:
    path = folder / {"csv": "log.csv", "json": "log.json"}.get(kind, f"{kind}.wpilog")
    if kind == "csv":
        path.write_text(csv_text(runs))
    elif kind == "json":
        path.write_text(sysid_json(runs, per_turn=TURN))
    elif kind == "sysid":
        sysid_log(path, runs)
    elif kind == "advantagekit":
        advantagekit_log(path, runs, radius=TANK.wheel_radius)
    else:
        urcl_log(path, runs, (1, 3), turn=TURN / TANK.gearing, aliases='{"1": "left", "3": "right"}')
    return path


@each("kind", ["csv", "json", "sysid", "advantagekit", "urcl"])
def test_the_runs_in_a_log_are_found(kind, runs, tmp_path):
    """Final positions are exact; URCL's floats resolve 24 bits of some 250 rotor turns."""
    found, _ = runs_of(write(tmp_path, kind, runs))
    assert [run.name for run in found][:1] != [] and len(found) == len(runs)
    for run, made in zip(found, runs, strict=True):
        assert run.way[-1] == pytest.approx(made.way[-1], abs=1e-4)
        assert np.abs(run.volts).max() == pytest.approx(np.abs(made.volts).max(), abs=0.01)


def test_battery_voltage_and_total_current_are_read_from_the_log(runs, tmp_path):
    """Values are interpolated linearly between timestamps, while the current jumps within 20 ms."""
    found, _ = runs_of(write(tmp_path, "advantagekit", runs))
    battery = fit_battery(found)
    assert battery is not None and battery.value == pytest.approx(0.02, rel=1e-3)
    assert quantity_of("URCL/left/InputVoltage") == ("bus", "left") and quantity_of("SupplyCurrentAmps")[0] == "total"


def test_the_distance_in_a_swerve_log_is_the_mean_of_its_modules(runs, tmp_path):
    found, _ = runs_of(write(tmp_path, "csv", runs), sided=False)
    assert found[0].way.shape[1] == 1 and found[0].way[-1, 0] == pytest.approx(runs[0].way[-1].mean(), abs=1e-5)


def test_sparks_are_assigned_to_sides_by_their_ids(runs, tmp_path):
    path = tmp_path / "log.wpilog"
    urcl_log(path, runs, (7, 9), turn=TURN / TANK.gearing)
    with pytest.raises(
        LogError, match=r"which signals are left_volts and right_volts\? Name them: --signal left_volts=NAME"
    ):
        runs_of(path)
    found, notes = runs_of(path, devices={"Spark-7": "left", "Spark-9": "right"})
    assert len(found) == 4 and "turns of the rotor" in notes[0]
    said = {
        f"{side}_{role}": f"URCL/Spark-{number}/{name}"
        for side, number in (("left", 7), ("right", 9))
        for role, name in (("volts", "AppliedOutputVoltage"), ("way", "PrimaryEncoderPosition"))
    }
    assert len(runs_of(path, said=said)[0]) == 4


def test_a_status_frame_is_decoded_by_revs_table(tmp_path):
    """Steps are 1 / 32444 of output, 30 / 4095 V and 150 / 4095 A; the errors are half a step."""
    path = tmp_path / "log.wpilog"
    urcl_log(path, driven(TANK, tests=("fast-backward",)), (1, 3), turn=1.0)
    signals = dict(urcl_signals(read_log(path)))
    assert signals["URCL/Spark-1/InputVoltage"].values[5] == pytest.approx(12.4, abs=15.0 / 4095.0)
    assert signals["URCL/Spark-3/CurrentOutput"].values[5] == pytest.approx(3.0, abs=75.0 / 4095.0)
    assert signals["URCL/Spark-1/AppliedOutputVoltage"].values.min() == pytest.approx(
        -5.0, abs=5.0 / 12.4 * 15.0 / 4095.0 + 2e-4
    )
    assert len(status_frame(1.0, 12.0, 2.0)) == 8


@each("kind", ["2020", "turns of another wheel"])
def test_sysid_files_of_2020_or_with_other_units_per_turn_are_read(kind, runs, tmp_path):
    """In 2020 a row had ten numbers; units per turn that differ by 2 % from the wheel's are noted and not used."""
    text = sysid_json(runs, per_turn=TURN)
    path = tmp_path / "log.json"
    if kind == "2020":
        data = __import__("json").loads(text)
        for run in runs:
            data[run.name] = [[row[0], 12.0, 0.0, *row[1:7], row[7]] for row in data[run.name]]
        path.write_text(__import__("json").dumps(data))
        assert runs_of(path)[0][2].way[-1] == pytest.approx(runs[2].way[-1], abs=1e-4)
    else:
        path.write_text(text.replace(f'"unitsPerRotation": {TURN}', f'"unitsPerRotation": {1.02 * TURN}'))
        found, notes = runs_of(path)
        assert found[2].way[-1] == pytest.approx(runs[2].way[-1], abs=1e-4)
        assert f"a turn is {1.02 * TURN:.4f} m by the log" in notes[0]


def test_units_are_guessed_if_the_log_names_none(runs, tmp_path):
    path, inches = tmp_path / "log.csv", [type(run)(run.name, run.times, run.volts, run.way / 0.0254) for run in runs]
    path.write_text(csv_text(inches, head="test,t,left volts,right volts,left position,right position,x"))
    found, notes = runs_of(path)
    assert found[2].way[-1] == pytest.approx(runs[2].way[-1], abs=1e-4)
    assert notes == [
        "positions are taken to be in in, judging by how fast the voltage can turn it; the log names no unit"
    ]
    path.write_text(csv_text(inches))
    with pytest.raises(LogError, match=r"if it is in m, it moves .* times as fast .* It would fit as in"):
        runs_of(path)


BROKEN = {
    "standing": (lambda t: t, "the robot stands still: with up to 5.0 V its wheels move 0.000 m"),
    "swapped": (None, "the side with the higher voltage moves less far: left and right are swapped"),
    "backward": (None, "it moves backward at positive voltage"),
    "no time": (None, "no time column: name one t_s; it has test, when"),
    "no way": (None, r"which signals are left_way and right_way\? .* it has left_V, left_x, right_V"),
    "word": (None, "line 3: could not convert string to float: 'a lot'"),
}


@each("case", [*BROKEN])
def test_the_error_for_an_unusable_log_states_the_cause_in_one_sentence(case, runs, tmp_path):
    path, some = tmp_path / "log.csv", runs[2:]
    if case == "standing":
        some = [type(run)(run.name, run.times, run.volts, 0.0 * run.way) for run in some]
    if case == "swapped":
        some = [type(run)(run.name, run.times, run.volts * [1.0, 0.6], run.way * [0.6, 1.0]) for run in some]
    if case == "backward":
        some = [type(run)(run.name, run.times, -run.volts, run.way) for run in some]
    text = csv_text(some)
    text = text.replace("t_s", "when") if case == "no time" else text
    text = text.replace("left_m,right_m", "left_x,right_x") if case == "no way" else text
    if case == "word":
        lines = text.splitlines()
        lines[2] = lines[2].replace("0.020000", "a lot", 1)
        text = "\n".join(lines)
    path.write_text(text)
    with pytest.raises(LogError, match=BROKEN[case][1]) as caught:
        runs_of(path)
    assert "\n" not in str(caught.value)


@each(
    ("name", "text", "said"),
    [
        ("log.json", "{}", "is not a SysId file: it has none of slow-forward"),
        ("log.json", "{", "is not valid JSON"),
        ("log.csv", "t_s\n", "no table"),
        ("log.hoot", "", "convert it to WPILOG first"),
        ("log.wpilog", "text", "not a .wpilog file"),
        ("missing.csv", None, "cannot read the log"),
    ],
)
def test_the_error_states_why_a_file_cannot_be_read_as_a_log(name, text, said, tmp_path):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(LogError, match=said):
        open_log(tmp_path / name)


def test_a_clockwise_gyro_is_reported(runs, tmp_path):
    turning = [type(r)(r.name, r.times, r.volts * [0.8, 1.0], r.way * [0.8, 1.0], yaw=-r.way[:, 1]) for r in runs]
    path = tmp_path / "log.csv"
    path.write_text(csv_text(turning))
    assert "left and right are swapped, or the gyro counts clockwise" in runs_of(path)[1][0]
