"""Mutants: `python scripts/mutants.py [word ...]` breaks the code in one place at a time and runs the test that minds.

Each mutant is put into a temporary copy of the sources, never into these. One that its test does not catch survives:
then the test, or the code that nothing tests, is missing something. The words choose mutants by their names.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Mutant(NamedTuple):
    """One change, and the test that must fail with it."""

    name: str
    file: str
    old: str
    new: str
    test: str


MATCH, FLOW = "simcore/match/match.py", "simcore/match/piece_flow.py"
MANAGER = "simcore/pieces/piece_manager.py"
MANIPULATORS, ROBOT = "tests/physics/test_manipulators.py", "tests/physics/test_robot.py"
SHOOTER = "tests/unit/pieces/test_shooter.py"
MATCHES, REPEATS = "tests/games/test_game_matches.py", "tests/games/test_game_repeats.py"

MUTANTS = (
    Mutant("mechanism currents not on the battery", MATCH, "other_current = robot.mechanism_current",
           "other_current = 0.0",
           "tests/games/test_robot_power.py::test_mechanisms_load_the_battery_and_estimates_do_not"),
    Mutant("intake takes what flies", FLOW, "near & (state.status[slots] != PieceStatus.IN_FLIGHT)", "near",
           f"{MANIPULATORS}::test_a_piece_in_flight_is_not_taken_until_it_has_touched_something"),
    Mutant("launch ignores the time flown", "simcore/pieces/shooter.py", "flown = dt - launch.delay", "flown = 0.0",
           f"{SHOOTER}::test_a_shot_in_the_course_of_a_tick_flies_for_the_rest_of_it"),
    Mutant("set_alliance does not tell the gyro", "simcore/robot/robot.py",
           "self.gyro.reset(yaw=self.gyro.yaw, true_yaw=pose[2])", "pass",
           f"{MATCHES}::test_set_alliance_puts_a_robot_on_the_other_side_while_its_gyro_keeps_its_reading"),
    Mutant("a carried robot keeps its last sub-step", "simcore/robot/chassis.py",
           "        self._h_before = 0.0\n        self.read()", "        self.read()",
           f"{ROBOT}::test_a_robot_that_is_carried_forgets_how_it_moved"),
    Mutant("a wall pushes back with 15 g", "simcore/robot/chassis.py", "_MOST_RESISTANCE = 1.5",
           "_MOST_RESISTANCE = 15.0", f"{ROBOT}::test_a_wall_pushes_back_with_no_more_than_a_tire_could_stand"),
    Mutant("gyro samples of a camera are not interpolated", "simcore/vision/heading.py",
           "+ s * (self._values[k] - self._values[k - 1])", "+ 0.0",
           "tests/unit/vision/test_heading.py::test_readings_are_interpolated_and_late_ones_dropped"),
    Mutant("a guarded piece may sleep", MANAGER, " & ~self._guarded[awake]", "",
           f"{MANIPULATORS}::test_a_piece_near_a_moving_robot_does_not_sleep"),
    Mutant("digest without status", MATCH, "update(state.pos[awake], state.status.astype(np.int64))",
           "update(state.pos[awake])", f"{REPEATS}::test_a_piece_that_changes_its_status_only_changes_the_digest"),
    Mutant("no supply limit on feeding back", "simcore/robot/tire_solver.py", " or v * i < -power:", ":",
           f"{ROBOT}::test_a_supply_limit_holds_while_the_motors_feed_the_battery"),
    Mutant("storage takes one too many", FLOW, "[: max(0, robot.storage.room)]", "[: max(0, robot.storage.room + 1)]",
           f"{MANIPULATORS}::test_no_more_pieces_are_taken_than_there_is_room_for"),
    # of the match and the robot's parts
    Mutant("intake looks at the present only", FLOW, "intake.captured(before, now)", "intake.captured(now, now)",
           f"{MANIPULATORS}::test_a_piece_that_passes_the_zone_between_two_ticks_is_taken"),
    Mutant("a second auto keeps the shots", MATCH, "            self.flow.clear()\n", "",
           f"{REPEATS}::test_a_second_auto_begins_at_zero"),
    Mutant("the start of a mode keeps the ticks", "simcore/match/clock.py",
           "        self._ticks = 0\n        self.time = self._start", "        self.time = self._start",
           "tests/unit/match/test_clock.py::test_a_driver_station_starts_and_stops_the_time"),
    Mutant("a sum of ticks", "simcore/match/clock.py", "self.time = self._start + self._ticks * dt", "self.time += dt",
           "tests/unit/match/test_clock.py::test_the_time_of_many_ticks_is_their_number_times_their_length"),
    Mutant("a mirrored heading is turned", "simcore/geometry/symmetry.py", "else math.pi - yaw", "else yaw + math.pi",
           "tests/unit/geometry/test_symmetry.py"),
    Mutant("held pieces are shown unturned", "simcore/match/publish.py", "dx, dy, dz = rotate(c.quat, pos)",
           "dx, dy, dz = pos", f"{MANIPULATORS}::test_a_released_piece_has_velocity_and_attitude_of_the_grip"),
    Mutant("a disabled robot's mechanisms run on", "simcore/robot/robot.py",
           "self.battery.browned_out or not self.drive.enabled", "self.battery.browned_out",
           "tests/games/test_robot_power.py::test_a_disabled_robot_coasts_and_goes_on_when_enabled_again"),
    Mutant("a released piece does not turn with the robot", "simcore/robot/robot.py",
           "(ox + wy * lz - wz * ly + vx, oy + wz * lx - wx * lz + vy, oz", "(ox + vx, oy + vy, oz",
           f"{MANIPULATORS}::test_a_released_piece_has_velocity_and_attitude_of_the_grip"),
    Mutant("the last in leaves first", "simcore/pieces/storage.py", '0 if self.config.order == "fifo" else -1', "-1",
           "tests/unit/pieces/test_storage.py::test_pieces_leave_in_their_order"),
    Mutant("topspin for backspin", "simcore/pieces/shooter.py", "(lower.velocity - upper.velocity)",
           "(upper.velocity - lower.velocity)",
           f"{SHOOTER}::test_two_wheels_throw_with_their_mean_and_spin_by_their_difference"),
    Mutant("a full placer takes more", "simcore/pieces/placer.py", "self.piece is None and self._mech", "self._mech",
           f"{MANIPULATORS}::test_a_full_placer_takes_nothing_more"),
    Mutant("the rung does not load the climber", "simcore/robot/climber.py", "set_load(effort * joint.ratio)",
           "set_load(0.0)", "tests/physics/test_climber.py::test_it_lifts_itself_and_the_forces_balance"),
)  # fmt: skip


def survives(mutant: Mutant, folder: Path) -> bool:
    """Whether its test passes all the same, in a copy of the sources."""
    path = folder / mutant.file
    text = path.read_text()
    if text.count(mutant.old) == 0:
        raise SystemExit(f"{mutant.name}: {mutant.file} does not hold {mutant.old!r} any more")
    path.write_text(text.replace(mutant.old, mutant.new))
    try:
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", mutant.test]
        environment = {**os.environ, "PYTHONPATH": str(folder), "SIMCORE_COMPILED": "0", "PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    finally:
        path.write_text(text)
    if done.returncode not in (0, 1):  # no such test, or it cannot be imported
        raise SystemExit(f"{mutant.name}: {mutant.test} did not run\n{done.stdout[-2000:]}{done.stderr[-500:]}")
    return done.returncode == 0


def main(words: list[str]) -> int:
    """Try all mutants, or those whose name holds one of the words; 1 if one survives."""
    chosen = [m for m in MUTANTS if not words or any(word in m.name for word in words)]
    left = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("simcore", "games", "models", "tests", "scripts", "conftest.py", "pyproject.toml"):
            source = ROOT / part
            if source.is_dir():
                shutil.copytree(source, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, folder / part)
        for mutant in chosen:
            is_left = survives(mutant, folder)
            left += is_left
            print(f"{'SURVIVED' if is_left else 'caught':8}  {mutant.name}", flush=True)
    print(f"{len(chosen) - left} of {len(chosen)} caught")
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
