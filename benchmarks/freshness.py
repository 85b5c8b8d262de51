"""Whether a confirmed trace can hold a point that was measured before its request.

    scripts/bench.sh freshness [--traces 24] [--workers 2] [--json FILE]

Takes traces from a simulated instrument of which the bit that shows the end of a sweep clears late,
or whose display follows that bit, by 0 to 1,000 ms, in both transfer formats, with 51, 501 and
4,000 points; 84 cells. Each trace is requested at another place of the antennas, and the medium
answers with the place and the number of the sweep.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Dict, List, Tuple

from freshness_kit import DELAYS_S, FAULTS, Count, cells, drawn
from graph_kit import print_table

SUMMED = ("traces", "stale", "mixed", "doubled", "repeated")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--traces", type=int, default=24, help="traces of each cell (24)")
    parser.add_argument("--workers", type=int, default=2, help="instruments at a time (2)")
    parser.add_argument("--json", type=Path, help="file for the figures")
    chosen = parser.parse_args()
    listed = list(cells())
    counts = drawn(listed, chosen.traces, chosen.workers)
    sums: Dict[Tuple[str, float], List[Count]] = {
        (fault, delay_s): [] for fault in FAULTS for delay_s in DELAYS_S
    }
    for cell, count in zip(listed, counts):
        sums[cell.fault, cell.delay_s].append(count)
    rows = [
        [fault, f"{1e3 * delay_s:g}", *(str(_sum(found, name)) for name in SUMMED)]
        for (fault, delay_s), found in sums.items()
    ]
    total = ["all", "", *(str(_sum(counts, name)) for name in SUMMED)]
    print_table(["late", "ms", *SUMMED], [*rows, total])
    if chosen.json:
        figures = [
            {**asdict(cell), "transfer": cell.transfer.value, **_figures(count)}
            for cell, count in zip(listed, counts)
        ]
        chosen.json.write_text(json.dumps({"benchmark": "freshness", "cells": figures}, indent=1))


def _sum(counts: List[Count], name: str) -> int:
    return sum(getattr(count, name) for count in counts)


def _figures(count: Count) -> Dict[str, int]:
    return {name: getattr(count, name) for name in SUMMED}


if __name__ == "__main__":
    main()
