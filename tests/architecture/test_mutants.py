"""Mutants are a list of lines of ours: one that is rewritten shall not leave a mutant behind that changes nothing."""

from pathlib import Path

import pytest
from pytest import MonkeyPatch

ROOT = Path(__file__).resolve().parents[2]

with MonkeyPatch.context() as patch:
    patch.syspath_prepend(str(ROOT / "scripts"))
    from mutants import MUTANTS


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_a_mutant_finds_its_line_and_its_test(mutant):
    assert mutant.old in (ROOT / mutant.file).read_text(encoding="utf-8")
    path, _, name = mutant.test.partition("::")
    assert (ROOT / path).exists()
    assert not name or f"def {name.partition('[')[0]}(" in (ROOT / path).read_text(encoding="utf-8")
