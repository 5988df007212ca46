"""Blocks of a report: what they hold, what they refuse, and the page around them; a browser is in tests/view."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from page_reader import report_blocks

from simcore.errors import ConfigError
from simcore.show.report import chart, field_map, headline, heat, paragraph, report_page, series, table


def test_a_page_holds_its_blocks_in_order_and_no_number_that_is_not_finite() -> None:
    x = np.array([1.0, 2.0, math.inf])
    blocks = [
        headline("41 turns/s", "from 2 m"),
        paragraph("two\nlines"),
        table(("a", "b"), [(1, np.float64("nan")), ("x", None)], "caption"),
        chart("c", [series("s", x, [1, math.nan, None], ink="hit")], marks=[(1.5, "here")], levels=[(2.0, "limit")]),
        heat("h", [1.0, 2.0], ["low", "high"], [[1.0, math.nan], [0.0, 2.0]]),
        field_map("m", (16.0, 8.0), [("#123456", [(0, 0), (1, 0), (1, 1)])], [{"x": 1, "y": 2, "ink": "miss"}]),
    ]
    kept = report_blocks(report_page("title", blocks))
    assert [block["kind"] for block in kept] == ["headline", "paragraph", "table", "chart", "heat", "field_map"]
    assert kept[2]["rows"] == [[1, None], ["x", None]]
    curve = {"name": "s", "kind": "line", "x": [1.0, 2.0, None], "y": [1, None, None], "color": "var(--hit)"}
    assert kept[3]["series"] == [curve] and kept[3]["levels"] == [{"y": 2.0, "label": "limit"}]
    assert (kept[4]["x"], kept[4]["y"], kept[4]["yNames"]) == ([1.0, 2.0], [0, 1], ["low", "high"])
    assert kept[4]["values"] == [[1.0, None], [0.0, 2.0]]
    assert kept[5]["points"] == [{"x": 1, "y": 2, "color": "var(--miss)"}]


def test_texts_cannot_break_the_page_and_nothing_is_loaded_from_anywhere() -> None:
    evil = "</script><script>alert(1)</script>"
    page = report_page(evil, [headline(evil), table([evil], [[evil]])], subtitle=evil)
    assert "alert(1)</script>" not in re.sub(r'(<script type="text/plain" id="\w+">)[^<]*', r"\1", page)
    assert report_blocks(page)[1]["rows"] == [[evil]] and "&lt;/script&gt;" in page
    assert "default-src 'none'" in page and "connect-src 'none'" in page


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: table(("a", "b"), [(1,)], "t"), "table 't': row 0 has 1 cells for 2 columns"),
        (lambda: series("s", [1, 2], [1]), "series 's': x, y, low and high need equal lengths"),
        (lambda: series("s", [1], [1], low=[0]), "low and high come together"),
        (lambda: series("s", [1], [1], kind="pie"), "kind must be one of line, dots, bars, steps, got 'pie'"),
        (lambda: series("s", [1], [1], ink="pink"), "no color named 'pink'. Known: paper"),
        (lambda: heat("h", [1, 2], [1], [[1]]), "heat map 'h': 1 rows of 2 cells wanted"),
        (lambda: heat("h", [], [], []), "heat map 'h'"),
        (lambda: field_map("m", (1, 1), [], [{"x": 1}]), "map 'm': a point has no y"),
    ],
)
def test_a_block_that_cannot_be_drawn_is_refused(make, sentence) -> None:
    with pytest.raises(ConfigError, match=re.escape(sentence)):
        make()
