"""What the kinds of faults have in common: a place, a seed, and surveys until enough was tried."""

from __future__ import annotations

import collections
import random
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, List

from fault_suite.judge import Result
from fault_suite.worker import Broken


@dataclass(frozen=True)
class Campaign:
    """Tries one kind of fault on many surveys.

    Attributes:
        place: Where the surveys are made.
        seed: Of everything that is random.
        broken: What the storage does wrong on purpose.
    """

    place: Path
    seed: str
    broken: Broken = Broken.NOTHING

    def chance(self, what: str) -> random.Random:
        """Return the random numbers of one part, the same whatever else is tried."""
        return random.Random(f"{self.seed} {what}")

    def until(
        self, result: Result, count: int, survey: Callable[[random.Random, str], List[str]]
    ) -> Result:
        """Make surveys until there were so many faults.

        Args:
            result: Where the faults are counted.
            count: How many faults.
            survey: Makes one survey of this name, and returns the phase of each fault.
        """
        phases: List[str] = []
        number = 0
        while result.times < count:
            what = f"{result.name} {number}"
            phases += survey(self.chance(what), what)
            number += 1
        counted = collections.Counter(phases).most_common()
        result.remark = ", ".join(f"{times} while {phase}" for phase, times in counted)
        return result
