"""Wrong input of every kind, each made from a number: configs, simcore.toml, field meshes, tag layouts, logs, flags.

A case does what a user would do with the input. It returns normally if the input was taken and makes sense, and raises
`Nonsense` if it was taken and does not.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math
import random
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import made_configs
import numpy as np

from simcore.cli import main
from simcore.errors import SimcoreError
from simcore.geometry.symmetry import FieldSymmetry
from simcore.physics.field import FieldGeometry
from simcore.robot_file.reader import read_settings
from simcore.show.log_page import recording_of
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink, read_log
from simcore.vision.tag_layout import load_layout

__all__ = ["COUNT", "Case", "Nonsense", "case", "take_good_inputs"]

COUNT = 2000
"""How many cases there are; any number up to this makes one."""

_PLAUSIBLE = {
    "m": 2000.0, "m, m, rad": 1e4, "kg": 1000.0, "s": 1e6, "V": 100.0, "A": 1e4, "rad": 1e4, "deg": 36_000.0, "px": 1e4,
    "1/s": 1000.0, "m/s": 100.0, "rad/s": 1e4, "m/s^2": 1000.0, "kg m^2": 1000.0, "N m": 1e4, "ohm": 100.0, "0..1": 1.0,
    "A h": 1e4,
}  # fmt: skip
_ANYTHING = 1e9
"""What no number of a config exceeds, whatever its unit."""


class Nonsense(Exception):
    """What cannot be was taken."""


@dataclass(frozen=True)
class Case:
    """One wrong input."""

    text: str
    """What it is, for messages."""
    names: tuple[str, ...]
    """One of these is in the sentence that refuses it."""
    run: Callable[[], None]


def case(number: int, folder: Path) -> Case:
    """The wrong input of a number.

    Args:
        number: From 0 to `COUNT` - 1.
        folder: For files.
    """
    rng = random.Random(number)
    kinds = (_config,) * 9 + (_toml,) * 4 + (_mesh,) + (_tags,) * 2 + (_log,) * 2 + (_flag,) * 2
    return kinds[number % len(kinds)](number, rng, folder)


def take_good_inputs(folder: Path) -> None:
    """What the cases spoil, unspoilt."""
    made_configs.examples()
    (folder / "simcore.toml").write_text(_TOML)
    read_settings(folder / "simcore.toml")
    (folder / "field.obj").write_text(_mesh_text(_corners()))
    FieldGeometry.load(folder / "field.obj", symmetry=_FIELD)
    (folder / "tags.json").write_text(json.dumps(_layout()))
    load_layout(folder / "tags.json")
    (folder / "run.wpilog").write_bytes(_log_bytes(folder))
    recording_of(read_log(folder / "run.wpilog"))


# --- configs ------------------------------------------------------------------------------------------------------


def _wrong(rng: random.Random) -> Any:
    return rng.choice(
        (
            math.nan,
            math.inf,
            -math.inf,
            1e300,
            -1e300,
            10**400,
            -(10**400),
            True,
            "5",
            "",
            None,
            [],
            {},
            (),
            b"1",
            object(),
            1j,
            -1,
            1e7,
            -1e7,
            np.float64("nan"),
            np.bool_(True),
            np.array([1.0, 2.0]),
            np.array(1e300),
            Fraction(10**30),
            [math.nan],
            (1.0, 2.0),
            0.5,
            100.0,
            range(3),
            float,
            2**70,
        )
    )


@cache
def _config_places() -> tuple[tuple[type, str], ...]:
    return tuple((kind, name) for kind in made_configs.config_types() for name in made_configs.number_places(kind))


def _config(number: int, rng: random.Random, folder: Path) -> Case:
    places = _config_places()
    kind, name = places[(number * 7919) % len(places)]
    good, wrong = made_configs.examples()[kind], _wrong(rng)
    before = getattr(good, name)
    value = wrong
    if rng.random() < 0.8:  # inside of what holds several
        if isinstance(before, np.ndarray) and before.size:
            value = before.astype(object)
            value.flat[rng.randrange(before.size)] = wrong
        elif isinstance(before, tuple) and before:
            row = rng.randrange(len(before))
            value = (*before[:row], wrong, *before[row + 1 :])
        elif isinstance(before, Mapping) and before:
            value = {**before, rng.choice(list(before)): wrong}

    def run() -> None:
        made = dataclasses.replace(good, **{name: value})
        _require_sense(made, name, {f.name: f for f in dataclasses.fields(made)}[name].default)

    return Case(f"{kind.__name__}({name}={_short(value)})", (name, name.replace("_", " ")), run)


def _require_sense(made: Any, name: str, default: Any) -> None:
    unit = made_configs.units(type(made)).get(name, "")
    for number in made_configs.numbers_in(getattr(made, name)):
        if dataclasses.is_dataclass(number) or (isinstance(number, str) and name in ("controller", "staging")):
            continue
        if (number is None and default is None) or (number == math.inf and unit in ("A", "A h")):
            continue
        is_number = isinstance(number, int | float | np.number | Fraction) and not isinstance(number, bool)
        if not (is_number and abs(number) <= _PLAUSIBLE.get(unit, _ANYTHING)):
            raise Nonsense(f"{name} is now {_short(number)} [{unit}]")


def _short(value: object) -> str:
    try:
        return repr(value)[:60]
    except ValueError:
        return "a number of many digits"


# --- simcore.toml -------------------------------------------------------------------------------------------------

_TOML = """
[robot]
mass = 50.0
bumper_length = 0.8
bumper_width = 0.8
center_of_mass_height = 0.2
tread = 1.1
capacity = 20

[start]
x = 3.0
y = 2.0
heading_deg = 90.0
preload = 3

[autos."Left"]
start = [2.0, 1.2, 0.0]

[[mechanism]]
name = "wheels"
kind = "flywheel"
leader = 20
followers = [21, 22]
gearing = 0.75
inertia = 0.004
friction_torque = 0.02

[[mechanism]]
name = "roller"
kind = "roller"
leader = 30
gearing = 3.0
inertia = 0.001
radius = 0.025

[[mechanism]]
name = "pivot"
kind = "arm"
leader = 31
cancoder = 5
cancoder_gearing = 2.0
gearing = 50.0
inertia = 0.2
mass = 2.0
center_of_mass = 0.3
min_deg = -10.0
max_deg = 90.0
start_deg = 20.0
x = 0.1
y = 0.0
z = 0.3
yaw_deg = 5.0

[[mechanism]]
name = "lift"
kind = "elevator"
leader = 32
gearing = 9.0
mass = 6.0
drum_radius = 0.02
min_height = 0.0
max_height = 1.2
start_height = 0.1
lean_deg = 3.0

[[mechanism]]
name = "hood"
kind = "servo"
pwm = 3
min_deg = 0.0
max_deg = 40.0
start_deg = 10.0
deg_per_second = 300.0

[[mechanism]]
name = "flap"
kind = "piston"
solenoid = [0, 1]
stroke = 0.2
stroke_time = 0.3

[intake]
x_min = -0.6
x_max = -0.4
y_min = -0.3
y_max = 0.3
z_min = -0.1
z_max = 0.2
roller = "roller"

[shooter]
wheels = "wheels"
feeder = "roller"
wheel_radius = 0.05
exit_efficiency = 0.45
height = 0.5
forward = 0.1
elevation_deg = 60.0
yaw_deg = 180.0
barrels = [0.1, -0.1]
shots_per_second = 8.0

[[camera]]
name = "limelight"
type = "LL4"
x = 0.3
y = 0.0
z = 0.4
pitch_deg = -20.0
fps = 40.0
horizontal_fov_deg = 70.0
latency_ms = 20.0
noise_px = 0.3

[[sensor]]
name = "gate"
kind = "beam break"
dio = 4
sees = "storage"
at_least = 2
delay = 0.1
"""
_TOML_VALUES = (
    "nan", "inf", "-inf", "1e300", "-1e300", "9" * 400, "-" + "9" * 5000, "true", "'five'", "''", "[]", "{}",
    "[1, nan]", "[[1]]", "-7.0", "0", "125", "1e9", "1979-05-27", "07:32:00", "0x" + "f" * 300, "1_000_000", "{a = 1}",
    "0.0000001", "[" * 5000 + "]" * 5000, "{a=" * 500 + "1" + "}" * 500, '"\\u0000"', "=", "",
)  # fmt: skip


def _toml(number: int, rng: random.Random, folder: Path) -> Case:
    lines = _TOML.splitlines()
    row = rng.choice([i for i, line in enumerate(lines) if " = " in line])
    key = lines[row].partition(" = ")[0]
    names: tuple[str, ...] = ("simcore.toml",)
    kind = rng.random()
    if kind < 0.75:
        parser = ("no valid TOML", "nested too deep", "a number that is too long")
        names = (key, key.replace("_deg", "_angle"), *parser)
        lines[row] = f"{key} = {rng.choice(_TOML_VALUES)}"
    elif kind < 0.8:
        lines[row] = f"{key}x = 1"
    elif kind < 0.85:
        lines.insert(row, lines[row])
    else:
        lines += [
            *rng.choice(
                (
                    [".".join(["a"] * 20_000) + " = 1"],
                    [f"a.b{i} = 1" for i in range(20_000)],
                    ["[" + ".".join(["a"] * 3000) + "]"],
                    [f"[[mechanism]]\nname = 'm{i}'\nkind = 'roller'\nleader = {i}\ngearing = 1" for i in range(900)],
                    ["x = '" + "a" * 3_000_000 + "'"],
                    ["[robot]", "mass = 3"],
                    ["\x00\x01"],
                    ["[[mechanism]]"] * 2000,
                )
            )
        ]
    text = "\n".join(lines).encode()
    if kind > 0.97:
        text = text[: rng.randrange(len(text))] + bytes(rng.randrange(256) for _ in range(20))
    path = folder / "simcore.toml"

    def run() -> None:
        path.write_bytes(text)
        settings = read_settings(path)
        for value in _all_numbers(settings):
            if not abs(value) <= _ANYTHING and value != math.inf:
                raise Nonsense(f"a number of the file is now {value}")

    return Case(f"simcore.toml: {lines[row][:60]} ({kind:.2f})", names, run)


def _all_numbers(value: Any) -> list[float]:
    if dataclasses.is_dataclass(value):
        return [n for f in dataclasses.fields(value) for n in _all_numbers(getattr(value, f.name))]
    if isinstance(value, Mapping):
        return [n for part in value.values() for n in _all_numbers(part)]
    if isinstance(value, tuple | list):
        return [n for part in value for n in _all_numbers(part)]
    return [value] if isinstance(value, int | float) else []


# --- field meshes -------------------------------------------------------------------------------------------------

_FIELD = FieldSymmetry("rotate", (16.0, 8.0))
_FACES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))


def _corners() -> np.ndarray:
    """Of a wall on each side."""
    boxes = (
        ((0, -0.3, 0), (16, 0, 0.5)),
        ((0, 8, 0), (16, 8.3, 0.5)),
        ((-0.3, 0, 0), (0, 8, 2)),
        ((16, 0, 0), (16.3, 8, 2)),
    )
    return np.array(
        [[(x, y, z) for x in xs for y in ys for z in zs] for xs, ys, zs in (zip(*b, strict=True) for b in boxes)]
    )


def _mesh_text(corners: np.ndarray) -> str:
    lines = []
    for number, box in enumerate(corners):
        lines += [f"o wall{number}"] + [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in box]
        lines += ["f " + " ".join(str(8 * number + i) for i in face) for face in _FACES]
    return "\n".join(lines) + "\n"


def _mesh(number: int, rng: random.Random, folder: Path) -> Case:
    corners, path = _corners(), folder / "field.obj"
    centered, y_up = corners - (8.0, 4.0, 0.0), corners[:, :, (0, 2, 1)] * (1, 1, -1)
    unit = rng.choice((1 / 0.3048, 1 / 0.0254, 100.0, 1000.0))
    plain = _mesh_text(corners)
    bad = rng.choice(("nan", "inf", "-1e300", "1e400", "x", "", "1e30"))
    kinds = {
        "other unit": _mesh_text(corners * unit),
        "centered": _mesh_text(centered),
        "y up": _mesh_text(y_up),
        "y up, centered, other unit": _mesh_text(centered[:, :, (0, 2, 1)] * (1, 1, -1) * unit),
        "tiny": _mesh_text(corners * 1e-6),
        f"vertex {bad}": plain.replace("v 16 ", f"v {bad} ", 1),
        "index": plain.replace("f 1 2", f"f {rng.choice(('0', '99', '-99', 'a', '1e3', '9' * 5000))} 2"),
        "cut off": plain[: rng.randrange(len(plain))],
        "noise": bytes(rng.randrange(1, 256) for _ in range(300)).decode("latin-1"),
        "no faces": "v 0 0 0\n" * 100,
        "a face of many corners": plain + "f " + " ".join(str(i % 32 + 1) for i in range(50_000)),
        "many groups": "".join(f"g g{i}\n{_mesh_text(corners[:1])}" for i in range(3000)),
        "many bodies": "".join(f"v {i % 16} {i // 2000} 0\nv {i % 16} {i // 2000} 1\nv {i % 16} 1 1\n"
                               f"f -1 -2 -3\n" for i in range(3000)),
        "many faces": plain + "f 1 2 3\n" * 1_000_000,
        "NUL": plain + "\0",
    }  # fmt: skip
    name = rng.choice(list(kinds))

    def run() -> None:
        path.write_text(kinds[name], encoding="utf-8")
        low, high = FieldGeometry.load(path, symmetry=_FIELD).bounds()
        if not (np.isfinite([low, high]).all() and (low >= -3.0).all() and (high <= (19.0, 11.0, 6.0)).all()):
            raise Nonsense(f"the field is from {low} to {high}")

    return Case(f"OBJ: {name}", ("field.obj", "group"), run)


# --- tag layouts --------------------------------------------------------------------------------------------------


def _layout() -> dict[str, Any]:
    tags: list[dict[str, Any]] = [
        {
            "ID": i,
            "pose": {
                "translation": {"x": 1.0 * i, "y": 2.0, "z": 0.5},
                "rotation": {"quaternion": {"W": 1.0, "X": 0.0, "Y": 0.0, "Z": 0.0}},
            },
        }
        for i in (1, 2, 3)
    ]
    return {"tags": tags, "field": {"length": 16.0, "width": 8.0}}


def _tags(number: int, rng: random.Random, folder: Path) -> Case:
    path, data = folder / "tags.json", _layout()
    tags = data["tags"]
    tag = rng.choice(tags)
    pose = tag["pose"]
    quaternion = pose["rotation"]["quaternion"]
    place = rng.choice(
        [
            *((pose["translation"], k) for k in "xyz"),
            *((quaternion, k) for k in "WXYZ"),
            *((data["field"], "length"), (data["field"], "width"), (data, "tags")),
            *((tag, "ID"), (tag, "pose"), (pose, "rotation")),
        ]
    )
    wrong = rng.choice(
        (math.nan, math.inf, -math.inf, 1e300, 10**400, "1", None, True, [], {}, -1, -3.5, 5000.0, 0, 1.5, [[]], 3)
    )
    place[0][place[1]] = wrong
    if rng.random() < 0.15:
        del place[0][place[1]]
    if rng.random() < 0.1:
        tags.append(dict(tags[0]))
    size = rng.choice((0.1651,) * 6 + (math.nan, -0.1, 0.0, math.inf, 1e9, "a", None))
    text = json.dumps(data)
    if rng.random() < 0.1:
        text = rng.choice(
            ("[" * 100_000, text[: rng.randrange(len(text))], "{" + '"a":{' * 50_000, "\0", " " * 3_000_000)
        )

    def run() -> None:
        path.write_text(text)
        layout = load_layout(path, size=size)
        good = np.isfinite(layout.corners).all() and np.abs(layout.corners).max(initial=0.0) < 200.0
        turned = np.allclose(np.linalg.norm(layout.normals, axis=1), 1.0)
        ids = len(set(layout.id_list)) == len(layout.id_list) and all(0 <= i < 587 for i in layout.id_list)
        if not (good and turned and ids and 0.0 < layout.size <= 1.0 and 0.0 < min(layout.field_size) <= 100.0):
            raise Nonsense(f"a layout of {text[:200]}")

    return Case(f"tags: {place[1]} = {_short(wrong)}, size {size}", ("tags.json",), run)


# --- logs ---------------------------------------------------------------------------------------------------------


@cache
def _log_bytes(folder: Path) -> bytes:
    path = folder / "good.wpilog"
    sink = WpilogSink(path)
    for tick in range(50):
        time = 0.02 * (tick + 1)
        pose = np.array((2.0 + time, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0))
        sink.write(
            Snapshot(
                time=time, tick=tick, poses={"Sim/Robot/Pose3d": pose},
                pose_arrays={"Sim/GamePieces/Ball": np.tile(pose, (5, 1))},
                doubles={"Sim/Debug/BatteryVoltage": 12.0 - time},
                integers={"Sim/Score/Blue": tick},
                strings={"Sim/Match/Period": f"p{tick // 10}"},
            )
        )  # fmt: skip
    sink.close()
    return path.read_bytes()


def _log(number: int, rng: random.Random, folder: Path) -> Case:
    data, path = bytearray(_log_bytes(folder)), folder / "run.wpilog"
    kind = rng.choice(("flip", "flip", "flip", "cut", "stamp", "gap", "noise", "head"))
    if kind == "flip":
        for _ in range(rng.choice((1, 1, 5))):
            data[rng.randrange(12, len(data))] ^= 1 << rng.randrange(8)
    elif kind == "cut":
        del data[rng.randrange(len(data)) :]
    elif kind in ("stamp", "gap"):
        stamp = rng.choice((2**63, 2**64 - 1, 2**62)) if kind == "stamp" else 86_400_000_000
        for entry in range(1, 40):
            data += struct.pack("<BBBQd", 0b0111_0000, entry, 8, stamp, 1.0)
    elif kind == "noise":
        data += bytes(rng.randrange(256) for _ in range(200))
    else:
        data[rng.randrange(12)] ^= 0xFF

    def run() -> None:
        path.write_bytes(data)
        log = read_log(path)
        with contextlib.redirect_stderr(io.StringIO()):
            recording = recording_of(log)
        log.snapshot_at(0.5)
        times = recording.times
        if not np.isfinite(times).all() or any(not np.isfinite(c.times).all() for c in log.columns.values()):
            raise Nonsense("times that are no numbers")

    return Case(f"log: {kind}", ("run.wpilog",), run)


# --- flags --------------------------------------------------------------------------------------------------------


def _flag(number: int, rng: random.Random, folder: Path) -> Case:
    wrong = rng.choice(
        ("nan", "inf", "-inf", "-1", "1.5x", "", "1e300", "9" * 400, "true", "0x10", "\0", "a\0b", "none")
    )
    flag = rng.choice(
        ("--seed", "--seconds", "--auto", "--alliance", "--engine", "--port", "--nt-port", "--field", "--year", "--log")
    )
    argv = ["play", "rebuilt", f"{flag}={wrong}"]
    if flag == "--year":
        argv = ["new-game", "discs", f"--year={wrong}"]
    if flag == "--log":  # any text is a name, but this cannot be one
        argv[-1] = rng.choice(("--log=a\0b", f"--log={folder}", f"--log={folder}/good.wpilog/x.wpilog"))
    if rng.random() < 0.2:
        argv = rng.choice(
            (
                ["page", str(folder)],
                ["page", str(folder / "none.wpilog")],
                ["page", "a\0b"],
                ["plya"],
                ["play", "rebilt"],
                ["play", "--sed=3"],
                ["view", str(folder / "none.wpilog")],
                ["view", "x", "--seconds=1"],
                ["page"],
                ["play", "rebuilt", "--seed"],
                ["new-game", "1 2"],
                ["new-game", ""],
                ["play", "rebuilt", "extra"],
            )
        )

    def run() -> None:
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            try:
                status = main(argv)
            except SystemExit as error:
                status = error.code
        if status in (0, None):
            raise Nonsense(f"{argv} ended with {status}")
        raise SimcoreError(said.getvalue())

    name = argv[-1].partition("=")[0]
    return Case(f"simcore {' '.join(argv)[:80]!r}", (name, name.lstrip("-"), "argument", argv[0]), run)
