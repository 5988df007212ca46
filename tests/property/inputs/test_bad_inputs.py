"""Wrong input is refused with a sentence that names it, or taken where it makes sense; nothing else, and at once."""

from __future__ import annotations

import dataclasses
import math
import signal
from collections import Counter

import bad_inputs
import made_configs
import numpy as np
import pytest

from simcore.errors import SimcoreError

MOST_SECONDS = 2.0
"""Of this process's time for one input [s]."""


class Hangs(BaseException):
    """It took too long."""


def _stop(number: int, frame: object) -> None:
    raise Hangs


def verdict(case: bad_inputs.Case) -> str:
    """`refused`, `taken`, or what is wrong with how simcore met an input."""
    signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
    try:
        case.run()
    except SimcoreError as error:
        text = str(error)
        return "refused" if any(name in text for name in case.names) else f"unnamed: {text[:200]}"
    except bad_inputs.Nonsense as error:
        return f"nonsense: {error}"
    except Hangs:
        return "hangs"
    except Exception as error:
        return f"foreign: {type(error).__name__}: {str(error)[:200]}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return "taken"


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer to stop a hang with")
def test_wrong_input_is_refused_by_name_or_makes_sense(whole, tmp_path, monkeypatch):
    """All of `bad_inputs.COUNT` with --whole, else every eleventh."""
    monkeypatch.chdir(tmp_path)
    before = signal.signal(signal.SIGPROF, _stop)
    met: Counter[str] = Counter()
    wrong = []
    try:
        bad_inputs.take_good_inputs(tmp_path)
        for number in range(0, bad_inputs.COUNT, 1 if whole else 11):
            case = bad_inputs.case(number, tmp_path)
            said = verdict(case)
            kind = case.text.split(":")[0] if ":" in case.text else "flag" if "simcore" in case.text else "config"
            met[f"{kind} {said.split(':')[0]}"] += 1
            if said not in ("refused", "taken"):
                wrong.append(f"{number} {case.text}: {said}")
    finally:
        signal.signal(signal.SIGPROF, before)
    print(f"\n{dict(sorted(met.items()))}")
    assert wrong == []
    assert sum(n for kind, n in met.items() if kind.endswith("refused")) > 0.6 * sum(met.values())


def test_every_config_has_an_example_and_refuses_no_number_where_a_number_is_due():
    """NaN in each number of each config, whether new or old: none is forgotten."""
    forgotten = []
    for kind in made_configs.config_types():
        good = made_configs.examples()[kind]
        for name in made_configs.number_places(kind):
            before = getattr(good, name)
            bad = math.nan
            if isinstance(before, np.ndarray):
                bad = np.full(before.shape, math.nan) if before.size else np.full((1, 3), math.nan)
            elif isinstance(before, tuple) and before and all(isinstance(n, float | int) for n in before):
                bad = (*before[:-1], math.nan)
            try:
                dataclasses.replace(good, **{name: bad})
            except SimcoreError as error:
                if name not in str(error):
                    forgotten.append(f"{kind.__name__}.{name} is not named in: {error}")
            except Exception as error:
                forgotten.append(f"{kind.__name__}.{name}: {type(error).__name__} {error}")
            else:
                forgotten.append(f"{kind.__name__}.{name} may be {bad}")
    assert forgotten == []
