"""Blocks of a report and the page around them; tests with a browser are in tests/view."""

import math
import re

import numpy as np
import pytest
from each_case import each
from page_reader import report_blocks

from simcore.errors import ConfigError
from simcore.show.report import chart, headline, paragraph, report_page, series, table


def test_a_page_contains_its_blocks_in_order_and_only_finite_numbers() -> None:
    x = np.array([1.0, 2.0, math.inf])
    blocks = [
        headline("41 turns/s", "from 2 m"),
        paragraph("two\nlines"),
        table(("a", "b"), [(1, np.float64("nan")), ("x", None)], "caption"),
        chart("c", [series("s", x, [1, math.nan, None])], marks=[(1.5, "here")]),
    ]
    kept = report_blocks(report_page("title", blocks))
    assert [block["kind"] for block in kept] == ["headline", "paragraph", "table", "chart"]
    assert kept[2]["rows"] == [[1, None], ["x", None]]
    curve = {"name": "s", "kind": "line", "x": [1.0, 2.0, None], "y": [1, None, None]}
    assert kept[3]["series"] == [curve] and kept[3]["marks"] == [{"x": 1.5, "label": "here"}]


def test_texts_cannot_break_a_report_and_a_report_loads_no_external_resource() -> None:
    evil = "</script><script>alert(1)</script>"
    page = report_page(evil, [headline(evil), table([evil], [[evil]])], subtitle=evil)
    assert "alert(1)</script>" not in re.sub(r'(<script type="text/plain" id="\w+">)[^<]*', r"\1", page)
    assert report_blocks(page)[1]["rows"] == [[evil]] and "&lt;/script&gt;" in page
    assert "default-src 'none'" in page and "connect-src 'none'" in page


@each(
    ("make", "sentence"),
    [
        (lambda: table(("a", "b"), [(1,)], "t"), "table 't': row 0 has 1 cells for 2 columns"),
        (lambda: series("s", [1, 2], [1]), "series 's': x, y, low and high need equal lengths"),
        (lambda: series("s", [1], [1], low=[0]), "low and high must be given together"),
        (lambda: series("s", [1], [1], kind="pie"), "kind must be one of line, dots, bars, steps, got 'pie'"),
    ],
)
def test_a_block_that_cannot_be_drawn_is_refused(make, sentence) -> None:
    with pytest.raises(ConfigError, match=re.escape(sentence)):
        make()
