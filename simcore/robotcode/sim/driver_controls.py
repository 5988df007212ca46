"""Controls of the drive team that a test operates: joysticks and dashboard choosers."""

from __future__ import annotations

from typing import Any, ClassVar

from simcore import season
from simcore.errors import ConfigError, UnknownNameError, nearest
from simcore.quantities import Quantity, require
from simcore.robotcode.networktables.control_topics import TABLE

DriverStationSim = season.wpilib_simulation.DriverStationSim
ntcore = season.ntcore

__all__ = ["Joystick", "XboxPad", "auto_choices", "choose_auto", "chosen_autos"]

_AXES, _BUTTONS, _POVS = 6, 16, 1
_STICK = Quantity("", -1.0, 1.0)


class Joystick:
    """Simulated joystick at a driver station port.

    Each value stays set until a test changes the value. Robot code reads a new value in the next loop.

    Args:
        port: Joystick port, 0..5.

    Raises:
        ConfigError: The port is out of range.
    """

    def __init__(self, port: int) -> None:
        if port not in range(6):
            raise ConfigError(f"joystick: port must be 0..5, got {port!r}")
        self.port = port
        season.open_joystick(port, axes=_AXES, buttons=_BUTTONS, povs=_POVS)
        self.center()

    def axis(self, number: int, value: float) -> None:
        """Set an axis, numbered from 0, to a value from -1 to 1.

        On most joysticks, forward and left are negative.

        Raises:
            ConfigError: The axis does not exist, or the value is out of range.
        """
        if number not in range(_AXES):
            raise ConfigError(f"joystick {self.port}: axis must be 0..{_AXES - 1}, got {number!r}")
        if not -1.0 <= value <= 1.0:
            raise ConfigError(f"joystick {self.port}: axis {number} must be -1..1, got {value}")
        DriverStationSim.set_joystick_axis(self.port, number, value)

    def press(self, button: int) -> None:
        """Press a button, numbered from 1, and hold the button down.

        Raises:
            ConfigError: The button does not exist.
        """
        self._button(button, True)

    def release(self, button: int) -> None:
        """Release a button, numbered from 1.

        Raises:
            ConfigError: The button does not exist.
        """
        self._button(button, False)

    def pov(self, angle: int | None) -> None:
        """Press the POV hat at an angle clockwise from forward [deg], a multiple of 45; None releases the hat.

        Raises:
            ConfigError: The angle is not 0, 45, ... 315 or None.
        """
        if angle is not None and angle not in range(0, 360, 45):
            raise ConfigError(f"joystick {self.port}: pov must be None or a multiple of 45 below 360, got {angle!r}")
        season.set_pov(self.port, angle)

    def center(self) -> None:
        """Center all axes and release all buttons and the POV hat."""
        for number in range(_AXES):
            DriverStationSim.set_joystick_axis(self.port, number, 0.0)
        for number in range(1, _BUTTONS + 1):
            season.press_button(self.port, number, False)
        self.pov(None)

    def _button(self, number: int, down: bool) -> None:
        if number not in range(1, _BUTTONS + 1):
            raise ConfigError(f"joystick {self.port}: button must be 1..{_BUTTONS}, got {number!r}")
        season.press_button(self.port, number, down)


class XboxPad(Joystick):
    """Simulated Xbox controller, on which assignments to attributes set the axes and buttons.

    Example:
        pad.left_y = -0.5  # forward
        pad.a = True
    """

    AXES: ClassVar = {"left_x": 0, "left_y": 1, "left_trigger": 2, "right_trigger": 3, "right_x": 4, "right_y": 5}
    BUTTONS: ClassVar = {
        **{"a": 1, "b": 2, "x": 3, "y": 4, "left_bumper": 5, "right_bumper": 6},
        **{"back": 7, "start": 8, "left_stick": 9, "right_stick": 10},
    }

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.AXES:
            require(f"Xbox pad {self.port}", name, value, _STICK)
            self.axis(self.AXES[name], float(value))
        elif name in self.BUTTONS:
            self._button(self.BUTTONS[name], bool(value))
        elif name == "port":
            super().__setattr__(name, value)
        else:
            raise ConfigError(
                f"an Xbox pad has no {name!r}.{nearest(name, (*self.AXES, *self.BUTTONS))} It has "
                f"{', '.join((*self.AXES, *self.BUTTONS))}; its hat is pov(angle)"
            )


def auto_choices() -> dict[str, list[str]]:
    """Return the options of all choosers on NetworkTables, by chooser key such as `/SmartDashboard/Auto`."""
    instance = ntcore.NetworkTableInstance.get_default()
    found = {}
    for topic in instance.get_topics():
        name = topic.get_name()
        if name.endswith("/options") and not name.startswith(TABLE):
            key = name.removesuffix("/options")
            if season.is_chooser(instance, key):
                found[key] = list(instance.get_entry(name).get_string_array([]))
    return dict(sorted(found.items()))


def chosen_autos() -> list[str]:
    """Return the option in use of each chooser in `auto_choices`.

    The option in use is the selected option, or else the active option, or else the default option. The list omits
    choosers without any of these options.
    """
    return _first_texts((*season.chooser_keys(), "default"))


def active_choices() -> list[str]:
    """Return the active option of each chooser in `auto_choices` that has an active option."""
    return _first_texts((season.chooser_keys()[1],))


def _first_texts(names: tuple[str, ...]) -> list[str]:
    table = ntcore.NetworkTableInstance.get_default()
    texts = [[table.get_entry(f"{key}/{name}").get_string("") for name in names] for key in auto_choices()]
    return [text for text in (next(filter(None, found), "") for found in texts) if text]


def choose_auto(name: str) -> str:
    """Select an option in the first chooser that offers the option, and return the chooser's key.

    Raises:
        UnknownNameError: No chooser offers the option; the message lists all options.
        ConfigError: Robot code has no chooser.
    """
    choices = auto_choices()
    for key, options in choices.items():
        if name in options:
            ntcore.NetworkTableInstance.get_default().get_entry(f"{key}/{season.chooser_keys()[0]}").set_string(name)
            return key
    if not choices:
        raise ConfigError(
            f"no auto named {name!r}: the robot shows no SendableChooser on its dashboard; "
            "SmartDashboard.putData(chooser), or call autonomous() without a name"
        )
    raise UnknownNameError("auto", name, [option for options in choices.values() for option in options])
