"""Readings of each gyro in robot code while the model turns left at 1 rad/s, tilted, and after a reset."""

from __future__ import annotations

import json
import math
import sys
from typing import Any

import hal
import numpy as np
import wpilib
from wpilib.simulation import pauseTiming

from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.gyro import Gyro, gyro_config
from simcore.robotcode.program.makers import device_of, maker_of, watch_makers
from simcore.robotcode.program.motor_ports import ShaftPorts, SuppliedMotor

DT, HEADING, PITCH, ROLL = 0.005, 2.5, 0.1, -0.05


def built(name: str) -> Any:
    """Build a gyro as robot programs do, from a derived class."""
    if name == "navx3":
        import navx

        return navx.Navx(3)
    if name.startswith("navx"):
        import navx

        if name == "navx-created":
            return navx.AHRS.create_spi()
        kinds = navx.AHRS.NavXComType
        kind = {"navx": kinds.kMXP_SPI, "navx-usb": kinds.kUSB1, "navx-i2c": kinds.kI2C}[name]

        class Heading(navx.AHRS):
            def __init__(self) -> None:
                super().__init__(kind)

        return Heading()
    return getattr(wpilib, name)(0) if name == "AnalogGyro" else getattr(wpilib, name)()


def read(gyro: Any) -> dict[str, Any]:
    """Return all readings of a gyro, in its own units and signs."""
    names = ("getYaw", "getAngle", "getRate", "getPitch", "getRoll", "getXComplementaryAngle", "getYComplementaryAngle")
    row = {name: float(getattr(gyro, name)()) for name in names if hasattr(gyro, name)}
    if hasattr(gyro, "getRotation2d"):
        row["rotation"] = float(gyro.getRotation2d().radians())
    if hasattr(gyro, "getRotation2D"):
        row["rotation"] = float(gyro.getRotation2D()[1].radians())
        row["getRate"] = float(gyro.getAngularVel()[3])
    if hasattr(gyro, "getRotation3d"):
        row["yaw of rotation 3d"] = float(gyro.getRotation3d().Z())
    return row


def turned(name: str) -> dict[str, Any]:
    """Return all readings of one gyro over the scenario."""
    gyro = built(name)
    device = device_of(gyro)
    assert device is not None, "the constructor was not seen"
    drive = TankDrive(TankConfig())
    motor = SuppliedMotor(lambda: 0.0)
    ports = ShaftPorts(drive, ([motor], [motor]), gyro=maker_of(device).gyro_port(device))
    model = Gyro(gyro_config("ideal"), np.random.default_rng(1))
    model.reset(yaw=HEADING, true_yaw=HEADING)
    angle = 0.0

    def turn(seconds: float) -> dict[str, Any]:
        nonlocal angle
        for _ in range(round(seconds / DT)):
            angle += DT
            model.step(DT, math.remainder(HEADING + angle, math.tau), PITCH, ROLL, (0.0, 0.0, 1.0))
            ports.write(model.yaw, model.pitch, model.roll, model.rates.tolist())
        return read(gyro)

    ports.write(model.yaw, 0.0, 0.0, [0.0, 0.0, 0.0])
    first = read(gyro)
    rows = {"start": first, "4 s": turn(4.0)}
    next(getattr(gyro, reset) for reset in ("zeroYaw", "resetYaw", "reset") if hasattr(gyro, reset))()
    rows["reset"] = read(gyro)
    rows["1 s later"] = turn(1.0)
    return {"number": device.address.number, "rows": rows}


def main() -> None:
    hal.initialize(500, 0)
    pauseTiming()
    watch_makers()
    print(json.dumps({"lateness_ms": 0.0, **{name: turned(name) for name in sys.argv[1:]}}))


if __name__ == "__main__":
    main()
