"""Two processes add to one survey that has ended, at the same time."""

from __future__ import annotations

import random
import shutil
from typing import List, Tuple

from fault_suite.campaign import Campaign
from fault_suite.child import Child, fork
from fault_suite.facts import Facts
from fault_suite.judge import STUCK, Judge, Result
from fault_suite.script import Call, Step, new_annotation, new_marker, whole_script
from fault_suite.worker import Conduct, Event

WRITERS = "two writers"
MOST_CALLS = 25


class Writers(Campaign):
    """Lets two processes write."""

    def run(self, count: int) -> Result:
        """Make so many surveys, each with two writers."""
        result = Result(WRITERS)
        refused = asked = 0
        for number in range(count):
            one = self._one_survey(result, self.chance(f"writers {number}"), number)
            refused, asked = refused + one[0], asked + one[1]
            result.times += 1
        result.remark = f"{refused} of {asked} calls were refused, and so not acknowledged"
        return result

    def _one_survey(self, result: Result, chance: random.Random, number: int) -> Tuple[int, int]:
        data, facts = self.place / f"writers {number}", Facts()
        data.mkdir(parents=True)
        first = Child(data, whole_script(chance), Conduct())
        first.end()
        first.tell(facts)
        before = facts.counts.copy()
        # One through the storage, as the robot; the other as a second robot, or as the command
        # gpr20 annotate.
        start, by_library = fork.Barrier(2), chance.random() < 0.5
        conducts = [
            Conduct(broken=self.broken, start=start, continues=True, by_library=one)
            for one in (False, by_library)
        ]
        children = [
            Child(data, _calls(chance, annotates=not which), conduct)
            for which, conduct in enumerate(conducts)
        ]
        for child in children:
            child.end()
            child.tell(facts)
        result.acknowledged += facts.counts - before
        judge = Judge(result, f"writers {number}, {'library' if by_library else 'storage'}")
        faults = len(result.texts)
        for child in children:
            for text in child.texts(Event.FAILED):
                judge.note(STUCK, text)
        judge.judge(data, self.place / f"writers {number} copy", facts)
        if len(result.texts) == faults:
            shutil.rmtree(str(data))
        refused = sum(len(one.texts(Event.REFUSED)) for one in children)
        return refused, sum(len(one.steps) for one in children)


def _calls(chance: random.Random, annotates: bool) -> List[Step]:
    """Return what one writer does; of two that annotate, nobody could say whose comes last."""

    def step() -> Step:
        if annotates and chance.random() < 0.2:
            return Step(Call.ANNOTATE, new_annotation(chance), ended=True)
        return Step(Call.MARK, new_marker(chance), ended=True)

    return [step() for _ in range(chance.randint(5, MOST_CALLS))]
