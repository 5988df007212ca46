"""Decorator that runs one test over many cases and lists those that fail."""

import functools
import inspect

import pytest


def each(names, cases):
    """Run a test for each case, parametrized like `pytest.mark.parametrize` but as one test.

    Fixtures are shared by all cases. Failing cases are listed together, the first one with its traceback.
    """
    names = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
    rows = [
        list(case.values) if hasattr(case, "marks") else [case] if len(names) == 1 else list(case) for case in cases
    ]
    assert rows, "a test without cases holds nothing"

    def decorate(test):
        @functools.wraps(test)
        def run(*args, **fixtures):
            failed = {}
            for row in rows:
                case = dict(zip(names, row, strict=True))
                try:
                    test(*args, **fixtures, **case)
                except (Exception, pytest.fail.Exception) as error:
                    failed[", ".join(f"{name}={value!r}" for name, value in case.items())] = error
            if failed:
                first = next(iter(failed.values()))
                listed = "\n".join(f"{case}: {type(error).__name__}: {error}"[:300] for case, error in failed.items())
                raise AssertionError(f"{len(failed)} of {len(rows)} cases\n{listed}") from first

        signature = inspect.signature(test)
        own = [parameter for name, parameter in signature.parameters.items() if name not in names]
        run.__signature__ = signature.replace(parameters=own)
        return run

    return decorate
