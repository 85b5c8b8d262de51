"""Cuts the power of a disk at random instants of a survey, and looks for what was acknowledged.

A program for test_power_cuts.py. A child opens, fills, interrupts, reopens and finishes a survey as
fast as it can, and sends each acknowledgement. In the middle of it the file system is shut down
without flushing its log and the child killed; after the next mount the files are examined, and the
survey is finished in a copy. Then a second child resumes the survey, and its power is cut too.

Prints a JSON object. Ends with status 77 and the reason where power cuts are not possible.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import json
import multiprocessing
import random
import shutil
import statistics
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

from power_cut_child import ENDED, FIRST, RESUMED, run_child
from power_cut_disk import PowerCutDisk, PowerCutError, check, hide_mounts
from power_cut_evidence import Acknowledged, check_continues, lost_traces

NOT_POSSIBLE = 77
# How long the child continues after a cut, in which nothing may be acknowledged [s].
ALIVE_AFTER_CUT_S = 0.02
DRY_RUNS = 5
fork = multiprocessing.get_context("fork")


def usual_durations_s(place):
    """Return how long each phase takes without a cut [s]."""
    runs = [durations_s(place / str(number)) for number in range(DRY_RUNS)]
    return {phase: statistics.median(run[phase] for run in runs) for phase in FIRST}


def durations_s(place):
    disk, data = new_disk(place)
    child, connection = start(data, resumed=False, durable=True)
    begun = [(value, end_s) for kind, value, _, end_s in received(connection) if kind == "phase"]
    begun.append((ENDED, time.monotonic()))
    child.join()
    disk.unmount()
    shutil.rmtree(str(place))
    return {phase: after_s - at_s for (phase, at_s), (_, after_s) in zip(begun, begun[1:])}


def received(connection):
    """Yield what a child sends until it ends, perhaps in the middle of a message."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            yield connection.recv()


def new_disk(place):
    place.mkdir(parents=True)
    disk = PowerCutDisk(place)
    disk.mount()
    data = disk.folder / "data"
    data.mkdir()
    # That the data folder exists is not part of the test.
    disk.write_back()
    return disk, data


def start(data, resumed, durable):
    own, given = fork.Pipe(duplex=False)
    child = fork.Process(target=run_child, args=(data, given, resumed, durable), daemon=True)
    child.start()
    given.close()
    return child, own


@dataclass(frozen=True)
class Moment:
    """When the power is cut."""

    phase: str
    """After this phase of the child began."""
    delay_s: float
    """This long after the phase began, or after the write-back [s]."""
    write_back_s: float = -1.0
    """This long after it began, the kernel writes everything to the disk; negative: it does not."""


def cut_during(disk, data, acknowledged, moment, resumed=False, durable=True):
    """Run a child, cut the power, and mount the disk again.

    Args:
        disk: The disk.
        data: The data folder on it.
        acknowledged: Takes what the child was answered.
        moment: When the power is cut.
        resumed: Whether the child resumes the survey.
        durable: Whether fsync works.
    """
    child, connection = start(data, resumed, durable)
    try:
        messages = []
        for message in received(connection):
            messages.append(message)
            if message[:2] == ("phase", moment.phase):
                break
        assert messages and messages[-1][1] == moment.phase, f"the child ended: {messages}"
        if moment.write_back_s >= 0.0:
            time.sleep(moment.write_back_s)
            disk.write_back()
        time.sleep(moment.delay_s)
        begun_s = time.monotonic()
        disk.cut()
        cut_s = (begun_s, time.monotonic())
        time.sleep(ALIVE_AFTER_CUT_S)
    finally:
        child.kill()
        child.join()
    acknowledged.note([*messages, *received(connection)], cut_s)
    connection.close()
    disk.unmount()
    disk.mount()
    assert not acknowledged.too_late, f"answered without a disk: {acknowledged.too_late}"


class Cuts:
    """Cuts the power of many surveys, twice each."""

    def __init__(self, place, seed):
        self.result = {"cuts": 0, "acknowledged": 0, "at the cut": 0, "faults": []}
        self.phases = collections.Counter()
        self._place = place
        self._seed = seed
        self._usual_s = usual_durations_s(place / "without a cut")

    def run(self, count):
        number = 0
        while self.result["cuts"] < count:
            self._cut_survey(number, random.Random(f"{self._seed} {number}"))
            number += 1

    def _cut_survey(self, number, rng):
        place = self._place / str(number)
        disk, data = new_disk(place)
        acknowledged, phases = Acknowledged(), FIRST
        try:
            for turn in range(2):
                moment = self._moment(rng, phases)
                cut_during(disk, data, acknowledged, moment, resumed=phases is RESUMED)
                self.result["cuts"] += 1
                self.phases[acknowledged.phase] += 1
                lost = lost_traces(data, place / f"repaired {turn}", acknowledged)
                assert not lost, lost
                if not check_continues(data, place / f"finished {turn}", acknowledged):
                    break
                phases = RESUMED
        except Exception:
            what = f"seed {self._seed}, survey {number}, cut while {acknowledged.phase}"
            self.result["faults"].append(f"{what}: {traceback.format_exc()}")
        finally:
            self.result["acknowledged"] += len(acknowledged.indices)
            self.result["at the cut"] += acknowledged.at_the_cut
            disk.unmount()
        shutil.rmtree(str(place))

    def _moment(self, rng, phases):
        phase = rng.choice(phases)
        duration_s = self._usual_s[phase]
        write_back_s = rng.uniform(0.0, duration_s) if rng.random() < 0.5 else -1.0
        return Moment(phase, rng.uniform(0.0, duration_s), write_back_s)


def run_without_fsync(place, count, rng):
    """Return in how many cuts traces were lost that a storage without fsync acknowledged."""
    losses = 0
    for number in range(count):
        disk, data = new_disk(place / str(number))
        acknowledged = Acknowledged()
        moment = Moment("last report", rng.uniform(0.0, 0.002))
        cut_during(disk, data, acknowledged, moment, durable=False)
        losses += bool(lost_traces(data, place / str(number) / "repaired", acknowledged))
        disk.unmount()
        shutil.rmtree(str(place / str(number)))
    return losses


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("place", type=Path)
    parser.add_argument("cuts", type=int)
    parser.add_argument("seed")
    parser.add_argument("--without-fsync", action="store_true")
    arguments = parser.parse_args()
    try:
        hide_mounts()
        check()
    except PowerCutError as error:
        print(error)
        return NOT_POSSIBLE
    if arguments.without_fsync:
        rng = random.Random(arguments.seed)
        losses = run_without_fsync(arguments.place, arguments.cuts, rng)
        print(json.dumps({"losses": losses}))
        return 0
    cuts = Cuts(arguments.place, arguments.seed)
    cuts.run(arguments.cuts)
    print(json.dumps({**cuts.result, "while": cuts.phases}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
