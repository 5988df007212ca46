"""Mirror, in simcore's HAL, of the ports of a robot program in another process.

The mirror receives the outputs of the program and sends the inputs. Drivetrains and mechanisms of `simcore.toml`
therefore work as with a Python program. The HAL does not report the class of a PWM device or whether the program
inverts the device, so the signs are those of the PWM signal.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from simcore import season
from simcore.bridge import packets
from simcore.bridge.packets import INPUTS, OUTPUTS, SIM_VALUE, Record
from simcore.robot_file.robot_settings import RobotSettings

hal: Any = season.hal
hal_simulation: Any = season.hal_simulation
wpilib: Any = season.wpilib
sim: Any = season.wpilib_simulation

__all__ = ["MirroredPorts"]

_JOYSTICKS = range(6)
_VALUE_TYPES: dict[int, tuple[str, Callable[[float], Any]]] = {
    1: ("Boolean", bool), 2: ("Double", float), 4: ("Int", int), 8: ("Int", int), 16: ("Long", int),
}  # fmt: skip
"""WPILib type name and conversion from a number, by HAL type code. An enum is represented by the index of its value."""
_GYROS = {"Gyro:ADIS16448": "ADIS16448_IMU", "Gyro:ADIS16470": "ADIS16470_IMU", "Gyro:ADXRS450": "ADXRS450_Gyro"}
"""WPILib class of each gyro, by the first part of the SimDevice name."""
_INPUT_KINDS = {name: row for row, name in enumerate(INPUTS)}
_OUTPUT_NAMES = list(OUTPUTS)
_TEXTS = ("SetGameSpecificMessage", "SetEventName")


class MirroredPorts:
    """Mirror, in simcore's HAL, of the ports and SimDevices that a program in another process has opened.

    Args:
        settings: Settings of simcore.toml, with the channels of all solenoids, because the HAL does not report these.
        follows: Whether the driver station of the program controls the robot instead of simcore's driver station.
    """

    def __init__(self, settings: RobotSettings, *, follows: bool = False) -> None:
        self._settings = settings
        self._follows = follows
        self.has_started = False
        """Whether the program has reached its main loop."""
        self.errors: list[str] = []
        """Errors and warnings that the program has reported. The caller clears the list after reading."""
        self._state: dict[str, dict[tuple[int, int], float]] = {name: {} for name in OUTPUTS}
        self._open: dict[tuple[str, int], Any] = {}
        self._inputs: list[tuple[int, int, int, Callable[[], float]]] = []
        self._sent: list[float] = []
        self._texts = dict.fromkeys(_TEXTS, "")
        self._choices: dict[str, str] = {}
        self._names: dict[int, tuple[str, str, int, float]] = {}
        """Name of the SimDevice, name of the value, HAL type code and initial value, by handle of the value."""
        self._values: dict[int, Any] = {}
        self._devices: dict[str, Any] = {}
        self._kept: list[Any] = []
        self._take: dict[str, Callable[[int, int, float], None]] = {
            "GetPWMSpeed": lambda n, _, value: sim.PWMSim(n).setSpeed(value),
            "GetPWMPosition": lambda n, _, value: sim.PWMSim(n).setPosition(value),
            "GetPWMPulseMicrosecond": lambda n, _, value: sim.PWMSim(n).set_pulse_microsecond(int(value)),
            "GetDIOValue": self._take_dio,
            "GetAnalogGyroAngle": self._take_gyro,
            "GetRelayForward": lambda n, _, value: sim.RelaySim(n).setForward(bool(value)),
            "GetRelayReverse": lambda n, _, value: sim.RelaySim(n).setReverse(bool(value)),
            "GetEncoderDistancePerPulse": self._take_distance,
            "GetEncoderReset": self._take_reset,
            "GetCTREPCMSolenoidOutput": lambda n, s, value: sim.CTREPCMSim(n).set_solenoid_output(s, bool(value)),
            "GetREVPHSolenoidOutput": lambda n, s, value: sim.REVPHSim(n).set_solenoid_output(s, bool(value)),
        }
        if follows:
            self._take |= {name: self._follow(name) for name in OUTPUTS if name.startswith("GetDriverStation")}
        self._add_driver_station()

    # --- from the program -----------------------------------------------------------------------------------------

    def take(self, found: Iterable[Record]) -> None:
        """Store the outputs and errors in records from the program, and publish the choosers.

        If the program has started, also open the program's ports and SimDevices in simcore's HAL, and write the outputs
        to these ports.
        """
        changed: list[Record] = []
        choosers: list[list[str]] = []
        opens = False
        for record in found:
            if record.kind < len(OUTPUTS):
                name = _OUTPUT_NAMES[record.kind]
                self._state[name][record.number, record.sub] = record.value
                opens |= "Initialized" in name or name == "GetProgramStarted"
                changed.append(record)
            elif record.kind == SIM_VALUE:
                changed.append(record)
            elif record.kind == packets.VALUE_NAME:
                device, name = record.parts
                self._names[record.number] = (device, name, record.sub, record.value)
            elif record.kind == packets.CHOOSER:
                choosers += [[]] if record.sub == 0 else []
                choosers[-1].append(record.parts[0])
            elif record.kind == packets.ERROR_TEXT:
                self.errors.append(record.text.decode("utf-8", "replace"))
        for texts in choosers:
            self._show_chooser(*texts)
        self.has_started = self.has_started or bool(self._now("GetProgramStarted"))
        if not self.has_started:
            return
        if opens:
            self._open_ports()
            known = ((name, key, value) for name in self._take for key, value in self._state[name].items())
            changed += [Record(_OUTPUT_NAMES.index(name), sub, n, value) for name, (n, sub), value in known]
        if len(self._values) < len(self._names):
            self._open_values()
        for record in changed:
            if record.kind == SIM_VALUE:
                self._take_value(record.number, record.value)
            elif take := self._take.get(_OUTPUT_NAMES[record.kind]):
                take(record.number, record.sub, record.value)

    def _now(self, name: str, number: int = 0) -> float:
        return self._state[name].get((number, 0), 0.0)

    def _take_dio(self, number: int, _: int, value: float) -> None:
        if not self._now("GetDIOIsInput", number):
            sim.DIOSim(number).set_value(bool(value))

    def _take_distance(self, number: int, _: int, value: float) -> None:
        if encoder := self._open.get(("Encoder", number)):
            encoder.set_distance_per_pulse(value)

    def _take_reset(self, number: int, _: int, value: float) -> None:
        if value and (encoder := self._open.get(("Encoder", number))):
            sim.EncoderSim(encoder).set_reset(True)

    def _take_gyro(self, number: int, _: int, value: float) -> None:
        """Reset the mirrored gyro if the program's gyro reads zero while the mirrored angle is not zero."""
        gyro = self._open.get(("AnalogGyro", number))
        if gyro and value == 0.0 != sim.AnalogGyroSim(number).getAngle():
            gyro.reset()

    def _follow(self, name: str) -> Callable[[int, int, float], None]:
        """Return a setter that copies a value of the program's driver station to `DriverStationSim`."""
        show = getattr(sim.DriverStationSim, name.replace("GetDriverStation", "set"))
        make = hal.AllianceStationID if name.endswith("Id") else bool
        return lambda number, sub, value: show(make(int(value)))

    # --- opening ----------------------------------------------------------------------------------------------------

    def _opened(self, name: str) -> list[int]:
        return sorted(number for (number, _), value in self._state[name].items() if value)

    def _make(self, what: str, number: int, build: Any, *args: Any) -> Any:
        """Open a port by calling `build` with `args`, and return the WPILib object of the port.

        Return None if the port is already open or cannot be opened.
        """
        if (what, number) in self._open:
            return None
        try:
            self._open[what, number] = build(*args)
        except RuntimeError:  # two objects in the program share the port
            self._open[what, number] = None
        return self._open[what, number]

    def _open_ports(self) -> None:
        """Open the ports that the program has opened, and register the inputs to send.

        Encoders come before digital inputs, because an encoder opens two digital inputs.
        """
        for n in self._opened("GetPWMInitialized"):
            self._make("PWM", n, wpilib.PWMSparkMax, n)
        for n in self._opened("GetEncoderInitialized"):
            channels = [int(self._now(f"GetEncoderDigitalChannel{letter}", n)) for letter in "AB"]
            if made := self._make("Encoder", n, wpilib.Encoder, *channels):
                self._open |= dict.fromkeys((("DIO", channel) for channel in channels), made)
                encoder = sim.EncoderSim(made)
                self._add("SetEncoderCount", n, encoder.get_count)
                self._add("SetEncoderPeriod", n, encoder.get_period)
                self._add("SetEncoderDirection", n, encoder.get_direction)
        for n in self._opened("GetDutyCycleInitialized"):
            channel = int(self._now("GetDutyCycleDigitalChannel", n))
            if made := self._make("DutyCycle", n, self._duty_cycle, channel):
                self._open["DIO", channel] = made
                self._add("SetDutyCycleOutput", n, sim.DutyCycleSim.create_for_channel(channel).get_output)
        for n in self._opened("GetAnalogGyroInitialized"):
            if made := self._make("AnalogGyro", n, wpilib.AnalogGyro, n):
                self._open["Analog", n] = made
                self._add("SetAnalogGyroAngle", n, sim.AnalogGyroSim(n).getAngle)
                self._add("SetAnalogGyroRate", n, sim.AnalogGyroSim(n).getRate)
        for n in self._opened("GetAnalogInInitialized"):
            build = wpilib.AnalogEncoder if self._has_device(f"AnalogEncoder[{n}]") else wpilib.AnalogInput
            if self._make("Analog", n, build, n):
                self._add("SetAnalogInVoltage", n, sim.AnalogInputSim(n).get_voltage)
        for n in self._opened("GetDIOInitialized"):
            is_input = bool(self._now("GetDIOIsInput", n))
            build = wpilib.DigitalInput if is_input else wpilib.DigitalOutput
            if self._make("DIO", n, build, n) and is_input:
                self._add("SetDIOValue", n, sim.DIOSim(n).get_value)
        for n in {*self._opened("GetRelayInitializedForward"), *self._opened("GetRelayInitializedReverse")}:
            self._make("Relay", n, wpilib.Relay, n)
        for m in self._settings.mechanisms:  # the HAL does not report the opened channels of a solenoid module
            model, _, number = m.module.partition(" ")
            if model and self._now(f"Get{model}Initialized", int(number)):
                for channel in m.channels:
                    coil = int(number), getattr(wpilib.PneumaticsModuleType, model), channel
                    self._make(m.module, channel, wpilib.Solenoid, *coil)

    def _has_device(self, name: str) -> bool:
        return any(device == name for device, *_ in self._names.values())

    def _duty_cycle(self, channel: int) -> Any:
        if self._has_device(f"DutyCycle:DutyCycleEncoder[{channel}]"):
            return wpilib.DutyCycleEncoder(channel)
        self._kept.append(wpilib.DigitalInput(channel))
        return wpilib.DutyCycle(self._kept[-1])

    # --- SimDevices -------------------------------------------------------------------------------------------------

    def _open_values(self) -> None:
        for handle in [handle for handle in self._names if handle not in self._values]:
            device, name, code, value = self._names[handle]
            type_name, make = _VALUE_TYPES[code]
            if device not in self._devices:
                gyro = _GYROS.get(re.sub(r"\[.*", "", device))
                is_there = device in sim.SimDeviceSim.enumerate_devices("")
                build = hal.SimDevice if gyro is None else lambda _, gyro=gyro: getattr(wpilib, gyro)()
                self._devices[device] = None if is_there else build(device)
            made, there = self._devices[device], sim.SimDeviceSim(device)
            if isinstance(made, hal.SimDevice):
                self._kept.append(getattr(made, f"create{type_name}")(name, 2, make(value)))
            elif name not in [known for known, _ in there.enumerate_values()]:
                continue  # the program's gyro is on another SPI port than the gyro in this process
            shown = getattr(there, f"get{type_name}")(name)
            shown.set(make(value))
            self._values[handle] = shown
            self._add("", handle, shown.get)

    def _take_value(self, handle: int, value: float) -> None:
        device, name, code, _ = self._names[handle]
        if (shown := self._values.get(handle)) is None:
            return
        gyro = self._devices[device]
        if value == 0.0 != shown.get() and name.startswith("angle") and hasattr(gyro, "reset"):
            gyro.reset()
        shown.set(_VALUE_TYPES[code][1](value))

    # --- to the program -------------------------------------------------------------------------------------------

    def inputs(self) -> list[Record]:
        """Return a record for each input whose value has changed since the last call."""
        found = []
        for row, (code, sub, number, get) in enumerate(self._inputs):
            value = float(get())
            if value != self._sent[row]:
                self._sent[row] = value
                found.append(Record(code, sub, number, value))
        return found

    def driver_station(self) -> list[Record]:
        """Return records of changed inputs, driver station texts and chooser selections, with `NEW_DATA` at the end.

        The inputs of a new joystick are included from the next call on.
        """
        hal.refreshDSData()
        found = self.inputs()
        said = wpilib.MatchState.get_game_data(), wpilib.MatchState.getEventName()
        for name, text in zip(_TEXTS, said, strict=True):
            if self._texts[name] != text:
                self._texts[name] = text
                found.append(Record(_INPUT_KINDS[name], 0, 0, 0.0, text.encode()))
        table = season.ntcore.NetworkTableInstance.get_default()
        for key, before in self._choices.items():
            choice = table.get_entry(f"{key}/selected").get_string(before)
            if choice != before:
                self._choices[key] = choice
                found.append(Record(packets.SELECT, 0, 0, 0.0, f"{key}\0{choice}".encode()))
        for port in _JOYSTICKS:
            if ("joystick", port) not in self._open and any(hal_simulation.getJoystickCounts(port)):
                self._open["joystick", port] = True
                self._add_joystick(port, *hal_simulation.getJoystickCounts(port))
        return [*found, Record(packets.NEW_DATA, 0, 0, 0.0)]

    def _add(self, name: str, number: int, get: Callable[[], float], sub: int = 0) -> None:
        self._inputs.append((_INPUT_KINDS[name] if name else SIM_VALUE, sub, number, get))
        self._sent.append(math.nan)

    def _add_driver_station(self) -> None:
        station, match = sim.DriverStationSim, wpilib.MatchState
        self._add("SetRoboRioVInVoltage", 0, sim.RoboRioSim.get_vin_voltage)
        if self._follows:
            return
        for name in ("Autonomous", "Test", "Enabled", "EStop", "FmsAttached", "DsAttached", "MatchTime"):
            self._add(f"SetDriverStation{name}", 0, getattr(station, f"get{name}"))
        self._add("SetDriverStationAllianceStationId", 0, lambda: int(station.getAllianceStationId()))
        self._add("SetMatchType", 0, lambda: int(match.getMatchType()))
        self._add("SetMatchNumber", 0, match.getMatchNumber)
        self._add("SetReplayNumber", 0, match.getReplayNumber)

    def _add_joystick(self, port: int, *counts: int) -> None:
        station = wpilib.DriverStation
        names = ("SetJoystickAxisCount", "SetJoystickButtonCount", "SetJoystickPOVCount")
        for name, count in zip(names, counts, strict=True):
            self._add(name, port, partial(float, count))
        for axis in range(counts[0]):
            self._add("SetJoystickAxis", port, partial(station.getStickAxis, port, axis), axis)
        for hat in range(counts[2]):
            self._add("SetJoystickPOV", port, partial(station.getStickPOV, port, hat), hat)
        self._add("SetJoystickButtonsValue", port, partial(station.getStickButtons, port))

    def _show_chooser(self, key: str, model: str, default: str, active: str, *options: str) -> None:
        """Publish a chooser of the program on simcore's NetworkTables."""
        table = season.ntcore.NetworkTableInstance.get_default()
        self._choices.setdefault(key, "")
        for name, text in ((".type", model), ("default", default), ("active", active)):
            table.get_entry(f"{key}/{name}").set_string(text)
        table.get_entry(f"{key}/options").set_string_array(list(options))
