"""Gyro model with drift, scale error, noise and disturbance by impacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.errors import NonFiniteError, UnknownNameError
from simcore.quantities import FRACTION, NOISE_DEGREES, Quantity, checked_number, require_fields
from simcore.typing import FloatArray

__all__ = ["GYROS", "Gyro", "GyroConfig", "gyro_config"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroConfig:
    """Config of a gyro: magnitudes of the errors, which do not depend on the length of a step."""

    name: str = "ideal"
    drift_deg_per_minute: float = 0.0
    """Standard deviation of the yaw drift at rest after calibration [deg/min]; the gyro draws one drift per run."""
    bias_dps: float = 0.0
    """Constant yaw rate at rest, added to the random drift [deg/s]."""
    scale_error: float = 0.0
    """Standard deviation of the scale error of yaw [-]; 0.01 means 3.6 deg per turn. The gyro draws one scale error per
    run."""
    rate_noise: float = 0.0
    """Standard deviation of the noise on each reported rate, as a fraction of the rate [-]; no effect on the angles."""
    rate_noise_floor_dps: float = 0.0
    """Standard deviation of the noise on each reported rate at rest [deg/s]."""
    tilt_noise_deg: float = 0.0
    """Standard deviation of the noise on each reported pitch and roll [deg]."""
    impact_deg: float = 0.0
    """Standard deviation of the yaw jump at an impact with a yaw acceleration of `impact_accel` [deg]. The jump is
    proportional to the yaw acceleration of harder impacts."""
    impact_accel: float = 500.0
    """Smallest yaw acceleration at which an impact disturbs the gyro [rad/s^2]; 0 for no disturbance by impacts."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            f"gyro {self.name}",
            drift_deg_per_minute=NOISE_DEGREES,
            bias_dps=Quantity("deg/s", -1000.0, 1000.0),
            scale_error=FRACTION,
            rate_noise=FRACTION,
            rate_noise_floor_dps=Quantity("deg/s", 0.0, 1000.0),
            tilt_noise_deg=NOISE_DEGREES,
            impact_deg=NOISE_DEGREES,
            impact_accel=Quantity("rad/s^2", 0.0, 1e6),
        )


# Drift: estimates, within a factor of 2. Rate noise: MapleSim's COTS table. Scale and tilt errors: estimates, +-50 %.
GYROS = {
    "ideal": GyroConfig(),
    "pigeon2": GyroConfig(
        name="Pigeon 2",
        drift_deg_per_minute=0.4,
        scale_error=0.002,
        rate_noise=0.02,
        rate_noise_floor_dps=0.05,
        tilt_noise_deg=0.05,
        impact_deg=1.0,
    ),
    "navx2": GyroConfig(
        name="navX-2",
        drift_deg_per_minute=1.0,
        scale_error=0.005,
        rate_noise=0.04,
        rate_noise_floor_dps=0.1,
        tilt_noise_deg=0.1,
        impact_deg=1.0,
    ),
    "generic": GyroConfig(
        name="generic",
        drift_deg_per_minute=2.0,
        scale_error=0.01,
        rate_noise=0.06,
        rate_noise_floor_dps=0.2,
        tilt_noise_deg=0.2,
        impact_deg=1.0,
    ),
}


def gyro_config(name: str) -> GyroConfig:
    """Look up the preset config of a gyro by name: ideal, pigeon2, navx2 or generic.

    Raises:
        UnknownNameError: If no preset has this name; the message suggests similar names.
    """
    if name not in GYROS:
        raise UnknownNameError("gyro", name, GYROS)
    return GYROS[name]


_DRAWN = 600  # random numbers per call of the generator; a call takes 3 us for 6 numbers and for 100 numbers


class Gyro:
    """Gyro that reports the true attitude and rates with errors.

    Random generators with equal seeds give equal readings.
    """

    def __init__(self, config: GyroConfig, rng: np.random.Generator) -> None:
        """Draw the constant errors, and start with zero yaw, pitch, roll and rates.

        Args:
            config: Errors of the gyro.
            rng: Random generator for all errors.
        """
        self.config = config
        self._rng = rng
        self._noise: list[float] = []
        self._scale = 1.0 + config.scale_error * float(rng.standard_normal())
        drift = config.drift_deg_per_minute / 60.0 * float(rng.standard_normal())
        self._bias, self._floor = math.radians(config.bias_dps + drift), math.radians(config.rate_noise_floor_dps)
        self._tilt = math.radians(config.tilt_noise_deg)
        self.reset()

    def reset(self, *, yaw: float = 0.0, true_yaw: float = 0.0) -> None:
        """Set the reported yaw, and zero the reported pitch, roll and rates.

        Args:
            yaw: New reported yaw [rad].
            true_yaw: Current true yaw of the robot [rad].

        Raises:
            NonFiniteError: If a value is not finite; the gyro is left unchanged.
        """
        yaw, true_yaw = checked_number("gyro: yaw", yaw), checked_number("gyro: true_yaw", true_yaw)
        self.yaw = yaw
        """Reported yaw, continuous over turns [rad]."""
        self.pitch = 0.0
        """Reported pitch, positive nose down, as in WPILib [rad]."""
        self.roll = 0.0
        """Reported roll [rad]."""
        self.rates: FloatArray = np.zeros(3)
        """Reported rates about the robot's x, y, z axes [rad/s], shape (3,)."""
        self._true_yaw = true_yaw
        self._true_rate: float | None = None

    def set_yaw(self, yaw: float) -> None:
        """Set the reported yaw [rad], as robot code does; raises the same errors as `reset`."""
        self.yaw = checked_number("gyro: yaw", yaw)

    def step(self, dt: float, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Update the readings at the end of a step.

        Args:
            dt: Time since the last step [s].
            yaw: True yaw at the end of the step, wrapped or continuous [rad]; must change by less than half a turn.
            pitch: True pitch at the end of the step [rad].
            roll: True roll at the end of the step [rad].
            rates: True rates about the robot axes [rad/s], shape (3,).

        Raises:
            NonFiniteError: If an argument is not finite; the gyro is left unchanged.
        """
        if not all(map(math.isfinite, (dt, yaw, pitch, roll, *rates))):
            raise NonFiniteError(f"gyro: need finite numbers, got dt={dt}, yaw={yaw}, pitch={pitch}, roll={roll}")
        c = self.config
        if len(self._noise) < 6:
            self._noise = self._rng.standard_normal(_DRAWN).tolist()
        noise = self._noise[-6:]
        del self._noise[-6:]
        turned = math.remainder(yaw - self._true_yaw, math.tau)
        self.yaw += turned * self._scale + self._bias * dt
        if self._true_rate is not None and c.impact_deg > 0.0 and dt > 0.0:
            accel = abs(rates[2] - self._true_rate) / dt
            if accel >= c.impact_accel > 0.0:
                self.yaw += math.radians(c.impact_deg) * accel / c.impact_accel * noise[0]
        self._true_yaw = yaw
        self._true_rate = rates[2]
        self.pitch = pitch + self._tilt * noise[1]
        self.roll = roll + self._tilt * noise[2]
        self.rates = np.array(
            [r + math.hypot(c.rate_noise * r, self._floor) * n for r, n in zip(rates, noise[3:], strict=True)]
        )
        self.rates[2] += self._bias
