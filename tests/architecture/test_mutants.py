"""Every mutant in scripts/mutants.py still fits: its source text and its test exist."""

import re
from pathlib import Path

import mutants

ROOT = Path(__file__).resolve().parents[2]


def has_test(path: str) -> bool:
    file, _, name = path.partition("::")
    pattern = rf"^def {name}\(" if name else r"^def test_"
    return (ROOT / file).is_file() and bool(re.search(pattern, (ROOT / file).read_text("utf-8"), re.MULTILINE))


def test_the_source_text_and_the_test_of_every_mutant_exist():
    gone = [one.name for one in mutants.MUTANTS if one.old not in (ROOT / one.file).read_text("utf-8")]
    assert not gone, f"the source text of these mutants is gone: {gone}"
    untested = {one.name: one.test for one in mutants.MUTANTS if not has_test(one.test)}
    assert not untested, f"the tests of these mutants are gone: {untested}"
