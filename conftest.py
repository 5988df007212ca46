"""Leaves out what needs a vendor's library that is not installed: the adapters are optional extras."""

from importlib.util import find_spec

collect_ignore_glob = ["examples/*", "tests/adapters/robots/*", "tests/adapters/scenarios/*"]
if find_spec("phoenix6") is None or find_spec("wpilib") is None:
    collect_ignore_glob.append("simcore/phoenix6/*")
if find_spec("photonlibpy") is None:
    collect_ignore_glob.append("simcore/photonvision/*")
if find_spec("pyfrc") is None or find_spec("phoenix6") is None:
    collect_ignore_glob.append("simcore/robotpy/*")
