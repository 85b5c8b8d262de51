"""The state of every planned sample of the survey that runs."""

from __future__ import annotations

import re
from typing import Callable, Dict, Iterable, List, Set, Tuple

from gpr20_common.message import Message
from gpr20_survey.plan.survey_state import SampleState, Verdict, verdict

RUN = re.compile(rb"(.)\1*", re.DOTALL)


class Coverage:
    """The state of every planned sample.

    A sample counts as measured once it is stored durably.

    Attributes:
        on_change: Called with this object at every change.
    """

    def __init__(self, planned: int, stored: Iterable[int] = ()) -> None:
        # One byte per sample: announcing a change must not take longer in a survey of many
        # thousands.
        self._states = bytearray(planned)
        self._reasons: Dict[int, Message] = {}
        self._measured_again: Set[int] = set()
        self.on_change: Callable[[Coverage], None] = lambda coverage: None
        for index in stored:
            self._states[index] = SampleState.MEASURED

    @property
    def planned(self) -> int:
        return len(self._states)

    @property
    def states(self) -> List[SampleState]:
        """The state of each planned sample, in the order of the plan."""
        return [SampleState(state) for state in self._states]

    def runs(self) -> List[Tuple[int, SampleState]]:
        """Return where in the plan each run of samples of one state begins, and that state."""
        found = RUN.finditer(bytes(self._states))
        return [(run.start(), SampleState(run[0][0])) for run in found]

    @property
    def reasons(self) -> Dict[int, Message]:
        """Why samples failed, by their index in the plan."""
        return dict(self._reasons)

    def note_stored(self, index: int) -> None:
        """Note that a sample is stored durably."""
        again = index in self._measured_again
        self._states[index] = SampleState.REMEASURED if again else SampleState.MEASURED
        self._reasons.pop(index, None)
        self.on_change(self)

    def note_remeasured(self, index: int) -> None:
        """Note that a sample was measured again, to compare; it may still wait for the disk."""
        self._measured_again.add(index)
        if self._states[index] == SampleState.MEASURED:
            self._states[index] = SampleState.REMEASURED
            self.on_change(self)

    def note_failed(self, index: int, reason: Message) -> None:
        """Note that a sample could not be measured, unless it is stored already."""
        if self._states[index] in (SampleState.NOT_VISITED, SampleState.FAILED):
            self._states[index] = SampleState.FAILED
            self._reasons[index] = reason
            self.on_change(self)

    def verdict(self) -> Verdict:
        """Return the coverage in one sentence; only a full one is called complete."""
        failed = self._states.count(SampleState.FAILED)
        missing = self._states.count(SampleState.NOT_VISITED)
        return verdict(len(self._states), failed, missing)
