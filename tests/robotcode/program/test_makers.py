"""Table of makers: device names in programs and in simcore.toml, and records of built devices."""

import gc
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

pytest.importorskip("wpilib", reason="needs the extra 'robotpy'")

from simcore.quantities import DeviceAddress
from simcore.robot_file.drivetrain_table import NO_PHOENIX_5
from simcore.robot_file.robot_settings import CONTROLLERS, PORT_CONTROLLERS
from simcore.robotcode.program.makers import MAKER_MODULES, installed_makers
from simcore.robotcode.program.motor_controllers import BuiltDevice, group_by_leader
from simcore.robotcode.program.recorder import BuiltDevices
from simcore.robotcode.program.unserved import unknown_sim_devices

ROOT = Path(__file__).resolve().parents[3]
needs_all = pytest.mark.skipif(
    any(find_spec(package) is None for package, _ in MAKER_MODULES), reason="needs the packages of all makers"
)


@needs_all
def test_the_robot_file_names_the_motor_controllers_of_the_makers():
    on_can = [model for maker in installed_makers() if not maker.on_ports for model in maker.motors]
    assert [c for c in CONTROLLERS if c not in PORT_CONTROLLERS] == sorted(on_can, key=CONTROLLERS.index)
    models = [m for maker in installed_makers() for m in (*maker.motors, *maker.encoders, *maker.gyros, *maker.others)]
    assert len(models) == len(set(models))


@needs_all
def test_each_device_without_a_maker_adapter_is_named_once():
    names = [
        *("Talon FX (v6)[1]", "Talon FX (v6)[1]/Rotor Sensor", "SPARK Flex [6] EXTERNAL ENCODER"),
        *("DutyCycle:DutyCycleEncoder[3]", "AnalogEncoder[0]"),
        *("navX-Sensor[4]", "ADXRS450_Gyro[0]", "Servo Hub [3]/Channel 0", "Servo Hub [3]/Channel 1"),
    ]
    installed_makers()  # loads them
    assert unknown_sim_devices(names) == ["ADXRS450_Gyro[0]", "Servo Hub [3]"]


def test_a_program_of_phoenix_5_is_refused_with_the_supported_controllers():
    code = "from simcore.robotcode.program.makers import watch_makers; watch_makers(); import phoenix5.sensors"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    last = done.stderr.rstrip().splitlines()[-1]
    assert done.returncode == 1 and last == f"simcore.errors.VendorError: {NO_PHOENIX_5}"


class Motor:
    """Device of robot code."""

    def __init__(self, number: int) -> None:
        self.number = number


class OwnMotor(Motor):
    """Device of a class that a program derives."""


def test_devices_are_found_by_object_and_dropped_when_the_object_is_deleted():
    devices = BuiltDevices()
    devices.record(Motor, "motor", lambda made, args, settings: DeviceAddress(made.number))
    devices.record(Motor, "motor", lambda made, args, settings: DeviceAddress(made.number))
    first, twin, own, none = Motor(1), Motor(1), OwnMotor(2), Motor(-1)
    assert [str(d) for d in devices.devices()] == ["motor 1", "motor 2"]
    assert len(devices.objects) == 3 and devices.find(none) is None
    found = devices.find(own)
    assert found is not None and found.hardware is own
    device = devices.find(twin)
    assert device is not None and device.hardware is first  # two objects with the same id are one device
    del first, twin, device
    gc.collect()
    assert [str(d) for d in devices.devices()] == ["motor 2"]


def test_followers_are_grouped_by_key_id_or_object_and_other_motors_stay_single():
    devices = [BuiltDevice("motor", DeviceAddress(k), Motor(k)) for k in range(6)]
    first = DeviceAddress(0)
    leaders = {1: (("motor", first), True), 2: (first, False), 3: (devices[0].hardware, True)}
    leaders |= {4: (DeviceAddress(9), True), 5: (DeviceAddress(5), False)}
    groups = group_by_leader(devices, lambda d: leaders.get(d.address.number, (None, False)))
    assert [str(g) for g in groups] == ["motor 0 + 1 + 2 + 3", "motor 4", "motor 5"]
    assert groups[0].opposed == (0, 2)
