"""Pages of results in a browser: a report with all blocks, a table of shots, and the findings of `simcore check`."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from page_reader import report_blocks

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.show.report import chart, headline, paragraph, report_page, series, share, table
from simcore.sweep.shot_files import table_page
from simcore.sweep.shot_table import make_table
from simcore.sweep.shot_task import ShotTask

X = np.arange(1.0, 9.0)


def complaints(page) -> list[str]:
    """Return the errors of scripts, without the warning that reading pixels back is slow."""
    return [error for error in page.errors if "ReadPixels" not in error]


BLOCKS = [
    headline("41 turns/s from 2 m", "a long detail <b> that must wrap " * 6),
    paragraph("one\ntwo"),
    table(["a", "b"], [[1, "a long sentence " * 9], [2.5, None]], "a table"),
    chart("curves", [series("a", X, X**2, low=X**2 - 3, high=X**2 + 3), series("b", X, [1, None, *X[2:]], kind="dots"),
                     series("c", X, X, kind="steps")], x_label="distance [m]", y_label="points",
          marks=[(3, "here")]),
    share(0.75, 0.5, 0.9, "9 of 12 runs"),
    chart("bars", [series("", range(3), [3, 5, math.nan], kind="bars")], x_names=["left", "a very long name", "right"]),
]  # fmt: skip

DRAWN = """[...document.querySelectorAll('figure:not(.robot)')].map((figure) => {
  const drawing = figure.lastElementChild, box = drawing.getBoundingClientRect();
  const shapes = [...drawing.querySelectorAll('path, rect, circle, text')].filter((node) => {
    const { width, height } = node.getBoundingClientRect(); return width + height > 0; });
  const outside = [...drawing.querySelectorAll('text')].filter((node) => {
    const at = node.getBoundingClientRect();
    return at.left < box.left - 2 || at.right > box.right + 2 || at.top < box.top - 2 || at.bottom > box.bottom + 2; });
  return [figure.className, shapes.length, outside.map((node) => node.textContent)];
})"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    """Return the paths of the pages by name."""
    folder = tmp_path_factory.mktemp("reports")
    found = {name: folder / f"{name}.html" for name in ("report", "shots", "check")}
    found["report"].write_text(report_page("all blocks", BLOCKS, subtitle="a note"), encoding="utf-8")
    found["shots"].write_text(table_page(make_table(ShotTask(REBUILT), (2.5, 3.0))), encoding="utf-8")
    words = ["check", str(folder), "--game", "rebuilt", "--out", str(found["check"])]
    assert main(words) == 0
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("name", "figures"), [("report", 3), ("shots", 4), ("check", 1)])
def test_every_chart_is_drawn_and_no_page_overflows(browser, pages, name, figures) -> None:
    url = pages[name].as_uri()
    page = browser("about:blank")
    papers = set()
    for width in (1400, 390):
        for scheme in ("light", "dark"):
            page.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
            page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            page.call("Page.navigate", url=url)
            page.wait_for(f"location.href === {json.dumps(url)} && document.body && document.body.dataset.shown")
            page.wait_for(
                "[...document.querySelectorAll('figure > svg')].every((drawing) => drawing.childElementCount)"
            )
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            drawn = page.evaluate(DRAWN)
            assert len(drawn) == figures
            for kind, shapes, outside in drawn:
                assert shapes > (4 if kind == "share" else 8) and outside == [], (kind, width, scheme)
            papers.add(page.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert len(papers) == 2, "light and dark"
    assert set(page.requests) <= {"about:blank", url} and complaints(page) == []


@pytest.mark.slow
def test_a_fraction_is_drawn_as_a_bar_of_proportional_length(browser, pages) -> None:
    """The bar has three quarters of the whole width, and whiskers are at both ends of the interval."""
    page = browser(pages["report"].as_uri())
    page.wait_for("document.body && document.body.dataset.shown && document.querySelector('figure.share rect')")
    whole, bar, line, low, high = page.evaluate(
        "[...document.querySelectorAll('figure.share rect')].map((one) => {"
        " const { left, right } = one.getBoundingClientRect(); return [left, right]; })"
    )
    wide = whole[1] - whole[0]
    found = [(at - whole[0]) / wide for at in (bar[1], line[0], line[1], low[0], high[1])]
    assert found == pytest.approx([0.75, 0.5, 0.9, 0.5, 0.9], abs=0.003)
    assert page.evaluate("document.querySelector('figure.share figcaption').innerText") == "9 of 12 runs"


@pytest.mark.slow
def test_a_robot_is_drawn_with_its_dimensions(browser, pages) -> None:
    """The label gives the bumpers as configured and the height of the highest corner, without zones and cameras."""
    page = browser(pages["check"].as_uri())
    page.wait_for("document.body && document.body.dataset.shown && document.querySelector('figure.robot canvas')")
    (block,) = [one for one in report_blocks(pages["check"].read_text()) if one["kind"] == "robot"]
    length, width = REBUILT.robot().bumper
    height = max(z for solid in block["solids"] if not solid["name"] for _, _, z in solid["points"])
    said = page.evaluate("document.querySelector('figure.robot canvas').getAttribute('aria-label')")
    assert f": bumpers {length:.2f} m, {width:.2f} m, height {height:.2f} m;" in said
    assert complaints(page) == []


@pytest.mark.slow
def test_pointing_at_a_chart_shows_values_and_texts_are_not_read_as_html(browser, pages) -> None:
    page = browser(pages["report"].as_uri())
    page.wait_for("document.body && document.body.dataset.shown && document.querySelector('figure.chart .cursor')")
    read = """(() => {
      const figure = document.querySelectorAll('figure')[%d], drawing = figure.lastElementChild;
      const box = drawing.getBoundingClientRect();
      const at = { clientX: box.left + %f * box.width, clientY: box.top + %f * box.height, bubbles: true };
      drawing.dispatchEvent(new PointerEvent('pointermove', at));
      return figure.querySelector('figcaption').innerText.replace(/\\s+/g, ' ');
    })()"""
    assert "a 64 (61 to 67) b 8 c 8" in page.evaluate(read % (0, 0.99, 0.5))
    assert "at right" in page.evaluate(read % (2, 0.9, 0.5))
    assert page.evaluate("document.querySelectorAll('main b').length") == 0, "a tag in a text is no tag"
