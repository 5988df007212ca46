"""Compare every control request on CTRE's simulation in real time with the emulator in simulated time: a table.

    python scripts/compare_emulator.py                        # both now; about 20 s of wall clock on a quiet machine
    python scripts/compare_emulator.py --recorded             # the real figures of the recording
    python scripts/compare_emulator.py --record               # both now, and keep the real ones as the recording
    python scripts/compare_emulator.py --only VoltageOut Follower

Ends with status 1 when a row is out of tolerance, 2 when the machine was too slow to judge.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SCENARIO = ROOT / "tests" / "adapters" / "scenarios" / "control_cases.py"
RECORDING = ROOT / "tests" / "adapters" / "data" / "phoenix6_26.3.0.json"

T90, OVERSHOOT, FINAL = 0.020, 0.03, 0.005
"""Tolerances: t90 [s], overshoot and final value as shares of the step [-]."""
LIMITED_T90 = 0.030
"""Tolerance of t90 at a supply limit, which CTRE's simulation applies late while a motor speeds up [s]."""
TOO_LATE_MS = 8.0


def run(mode: str, names: list[str]) -> dict[str, Any]:
    """Return figures by case, from a separate process in its own folder."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, str(SCENARIO), mode, *names],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            timeout=180,
            check=False,
        )
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        raise SystemExit(f"{mode}: the scenario failed\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    result: dict[str, Any] = json.loads(lines[-1])
    return result


def misses(name: str, real: dict[str, float], simulated: dict[str, float]) -> list[str]:
    """Return the figures of a case that are out of tolerance."""
    found = []
    if abs(real["t90"] - simulated["t90"]) > (LIMITED_T90 if "supply" in name else T90):
        found.append("t90")
    if abs(real["overshoot"] - simulated["overshoot"]) > OVERSHOOT:
        found.append("overshoot")
    if abs(real["final"] - simulated["final"]) > FINAL * real["step"]:
        found.append("final")
    return found


def table(real: dict[str, Any], simulated: dict[str, Any]) -> tuple[str, int]:
    """Return the figures side by side as Markdown, and the number of rows out of tolerance."""
    rows = [
        "| request | t90 real | simulated | difference | overshoot real | simulated | final real | simulated | off |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    bad = 0
    for name, a in real.items():
        b = simulated[name]
        missed = misses(name, a, b)
        bad += bool(missed)
        t90 = [f"{x['t90']:.3f} s" if x["t90"] >= 0.0 else "-" for x in (a, b)]
        late = f"{1e3 * (b['t90'] - a['t90']):+.1f} ms"
        final = f"{100.0 * (b['final'] - a['final']) / a['step']:+.2f} %"
        rows.append(
            f"| {name}{' **out: ' + ', '.join(missed) + '**' if missed else ''} | {t90[0]} | {t90[1]} | {late} "
            f"| {100 * a['overshoot']:.1f} % | {100 * b['overshoot']:.1f} % "
            f"| {a['final']:.4g} | {b['final']:.4g} | {final} |"
        )
    return "\n".join(rows), bad


def main(arguments: list[str] | None = None) -> int:
    """Run both, compare and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recorded", action="store_true", help="take the real figures from the recording")
    parser.add_argument("--record", action="store_true", help="keep the real figures as the recording")
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE", help="these cases only")
    options = parser.parse_args(arguments)
    recording = json.loads(RECORDING.read_text())
    simulated = run("simulated", options.only)["figures"]
    if options.recorded:
        real = {name: figures for name, figures in recording["figures"].items() if name in simulated}
        print(f"recorded with phoenix6 {recording['phoenix6']}")
    else:
        result = run("real", options.only)
        real = result["figures"]
        print(f"phoenix6 {metadata.version('phoenix6')}, physics at most {result['lateness_ms']:.1f} ms late")
        if result["lateness_ms"] > TOO_LATE_MS:
            print("too slow to judge: CTRE's simulation runs on the wall clock")
            return 2
    text, bad = table(real, simulated)
    print(text)
    if options.record and not options.only:
        recording["figures"], recording["phoenix6"] = real, metadata.version("phoenix6")
        RECORDING.write_text(json.dumps(recording, indent=1) + "\n")
    print(
        f"{len(real) - bad} of {len(real)} within {1e3 * T90:.0f} ms, {100 * OVERSHOOT:.0f} % and {100 * FINAL:.1f} %"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
