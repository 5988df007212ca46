"""Sensors, servos, pistons and controllers on ports in simcore.toml, and the messages about mistakes."""

import math
import re

import pytest
from each_case import each

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import DeviceAddress
from simcore.robot.mechanisms import PistonSim, ServoSim
from simcore.robot.robot_config import build_mechanism
from simcore.robot_file.sensor_tables import PieceView

HOOD = """
[[mechanism]]
name = "hood"
kind = "arm"
controller = "PWM"
leader = 2
gearing = 100.0
inertia = 0.02
min_deg = 0
max_deg = 50
"""
LIFT = """
[[mechanism]]
name = "lift"
kind = "elevator"
leader = 1
gearing = 9
mass = 6
drum_radius = 0.02
max_height = 1.0
"""
PISTON = """
[[mechanism]]
name = "deploy"
kind = "piston"
solenoid = [4, 5]
module = "CTREPCM"
stroke = 0.2
stroke_time = 0.4
start = "out"
"""
SERVO = """
[[mechanism]]
name = "latch"
kind = "servo"
pwm = 3
min_deg = 0
max_deg = 180
start_deg = 45
deg_per_second = 400
"""
ROLLER = """
[[mechanism]]
name = "roller"
kind = "roller"
leader = 30
gearing = 3
"""
ENCODER = '[[sensor]]\nname = "e"\nkind = "encoder"\nmechanism = "hood"\ndio = [0, 1]\npulses_per_turn = 2048\n'
SWITCH = '[[sensor]]\nname = "s"\nkind = "limit switch"\ndio = 3\n'
BEAM = '[[sensor]]\nname = "b"\nkind = "beam break"\n'


def test_the_reader_accepts_a_piston_and_a_servo(read):
    robot = read(PISTON + SERVO)
    piston, servo = (build_mechanism(m.config) for m in robot.mechanisms)
    assert isinstance(piston, PistonSim) and piston.stops == (0.0, 0.2) and piston.extension == 0.2
    assert isinstance(servo, ServoSim) and servo.position == pytest.approx(math.pi / 4)
    assert robot.mechanism("deploy").keys == [("CTREPCM 0 Solenoid", DeviceAddress(n)) for n in (4, 5)]
    assert robot.mechanism("latch").keys == [("PWM", DeviceAddress(3))]


def test_a_piston_on_a_reversed_single_solenoid_springs_out(read):
    text = PISTON.replace("[4, 5]", "4").replace('start = "out"', "reversed = true")
    piston = build_mechanism(read(text).mechanism("deploy").config)
    piston.coast()
    piston.step(1.0)
    assert piston.position == 0.2


def test_the_reader_accepts_sensors_of_several_kinds(read):
    robot = read(
        HOOD
        + LIFT
        + ENCODER
        + "reversed = true\ngearing = 4\n"
        + SWITCH
        + 'mechanism = "lift"\nat_height = 0.5\nwithin = 0.02\nnormally = "closed"\n'
        + BEAM
        + 'candi = 30\npin = 2\nat_least = 3\ndelay = 0.2\nkinds = "Cube"\n'
        + '[[sensor]]\nname = "r"\nkind = "canrange"\nid = 9\nmechanism = "lift"\ndistance = 0.1\n'
    )
    encoder, switch, beam, ranging = robot.sensors
    assert encoder.kind == "encoder" and encoder.keys == (("DIO", DeviceAddress(0)), ("DIO", DeviceAddress(1)))
    assert (encoder.gearing, encoder.pulses_per_turn) == (-4.0, 2048.0)
    assert switch.kind == "limit switch" and switch.normally_closed
    assert switch.pressed == pytest.approx((0.48 / 0.02, 0.52 / 0.02))
    assert beam.sees == PieceView(place="storage", at_least=3, delay=0.2, kinds=("Cube",))
    assert beam.keys == (("CANdi", DeviceAddress(30)),) and beam.pin == 2
    assert ranging.mechanism == "lift" and ranging.sees is None and ranging.distance == 0.1
    with pytest.raises(UnknownNameError, match="no kind of piece named 'Cube'"):
        robot.require_pieces(["Cone"])


@pytest.mark.parametrize(("at", "low", "high"), [("lower", -math.inf, 0.5), ("upper", 49.5, math.inf)])
def test_a_limit_switch_at_a_stop_is_pressed_in_the_last_hundredth_of_the_travel(read, at, low, high):
    (switch,) = read(HOOD + SWITCH + f'mechanism = "hood"\nat = "{at}"\n').sensors
    assert [math.degrees(end) for end in switch.pressed] == pytest.approx([low, high])


@each(
    ("text", "said"),
    [
        (HOOD + "coasts = 1", "[[mechanism]] 'hood': coasts must be true or false, got 1"),
        (ROLLER + "coasts = true", "coasts is for a PWM or relay port; a TalonFX has a configured neutral mode"),
        (HOOD + SERVO.replace("pwm = 3", "pwm = 2"), "'latch': PWM 2 already belongs to 'hood'"),
        (SERVO.replace("pwm = 3", "pwm = 20"), "pwm must be a whole number from 0 to 19, got 20"),
        (SERVO.replace("start_deg = 45", "start_deg = 200"), "start_deg must be between min_deg and max_deg, got 200"),
        (SERVO + "leader = 3", "[[mechanism]] 'latch': no key 'leader'"),
        (
            PISTON.replace("[4, 5]", "[4, 4]"),
            "solenoid must be a channel from 0 to 15, or two: [forward, reverse]; got",
        ),
        (PISTON.replace("[4, 5]", "'4'"), "solenoid must be a whole number from 0 to 15, got '4'"),
        (PISTON.replace("CTREPCM", "PCM"), "module must be one of REVPH, CTREPCM, got 'PCM'. Did you mean 'CTREPCM'?"),
        (ENCODER, "mechanism must name a mechanism, but there is no [[mechanism]] in the file"),
        (HOOD + ENCODER.replace("[0, 1]", "[0]"), "[[sensor]] 'e': dio must be the two channels of the encoder"),
        (HOOD + ENCODER + "zero = 3", "[[sensor]] 'e': no key 'zero'"),
        (PISTON + ENCODER.replace("hood", "deploy"), "must turn, and 'deploy' is a piston: a limit switch sees where"),
        (HOOD + ENCODER + ENCODER.replace('"e"', '"f"'), "[[sensor]] 'f': DIO 0 already belongs to 'e'"),
        (HOOD + ENCODER + BEAM.replace('"b"', '"E"') + "dio = 7", "name is 'E' in telemetry, where each sensor needs"),
        (ROLLER + SWITCH + 'mechanism = "roller"\nat = "lower"', "must have stops, like an arm or an elevator"),
        (HOOD + SWITCH + 'mechanism = "hood"', "at is missing"),
        (HOOD + SWITCH + 'mechanism = "hood"\nat_deg = 60', "at_deg must be between the stops, 0 and 50 deg; got 60"),
        (
            HOOD + SWITCH + 'mechanism = "hood"\nat_height = 0.1',
            "at_height does not fit this mechanism: it must be at_deg, or at = 'lower' or 'upper'",
        ),
        (BEAM, "dio is missing; it must be a DIO channel, or candi = <CAN id> and pin = 1 or 2 instead"),
        (BEAM + "dio = 1\ncandi = 30\npin = 1", "dio and candi exclude each other: a switch is wired to one of them"),
        (BEAM + "candi = 30", "candi needs pin = <1 or 2> as well"),
        (
            BEAM + 'dio = 1\nsees = "storag"',
            "sees must be one of storage, claw, intake, shooter, got 'storag'. Did you",
        ),
        (BEAM + 'dio = 1\nsees = "intake"\nat_least = 2', "at_least goes with sees = 'storage', not with 'intake'"),
        (BEAM + "dio = 1\npassing_time = 2", "passing_time goes with sees = 'intake' or 'shooter', not with 'storage'"),
        (BEAM + "dio = 1\nat_least = 0", "at_least must be a whole number from 1 to 500, got 0"),
        (
            HOOD + '[[sensor]]\nname = "r"\nkind = "canrange"\nid = 9\nmechanism = "hood"',
            "must be an elevator, rack or",
        ),
        (
            HOOD + '[[sensor]]\nname = "p"\nkind = "potentiometer"\nmechanism = "hood"\nanalog = 0\nlower_volts = 6\n',
            "lower_volts must be a number from 0 to 5 V, got 6",
        ),
    ],
)
def test_the_error_names_each_mistake_in_a_sensor_or_mechanism(read, text, said):
    with pytest.raises(ConfigError, match=re.escape(said)):
        read(text)
