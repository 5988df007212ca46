"""Command `simcore calibrate FILE ...`, which fits a robot model to logs and measured shots.

The command prints lines for simcore.toml and writes an HTML page.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from simcore.calibrate.assembling import assembled
from simcore.calibrate.described import Described, described
from simcore.calibrate.drive_fit import Prediction, fit_battery, fit_drive
from simcore.calibrate.fitting import Estimate
from simcore.calibrate.logs import Log, open_log
from simcore.calibrate.mechanism_fit import FittedMechanism, fit_mechanism
from simcore.calibrate.runs import Run
from simcore.calibrate.shot_fit import Shot, fit_shots, read_shots
from simcore.calibrate.signals import ROLES
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.registry import find_game
from simcore.quantities import text_flag
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RollerConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.show.report import chart, headline, paragraph, report_page, series, table
from simcore.sweep.shot_task import ShotTask
from simcore.telemetry.sinks import write_text

__all__ = ["add_arguments", "run"]

_VAGUE = 0.3  # largest half-width of an interval relative to the value for a line in simcore.toml
_DELAY = "delay from voltage to reading"  # name of the estimate of `lag`
_MASSES = (20.0, 75.0)  # [kg], range of masses in simcore.toml


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore calibrate`."""
    parser.add_argument(
        "logs", nargs="*", type=Path, metavar="FILE", help="logs of one robot: SysId's JSON, .wpilog or .csv"
    )
    parser.add_argument(
        "--project", type=Path, default=Path(), help="where robot.py and simcore.toml are (default: here)"
    )
    parser.add_argument(
        "--mechanism", metavar="NAME", help="fit this mechanism of simcore.toml instead of the drivetrain"
    )
    parser.add_argument("--signal", action="append", default=[], metavar="ROLE=NAME", type=_signal,
                        help=f"name of a signal in the log, by role: {', '.join(ROLES)}; for one side, left_volts or "
                            "right_way")  # fmt: skip
    parser.add_argument("--shot", action="append", default=[], metavar="WHAT", type=text_flag(Shot.parse),
                        help="a shot from standstill: distance=2.8,rps=38 and elevation_deg, hood_deg, time, "
                        "result=hit|miss|short|long; may be given again; or give a CSV with these columns")  # fmt: skip
    parser.add_argument(
        "--shooter", type=int, default=1, metavar="N", help="number of the shooter, in the file's order"
    )
    parser.add_argument("--game", metavar="NAME", help="game whose goal is shot at (default: as simcore.toml says)")
    parser.add_argument("--out", type=Path, default=Path("out/twin.html"), help="the page (default: %(default)s)")


def _signal(text: str) -> tuple[str, str]:
    role, _, name = text.partition("=")
    if role.removeprefix("left_").removeprefix("right_") not in ROLES or not name:
        raise argparse.ArgumentTypeError(f"must be ROLE=NAME with one of {', '.join(ROLES)}, got {text!r}")
    return role, name


@dataclass(slots=True)
class _Finding:
    """Result of the fit of a drivetrain, a mechanism or a shooter, for the console and the page."""

    title: str
    rows: list[tuple[str, Estimate, str]] = field(default_factory=list)
    """Name, estimate and unit of each parameter."""
    lines: list[str] = field(default_factory=list)
    """Lines to add to simcore.toml."""
    predictions: Sequence[Prediction] = ()
    shots: Sequence[tuple[Shot, float, float]] = ()
    unit: str = "m"
    unknown: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def run(args: argparse.Namespace) -> int:
    """Fit a robot model to logs and shots, print the results, write the page, and return exit status 0.

    Raises:
        SimcoreError: If a log, simcore.toml or a shot is invalid, or if the data do not determine the model.
    """
    if not args.logs and not args.shot:
        raise ConfigError("give a log (simcore calibrate FILE), or shots (--shot distance=2.8,rps=38)")
    robot = described(args.project)
    shots, logs = [*args.shot], []
    for path in args.logs:
        rows = read_shots(path) if path.suffix.lower() == ".csv" else None
        if rows is None:
            logs.append(open_log(path))
        else:
            shots += rows
    sources = ", ".join([path.name for path in args.logs] or ["shots"])
    found = [_logged(args, robot, logs)] if logs else []
    found += [_shot(args, robot, shots)] if shots else []
    for finding in found:
        _print(finding, sources)
    write_text("page", args.out, _page(found, sources, robot))
    print(f"the page is {args.out}")
    return 0


def _logged(args: argparse.Namespace, robot: Described, logs: Sequence[Log]) -> _Finding:
    said = dict(args.signal)
    kinds = {log.kind for log in logs} & {"Simple", "Arm", "Elevator", "Elevator Linear"}
    if args.mechanism is not None or kinds:
        return _mechanism(args.mechanism, robot, logs, said)
    drivetrain = robot.drivetrain
    is_swerve = isinstance(drivetrain, SwerveConfig)
    gearing = drivetrain.modules[0].drive_gearing if isinstance(drivetrain, SwerveConfig) else drivetrain.gearing
    motor = drivetrain.modules[0].drive_motor if isinstance(drivetrain, SwerveConfig) else drivetrain.motor
    per_speed = gearing / motor.kv / drivetrain.wheel_radius
    runs, notes = _runs(logs, said, dict(
        sided=isinstance(drivetrain, TankConfig), radius=drivetrain.wheel_radius, volts_per_speed=per_speed,
        gearing=gearing, devices=robot.devices,
    ))  # fmt: skip
    fitted = fit_drive(drivetrain, runs)
    of = fitted.estimates
    finding = _Finding(
        f"drivetrain, {robot.about}", predictions=fitted.predictions, unknown=[*fitted.unknown], notes=notes
    )
    names = (
        ("ks", "kS", "V", "drive_friction_volts"), ("mass", "mass", "kg", "mass"),
        ("left_efficiency", "left efficiency", "", "drive_efficiency"),
        ("right_efficiency", "right efficiency", "", "right_efficiency"),
        ("free_speed_share", "free speed relative to the datasheet", "", "free_speed_share"),
        ("wheel_radius", "wheel radius", "m", ""), ("lag", _DELAY, "s", ""),
    )  # fmt: skip
    for name, words, unit, key in names:
        if name in of:
            _add(
                finding,
                words,
                of[name],
                unit,
                key if name != "mass" or _MASSES[0] < of[name].value < _MASSES[1] else "",
            )
    if "mass" in of and not _MASSES[0] < of["mass"].value < _MASSES[1]:
        finding.unknown.append(
            f"mass: {of['mass'].value:.0f} kg is not plausible for a robot: are motors, gearing and wheels as "
            f"described? (the robot is {robot.about})"
        )
    battery = fit_battery(runs)
    if battery is None:
        finding.unknown.append("battery: its voltage and current are not both logged")
    else:
        _add(finding, "battery and cables", battery, "ohm", "battery_resistance")
    finding.lines = ["[robot]", *finding.lines] if finding.lines else []
    if "wheel_radius" in of:
        wheel = of["wheel_radius"].mapped(lambda x: 2.0 * x)
        finding.lines += ["[drivetrain]", _line("wheel_diameter", wheel)]
    if is_swerve:
        finding.notes.append("a swerve drive is assumed to drive straight, with identical modules")
    return finding


def _runs(logs: Sequence[Log], said: Mapping[str, str], asked: Mapping[str, object]) -> tuple[list[Run], list[str]]:
    runs: list[Run] = []
    notes: dict[str, None] = {}
    for log in logs:
        some, words = assembled(log, said=said, **asked)  # type: ignore[arg-type]
        runs += some
        notes |= dict.fromkeys(words)
    return runs, [*notes]


def _mechanism(name: str | None, robot: Described, logs: Sequence[Log], said: Mapping[str, str]) -> _Finding:
    known = {m.name: m.config for m in robot.settings.mechanisms
             if isinstance(m.config, FlywheelConfig | RollerConfig | ArmConfig | ElevatorConfig)}  # fmt: skip
    if name is None:
        wanted = {"Simple": FlywheelConfig | RollerConfig, "Arm": ArmConfig}.get(logs[0].kind, ElevatorConfig)
        fitting = [one for one, config in known.items() if isinstance(config, wanted)]
        if len(fitting) != 1:
            raise ConfigError(
                f"{logs[0].path.name} is of a mechanism ({logs[0].kind}): give --mechanism NAME; {FILE_NAME} describes "
                f"{', '.join(known) or 'none, but motor and gearing must be known'}"
            )
        name = fitting[0]
    if name not in known:
        raise UnknownNameError("mechanism with a motor", name, known)
    config: FittedMechanism = known[name]
    radius = config.drum_radius if isinstance(config, ElevatorConfig) else None
    box = config.gearbox
    runs, notes = _runs(logs, said, dict(
        sided=False, radius=radius, volts_per_speed=box.volts_per_speed / (radius or 1.0), gearing=box.gearing,
        about=name,
    ))  # fmt: skip
    if radius is not None:
        runs = [
            Run(r.name, r.times, r.volts, r.way / radius, bus=r.bus, amps=r.amps, origin=r.origin / radius)
            for r in runs
        ]
    fitted = fit_mechanism(config, runs)
    finding = _Finding(
        f"mechanism {name}", predictions=fitted.predictions, unknown=[*fitted.unknown], notes=notes, unit="rad"
    )
    units = {"friction_volts": ("kS", "V"), "inertia": ("inertia", "kg m^2"), "mass": ("mass", "kg"),
             "weight_torque": ("weight torque when level", "N m"), "lag": (_DELAY, "s")}  # fmt: skip
    for key, estimate in fitted.estimates.items():
        _add(finding, units[key][0], estimate, units[key][1], "" if key in ("weight_torque", "lag") else key)
    finding.lines = [f'[[mechanism]]  # the one with name = "{name}"', *finding.lines] if finding.lines else []
    return finding


def _shot(args: argparse.Namespace, robot: Described, shots: Sequence[Shot]) -> _Finding:
    task = ShotTask(find_game(args.game or robot.settings.game), robot.config, shooter=args.shooter - 1)
    fitted = fit_shots(task, shots)
    finding = _Finding(f"shooter {args.shooter}, at {task.zone.name}", shots=fitted.rows, unknown=[*fitted.unknown])
    for name, estimate in fitted.estimates.items():
        _add(finding, name.replace("_", " "), estimate, "", name if name == "exit_efficiency" else "")
    most, value = 0.5 if len(task.shooter.wheels) == 1 else 1.0, fitted.estimates["exit_efficiency"].value
    if value > most:
        finding.unknown.append(
            f"whether this exit efficiency is right: above {most:g} is possible "
            f"{'only where wheels drive both sides of a piece' if most < 1.0 else 'nowhere'}; look at wheel_radius, "
            "gearing, height and elevation, and whether rps counts turns of the wheels, not of the motor"
        )
    finding.lines = ["[[shooter]]", *finding.lines] if finding.lines else []
    return finding


# --- output -----------------------------------------------------------------------------------------------------------


def _add(finding: _Finding, words: str, estimate: Estimate, unit: str, key: str) -> None:
    """Add an estimate to the table of a finding, and to the lines for simcore.toml if `key` is not empty.

    If the half-width of the interval is over 30 % of the value, add the estimate to the unknown properties instead of
    the lines. The delay is never unknown.
    """
    finding.rows.append((words, estimate, unit))
    if estimate.share > _VAGUE and words != _DELAY:
        finding.unknown.append(f"{words}: the log only narrows it to {_interval(estimate)} {unit}".rstrip())
    elif key:
        finding.lines.append(_line(key, estimate))


def _line(key: str, estimate: Estimate) -> str:
    return f"{key} = {estimate.value:.4g}  # {_interval(estimate)}"


def _interval(estimate: Estimate) -> str:
    return f"{estimate.low:.4g} to {estimate.high:.4g}"


def _errors(finding: _Finding) -> list[tuple[object, ...]]:
    size, unit = (1e3, "mm") if finding.unit == "m" else (1e3, "mrad")
    return [
        (one.run.name + (", its last third" if one.first else ""), f"{100.0 * one.error:+.1f} %",
         f"{size * one.rms:.0f} {unit}")
        for one in finding.predictions
    ]  # fmt: skip


def _print(finding: _Finding, sources: str) -> None:
    print(f"{finding.title}; from {sources}")
    for words, estimate, unit in finding.rows:
        print(f"  {words}: {estimate.value:.4g} {unit} (95 %: {_interval(estimate)})".replace("  (", " ("))
    for name, error, rms in _errors(finding):
        print(f"  held out, {name}: prediction off by {error} of the distance, {rms} rms")
    for shot, beyond, seconds in finding.shots:
        clock = "" if shot.time is None else f", {seconds - shot.time:+.2f} s of flight time"
        print(
            f"  held out, shot from {shot.distance:g} m: prediction {beyond:+.2f} m beyond the center of the "
            f"goal{clock}"
        )
    for note in finding.notes:
        print(f"  note: {note}")
    for line in finding.unknown:
        print(f"  the data cannot tell {line}")
    if finding.lines:
        print(f"\nfor {FILE_NAME} (95 % intervals; from {sources}):\n")
        print("\n".join(finding.lines) + "\n")


def _page(found: Sequence[_Finding], sources: str, robot: Described) -> str:
    blocks: list[dict[str, object]] = []
    for finding in found:
        blocks.append(headline(finding.title, f"from {sources}"))
        rows = [(words, estimate.value, estimate.low, estimate.high, unit) for words, estimate, unit in finding.rows]
        blocks.append(table(("", "value", "from", "to", "unit"), rows, "Fitted values, with 95 % intervals"))
        if finding.lines:
            blocks.append(paragraph("\n".join([f"For {FILE_NAME}:", *finding.lines])))
        if finding.unknown:
            blocks.append(table(("the data cannot tell",), [(line,) for line in finding.unknown]))
        if finding.predictions:
            blocks.append(
                table(
                    ("held out", "error of the distance", "rms"),
                    _errors(finding),
                    "Prediction of each run by a fit without it",
                )
            )
        for one in finding.predictions:
            times = one.run.times
            ways = [series("real", times, one.real), series("simulated", times, one.way)]
            blocks.append(chart(f"{one.run.name}: position", ways, x_label="s", y_label=finding.unit))
            off = series("", times, one.way - one.real)
            blocks.append(
                chart(f"{one.run.name}: simulated minus real", [off], x_label="s", y_label=finding.unit, from_zero=True)
            )
        if finding.shots:
            distances = [shot.distance for shot, _, _ in finding.shots]
            beyond = series("", distances, [beyond for _, beyond, _ in finding.shots], kind="dots")
            blocks.append(
                chart(
                    "Shots held out: distance beyond the center of the goal",
                    [beyond],
                    x_label="distance [m]",
                    y_label="m",
                )
            )
    return report_page("Real and simulated", blocks, subtitle=f"{robot.about}; {sources}")
