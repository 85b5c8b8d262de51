"""Make faults of processes and disks on purpose, and look for every acknowledged fact.

Surveys are made in a folder on the disk that is to be tried, by the storage of the robot. A process
stores traces, markers, annotations and reports in a random order, reopens and finishes the survey
and adds to it later, and sends each acknowledgement to this one. Then comes one of these faults:

  kills         kill -9 of the process
  power cuts    a file system in a file on this disk is shut down without flushing its log; needs
                root, mkfs.ext4 and loop devices
  n-th call     a call of the disk fails (full, read-only, input/output error), once or for good,
                with or without half of the bytes written
  torn sectors  a model of a power cut: of the sectors written since the last fsync some are kept
  flips         one bit of a file of a survey that nobody writes; verify must find it, and
                reopening must bring everything back or name it
  two writers   two processes add to one survey at the same time

After each fault the files are read with the readers of Python's json, of mcap and of rosbags, the
survey is finished in a copy, read again, and verified.

Exit status: 0 nothing lost, 1 something lost, doubled, wrong or called intact though it is not (the
folder is kept), 2 wrong arguments, 77 none of what was asked for is possible here.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence

from fault_suite.child import refusal_of
from fault_suite.disk_calls import DiskCalls
from fault_suite.flips import Flips
from fault_suite.interruptions import Interruptions
from fault_suite.judge import Result, as_json
from fault_suite.table import print_table
from fault_suite.worker import Broken
from fault_suite.writers import Writers

NOTHING_LOST, LOST, NOT_POSSIBLE = 0, 1, 77
SHOWN = 20
USUAL = {"kills": 30, "power_cuts": 20, "faults": 60, "torn": 60, "flips": 120, "writers": 10}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run what is asked for, print the table and return the exit status."""
    chosen = _parser().parse_args(arguments)
    counts = {name: getattr(chosen, name) for name in USUAL}
    if all(count is None for count in counts.values()):
        counts = dict(USUAL)
    seed = chosen.seed or str(random.SystemRandom().randrange(10**9))
    print(f"seed {seed}: repeat with --seed {seed} and the same counts", flush=True)
    if chosen.data is not None:
        chosen.data.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(prefix="gpr20_fault_suite_", dir=chosen.data)).resolve()
    try:
        refusal = refusal_of(place / "without a fault")
        if refusal:
            print(f"no survey can be stored here: {refusal}")
            shutil.rmtree(str(place))
            return NOT_POSSIBLE
        results = _run(counts, place, seed, Broken(chosen.broken))
    except BaseException:
        print(f"ended early; remove {place}", file=sys.stderr)
        raise
    print_table(results)
    return _end(results, place, chosen.json)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fault_suite.sh",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--data", type=Path, help="folder on the disk to be tried; default: a temporary one"
    )
    for name, usual in USUAL.items():
        option = f"--{name.replace('_', '-')}"
        parser.add_argument(option, type=int, metavar="N", help=f"{usual} if no count is given")
    parser.add_argument("--seed", help="repeats the faults of a run; instants differ")
    parser.add_argument("--json", type=Path, help="file for the results, a JSON object a line")
    parser.add_argument(
        "--broken",
        choices=[one.value for one in Broken],
        default=Broken.NOTHING.value,
        help="break the storage on purpose, to see that the suite finds it",
    )
    return parser


def _run(counts: Dict[str, Optional[int]], place: Path, seed: str, broken: Broken) -> List[Result]:
    interruptions = Interruptions(place, seed, broken)
    calls = DiskCalls(place, seed, broken)
    runs: Dict[str, Callable[[int], Result]] = {
        "kills": interruptions.kills,
        "power_cuts": interruptions.power_cuts,
        "faults": calls.failing,
        "torn": calls.torn,
        "flips": Flips(place, seed, broken).run,
        "writers": Writers(place, seed, broken).run,
    }
    results = []
    for name, run in runs.items():
        if counts[name]:
            begun_s = time.monotonic()
            results.append(run(counts[name] or 0))
            found = sum(results[-1].found.values())
            took_s = time.monotonic() - begun_s
            print(f"  {results[-1].name}: {found} findings, {took_s:.0f} s", flush=True)
    return results


def _end(results: Sequence[Result], place: Path, output: Optional[Path]) -> int:
    if output is not None:
        output.write_text("".join(f"{as_json(one)}\n" for one in results), encoding="utf-8")
    texts = [text for one in results for text in one.texts]
    for text in texts[:SHOWN]:
        print(text)
    if len(texts) > SHOWN:
        print(f"... and {len(texts) - SHOWN} more, in {place}/findings.txt")
    if any(one.has_faults for one in results):
        (place / "findings.txt").write_text("".join(f"{one}\n" for one in texts), encoding="utf-8")
        print(f"everything is kept in {place}")
        return LOST
    shutil.rmtree(str(place))
    return NOTHING_LOST if any(one.times for one in results) else NOT_POSSIBLE


if __name__ == "__main__":
    sys.exit(main())
