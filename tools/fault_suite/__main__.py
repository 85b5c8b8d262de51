"""Make accidents of the storage on purpose, and look for all that it had acknowledged.

A worker opens, fills, closes and reopens a survey in a random course of traces, markers,
annotations, reports and decisions. Then its files are read by json, mcap and rosbags, and it is
verified, finished in a copy, read and verified again. The accidents:

  kills     kill -9 of the worker
  graph     kill -9 of a node, rosout, the master, roslaunch or all of them, in a survey of the
            simulated robot; takes minutes, and needs the built workspace
  cuts      power cuts of an ext4 in a file; where none can be mounted, of a simulated disk
  flips     a bit or a byte of a file is changed; verify must find it if the survey was closed
  calls     calls of the disk fail: full, input/output error, half of the bytes written
  writers   two processes want to write one survey at the same time

Exit status: 0 nothing failed; 1 something was lost, doubled, moved, changed, called intact though
it is not, unseen or stuck (the folder is kept); 2 wrong arguments; 77 nothing is possible here.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import shutil
import sys
import tempfile
from pathlib import Path
from typing import ContextManager, Dict, Optional, Sequence

from power_cut_disk import PowerCutError, check, hide_mounts

from fault_suite import accidents
from fault_suite.accidents import Accident
from fault_suite.judge import Became, Result

NOTHING_LOST, LOST, NOT_POSSIBLE = 0, 1, 77
# How many accidents of each kind there are, and how many in a quick run.
COUNTS = {"kills": (80, 3), "graph": (20, 0), "cuts": (60, 2)}
COUNTS.update({"flips": (500, 10), "calls": (200, 4), "writers": (20, 1)})


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run what is asked for, print the table and return the exit status."""
    parser = argparse.ArgumentParser(
        "fault_suite.sh", None, __doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--only", nargs="+", choices=COUNTS, default=[*COUNTS], metavar="KIND", help="some kinds")
    add("--data", type=Path, default=tempfile.gettempdir(), help="a folder on the disk to try")
    add("--seed", type=int, default=1, help="of the first course; each next one has the next")
    add("--count", type=int, metavar="N", help="how many accidents of each kind")
    add("--quick", action="store_true", help="a few of each kind but the graph, in seconds")
    add("--simulated-disk", action="store_true", help="cut the power of a simulated disk")
    chosen = parser.parse_args(arguments)
    chosen.data.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(prefix="gpr20_fault_suite_", dir=chosen.data)).resolve()
    results = [Result(one) for one in chosen.only]
    for one in results:
        count = COUNTS[one.kind][chosen.quick] if chosen.count is None else chosen.count
        try:
            with _accident(one, place / one.kind, chosen.simulated_disk) as accident:
                accidents.run(accident, one, place / one.kind, count, chosen.seed)
        except ImportError as error:
            one.remark = f"not possible without the built workspace: {error}"
        print(f"  {one.kind} from seed {chosen.seed}: {len(one.failures)} failures", flush=True)
    _print_table(results)
    failures = [text for one in results for text in one.failures]
    if failures:
        (place / "failures.txt").write_text("\n".join(failures), "utf-8")
        print(*failures[:20], f"all {len(failures)} are in {place}, with the surveys", sep="\n")
        return LOST
    shutil.rmtree(str(place))
    return NOTHING_LOST if any(one.sorts for one in results) else NOT_POSSIBLE


def _accident(result: Result, place: Path, simulated: bool) -> ContextManager[Accident]:
    if result.kind == "graph":
        from fault_suite.graph import RobotKills  # needs ROS

        return RobotKills(place)
    if result.kind == "cuts":
        try:
            hide_mounts()
            check()
        except PowerCutError as error:
            simulated, result.remark = True, f"{error}; "
        result.remark += f"on {'a simulated disk' if simulated else 'an ext4 in a file'}: "
    cuts = functools.partial(accidents.disk_faults, power=True)
    found: Dict[str, Accident] = {
        "kills": accidents.kills,
        "cuts": cuts if simulated else accidents.power_cuts,
        "flips": accidents.flips,
        "calls": functools.partial(accidents.disk_faults, power=False),
        "writers": accidents.two_writers,
    }
    return contextlib.nullcontext(found[result.kind])


def _print_table(results: Sequence[Result]) -> None:
    print("accident times acknowledged", *(f"{one.name.lower():>9}" for one in Became), "of which")
    for one in results:
        counts = (f"{one.found[became]:9}" for became in Became)
        sorts = ", ".join(f"{count} {sort}" for sort, count in one.sorts.most_common() if count)
        print(f"{one.kind:8} {sum(one.sorts.values()):5} {one.acknowledged:12}", *counts, end=" ")
        print(f"{one.remark}{sorts}")


if __name__ == "__main__":
    sys.exit(main())
