from __future__ import annotations

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.match.run_record import TickTimer, TickTimes, TrajectoryDigest


def digest(*ticks: tuple[object, ...]) -> str:
    recorder = TrajectoryDigest()
    for arrays in ticks:
        recorder.update(*(np.asarray(array) for array in arrays))
    return recorder.hexdigest()


def test_one_bit_changes_the_digest() -> None:
    assert digest(([1.0, 2.0],)) != digest(([1.0, np.nextafter(2.0, 3.0)],))


def test_layout_and_sign_of_zero_do_not() -> None:
    values = np.arange(12.0).reshape(3, 4)
    assert digest((values,)) == digest((np.asfortranarray(values),)) == digest((values.astype(">f8"),))
    assert digest(([0.0],)) == digest(([-0.0],))


def test_shape_and_order_count() -> None:
    assert digest((np.zeros((2, 3)),)) != digest((np.zeros((3, 2)),))
    assert digest(([1.0], [2.0])) != digest(([2.0], [1.0]))


def test_input_is_left_alone() -> None:
    values = np.array([-0.0])
    values.setflags(write=False)
    TrajectoryDigest().update(values)
    assert np.signbit(values[0])


def test_known_value() -> None:
    """Fixed for good: another value means that digests of old reports no longer compare."""
    assert digest(([1.0, 2.0],)) == "f2942cc692d15d574dc0dd7f6b46695441e9fedd690d3b7ce38ad1f5127d1924"


def test_percentiles() -> None:
    timer = TickTimer()
    for k in range(101):
        timer.add(k / 1000.0)
    assert timer.times() == TickTimes(
        median=pytest.approx(50.0), p95=pytest.approx(95.0), p99=pytest.approx(99.0), max=pytest.approx(100.0)
    )
    assert len(timer) == 101


def test_no_tick() -> None:
    assert TickTimer().times() == TickTimes(median=0.0, p95=0.0, p99=0.0, max=0.0)


@pytest.mark.parametrize("seconds", [-1e-3, float("nan"), float("inf")])
def test_bad_time(seconds: float) -> None:
    with pytest.raises(ConfigError, match="tick"):
        TickTimer().add(seconds)
