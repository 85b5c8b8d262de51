"""Make accidents of the storage on purpose, and look for all that it had acknowledged.

A worker opens, fills, closes and reopens a survey in a random course of traces, markers,
annotations, reports and decisions. Then its files are read by json, mcap and rosbags, and it is
verified, finished in a copy, read and verified again. The accidents:

  kills     kill -9 of the worker
  cuts      power cuts of an ext4 in a file, where one can be mounted
  calls     calls of the disk fail: full, input/output error, half of the bytes written; or the
            power of a simulated disk is cut, which tears what it has not made durable
  writers   two processes want to write one survey at the same time

Exit status: 0 nothing failed; 1 something was lost, doubled, moved, changed, called complete though
it is not, or stuck (the folder is kept); 2 wrong arguments; 77 nothing is possible here.
"""

from __future__ import annotations

import argparse
import errno
import itertools
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, List, Optional, Sequence

from failing_disk import FOR_EVER, Failure, PowerCutDisk, PowerCutError, can_be_cut

from fault_suite.judge import Ledger, judged
from fault_suite.worker import Call, Event, Step, Worker, new_course

NOTHING_LOST, LOST, NOT_POSSIBLE = 0, 1, 77
# How many accidents of each kind there are.
COUNTS = {"kills": 80, "cuts": 60, "calls": 260, "writers": 20}
MOST_TURNS = 3
# How long a step is waited for before the accident comes in it [s].
STEP_S = 0.02
# How many calls of the disk come before a fault, from a random step on; how many fail then.
MOST_CALLS, FAILING = 60, (1, 6, FOR_EVER)
ERRORS = (errno.ENOSPC, errno.EIO, errno.EROFS, errno.EDQUOT)
# Of what was not made durable, this much is lost.
LOST_SHARES = (0.3, 0.5, 0.8, 1.0)


class Course:
    """What one seed gives: each method makes accidents of one kind in one survey.

    Attributes:
        ledger: What was acknowledged.
        wrong: What was not found of it.
        count: How many accidents there were.
    """

    def __init__(self, name: str, place: Path) -> None:
        self.chance, self.place = random.Random(name), place
        self.ledger, self.count = Ledger(), 0
        self.wrong: List[str] = []
        place.mkdir(parents=True)

    def kills(self) -> None:
        """Kill a worker with -9 at a random moment of a step."""

        def kill(worker: Worker) -> bool:
            time.sleep(STEP_S * self.chance.random())
            return worker.end(kill=True)

        self._interrupt(self.place / "data", kill)

    def cuts(self) -> None:
        """Cut the power of an ext4 in a file."""
        disk = PowerCutDisk(self.place)
        disk.mount()
        (disk.folder / "data").mkdir()
        disk.write_back()

        def cut(worker: Worker) -> bool:
            time.sleep(STEP_S * self.chance.random())
            worker.freeze()
            disk.cut()
            worker.end(kill=True)
            disk.unmount()
            disk.mount()
            return True

        self._interrupt(disk.folder / "data", cut)
        disk.unmount()

    def calls(self) -> None:
        """Let calls of the disk fail, or cut the power of a model of it, which tears files."""
        chance, data, after = self.chance, self.place / "data", self.place / "after"
        failure = Failure(
            chance.randrange(MOST_CALLS),
            power=chance.random() < 0.3,
            lost_share=chance.choice(LOST_SHARES),
            seed=chance.getrandbits(30),
            by_sector=chance.random() < 0.8,
            error=chance.choice(ERRORS),
            lasts=chance.choice(FAILING),
            short=chance.random() < 0.5,
        )

        def fail(worker: Worker) -> bool:
            worker.end()
            if after.exists():
                shutil.rmtree(str(data))
                after.rename(data)
            return failure.power or bool(worker.texts(Event.FAILED))

        self._interrupt(data, fail, failure, after)

    def writers(self) -> None:
        """Let two processes reopen a survey, add to it and finish it; one may be refused."""
        data, chance = self.place / "data", self.chance
        data.mkdir()
        steps = new_course(chance, begins=True)
        # It was finished, stopped, interrupted or crashed.
        end = chance.choice([Call.FINISHED, Call.STOPPED, Call.SHUT_DOWN, None])
        if end is not Call.FINISHED:
            ends = (Call.FINISHED, Call.STOPPED)
            last = next(number for number, one in enumerate(steps) if one.call in ends)
            steps = steps[: chance.randint(2, last)] + ([Step(end)] if end else [])
        self._end(Worker(data, steps))
        pair = [Worker(data, new_course(chance, begins=False)) for _ in range(2)]
        for worker in pair:
            self._end(worker)
        self.count += 1
        self.wrong.extend(dict.fromkeys(judged(data, self.ledger, *pair)))

    def _end(self, worker: Worker) -> None:
        worker.end()
        self.ledger.take_down(worker)

    def _interrupt(self, data: Path, strike: Callable[[Worker], bool], *fault: Any) -> None:
        """Let workers have accidents in one survey, one after the other, each at a random step.

        Args:
            data: The data folder.
            strike: Ends a worker whose step has begun; returns whether it had an accident.
            fault: How the disk of a worker fails from that step on.
        """
        chance = self.chance
        data.mkdir(exist_ok=True)
        for turn in range(chance.randint(1, MOST_TURNS)):
            steps = new_course(chance, begins=turn == 0)
            phase = chance.choice(sorted({one.phase for one in steps}))
            number = chance.choice([n for n, one in enumerate(steps) if one.phase == phase])
            worker = Worker(data, steps, number, *fault)
            worker.wait_for(number)
            self.count += strike(worker)
            self.ledger.take_down(worker)
            found = dict.fromkeys(judged(data, self.ledger, worker))
            self.wrong.extend(f"{one} (turn {turn}, {phase})" for one in found)
            if not self.ledger.opened:
                break


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run what is asked for, print a line for each kind and return the exit status."""
    parser = argparse.ArgumentParser(
        "fault_suite.sh", None, __doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--only", nargs="+", choices=COUNTS, default=[*COUNTS], metavar="KIND", help="some kinds")
    add("--data", type=Path, default=tempfile.gettempdir(), help="a folder on the disk to try")
    add("--seed", type=int, default=1, help="of the first course; each next one has the next")
    add("--count", type=int, metavar="N", help="how many accidents of each kind")
    chosen = parser.parse_args(arguments)
    chosen.data.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(prefix="gpr20_fault_suite_", dir=chosen.data)).resolve()
    total = 0
    failures: List[str] = []
    for kind in chosen.only:
        least = COUNTS[kind] if chosen.count is None else chosen.count
        try:
            if kind == "cuts":
                can_be_cut()
        except PowerCutError as error:
            print(f"{kind:8} not possible here: {error}")
            continue
        count, acknowledged, wrong = 0, 0, len(failures)
        for seed in itertools.count(chosen.seed):
            name = f"{kind} --seed {seed}"
            course = Course(name, place / kind / str(seed))
            getattr(course, kind)()
            count += course.count
            acknowledged += len(course.ledger.stored) + len(course.ledger.acknowledged())
            failures += [f"{one}; {name}" for one in course.wrong]
            if not course.wrong:
                shutil.rmtree(str(course.place))
            if count >= least:
                break
        wrong = len(failures) - wrong
        print(f"{kind:8} {count:4} accidents, {acknowledged:5} acknowledged, {wrong} wrong")
        total += count
    if failures:
        (place / "failures.txt").write_text("\n".join(failures), "utf-8")
        print(*failures[:20], f"all {len(failures)} are in {place}, with the surveys", sep="\n")
        return LOST
    shutil.rmtree(str(place))
    return NOTHING_LOST if total else NOT_POSSIBLE


if __name__ == "__main__":
    sys.exit(main())
