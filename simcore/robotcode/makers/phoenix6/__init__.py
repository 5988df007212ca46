"""Adapters to CTRE's Phoenix 6 devices: physics writes the simulated state and reads the motor voltages."""

from importlib.metadata import PackageNotFoundError, version

from simcore.errors import VendorError

__all__ = ["TESTED_PHOENIX6", "require_phoenix6"]

TESTED_PHOENIX6 = "26.3.0"


def require_phoenix6(found: str | None) -> None:
    """Check that Phoenix 6 of 2026 is installed, since the simulated devices of other years may differ.

    Args:
        found: Installed version; None if Phoenix 6 is not installed.

    Raises:
        VendorError: Phoenix 6 is not installed, or not a 2026 version.
    """
    if found is None:
        raise VendorError('simcore needs Phoenix 6, which is not installed: pip install "phoenix6>=26.1,<27"')
    if found.split(".")[0] != "26":
        raise VendorError(
            f"simcore needs Phoenix 6 of 2026 (26.x, tested with {TESTED_PHOENIX6}), got {found}: "
            'pip install "phoenix6>=26.1,<27"'
        )


def _installed() -> str | None:
    try:
        return version("phoenix6")
    except PackageNotFoundError:
        return None


require_phoenix6(_installed())
