"""One bit of one file of a survey that nobody writes is flipped."""

from __future__ import annotations

import collections
import contextlib
import copy
import itertools
import random
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Counter, Dict, List, Sequence, Tuple

from fault_suite.campaign import Campaign
from fault_suite.child import Child
from fault_suite.evidence import survey_in
from fault_suite.facts import Facts
from fault_suite.judge import UNSEEN, Judge, Result
from fault_suite.script import Call, Step, new_marker, whole_script
from fault_suite.worker import Conduct
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.manifest_repair import repair_manifest
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import ProcessingError

FLIPS = "flips"
FLIPS_PER_SURVEY = 8
# How often somebody adds a marker, and calls gpr20 repair, before the survey is resumed.
ADDED_SHARE, REPAIRED_SHARE = 0.3, 0.5
NOW = "2026-11-21T05:10:00.000000Z"
# How a survey came to its end.
FINISHED, STOPPED, CRASHED, INTERRUPTED = "finished", "stopped", "crashed", "interrupted"
STATES = (FINISHED, STOPPED, CRASHED, INTERRUPTED)


@dataclass(frozen=True)
class State:
    """A survey in one of the states.

    Attributes:
        data: Its data folder.
        facts: What was acknowledged.
    """

    data: Path
    facts: Facts


class Flips(Campaign):
    """Flips bits."""

    def run(self, count: int) -> Result:
        """Flip bits of so many surveys, each in a copy."""
        result, states = Result(FLIPS), {}
        counted: Counter[str] = collections.Counter()
        for number in range(count):
            chance = self.chance(f"flip {number}")
            if number % (FLIPS_PER_SURVEY * len(STATES)) == 0:
                states = self._new_states(number, chance)
            name = STATES[number % len(STATES)]
            counted[self._flip(result, chance, number, name, states[name])] += 1
            result.acknowledged += states[name].facts.counts
            result.times += 1
        result.remark = ", ".join(f"{times} {name}" for name, times in counted.most_common())
        return result

    def _new_states(self, number: int, chance: random.Random) -> Dict[str, State]:
        made = {}
        for name in STATES:
            steps = _steps_to(name, whole_script(chance))
            made[name] = self._make(self.place / f"{name} {number}", steps)
        return made

    def _make(self, data: Path, steps: Sequence[Step]) -> State:
        data.mkdir(parents=True)
        child = Child(data, steps, Conduct(broken=self.broken))
        child.end()
        facts = Facts()
        child.tell(facts)
        return State(data, facts)

    def _flip(
        self, result: Result, chance: random.Random, number: int, name: str, state: State
    ) -> str:
        data = self.place / f"flip {number}"
        shutil.copytree(str(state.data), str(data))
        folder = survey_in(data)
        assert folder is not None
        kind, what = _flip_bit(chance, folder)
        judge = Judge(result, f"{name}, {what}", may_name=True)
        faults = len(result.texts)
        if name != CRASHED and not verify_survey(folder).faults:
            judge.note(UNSEEN, "verify finds nothing")
        facts = copy.deepcopy(state.facts)
        _use(chance, data, folder, facts)
        judge.judge(data, self.place / f"flip {number} repaired", facts)
        if len(result.texts) == faults:
            shutil.rmtree(str(data))
        return f"{kind} {name}"


def _steps_to(state: str, steps: Sequence[Step]) -> List[Step]:
    """Return the part of a script that leads to a state."""
    if state == FINISHED:
        return list(steps)
    half = list(itertools.takewhile(lambda one: one.call is not Call.INTERRUPT, steps))
    # A process that has done its steps ends without a further call of its storage.
    last = {CRASHED: [], STOPPED: [Step(Call.STOP)], INTERRUPTED: [Step(Call.INTERRUPT)]}
    return [*half, *last[state]]


def _use(chance: random.Random, data: Path, folder: Path, facts: Facts) -> None:
    """Do what people do with a survey of which they do not know, or know, that it is damaged."""
    if chance.random() < ADDED_SHARE:
        child = Child(data, [Step(Call.MARK, new_marker(chance))], Conduct(may_give_up=True))
        child.end()
        child.tell(facts)
    if chance.random() < REPAIRED_SHARE:
        # It says what it cannot repair.
        with contextlib.suppress(AnalysisError, ProcessingError):
            repair_manifest(folder, "1.2.3", NOW)


def _flip_bit(chance: random.Random, folder: Path) -> Tuple[str, str]:
    """Flip a bit; return in what kind of file, and which."""
    path = _some_file(chance, folder)
    content = bytearray(path.read_bytes())
    place, bit = chance.randrange(len(content)), chance.randrange(8)
    content[place] ^= 1 << bit
    path.write_bytes(content)
    kind = "a trace" if path.parent.name == "traces" else path.name
    return kind, f"bit {bit} of byte {place} of {path.name}"


def _some_file(chance: random.Random, folder: Path) -> Path:
    """Return a file of the survey: all traces together are drawn as often as another one."""
    traces = sorted((folder / "traces").iterdir())
    others = sorted(one for one in folder.iterdir() if one.is_file())
    return chance.choice([chance.choice(traces), *others]) if traces else chance.choice(others)
