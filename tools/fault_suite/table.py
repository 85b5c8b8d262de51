"""The one table that is the result of a run."""

from __future__ import annotations

import textwrap
from typing import List, Sequence

from fault_suite.facts import Fault, Kind
from fault_suite.judge import LAUNDERED, NAMED, STUCK, UNSEEN, Result

COLUMNS = [*(one.value for one in Fault), LAUNDERED, UNSEEN, STUCK, NAMED]
WIDTH = 100


def print_table(results: Sequence[Result]) -> None:
    """Print a line for each kind of faults, and what else a reader should know."""
    header = ["fault", "times", "failed", *(one.value for one in Kind), *COLUMNS]
    lines = [header, *map(_line, results)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    print()
    for line in lines:
        cells = [line[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(line[1:], widths[1:])]
        print("  ".join(cells))
    print()
    for one in results:
        if one.remark:
            print(textwrap.fill(f"{one.name}: {one.remark}", WIDTH, subsequent_indent="    "))


def _line(result: Result) -> List[str]:
    if not result.times:
        return [result.name, *"-" * (2 + len(Kind) + len(COLUMNS))]
    facts = [str(result.acknowledged[one]) for one in Kind]
    return [
        result.name,
        str(result.times),
        str(len(result.failed)),
        *facts,
        *(str(result.found[one]) for one in COLUMNS),
    ]
