"""Counts how often the intervals of `simcore calibrate` hold values that are known: those of made logs.

python scripts/calibrate_coverage.py [--logs 100]

A log of a tank has SysId's four runs, 20 ms apart, with 2.5 mm of noise on ways and .05 V on volts; 95 of 100 hold.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "shared"))

from made_logs import driven

from simcore.calibrate.drive_fit import fit_drive
from simcore.calibrate.drive_model import varied
from simcore.robot.fixed_wheel_config import TankConfig


def main() -> None:
    """Print how many intervals hold, and how wide they are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=100, help="how many")
    held: dict[str, list[bool]] = {"ks": [], "mass": []}
    widths: dict[str, list[float]] = {"ks": [], "mass": []}
    for seed in range(parser.parse_args().logs):
        rng = np.random.default_rng(seed)
        known = {"ks": rng.uniform(0.2, 1.0), "mass": rng.uniform(30.0, 65.0)}
        config = varied(TankConfig(), ks=known["ks"], mass=known["mass"])
        found = fit_drive(TankConfig(), driven(config, noise=0.0025, seed=seed)).estimates
        for name, value in known.items():
            held[name].append(found[name].low <= value <= found[name].high)
            widths[name].append(found[name].share)
    for name, ones in held.items():
        print(f"{name}: {sum(ones)} of {len(ones)} hold; half an interval is {100 * np.median(widths[name]):.1f} %")


if __name__ == "__main__":
    main()
