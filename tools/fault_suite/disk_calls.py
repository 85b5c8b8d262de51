"""Faults at the n-th call of the disk: it fails, or its power goes and tears what is not synced."""

from __future__ import annotations

import errno
import random
import shutil
from dataclasses import replace
from typing import Dict, List, Sequence

from failing_disk import FOR_EVER, Failure

from fault_suite.campaign import Campaign
from fault_suite.child import Child
from fault_suite.evidence import survey_in
from fault_suite.facts import Facts
from fault_suite.judge import STUCK, Judge, Result
from fault_suite.script import Call, Step, end_of_script, some_step, whole_script
from fault_suite.worker import Conduct, Event

CALLS, TORN = "n-th call", "torn sectors"
ERRORS = (errno.ENOSPC, errno.EIO, errno.EROFS, errno.EDQUOT)
MOST_FAILING = 6
# How many of the faults last until the process has ended.
FOR_EVER_SHARE = 0.3
TURNS = 2
DRY_RUNS = 3
# Of what was not made durable, this much is lost.
LOST_SHARES = (0.3, 0.5, 0.8, 1.0)


class DiskCalls(Campaign):
    """Surveys of which a call of the disk fails or is the last one."""

    def failing(self, count: int) -> Result:
        """Let calls fail, with and without half of the bytes written."""
        return self._run(Result(CALLS), count)

    def torn(self, count: int) -> Result:
        """Cut the power of a model of the disk: of the sectors not synced a random part is kept."""
        return self._run(Result(TORN), count)

    def _run(self, result: Result, count: int) -> Result:
        usual = self._usual_calls(result.name)

        def survey(chance: random.Random, what: str) -> List[str]:
            return self._one_survey(result, chance, what, usual)

        return self.until(result, count, survey)

    def _usual_calls(self, name: str) -> Dict[str, int]:
        """Return how many calls of the disk each phase of a script needs."""
        usual: Dict[str, int] = {}
        for number in range(DRY_RUNS):
            data = self.place / f"{name} usual {number}"
            data.mkdir(parents=True)
            steps = whole_script(self.chance(f"usual {number}"))
            child = Child(data, steps, Conduct(Failure(FOR_EVER, power=False)))
            child.end()
            shutil.rmtree(str(data))
            counts = [
                (number, int(text))
                for event, number, _, _, text in child.messages
                if event in (Event.ASKED, Event.ENDED)
            ]
            for (step, before), (_, after) in zip(counts, counts[1:]):
                phase = steps[step].phase
                usual[phase] = max(usual.get(phase, 1), after - before)
        return usual

    def _one_survey(
        self, result: Result, chance: random.Random, what: str, usual: Dict[str, int]
    ) -> List[str]:
        data, facts, phases = self.place / what / "data", Facts(), []
        data.mkdir(parents=True)
        steps: Sequence[Step] = whole_script(chance)
        faults = len(result.texts)
        for turn in range(TURNS):
            step = some_step(steps, chance)
            # One more: the fault comes between two steps.
            calls = chance.randrange(usual.get(steps[step].phase, 1) + 1)
            failure = _draw(chance, calls, torn=result.name == TORN)
            after = data.with_name(f"after {turn}")
            conduct = Conduct(failure, step, after, self.broken, may_give_up=True)
            child = Child(data, steps, conduct)
            child.end()
            child.tell(facts)
            data = after if after.exists() else data
            result.times += 1
            phases.append(steps[step].phase)
            judge = Judge(result, f"{what}, turn {turn}, {steps[step].phase}, {failure}")
            # A disk that fails may lead to a refusal, but a survey can be asked for again.
            refused = child.texts(Event.REFUSED) if child.phase == Call.OPEN.value else []
            for text in [*child.texts(Event.FAILED), *refused]:
                judge.note(STUCK, text)
            judge.judge(data, self.place / what / f"copy {turn}", facts)
            if survey_in(data) is None or not facts.opened:
                break
            steps = end_of_script(chance, facts.present_markers())
        result.acknowledged += facts.counts
        if len(result.texts) == faults:
            shutil.rmtree(str(self.place / what))
        return phases


def _draw(chance: random.Random, calls: int, torn: bool) -> Failure:
    failure = Failure(calls, power=torn, seed=chance.getrandbits(30))
    if torn:
        share = chance.choice(LOST_SHARES)
        return replace(failure, durable_share=share, by_sector=chance.random() < 0.8)
    lasts = FOR_EVER if chance.random() < FOR_EVER_SHARE else chance.randint(1, MOST_FAILING)
    return replace(failure, error=chance.choice(ERRORS), lasts=lasts, short=chance.random() < 0.5)
