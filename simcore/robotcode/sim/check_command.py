"""`simcore check`: run each mechanism of the described robot for a second and report implausible results.

The command also writes the results to a page, with a drawing of the robot and charts of the wheel speeds for shots.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import ConfigError, SimcoreError
from simcore.match.registry import find_game, game_names
from simcore.quantities import DeviceAddress
from simcore.robot.dc_motor import MotorModel
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.mechanisms import ArmSim, FlywheelSim, RackSim, RollerSim, place_text
from simcore.robot.robot_config import RobotConfig, tipping_limit
from simcore.robot.shooter import ShooterConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.init_command import survey
from simcore.robot_file.needed_speeds import NeededSpeed, elevations, goal_of, needed_speeds
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_findings import (
    CodeView,
    MechanismRun,
    RobotFinding,
    findings,
    reading_unit,
    run_findings,
    run_mechanism,
    speed_text,
    top_exit_speed,
)
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, RobotSettings, practice_match
from simcore.robot_file.template import FILE_NAME
from simcore.show.report import chart, headline, paragraph, report_page, robot_model, series, table
from simcore.telemetry.sinks import write_text

if TYPE_CHECKING:
    from simcore.match.game import Game

__all__ = ["add_arguments", "run", "surveyed_drivetrain"]

_STILL = 1e-6  # largest travel of a mechanism that does not move [rad]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `simcore check` to a parser."""
    parser.add_argument("project", nargs="?", type=Path, default=Path(), help="where robot.py is (default: here)")
    parser.add_argument(
        "--game", metavar="NAME", help="game to play; in a folder without a robot, check the game's own robot"
    )
    parser.add_argument("--out", type=Path, default=Path("out/robot.html"), help="the page (default: %(default)s)")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Subject:
    """Robot to check, with the game, settings and findings from the robot description file and the program."""

    name: str
    config: RobotConfig
    game: Game | None
    about: str
    """Text that states the source of the robot description."""
    settings: RobotSettings | None = None
    """Settings from the robot description file; None for a game's own robot."""
    codes: Mapping[str, CodeView] = field(default_factory=dict)
    """Controller configurations in the robot program, by mechanism name."""
    problems: Sequence[RobotFinding] = ()
    """Findings from the survey of the program and from the robot description file."""


def run(args: argparse.Namespace) -> int:
    """Check the robot, print the findings and write the page.

    Returns:
        Exit status: 1 if a finding is an error, else 0.

    Raises:
        ConfigError: The folder contains no robot, or the robot description is invalid.
        OutputError: The page cannot be written.
    """
    folder: Path = args.project
    has_robot = any((folder / name).is_file() for name in ("robot.py", FILE_NAME))
    if not has_robot and not args.game:
        raise ConfigError(
            f"no robot.py and no {FILE_NAME} in {folder.resolve()}: go to your robot project, name its folder "
            "(simcore check FOLDER), or check a game's own robot (simcore check --game NAME)"
        )
    subject = _described(folder, args.game) if has_robot else _own_robot(find_game(args.game))
    runs = [_run(name, subject) for name in subject.config.mechanisms]
    found = [
        *subject.problems,
        *findings(subject.config, game=subject.game, codes=subject.codes),
        *run_findings(runs),
    ]
    found.sort(key=lambda finding: not finding.is_wrong)
    said = [("wrong" if finding.is_wrong else "note", finding.text) for finding in found]
    wrong = len([finding for finding in found if finding.is_wrong])
    verdict = f"{wrong} wrong" if wrong else "nothing wrong"
    rows = _run_rows(runs, subject)
    shots = [*_shots(subject)]
    print(f"{subject.name}: {_figures(subject)}")
    print(subject.about)
    wide = [max((len(row[column]) for row in rows), default=0) for column in (0, 1)]
    for row in rows:
        print(f"  {row[0]:<{wide[0]}}  {row[1]:<{wide[1]}}  {row[2]}".rstrip())
    for line in (*shots, _tipping(subject)):
        print(f"  {line}")
    for word, text in said:
        print(f"{word}: {text}")
    write_text("page", args.out, _page(subject, verdict, said, rows, shots))
    print(f"{verdict}; the page is {args.out}")
    return 1 if wrong else 0


def _page(
    subject: _Subject,
    verdict: str,
    said: Sequence[tuple[str, str]],
    rows: Sequence[Sequence[str]],
    shots: Sequence[str],
) -> str:
    """Return the HTML page with the verdict, findings, robot drawing, mechanism runs and wheel speeds for shots."""
    from simcore.show.solids import described_solids  # takes half a second

    blocks = [headline(verdict.capitalize(), subject.about)]
    blocks += [table(("", "finding"), said)] if said else []
    blocks.append(robot_model("As described", subject.config.bumper, described_solids(subject.config)))
    blocks += [table(rows[0], rows[1:])] if rows else []
    for shooter in subject.config.shooters:
        needs = _needs(shooter, subject)
        if not needs:
            continue
        first = needs[0]
        tilt = f"up {math.degrees(first.elevation):.0f} deg, {first.speed:.1f} m/s"
        blocks.append(headline(f"{first.wheel_rps:.0f} turns/s from {first.distance:g} m", tilt))
        wheels = series("", [need.distance for need in needs], [need.wheel_rps for need in needs])
        blocks.append(chart("Wheels", [wheels], x_label="distance [m]", y_label="turns/s", from_zero=True))
    blocks.append(paragraph("\n".join([*map(str.strip, shots), _tipping(subject)])))
    return report_page(subject.name, blocks, subtitle=_figures(subject))


def _needs(shooter: ShooterConfig, subject: _Subject) -> list[NeededSpeed]:
    """Return the exit and wheel speeds needed for shots into a shooter's goal; empty without a game or a goal."""
    game = subject.game
    return [] if game is None or goal_of(shooter, game) is None else needed_speeds(shooter, subject.config, game)


# --- robot to check -----------------------------------------------------------------------------------------------


def _own_robot(game: Game) -> _Subject:
    name = f"{game.heading}: the game's own robot"
    return _Subject(name=name, config=game.robot(), game=game, about=f"described by the game {game.name}")


def _described(folder: Path, game_name: str | None) -> _Subject:
    """Return the robot of a project, with findings from the robot description file and the robot program.

    If the program is missing or cannot be built, the function uses the file alone, with a default drivetrain.
    """
    settings = read_settings(folder / FILE_NAME)
    named = game_name or settings.game
    game = find_game(named) if named or game_names() else None
    answer: dict[str, Any] = {}
    why_not = "there is no robot.py"
    if (folder / "robot.py").is_file():
        answer = survey((folder / "robot.py").resolve(), "described")
        why_not = answer.get("error", answer.get("not_modelled", ""))
    if why_not:
        answer = {}
    about = "as the program builds it and " if answer else f"robot program not read ({why_not}); as "
    about += f"{FILE_NAME} says" if (folder / FILE_NAME).is_file() else f"without a {FILE_NAME}"
    problems: list[RobotFinding] = []
    drivetrain: SwerveConfig | TankConfig | MecanumConfig = _assumed_drivetrain(settings)
    found = answer.get("drivetrain", {})
    if "model" in found:
        drivetrain = surveyed_drivetrain(found["model"])
        problems += [RobotFinding(line, is_wrong=False) for line in found["lines"]]
    else:
        is_wrong = (folder / "robot.py").is_file()
        why = f" ({found['problem'] if found else why_not})" if is_wrong else ""
        problems.append(RobotFinding(f"the drivetrain is a guess{why}: four modules", is_wrong=is_wrong))
    if (folder / "physics.py").is_file():
        problems.append(RobotFinding("physics.py is not read: its models may differ", is_wrong=False))
    codes: dict[str, CodeView] = {}
    if answer:
        motors = [_with_addresses(m) for m in answer["motors"]]
        settings = _with_program(settings, motors, answer["built"])
        codes = _codes(settings, motors)
        problems += _of_program(settings, motors)
    problems += [
        RobotFinding(f"{m.name}: guessed, as the file does not say: {m.guesses}", is_wrong=False)
        for m in settings.mechanisms
        if m.guesses
    ]
    config = settings.robot_config(drivetrain, storage=None if game is None else game.robot().storage)
    if game is not None:
        try:
            practice_match(game, settings, drivetrain).close()
        except SimcoreError as error:
            problems.append(RobotFinding(str(error)))
    return _Subject(
        name=folder.resolve().name, config=config, game=game, about=about, settings=settings, codes=codes,
        problems=problems,
    )  # fmt: skip


def _assumed_drivetrain(settings: RobotSettings) -> SwerveConfig:
    """Return a default swerve drive, with four modules 15 cm inside the outer edges of the bumpers."""
    length, width = settings.bumper or (0.83, 0.83)
    module = SwerveModuleConfig(x=0.0, y=0.0)
    return SwerveConfig.rectangle(length - 0.3, width - 0.3, module, mass=settings.mass)


def surveyed_drivetrain(answer: dict[str, Any]) -> SwerveConfig | TankConfig | MecanumConfig:
    """Return the drivetrain configuration for the drivetrain model in a survey answer."""
    fields = {name: value for name, value in answer.items() if name not in ("kind", "positions", "lowered")}
    fields["center_of_mass"] = tuple(fields["center_of_mass"])
    if answer["kind"] == "swerve":
        modules = tuple(
            SwerveModuleConfig(**{**m, **{key: MotorModel(**m[key]) for key in ("drive_motor", "steer_motor")}})
            for m in answer["modules"]
        )
        return SwerveConfig(**{**fields, "modules": modules})
    fields["motor"] = MotorModel(**fields["motor"])
    if answer["kind"] == "mecanum":
        return MecanumConfig(**{**fields, "places": tuple(tuple(place) for place in fields["places"])})
    return TankConfig(**{**fields, "wheel_xs": tuple(fields["wheel_xs"])})


def _with_addresses(motors: dict[str, Any]) -> dict[str, Any]:
    """Return a survey row with leader, followers and opposed followers converted to `DeviceAddress`."""
    rows = {key: [DeviceAddress.parse(one) for one in motors[key]] for key in ("followers", "opposed")}
    return {**motors, **rows, "leader": DeviceAddress.parse(motors["leader"])}


def _with_program(
    settings: RobotSettings, motors: Sequence[dict[str, Any]], built: Sequence[tuple[str, int | str]]
) -> RobotSettings:
    """Return the settings, with buses, gearings and inertias from the program if the file gives no values.

    Args:
        settings: Settings from the robot description file.
        motors: Survey rows of the motors.
        built: Model and address of every device.
    """
    configured = {(m["controller"], m["leader"]): (m["gearing"], m["inertia"]) for m in motors if "inertia" in m}
    addresses = [(model, DeviceAddress.parse(address)) for model, address in built]
    found = [m.among([at for model, at in addresses if at and model == m.controller]) for m in settings.mechanisms]
    mechanisms = [
        m.with_program(*configured[m.controller, m.leader]) if (m.controller, m.leader) in configured else m
        for m in found
    ]
    return replace(settings, mechanisms=tuple(mechanisms))


def _codes(settings: RobotSettings, motors: Sequence[dict[str, Any]]) -> dict[str, CodeView]:
    views = {(m["controller"], m["leader"]): m["code"] for m in motors if m["code"] is not None}
    return {
        m.name: CodeView(**views[m.controller, m.leader])
        for m in settings.mechanisms
        if (m.controller, m.leader) in views
    }


def _of_program(settings: RobotSettings, motors: Sequence[dict[str, Any]]) -> Iterator[RobotFinding]:
    """Yield a finding for each motor that the program does not build or that has another direction than in the file."""
    opposed = {
        (m["controller"], number): number in m["opposed"] for m in motors for number in (m["leader"], *m["followers"])
    }
    for m in settings.mechanisms:
        for number in () if m.controller in PORT_CONTROLLERS else m.devices:
            key = (m.controller, number)
            if key not in opposed:
                there = ", ".join(str(at) for model, at in sorted(opposed) if model == m.controller)
                none = f"besides its drivetrain the program builds no {m.controller} {number}"
                yield RobotFinding(f"{m.name}: {none}; it builds [{there}]")
            elif number != m.leader and opposed[key] != (number in m.opposed):
                said = f"{'opposes' if opposed[key] else 'is aligned with'} its leader in the program"
                yield RobotFinding(f"{m.name}: {m.controller} {number} {said}, but not in the file: look at opposed")


# --- output -------------------------------------------------------------------------------------------------------


def _figures(subject: _Subject) -> str:
    body, drivetrain = subject.config.body, subject.config.drivetrain
    text = f"{body.mass:g} kg, bumpers {body.bumper_length:.3g} x {body.bumper_width:.3g} m, "
    if isinstance(drivetrain, SwerveConfig):
        one = drivetrain.modules[0]
        speed = one.drive_motor.free_speed / one.drive_gearing * one.wheel_radius
        text += f"{len(drivetrain.modules)} swerve modules, {speed:.1f} m/s free speed"
    else:
        kind = "mecanum" if isinstance(drivetrain, MecanumConfig) else "tank"
        speed = drivetrain.motor.free_speed / drivetrain.gearing * drivetrain.wheel_radius
        text += f"{kind} drive, {speed:.1f} m/s free speed"
    if subject.settings is None:
        return text
    x, y, heading = subject.settings.start
    starts = subject.settings.auto_starts
    text += f"; starts at ({x:g}, {y:g}) m, {math.degrees(heading):.0f} deg"
    return text + (f", {len(starts)} autos elsewhere" if starts else "")


def _run(name: str, subject: _Subject) -> tuple[MechanismRun, MechanismRun | None]:
    """Run a mechanism for a second at full positive output, and return the result.

    If the mechanism has not moved, the second return value is the result at full negative output, else None.
    """
    settings = subject.settings
    is_reversed = settings is not None and settings.mechanism(name).reversed
    config, code = subject.config.mechanisms[name], subject.codes.get(name)
    first = run_mechanism(name, config, code=code, reversed=is_reversed)
    if abs(first.travel) > _STILL:
        return first, None
    return first, run_mechanism(name, config, code=code, reversed=is_reversed, output=-1.0)


def _run_rows(
    runs: Sequence[tuple[MechanismRun, MechanismRun | None]], subject: _Subject
) -> list[tuple[str, str, str]]:
    """Return table rows (name, motion, sensor reading) of the mechanism runs, with a header row; empty without runs."""
    rows = []
    for run, back in runs:
        text = _motion(run, subject)
        if back is not None:
            text += f"; - output: {_motion(back, subject)}"
        rows.append((run.name, text, _reading(back or run)))
    head = ("mechanism", "full + output for a second", "what robot code reads" if any(row[2] for row in rows) else "")
    return [head, *rows] if rows else []


def _motion(run: MechanismRun, subject: _Subject) -> str:
    mechanism = run.mechanism
    word = _words(run, subject)[0 if run.sign > 0.0 else 1]
    if abs(run.travel) <= _STILL:
        if run.soft_limit is not None:
            return f"{word}: held at its soft limit"
        return (
            f"{word}: at its stop, {place_text(mechanism, run.position)}" if run.stop is not None else "does not move"
        )
    if run.sign * run.travel < 0.0:
        return f"told to move {word}, but falls: too weak for its weight"
    text = f"{word}, {speed_text(mechanism, run.speed)}"
    if isinstance(mechanism, FlywheelSim | RollerSim):
        when = " and rising" if run.is_rising else f" after {run.spin_up:.2f} s"
        return f"{text}{when}{_purpose(run, subject)}"
    if run.stop is not None:
        return f"{text}, stop at {place_text(mechanism, run.position)} after {run.stop:.2f} s"
    if run.soft_limit is not None:
        return f"{text}, soft limit at {place_text(mechanism, run.position)} after {run.soft_limit:.2f} s"
    return f"{text}, then at {place_text(mechanism, run.position)}"


def _words(run: MechanismRun, subject: _Subject) -> tuple[str, str]:
    """Return the words for positive and negative motion of a mechanism."""
    if isinstance(run.mechanism, FlywheelSim | RollerSim):
        return "forward", "backward"
    if isinstance(run.mechanism, RackSim):
        return "out", "in"
    is_turret = any(shooter.turret == run.name for shooter in subject.config.shooters)
    return ("to the left", "to the right") if is_turret and isinstance(run.mechanism, ArmSim) else ("up", "down")


def _purpose(run: MechanismRun, subject: _Subject) -> str:
    """Describe the effect of a flywheel or roller run on game pieces; empty for no effect."""
    forward, config = run.sign > 0.0, subject.config
    said = []
    for number, intake in enumerate(config.intakes, 1):
        if intake.roller == run.name:
            said.append(f"{'takes in' if forward != intake.roller_reversed else 'pushes out'} (intake {number})")
    for number, shooter in enumerate(config.shooters, 1):
        if run.name in shooter.gate:
            said.append(f"{'feeds' if forward != (run.name in shooter.gate_reversed) else 'holds'} shooter {number}")
        if run.name in shooter.wheels:
            said.append(f"{'throws' if forward else 'does not throw'} (shooter {number})")
    for number, placer in enumerate(config.placers, 1):
        if placer.roller == run.name:
            said.append(f"{'takes' if forward else 'lets go'} (claw {number})")
    return f": {', '.join(said)}" if said else ""


def _reading(run: MechanismRun) -> str:
    if run.read is None or run.code is None:
        return ""
    before, after = run.read
    unit = reading_unit(run.mechanism, run.code) or "turns"
    text = f"{before:.2f} to {after:.2f} {unit}" if run.code.reading is not None else f"{after - before:+.2f} {unit}"
    limits = [f"{limit:.3g}" if limit is not None else "-" for limit in (run.code.lower_limit, run.code.upper_limit)]
    if limits != ["-", "-"]:
        text += f", soft limits {limits[0]} to {limits[1]}"
    return text + (", inverted" if run.code.clockwise else "")


def _shots(subject: _Subject) -> Iterator[str]:
    """Yield a line with each shooter's exit speed and elevation, and indented lines about shots into the goal.

    The indented lines state the wheel speed needed from each distance, and the exit efficiency needed if the exit speed
    at 12 V is too low.
    """
    for number, shooter in enumerate(subject.config.shooters, 1):
        speed = top_exit_speed(shooter, subject.config)
        low, high = (math.degrees(angle) for angle in elevations(shooter, subject.config))
        angle = f"{low:.0f}" if math.isclose(low, high) else f"{low:.0f} to {high:.0f}"
        yield f"shooter {number}: {speed:.1f} m/s at 12 V, up {angle} deg"
        needs = _needs(shooter, subject)
        rows = [f"{n.wheel_rps:.0f} from {n.distance:g} m (at {math.degrees(n.elevation):.0f} deg)" for n in needs]
        if rows:
            assert subject.game is not None
            goal = goal_of(shooter, subject.game)
            assert goal is not None
            rows[0] = rows[0].replace(" from", " turns/s from")
            wanted = f"exit_efficiency {shooter.exit_efficiency:g} its wheels need {', '.join(rows)}"
            yield f"  for {goal.name} at {wanted}"
        short = [n for n in needs if n.speed > speed]
        if short:
            least = shooter.exit_efficiency * short[0].speed / speed
            yield f"  at 12 V they reach it from {short[0].distance:g} m with an exit_efficiency of {least:.2f} or more"


def _tipping(subject: _Subject) -> str:
    """Return text about tipping: the full robot's mass, center of mass and limits, and the drivetrain's limit."""
    tips = tipping_limit(subject.config, [] if subject.game is None else [s.kind for s in subject.game.pieces])
    return (
        f"with everything up and full ({tips.mass:.1f} kg, center {tips.height:.2f} m up) it tips at "
        f"{tips.forward:.1f} m/s^2 forward, {tips.sideways:.1f} sideways; its drivetrain can do {tips.drivetrain:.1f}"
    )
