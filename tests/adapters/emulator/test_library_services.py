"""Each native function that the Python library calls answers as in CTRE's simulation or is refused."""

import inspect
import re
from pathlib import Path

import pytest

pytest.importorskip("phoenix6", reason="needs phoenix6: pip install .[phoenix6]")

DEVICES = ("TalonFX", "TalonFXS", "CANcoder", "Pigeon2", "CANrange", "CANdi", "CANdle")


def names(statuses):
    return [status.name for status in statuses]


def test_generated_telemetry_can_write_structs_to_a_log(bench):
    """CTRE's generated telemetry.py writes structs 250 times a second."""
    from phoenix6 import SignalLogger
    from phoenix6.hoot_schema_type import HootSchemaType

    try:
        from wpimath import Pose2d, SwerveModuleVelocity
    except ImportError:  # names of 2026
        from wpimath.geometry import Pose2d
        from wpimath.kinematics import SwerveModuleState as SwerveModuleVelocity

    def write():
        return names(
            (
                SignalLogger.write_struct("DriveState/Pose", Pose2d, Pose2d()),
                SignalLogger.write_struct_array(
                    "DriveState/ModuleStates", SwerveModuleVelocity, [SwerveModuleVelocity()]
                ),
                SignalLogger.write_double("DriveState/OdometryPeriod", 0.004, "seconds"),
                SignalLogger.write_string_array("Names", ["a", "b"]),
            )
        )

    assert SignalLogger.set_path("/tmp").is_ok() and SignalLogger.start().is_ok()
    assert write() == ["OK"] * 4
    assert SignalLogger.add_schema("struct:Mine", HootSchemaType.STRUCT, "double x").is_ok()
    assert SignalLogger.write_schema_value("m", "struct:Mine", HootSchemaType.STRUCT, b"1").is_ok()
    assert SignalLogger.stop().is_ok()


def test_devices_on_a_bus_with_a_hoot_file_answer_although_the_file_is_missing(bench):
    """Nearly every generated constants file has `CANBus(name, "./logs/example.hoot")`."""
    from phoenix6 import CANBus, HootReplay, hardware

    from simcore.robotcode.emulator.emulated_native import IS_2027

    if IS_2027:
        pytest.skip("a CANBus of 26.70 takes no hoot file")
    device = hardware.TalonFX(7, CANBus("canivore", "./logs/example.hoot"))
    assert device.get_position().refresh().status.is_ok()
    assert names((HootReplay.play(), HootReplay.pause(), HootReplay.restart(), HootReplay.get_double("x").status)) == (
        ["NOT_SUPPORTED"] * 4
    )
    assert not HootReplay.is_file_loaded() and HootReplay.is_playing() and HootReplay.is_finished()


def test_an_orchestra_accepts_every_call_and_makes_no_sound(bench):
    from phoenix6 import Orchestra, hardware

    orchestra = Orchestra([hardware.TalonFX(1, bench.bus)])
    calls = (orchestra.load_music("song.chrp"), orchestra.play(), orchestra.pause(), orchestra.stop())
    assert names(calls) == ["OK"] * 4
    assert not orchestra.is_playing() and orchestra.get_current_time() == 0.0


@pytest.mark.parametrize("name", DEVICES)
def test_every_device_method_without_arguments_returns_a_valid_value(bench, name):
    device = bench.device(name, 9)
    bench.emulator.step(0.02)
    called = 0
    for attribute in dir(device):
        function = getattr(device, attribute, None)
        if attribute.startswith("_") or attribute == "close" or not callable(function):
            continue
        needs = [p for p in inspect.signature(function).parameters.values() if p.default is p.empty]
        if needs:
            continue
        answer = function()
        called += 1
        if hasattr(answer, "refresh"):
            assert answer.refresh().status.is_ok(), attribute
            assert answer.value is not None
    assert called > 20


def test_the_emulator_has_every_function_that_the_python_library_calls():
    """Only requests of differential mechanisms are missing."""
    import phoenix6

    from simcore.robotcode import emulator

    emulator.install()
    from phoenix6.phoenix_native import Native

    libraries = (Native.instance(), Native.api_instance())
    missing = set()
    for path in Path(phoenix6.__file__).parent.rglob("*.py"):
        for function in re.findall(r"\.(c_(?:ctre|Phoenix)\w+)\(", path.read_text()):
            if not any(_has(library, function) for library in libraries):
                missing.add(function.removeprefix("c_ctre_phoenix6_RequestControl"))
    emulator.uninstall()
    assert {m for m in missing if not m.startswith(("Diff_", "Differential"))} == set()


def _has(library, name):
    try:
        getattr(library, name)
    except NotImplementedError:
        return False
    return True
