"""The accidents of a storage on its own: kills, power cuts, failing calls, flips, two writers."""

from __future__ import annotations

import contextlib
import copy
import errno
import itertools
import random
import shutil
import time
from pathlib import Path
from typing import Any, Callable, NamedTuple, Tuple

from failing_disk import FOR_EVER, Failure
from power_cut_disk import PowerCutDisk
from storage_kit import with_bag

from fault_suite.judge import Became, Judge, Ledger, Result, verdict_of
from fault_suite.worker import Call, Event, Step, Worker, closed_additions, new_course
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.repair import repair_survey
from gpr20_analysis.read.verdict import DAMAGED
from gpr20_survey.errors import ProcessingError

MOST_TURNS = 3
ENOUGH = 1000  # failures
# How long a process continues after its disk is gone, in which nothing may be acknowledged [s].
ALIVE_AFTER_CUT_S = 0.02
# How many calls of the disk come before a fault, from a random step on; how many fail then.
MOST_CALLS, FAILING = 60, (1, 6, FOR_EVER)
ERRORS = (errno.ENOSPC, errno.EIO, errno.EROFS, errno.EDQUOT)
# Of what was not made durable, this much is lost.
LOST_SHARES = (0.3, 0.5, 0.8, 1.0)
FLIPS_PER_SURVEY = 10
# How often somebody adds to a survey with a flip, and repairs it, before it is resumed.
ADDED_SHARE, REPAIRED_SHARE = 0.3, 0.5
CRASHED = "crashed"
# How a survey ends in the middle of a course.
ENDS = {"stopped": [Step(Call.STOPPED)], "interrupted": [Step(Call.SHUT_DOWN)], CRASHED: []}


class Course(NamedTuple):
    """What one seed gives: its random numbers, a folder, and what is acknowledged there."""

    result: Result
    name: str
    chance: random.Random
    place: Path
    ledger: Ledger


Accident = Callable[[Course], None]
# Ends a worker that is to have an accident at a step; returns whether it had one.
Strike = Callable[[Worker, int], bool]


def run(accident: Accident, result: Result, place: Path, count: int, seed: int) -> None:
    """Run courses, of which each has its seed, until there were so many accidents."""
    while sum(result.sorts.values()) < count and len(result.failures) < ENOUGH:
        name, failures = f"{result.kind} --seed {seed}", len(result.failures)
        course = Course(result, name, random.Random(name), place / str(seed), Ledger())
        course.place.mkdir(parents=True)
        accident(course)
        result.acknowledged += len(course.ledger.stored) + len(course.ledger.acknowledged())
        if len(result.failures) == failures:
            shutil.rmtree(str(course.place))
        seed += 1


def kills(course: Course) -> None:
    """Kill a worker with -9 at a random moment; its survey is resumed, and interrupted again."""

    def kill(worker: Worker, number: int) -> bool:
        time.sleep(worker.wait_for(number) * course.chance.random())
        return worker.end(kill=True)

    _interrupt(course, course.place / "data", kill)


def power_cuts(course: Course) -> None:
    """Cut the power of an ext4 in a file."""
    disk = PowerCutDisk(course.place)
    disk.mount()
    (disk.folder / "data").mkdir()
    disk.write_back()

    def cut(worker: Worker, number: int) -> bool:
        time.sleep(worker.wait_for(number) * course.chance.random())
        begun_s = time.monotonic()
        disk.cut()
        worker.dark_s = (begun_s, time.monotonic())
        time.sleep(ALIVE_AFTER_CUT_S)
        worker.end(kill=True)
        disk.unmount()
        disk.mount()
        return True

    _interrupt(course, disk.folder / "data", cut)
    disk.unmount()


def disk_faults(course: Course, power: bool) -> None:
    """Let calls of the disk fail, or cut the power of a model of it, which tears what it holds."""
    chance, data, after = course.chance, course.place / "data", course.place / "after"
    failure = Failure(
        chance.randrange(MOST_CALLS),
        power,
        durable_share=chance.choice(LOST_SHARES),
        seed=chance.getrandbits(30),
        by_sector=chance.random() < 0.8,
        error=chance.choice(ERRORS),
        lasts=chance.choice(FAILING),
        short=chance.random() < 0.5,
    )

    def fail(worker: Worker, _number: int) -> bool:
        worker.end()
        if after.exists():
            shutil.rmtree(str(data))
            after.rename(data)
        return power or bool(worker.texts(Event.FAILED))

    _interrupt(course, data, fail, failure, after)


def _interrupt(course: Course, data: Path, accident: Strike, *fault: Any) -> None:
    """Let workers have accidents in one survey, one after the other, each at a random step."""
    chance, ledger = course.chance, course.ledger
    data.mkdir(exist_ok=True)
    for turn in range(chance.randint(1, MOST_TURNS)):
        steps = new_course(chance, begins=turn == 0)
        phase = chance.choice(sorted({one.phase for one in steps}))
        number = chance.choice([n for n, one in enumerate(steps) if one.phase == phase])
        worker = Worker(data, steps, number, *fault)
        happened = accident(worker, number)
        ledger.take_down(worker)
        course.result.sorts[phase] += happened
        judge = Judge(course.result, f"{course.name}, turn {turn}, {phase}")
        judge.judge(data, ledger, worker)
        if not ledger.opened:
            break


def flips(course: Course) -> None:
    """Change a bit or a byte of a file while nobody writes the survey."""
    chance, (original, end) = course.chance, _new_survey(course)
    for number in range(FLIPS_PER_SURVEY):
        data, ledger = course.place / str(number), copy.deepcopy(course.ledger)
        shutil.copytree(str(original), str(data))
        (folder,) = data.glob("*_*")
        # All traces together are drawn as often as any other file.
        names = sorted(one.name for one in folder.iterdir() if one.is_file())
        pattern = chance.choice(["*/*", *names])
        path = chance.choice(sorted(folder.glob(pattern)) or [folder / names[0]])
        content = bytearray(path.read_bytes())
        place = chance.randrange(len(content))
        content[place] ^= chance.choice([1 << chance.randrange(8), chance.randint(1, 255)])
        path.write_bytes(content)
        course.result.sorts[f"{pattern} {end}"] += 1
        what = f"{course.name}, {end}, byte {place} of {path.name} is {content[place]}"
        judge = Judge(course.result, what, is_damaged=True)
        if end != CRASHED and verdict_of(folder)[0] != DAMAGED:
            judge.note([(Became.UNSEEN, "verify finds nothing")])
        # What people do who do not know of it, or do.
        if chance.random() < ADDED_SHARE:
            worker = Worker(data, closed_additions(chance))
            worker.end()
            ledger.take_down(worker)
        if chance.random() < REPAIRED_SHARE:
            with contextlib.suppress(AnalysisError, ProcessingError):
                repair_survey(folder)
        judge.judge(data, ledger)


def two_writers(course: Course) -> None:
    """Let two processes reopen a survey, add to it and finish it; one may be refused."""
    data, end = _new_survey(course)
    pair = [Worker(data, new_course(course.chance, begins=False)) for _ in range(2)]
    for worker in pair:
        worker.end()
        course.ledger.take_down(worker)
    course.result.sorts[end] += 1
    Judge(course.result, f"{course.name}, {end}").judge(data, course.ledger, *pair)


def _new_survey(course: Course) -> Tuple[Path, str]:
    """Make a survey that came to an end in some way; return its data folder, and how it ended."""
    chance, data = course.chance, course.place / "data"
    data.mkdir()
    steps, end = new_course(chance, begins=True), chance.choice(["finished", *ENDS])
    if end != "finished":
        calls = (Call.OPEN, Call.STORE, Call.ADD)
        opened = list(itertools.takewhile(lambda one: one.call in calls, steps))
        steps = [*opened[: chance.randint(2, len(opened))], *ENDS[end]]
    worker = Worker(data, steps)
    worker.end()
    course.ledger.take_down(worker)
    if end != CRASHED:
        with_bag(next(data.glob("*_*")))
    return data, end
