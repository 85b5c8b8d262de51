"""Kills and power cuts: a survey is ended at random instants, resumed, and ended again."""

from __future__ import annotations

import collections
import random
import shutil
import statistics
import time
from pathlib import Path
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from power_cut_disk import PowerCutDisk, PowerCutError, check, hide_mounts

from fault_suite.campaign import Campaign
from fault_suite.child import Child, durations_s
from fault_suite.evidence import survey_in
from fault_suite.facts import Facts
from fault_suite.judge import STUCK, Judge, Result
from fault_suite.script import Step, end_of_script, some_step, whole_script
from fault_suite.worker import Conduct, Event

KILLS, POWER_CUTS = "kills", "power cuts"
MOST_TURNS = 3
DRY_RUNS = 3
# How long a process continues after its disk is gone, in which nothing may be acknowledged [s].
ALIVE_AFTER_CUT_S = 0.02
# How often the kernel writes everything back some time before a power cut.
WRITTEN_BACK = 0.5

Span = Tuple[float, float]
"""When something began and ended [s]."""


class Place:
    """A data folder on the user's disk, in which processes are killed."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True)
        self.folder = folder
        self.data = folder / "data"
        self.data.mkdir()

    def end(self, child: Child, chance: random.Random, after_s: float) -> Optional[Span]:
        """End a child some time after now."""
        time.sleep(after_s)
        child.kill()
        return None

    def remove(self) -> None:
        """Remove everything."""
        shutil.rmtree(str(self.folder))


class PoweredPlace(Place):
    """A data folder on a file system whose power can be cut."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._disk = PowerCutDisk(folder)
        self._disk.mount()
        self.data = self._disk.folder / "data"
        self.data.mkdir()
        # That the data folder exists is not part of what is tried.
        self._disk.write_back()

    def end(self, child: Child, chance: random.Random, after_s: float) -> Optional[Span]:
        """Cut the power some time after now; return when that began and ended [s]."""
        if chance.random() < WRITTEN_BACK:
            # What is lost is then the rest of a call, but not its begin.
            before_s = chance.uniform(0.0, after_s)
            time.sleep(before_s)
            self._disk.write_back()
            after_s -= before_s
        time.sleep(after_s)
        begun_s = time.monotonic()
        self._disk.cut()
        cut_s = (begun_s, time.monotonic())
        time.sleep(ALIVE_AFTER_CUT_S)
        child.kill()
        self._disk.unmount()
        self._disk.mount()
        return cut_s

    def remove(self) -> None:
        """Remove everything, or only unmount it if something is to be kept."""
        self._disk.unmount()
        super().remove()


class Interruptions(Campaign):
    """Kills, or power cuts."""

    def kills(self, count: int) -> Result:
        """Kill processes."""
        return self._run(Result(KILLS), count, Place)

    def power_cuts(self, count: int) -> Result:
        """Cut the power of a file system, where this machine lets one be mounted."""
        result = Result(POWER_CUTS)
        try:
            hide_mounts()
            check()
        except PowerCutError as error:
            result.remark = f"not possible here: {error}"
            return result
        return self._run(result, count, PoweredPlace)

    def _run(self, result: Result, count: int, kind: Callable[[Path], Place]) -> Result:
        usual_s = self._usual_s(result.name, kind)

        def survey(chance: random.Random, what: str) -> List[str]:
            return self._one_survey(result, kind, chance, what, usual_s)

        return self.until(result, count, survey)

    def _usual_s(self, name: str, kind: Callable[[Path], Place]) -> Dict[str, float]:
        places: List[Place] = []

        def make() -> Tuple[Path, Sequence[Step]]:
            number = len(places)
            places.append(kind(self.place / f"{name} usual {number}"))
            return places[-1].data, whole_script(self.chance(f"usual {number}"))

        by_phase = collections.defaultdict(list)
        for phase, duration_s in durations_s(make, DRY_RUNS):
            by_phase[phase].append(duration_s)
        for one in places:
            one.remove()
        return {phase: statistics.median(found) for phase, found in by_phase.items()}

    def _one_survey(
        self,
        result: Result,
        kind: Callable[[Path], Place],
        chance: random.Random,
        what: str,
        usual_s: Dict[str, float],
    ) -> List[str]:
        place, facts, phases = kind(self.place / what), Facts(), []
        steps = whole_script(chance)
        faults = len(result.texts)
        for turn in range(chance.randint(1, MOST_TURNS)):
            child = Child(place.data, steps, Conduct(broken=self.broken))
            step = some_step(steps, chance)
            child.wait_for(step)
            usual = usual_s.get(steps[step].phase, 0.0)
            cut_s = place.end(child, chance, chance.uniform(0.0, usual))
            child.tell(facts, cut_s)
            result.times += 1
            phases.append(child.phase)
            judge = Judge(result, f"{what}, turn {turn}, {child.phase}")
            for text in child.texts(Event.FAILED):
                judge.note(STUCK, text)
            judge.judge(place.data, self.place / f"{what} copy {turn}", facts)
            if survey_in(place.data) is None or not facts.opened:
                break
            steps = end_of_script(chance, facts.present_markers())
        result.acknowledged += facts.counts
        if len(result.texts) > faults:
            shutil.copytree(str(place.data), str(self.place / f"{what} kept"))
        place.remove()
        return phases
