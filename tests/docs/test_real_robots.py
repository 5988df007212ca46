"""docs/real_robots.md states simcore's current errors against real robots."""

import re
import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_real_robots_page_and_its_figure_are_up_to_date():
    """`scripts/write_real_robots.py` updates them."""
    script = runpy.run_path(str(ROOT / "scripts" / "write_real_robots.py"))
    found = script["rows"]()
    assert script["text"](found) == script["PAGE"].read_text(encoding="utf-8")
    assert script["figure"](found) == script["FIGURE"].read_text(encoding="utf-8")
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    by_defaults = [abs(error) for row in found if row.what == "way by defaults" for error in row.errors]
    held_out = [abs(error) for row in found if row.what == "way of a run held out" for error in row.errors]
    said = re.search(r"two real drivetrains within (\d) % by defaults, and within (\d) % once", readme)
    assert said is not None
    assert int(said[1]) - 1 < 100.0 * max(by_defaults) <= int(said[1])
    assert int(said[2]) - 1 < 100.0 * max(held_out) <= int(said[2])
