"""The choosers that a robot program shows on its dashboard, worked as a driver would: by name."""

from __future__ import annotations

import ntcore

from simcore.errors import ConfigError, UnknownNameError

__all__ = ["auto_choices", "choose"]


def auto_choices() -> dict[str, list[str]]:
    """Options of every `SendableChooser` on NetworkTables, by its key such as `/SmartDashboard/Auto`."""
    instance = ntcore.NetworkTableInstance.getDefault()
    found = {}
    for topic in instance.getTopics():
        name = topic.getName()
        if name.endswith("/options"):
            key = name.removesuffix("/options")
            if instance.getEntry(f"{key}/.type").getString("") == "String Chooser":
                found[key] = list(instance.getEntry(name).getStringArray([]))
    return dict(sorted(found.items()))


def choose(name: str) -> str:
    """Choose an option in the chooser that has it; returns the chooser's key.

    Raises:
        UnknownNameError: No chooser has it; the text lists what there is.
        ConfigError: There is no chooser.
    """
    choices = auto_choices()
    for key, options in choices.items():
        if name in options:
            ntcore.NetworkTableInstance.getDefault().getEntry(f"{key}/selected").setString(name)
            return key
    if not choices:
        raise ConfigError(
            f"no auto named {name!r}: the robot shows no SendableChooser on its dashboard; "
            "SmartDashboard.putData(chooser), or call autonomous() without a name"
        )
    raise UnknownNameError("auto", name, [option for options in choices.values() for option in options])
