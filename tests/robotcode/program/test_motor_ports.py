"""Ports with doubles of the devices: volts go in and motion comes out."""

import math

import pytest

from simcore.errors import ConfigError, NonFiniteError
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robotcode.program.motor_ports import ShaftPorts, SuppliedMotor, SwervePorts
from simcore.testing.benches import hold


class Angle:
    def __init__(self) -> None:
        self.angle = self.rate = math.nan

    def write(self, angle: float, rate: float) -> None:
        self.angle, self.rate = angle, rate


class Gyro:
    def write(self, yaw, pitch, roll, rates) -> None:
        self.yaw = yaw


class Controller:
    """Motor controller with an encoder, as another maker may have it."""

    def __init__(self, volts: float = 0.0, coasts: bool = False) -> None:
        self.asked, self.rotor, self.supply = volts, (math.nan, math.nan), math.nan
        self.port = SuppliedMotor(lambda: self.asked, self.turn, supply=self.power, coasts=coasts)

    def turn(self, rotations: float, rps: float) -> None:
        self.rotor = rotations, rps

    def power(self, volts: float) -> None:
        self.supply = volts


def swerve(**module) -> SwerveDrive:
    return SwerveDrive(SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0, **module)))


def test_swerve_voltages_are_read_from_the_motors_and_every_sensor_gets_the_motion():
    """Rotors turn by the gearing times the wheel, and a steering module drags its drive rotor along by the coupling."""
    drive = swerve(coupling_ratio=3.0)
    drives, steers = [Controller(6.0) for _ in range(4)], [Controller(1.0) for _ in range(4)]
    azimuths, wheels, gyro = [Angle() for _ in range(4)], [Angle() for _ in range(4)], Gyro()
    ports = SwervePorts(
        drive,
        [c.port for c in drives],
        [c.port for c in steers],
        steer_encoders=azimuths,
        wheel_encoders=wheels,
        gyro=gyro,
    )
    ports.write(0.7, 0.0, 0.0, [0.0] * 3)
    for _ in range(10):
        ports.read(11.5)
        hold(drive, 0.005, (0.0, 0.0, 0.0))
    ports.write(0.9, 0.0, 0.0, [0.0] * 3)
    assert drives[2].supply == steers[3].supply == 11.5
    state, m = drive.state, drive.config.modules[1]
    assert state.wheel_angle[1] > 0.0 and state.steer_angle[1] > 0.0
    assert wheels[1].angle == state.wheel_angle[1] and azimuths[1].rate == state.steer_speed[1]
    rotor = (m.drive_gearing * state.wheel_angle[1] + 3.0 * state.steer_angle[1]) / math.tau
    assert drives[1].rotor[0] == pytest.approx(rotor)
    assert steers[1].rotor[1] == pytest.approx(m.steer_gearing * state.steer_speed[1] / math.tau)
    assert gyro.yaw == pytest.approx(0.2)  # it was zero when it was switched on


@pytest.mark.parametrize(("coasts", "slows"), [(True, False), (False, True)])
def test_zero_volts_brake_or_coast_according_to_the_controllers_neutral_mode(coasts, slows):
    """A motor that brakes from 20 rad/s of the wheel carries current; a coasting motor carries none."""
    drive = swerve(drive_friction_volts=0.0)
    motors = [Controller(0.0, coasts) for _ in range(8)]
    ports = SwervePorts(drive, [c.port for c in motors[:4]], [c.port for c in motors[4:]], steer_encoders=[None] * 4)
    drive.state.wheel_speed[:] = [20.0] * 4
    ports.read(12.0)
    hold(drive, 0.02, (20.0 * 0.0508, 0.0, 0.0))
    current = max(abs(c) for c in drive.drive_motors.current)
    assert (current > 5.0) == slows


def test_the_sides_of_a_tank_drive_move_independently():
    drive = TankDrive(TankConfig())
    left, right, encoders = Controller(6.0), Controller(-6.0), (Angle(), Angle())
    ports = ShaftPorts(drive, ([left.port], [right.port]), encoders=encoders)
    for _ in range(40):
        ports.read(12.0)
        hold(drive, 0.005, (0.0, 0.0, 0.0))
    ports.write(0.0, 0.0, 0.0, [0.0] * 3)
    assert encoders[0].angle > 0.0 > encoders[1].angle
    assert left.rotor[0] == pytest.approx(encoders[0].angle * drive.config.gearing / math.tau)


def test_invalid_ports_are_refused():
    drive = swerve()
    four = [Controller().port] * 4
    with pytest.raises(ConfigError, match="3 drive motors for a model of 4 modules"):
        SwervePorts(drive, four[:3], four, steer_encoders=[None] * 4)
    with pytest.raises(ConfigError, match="2 steer encoders for a model of 4 modules"):
        SwervePorts(drive, four, four, steer_encoders=[None] * 2)
    with pytest.raises(ConfigError, match="each of the 2 shafts needs at least one motor controller, got 1, 0"):
        ShaftPorts(TankDrive(TankConfig()), (four[:1], []))
    with pytest.raises(NonFiniteError, match="volts must be a finite number, got nan"):
        SuppliedMotor(lambda: math.nan).volts()
