"""Many cases of one rule as one test, whose failure names each case that breaks the rule."""

from __future__ import annotations

import functools
import inspect
from typing import Any, Callable, Iterable, List

import pytest


def each_case(names: str, cases: Iterable[Any]) -> Callable[[Callable[..., None]], Any]:
    """Run a test for every case, as one test with the same fixtures.

    Args:
        names: The arguments that a case gives, separated by commas.
        cases: A tuple for each case; with one name, the value itself.
    """
    arguments = [name.strip() for name in names.split(",")]
    listed = [case if len(arguments) > 1 else (case,) for case in cases]
    if not listed:
        raise ValueError(f"{names}: a test without cases shows nothing")
    if any(len(case) != len(arguments) for case in listed):
        raise ValueError(f"a case gives no values for {names}")

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        signature = inspect.signature(test)

        @functools.wraps(test)
        def run(*instance: Any, **fixtures: Any) -> None:
            failures: List[BaseException] = []
            shown: List[str] = []
            for case in listed:
                try:
                    test(*instance, **fixtures, **dict(zip(arguments, case)))
                except (Exception, pytest.fail.Exception) as failure:
                    values = repr(case if len(arguments) > 1 else case[0])[:200]
                    failures.append(failure)
                    shown.append(f"{names} = {values}: {type(failure).__name__}: {failure}")
            if failures:
                raise AssertionError("\n".join(shown)) from failures[0]

        others = [one for name, one in signature.parameters.items() if name not in arguments]
        run.__signature__ = signature.replace(parameters=others)  # type: ignore[attr-defined]
        return run

    return decorate
