"""Mutants: `python scripts/mutants.py [word ...]` breaks the code in one place at a time and runs the test for it.

Each mutant is made in a temporary copy of the sources. A mutant that its test does not catch survives: then the test is
too weak, or the code has no effect. The words choose mutants by their names.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Mutant(NamedTuple):
    """Change of the code, with the test that must fail with it."""

    name: str
    file: str
    old: str
    new: str
    test: str


MATCH, FLOW = "simcore/match/match.py", "simcore/match/piece_flow.py"
MANAGER, BALLS = "simcore/pieces/piece_manager.py", "simcore/loop/balls.py"
MANIPULATORS, ROBOT = "tests/laws/test_manipulators.py", "tests/laws/test_robot.py"
SHOOTER, SHOTS = "tests/robot/test_shooter.py", "tests/laws/test_shots.py"
PATHS, PINS = "tests/laws/test_robot_paths.py", "tests/laws/test_pins.py"
RETURNED, MASSES = "tests/laws/test_returned_pieces.py", "tests/laws/test_moving_mass.py"
ROBOTS, BUMPERS = "simcore/loop/robots.py", "simcore/loop/bumpers.py"
FOULS, REEF = "tests/games/test_rebuilt_fouls.py", "tests/games/test_reefscape_match.py"
BATTERY, STAGE = "tests/robot/test_battery.py", "simcore/robotcode/emulator/output_stage.py"
BODY, BODIES = "simcore/loop/body.py", "tests/loop/test_body.py"
PLAIN = (BATTERY, BODIES)
"""Tests that need no compiler, which takes minutes after a change of the loop."""
WATCH, WATCHED = "simcore/robotcode/sim/belief_watch.py", "tests/robotcode/sim/test_belief_watch.py"
POLICY = "tests/games/test_human_actions.py::test_the_policy_keeps_eight_fuel_for_robots_and_feeds_waiting_robots"
MATCHES, REPEATS = "tests/games/test_game_matches.py", "tests/games/test_game_repeats.py"

MUTANTS = (
    Mutant("a shot does not push the robot", FLOW, "robot.balance.exchange(-mass,", "robot.balance.exchange(0.0,",
           f"{MASSES}::test_the_recoil_of_a_shot_pushes_the_robot"),
    Mutant("what is held weighs nothing", FLOW, "robot.balance.update(self._pieces.mass, self._pieces.radius)", "pass",
           f"{MASSES}::test_fifty_fuel_in_the_hopper_slow_the_acceleration"),
    Mutant("contacts on MuJoCo have no restitution", "simcore/world/contact_law.py",
           "np.interp(restitution, places", "np.interp(0.0, places",
           "tests/world/test_contact_law.py::test_a_spring_and_a_damper_produce_the_configured_restitution"),
    Mutant("foam does not get harder", "simcore/loop/contact.py", "+ cubic * depth * depth * depth", "",
           "tests/loop/test_contact.py::test_foam_between_two_plates_exerts_the_force_in_the_makers_report"),
    Mutant("dense foam is soft", "simcore/loop/contact.py", "force += hard * over * over", "pass",
           f"{PINS}::test_a_ball_pinned_by_a_robot_stays_in_front_of_the_wall"),
    Mutant("friction forgets", BALLS, "if is_new:\n        x = y", "if True:\n        x = y",
           "tests/laws/test_ball_laws.py::test_a_ball_squeezed_between_two_walls_is_held_by_friction"),
    Mutant("balls roll on without loss", BALLS, "h * (rolling * turnability / size +", "h * (0.0 +",
           "tests/laws/test_ball_laws.py::test_rolling_resistance_slows_a_rolling_ball"),
    Mutant("edges within a floor are felt", BALLS, "if n > 1:", "if False:",
           "tests/laws/test_ball_laws.py::test_a_ball_that_rolls_over_seams_keeps_its_path"),
    Mutant("sleepers are not woken", BALLS, "    status[i] = AWAKE\n", "    pass\n",
           "tests/laws/test_sleeping.py"),
    Mutant("pieces that moved are shown where they were", MANAGER, "        self._pool.changes += 1\n        moving",
           "        moving", "tests/laws/test_shown_pieces.py::test_exactly_the_pieces_on_the_field_are_published"),
    Mutant("launch ignores the time flown", FLOW, "self._pieces.fly(slot, TICK - launch.delay)", "pass",
           f"{SHOTS}::test_a_shot_of_a_moving_robot_leaves_the_muzzle_at_its_scheduled_time"),
    Mutant("pieces come back in a pile", MANAGER,
           "and not (_squares(taken", "and True or (_squares(taken",
           f"{RETURNED}::test_thirty_shots_out_of_the_field_return_without_overlap"),
    Mutant("what rests behind a wall stays there", MANAGER, "if out.any():", "if False:",
           f"{RETURNED}::test_a_piece_at_rest_behind_or_on_a_wall_returns_to_the_field"),
    Mutant("a robot is put on fuel", MANAGER, "for slot in here[np.any(inside, axis=0)].tolist():", "for slot in ():",
           f"{RETURNED}::test_a_robot_is_never_placed_on_fuel"),
    Mutant("intake takes what flies", FLOW, "near &= ~self._pieces.is_untouched[slots]", "",
           f"{MANIPULATORS}::test_a_piece_in_flight_is_not_taken_until_it_touches_something"),
    Mutant("set_alliance does not tell the gyro", "simcore/robot/robot.py",
           "self.gyro.reset(yaw=yaw, true_yaw=pose[2])", "pass",
           f"{MATCHES}::test_set_alliance_moves_a_robot_to_the_other_side_and_keeps_its_gyro_reading"),
    Mutant("gyro samples of a camera are not interpolated", "simcore/vision/heading.py",
           "(time - times[k - 1]) / (times[k] - times[k - 1]))", "0.0)",
           "tests/vision/test_heading.py::test_readings_are_interpolated_and_late_readings_are_dropped"),
    Mutant("digest without status", "simcore/match/match.py",
           "update(state.pos.take(awake, axis=0), state.status)", "update(state.pos[awake])",
           f"{REPEATS}::test_changing_only_the_status_of_a_piece_changes_the_digest"),
    Mutant("no supply limit on feeding back", "simcore/loop/motor.py", "drawn > power or drawn < -power:",
           "drawn > power:", f"{ROBOT}::test_a_supply_limit_also_holds_while_the_motors_feed_the_battery"),
    Mutant("storage takes one too many", FLOW, "_room_behind(robot, intake))]", "_room_behind(robot, intake) + 1)]",
           f"{MANIPULATORS}::test_an_intake_takes_no_more_pieces_than_there_is_room_for"),
    # of the match and the robot's parts
    Mutant("intake looks at the present only", FLOW, "intake.captured(before, now)", "intake.captured(now, now)",
           f"{MANIPULATORS}::test_a_piece_that_crosses_the_intake_zone_between_two_ticks_is_taken"),
    Mutant("a second auto keeps the shots", MATCH, "            self.record.forget_pieces()\n", "",
           f"{REPEATS}::test_a_second_auto_begins_with_time_and_score_at_zero"),
    Mutant("the start of a mode keeps the ticks", "simcore/match/clock.py",
           "        self._ticks = 0\n        self.time = self._start", "        self.time = self._start",
           "tests/match/test_clock.py::test_a_driver_station_starts_and_stops_the_match_time"),
    Mutant("a sum of ticks", "simcore/match/clock.py", "self.time = self._start + self._ticks * dt", "self.time += dt",
           "tests/match/test_clock.py::test_the_time_of_many_ticks_is_exactly_their_number_times_their_length"),
    Mutant("a mirrored heading is turned", "simcore/world/symmetry.py", "else math.pi - yaw", "else yaw + math.pi",
           "tests/world/test_symmetry.py"),
    Mutant("held pieces are shown unturned", "simcore/robot/components.py",
           "x, y, z = rotate((q[4], q[5], q[6], q[3]), p[0], p[1], p[2])", "x, y, z = p[0], p[1], p[2]",
           "tests/robot/test_components.py::test_carried_pieces_follow_the_pose_of_their_robot"),
    Mutant("a disabled robot's mechanisms run on", ROBOTS, "if battery.is_off or not robot.request.is_enabled:",
           "if battery.is_off:",
           "tests/games/test_robot_power.py::test_a_disabled_robot_coasts_and_continues_when_enabled_again"),
    Mutant("a released piece does not turn with the robot", "simcore/robot/robot.py",
           "(ox + wy * lz - wz * ly + vx, oy + wz * lx - wx * lz + vy, oz", "(ox + vx, oy + vy, oz",
           f"{MANIPULATORS}::test_a_released_piece_has_the_velocity_and_attitude_of_the_gripper"),
    Mutant("the last in leaves first", "simcore/robot/storage.py", '0 if self.config.order == "fifo" else -1', "-1",
           "tests/robot/test_storage.py::test_pieces_leave_a_storage_in_the_configured_order"),
    Mutant("topspin for backspin", "simcore/robot/shooter.py", "yaw - 0.5 * math.pi, 0.0",
           "yaw + 0.5 * math.pi, 0.0",
           f"{SHOOTER}::test_two_wheels_throw_at_their_mean_speed_and_spin_by_their_difference"),
    Mutant("a full placer takes more", "simcore/robot/placer.py", "if self.piece is not None or (", "if (",
           f"{MANIPULATORS}::test_a_full_placer_takes_no_second_piece"),
    Mutant("the rung does not load the climber", "simcore/robot/climber.py", "set_load(effort * joint.ratio)",
           "set_load(0.0)", "tests/laws/test_climber.py::test_a_climber_lifts_its_robot_and_the_forces_balance"),
    # of paths, rolling balls, shots and meshes
    Mutant("long steps", "simcore/loop/robot_state.py", "STEP = 1e-3", "STEP = 5e-3",
           f"{PATHS}::test_a_path_hardly_depends_on_the_step_length"),
    Mutant("a held azimuth has no supply limit", "simcore/loop/shaft.py", "power = s.request.supply_limit * supply",
           "power = math.inf",
           "tests/robot/test_swerve_drive.py::test_a_stalled_steer_motor_keeps_its_supply_limit"),
    Mutant("a shot leaves before the gate opens", "simcore/robot/shooter.py", "self._opening() * TICK", "0.0",
           f"{SHOOTER}::test_no_shot_leaves_before_the_gate_has_opened"),
    Mutant("all shots of a tick have the aim of its end", "simcore/robot/shooter.py", "if before is None:", "if True:",
           f"{SHOOTER}::test_a_shot_within_a_tick_has_the_aim_at_the_time_of_its_release"),
    Mutant("a muzzle in a wall shoots", FLOW, "return not obstacles[-1]", "return True",
           f"{SHOTS}::test_a_muzzle_inside_the_alliance_wall_holds_fire_until_the_robot_backs_off"),
    Mutant("a wheel gives a ball no spin", "simcore/robot/shooter.py", "share = 0.2 * self", "share = 0.0 * self",
           f"{SHOOTER}::test_a_ball_on_a_fixed_hood_takes_seven_tenths_of_its_momentum_from_the_wheel"),
    Mutant("the cloth of bumpers does not matter", BUMPERS, "part.model.friction * one.friction", "one.friction",
           "tests/laws/test_bumper_contact.py::test_friction_with_a_wall_slows_a_robot_pushed_along_it_by_mu_n"),
    Mutant("plates on the side of the fewer faces", "simcore/world/mesh.py",
           "areas[turned].sum() > areas[~", "areas[turned].sum() < areas[~", "tests/laws/test_sheets.py"),
    Mutant("odometry goes along chords", "simcore/robot/robot.py",
           "s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn", "s, c = 1.0, 0.0",
           "tests/laws/test_swerve_odometry.py::test_odometry_of_one_long_sample_ends_on_the_circle"),
    Mutant("last bits are an effect", "simcore/sweep/sweep_statistics.py",
           "np.isclose(a, b, rtol=5e-4, atol=1e-6)", "a != a",
           "tests/sweep/test_sweep_statistics.py::test_a_difference_below_the_printed_digits_counts_as_zero"),
    Mutant("fuel over the guardrail is counted for all robots", "games/rebuilt/fouls.py",
           "before = self._thrown.get(robot, 0)", "before = sum(self._thrown.values())",
           "tests/games/test_rebuilt_fouls.py::test_g405_counts_per_robot_and_only_for_fuel_that_touched_nothing"),
    Mutant("a gap does not end a closed passage", "games/rebuilt/fouls.py",
           "+ TICK if closed else 0.0", "+ TICK * closed",
           "tests/games/test_rebuilt_fouls.py::test_g419_the_three_seconds_restart_after_a_gap"),
    Mutant("a pin goes on where both have moved", "simcore/match/foul_book.py",
           "max(apart, moved) >=", "apart >=",
           "tests/games/rebuilt/test_scoring.py::test_g418_a_pin_count_ends_three_seconds_after_either_robot_leaves"),
    Mutant("a recoil has no lever", "simcore/robot/robot.py",
           "px, py, pz = m * (px - mx), m * (py - my), m * (pz - mz)", "px, py, pz = 0.0, 0.0, 0.0",
           f"{MASSES}::test_an_off_center_shot_turns_the_robot"),
    Mutant("any type is taken for a config", "simcore/quantities.py", "fits = isinstance(value, kind)", "fits = True",
           "tests/test_config_types.py"),
    Mutant("robots stand where others are in the next tick", "simcore/match/starts.py",
           "ox + TICK * vx", "ox",
           "tests/games/test_placing.py::test_a_robot_cannot_be_placed_where_another_robot_will_be_in_the_next_tick"),
    # of rules, sweeps and pieces without a test before
    Mutant("robots that drive close a passage", "games/rebuilt/fouls.py", "< _STANDS", "< 99.0",
           f"{FOULS}::test_g419_also_applies_to_bumps_with_robots_at_rest"),
    Mutant("bumps are no passages", "games/rebuilt/fouls.py", "for y in (dim.BUMP_LEFT_Y, dim.BUMP_RIGHT_Y)",
           "for y in (1e3,)", f"{FOULS}::test_g419_also_applies_to_bumps_with_robots_at_rest"),
    Mutant("a fuel that came to rest is still a shot", "games/rebuilt/fouls.py", "            del self._shots[slot]\n",
           "            pass\n", f"{FOULS}::test_fuel_that_has_come_to_rest_is_no_longer_a_shot_of_its_shooter"),
    Mutant("partners may not touch at the tower", "games/rebuilt/fouls.py",
           "match.alliances[number] != match.alliances[other] and self._is", "self._is",
           f"{FOULS}::test_g420_gives_level_3_to_a_robot_off_the_carpet_and_does_not_apply_to_partners"),
    Mutant("who holds fuel of a hub for a moment keeps it", "games/rebuilt/fouls.py", "match.time - since > _MOMENT",
           "match.time - since > 0.0", f"{FOULS}::test_g408_catching_and_keeping_fuel_out_of_a_hub_is_a_foul"),
    Mutant("fuel of the pause is none of auto", "games/rebuilt/scoring.py", '"pause": "auto"', '"pause": "transition"',
           "tests/games/rebuilt/test_scoring.py::test_fuel_counts_in_the_periods_stated_in_the_manual"),
    Mutant("both have to move on from a pin", "simcore/match/foul_book.py", "moved = max(math.dist",
           "moved = min(math.dist",
           "tests/games/rebuilt/test_scoring.py::test_g418_a_pin_count_ends_three_seconds_after_either_robot_leaves"),
    Mutant("a coral that is knocked off fell by itself", "games/reefscape/fouls.py",
           "self._match.time - time < _KNOCKED", "False",
           "tests/games/test_reefscape_fouls.py::test_g410_also_applies_to_a_coral_knocked_off_the_opponents_reef"),
    Mutant("a robot leaves with its center", "games/reefscape/rules.py", "x.max() < dim.STARTING_LINE_X",
           "x.mean() < dim.STARTING_LINE_X",
           f"{REEF}::test_a_robot_leaves_only_if_all_bumpers_are_off_the_starting_line"),
    Mutant("ranking points before the assessment", "games/reefscape/rules.py", "0 if is_early or", "0 if",
           f"{REEF}::test_after_the_assessment_a_win_gives_three_ranking_points_and_a_tie_gives_one"),
    Mutant("one robot leaves for all", "games/reefscape/rules.py", "bool(robots) and all(", "bool(robots) and any(",
           f"{REEF}::test_the_auto_ranking_point_needs_all_robots_to_leave_and_one_coral"),
    Mutant("rows are written once or never", "simcore/sweep/run_store.py",
           '            self._problem = ""\n            self', '            self._problem = ""\n        self',
           "tests/sweep/test_run_store.py::test_rows_that_could_not_be_written_are_tried_again"),
    Mutant("a late hit lands where it was after 2 s", "simcore/match/run_record.py",
           "shot.points.append(place)", "pass",
           "tests/sweep/test_run_metrics.py"),
    Mutant("the first in leaves a hopper first", "simcore/robot/hopper.py", "np.argsort(-ahead, kind",
           "np.argsort(0.0 * ahead, kind",
           "tests/robot/test_hopper.py::test_the_foremost_ball_leaves_first_for_any_order_of_arrival"),
    Mutant("two wheels lose what foam takes twice", "simcore/robot/shooter.py",
           "self.config.compression_loss / len(self._wheels)", "self.config.compression_loss",
           f"{SHOOTER}::test_slip_depends_on_piece_size_and_a_compression_loss_slows_the_wheel"),
    Mutant("who is put somewhere drives there", "simcore/match/run_record.py",
           "        self._place = pose[:2]\n        self.placements", "        self.placements",
           "tests/games/test_placing.py::test_a_robot_cannot_be_placed_where_another_robot_will_be_in_the_next_tick"),
    Mutant("a driver's robot starts at the speed of before", "simcore/match/players/driven_robot.py",
           "time > self._last + 1.5 * TICK", "False",
           "tests/match/players/test_driven_robot.py::test_a_robot_accelerates_from_rest_after_it_was_disabled"),
    Mutant("pairs of a seed are its first", "simcore/sweep/results.py", "np.mean(pairs, axis=0)", "pairs[0]",
           "tests/sweep/test_results.py::test_all_pairs_of_a_seed_count_as_one_mean_difference"),
    Mutant("robots stand where others turn to in the next tick", "simcore/match/starts.py",
           "from_yaw(TICK * other.chassis.rate[2])", "from_yaw(0.0)",
           "tests/games/test_placing.py::"
           "test_a_robot_cannot_be_placed_where_a_turning_robot_will_reach_in_the_next_tick"),
    Mutant("balls do not spin where they hit each other", BALLS, "vel[b, 0] - (wy * nz - wz * ny)", "vel[b, 0]",
           "tests/laws/test_ball_laws.py::"
           "test_head_on_balls_with_equal_spin_deflect_by_mu_times_the_normal_impulse"),
    Mutant("balls do not spin where they hit the field", BALLS, "vx - lever * (sy * nz - sz * ny)", "vx",
           "tests/laws/test_ball_laws.py::test_a_spinning_ball_gains_mu_times_its_normal_velocity_change_sideways"),
    Mutant("what turns has no surface speed", BALLS, "moving[b, 0] + turning[b, 1] * az - turning[b, 2] * ay",
           "moving[b, 0]",
           "tests/laws/test_ball_laws.py::test_a_ball_falling_on_a_turning_body_is_dragged_along_its_surface"),
    Mutant("no air where a ball touches", BALLS,
           "vx, vy, vz, sx, sy, sz, air[i, 0], air[i, 1], air[i, 2])",
           "vx, vy, vz, sx, sy, sz, air[i, 0] if touched == 0 else 0.0, air[i, 1], air[i, 2])",
           "tests/laws/test_ball_laws.py::test_air_drag_slows_a_rolling_ball_like_a_flying_ball"),
    Mutant("bounces gain energy", "simcore/loop/contact.py", "turned = 4.0 *", "turned = -4.0 *",
           "tests/laws/test_ball_laws.py::test_a_bounce_has_the_restitution_of_its_pair"),
    Mutant("a ball that is put into an element is thrown out", BALLS,
           "max(0.0, depth - max(0.0, closing) * h) if is_put else 0.0", "0.0",
           "tests/laws/test_ball_laws.py::"
           "test_a_ball_placed_inside_an_element_leaves_the_element_without_gaining_energy"),
    Mutant("what is put down remembers what it touched before", BALLS,
           "stamp[i, m] < now - 1 or is_put[i] == JUST_PUT", "stamp[i, m] < now - 1",
           "tests/games/test_random_games.py::test_a_random_game_satisfies_all_laws_and_repeats_identically"),
    Mutant("coral is dropped into the alliance wall", "games/reefscape/human_players.py",
           "min(max(aside, -_HALF_DROP), _HALF_DROP)", "min(max(aside, -_HALF_CHUTE), _HALF_CHUTE)",
           "tests/games/test_random_games.py::test_a_random_game_satisfies_all_laws_and_repeats_identically"),
    Mutant("coral is put into the reef", MANAGER, "self._is_ball[slot] else _DEEPEST):",
           "self._is_ball[slot] else 9.0):",
           "tests/games/test_random_games.py::test_a_random_game_satisfies_all_laws_and_repeats_identically"),
    # of human players, ranking points, batteries, pages and the check of odometry
    Mutant("a battery charges above full", "simcore/loop/battery.py", "min(1.0, max(0.0, b.charge",
           "(max(0.0, b.charge", f"{BATTERY}::test_the_charge_falls_by_the_ampere_hours_drawn_and_stays_in_range"),
    Mutant("a brownout ends at its level", "simcore/loop/battery.py", " or (b.is_low and v == level)", "",
           f"{BATTERY}::test_a_brownout_begins_below_6_75_volts_and_ends_above_7_5_volts"),
    Mutant("60 tower points are not yet enough", "games/rebuilt/rules.py", "tower >= event.traversal",
           "tower > event.traversal", f"{FOULS}::test_the_score_sheet_adds_up_and_contains_the_ranking_points"),
    Mutant("100 fuel are not yet enough", "games/rebuilt/rules.py", "fuel >= event.energized",
           "fuel > event.energized", f"{FOULS}::test_the_score_sheet_adds_up_and_contains_the_ranking_points"),
    Mutant("ranking points while fuel still counts", "games/rebuilt/rules.py",
           "time < MATCH.duration + ASSESSMENT - 1e-9", "time < 0.0",
           f"{FOULS}::test_after_the_assessment_a_win_gives_three_ranking_points_and_a_tie_gives_one"),
    Mutant("a full robot is fed", "games/rebuilt/human_players.py", " and robot.storage.room", "", POLICY),
    Mutant("opponents are fed", "games/rebuilt/human_players.py", "if owner == alliance and is_there", "if is_there",
           POLICY),
    Mutant("robots that drive past a station are fed", "games/reefscape/human_players.py",
           " and robot.chassis.speed < _WAITING", "",
           f"{REEF}::test_human_players_feed_waiting_robots_and_throw_processed_algae"),
    Mutant("a torque current ignores the stator limit", STAGE, "min(abs(self.asked), self._stator_limit) if",
           "abs(self.asked) if", "tests/adapters/emulator/test_output_stage.py"),
    Mutant("a supply limit is lowered at once", STAGE, "self._over > self._lower_time > 0.0",
           "self._lower_time > 0.0",
           "tests/adapters/emulator/test_examples.py::test_current_limits_bound_stator_and_supply_current"),
    Mutant("pages that are behind get frames", "simcore/show/view_server.py",
           "if not is_frame or one.transport is None", "if True or one.transport is None",
           "tests/view/test_live.py::test_a_page_that_falls_behind_is_sent_everything_except_frames"),
    Mutant("bodies do not wobble", BODY, "(torque[0] - (iz - iy) * wy * wz) / ix", "torque[0] / ix",
           f"{BODIES}::test_a_body_turns_by_eulers_equations"),
    Mutant("an impulse has no lever about x", BODY, "    mx = ay * jz - az * jy\n    my", "    mx = 0.0\n    my",
           f"{BODIES}::test_an_impulse_changes_linear_and_angular_momentum"),
    Mutant("a robot is put into something and thrown out", BODY, "unexplained(depth, -out, h)", "0.0",
           f"{BODIES}::test_a_soft_contact_sticks_up_to_mu_n_then_slips_and_never_pulls"),
    Mutant("a contact pulls", BODY, "    if load <= 0.0:\n        spring", "    if load <= -1e9:\n        spring",
           f"{BODIES}::test_a_soft_contact_sticks_up_to_mu_n_then_slips_and_never_pulls"),
    Mutant("friction remembers what is over", BODY, "if one.key == key and one.stamp >= stamp - 1:",
           "if one.key == key:",
           f"{BODIES}::test_a_contact_keeps_its_spring_and_a_new_contact_replaces_the_oldest_contact"),
    Mutant("a box pushes out through its farthest face", BODY, "        if over > best:\n            best = over",
           "        if over < best:\n            best = over",
           f"{BODIES}::test_the_gap_of_a_point_is_its_signed_distance_from_the_box"),
    Mutant("left and right are never swapped", WATCH, "if mirrored > abs(size) + 0.1:", "if False:",
           f"{WATCHED}::test_a_fault_at_constant_heading_is_reported_with_its_cause"),
    Mutant("a heading that turns half as far again is right", WATCH,
           "most = _TURNED if 0.8 < self._share_of_turning() < 1.25 else _TURNED_WRONG", "most = _TURNED",
           f"{WATCHED}::test_a_fault_is_reported_once_with_its_cause"),
    Mutant("what a camera has seen is a step of the program", WATCH, "if abs(step) > _CARRIED[0]:", "if False:",
           f"{WATCHED}::test_a_fault_is_reported_once_with_its_cause"),
    Mutant("a meter that is a tenth long is told", WATCH, "max(_APART, _SHARE * self._way)", "_APART",
           f"{WATCHED}::test_nothing_is_reported_while_the_odometry_is_right"),
    Mutant("who pushes a disabled robot is told", WATCH, "or not is_driving or", "or",
           f"{WATCHED}::test_errors_while_disabled_or_after_a_reset_or_camera_correction_are_not_faults"),
)  # fmt: skip


def survives(mutant: Mutant, folder: Path) -> bool:
    """Return whether its test passes in a copy of the sources with the change."""
    path = folder / mutant.file
    text = path.read_text()
    if text.count(mutant.old) == 0:
        raise SystemExit(f"{mutant.name}: {mutant.file} does not hold {mutant.old!r} any more")
    path.write_text(text.replace(mutant.old, mutant.new))
    try:
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", mutant.test]
        environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
        environment |= {"NUMBA_DISABLE_JIT": "1"} if mutant.test.startswith(PLAIN) else {}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    finally:
        path.write_text(text)
    if done.returncode not in (0, 1):  # no such test, or it cannot be imported
        raise SystemExit(f"{mutant.name}: {mutant.test} did not run\n{done.stdout[-2000:]}{done.stderr[-500:]}")
    return done.returncode == 0


def main() -> int:
    """Try all mutants, or those whose name contains one of the words, and return 1 if one survives."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("words", nargs="*", metavar="WORD", help="try mutants whose name holds one of these")
    words = parser.parse_args().words
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
    sys.exit(main())
