"""What is asked of the storage, step by step: one survey from its opening to after its end."""

from __future__ import annotations

import enum
import random
import uuid
from dataclasses import asdict, dataclass
from typing import Any, Dict, List, Sequence

from planned_survey import METADATA, POINTS, planned_trace
from trace_examples import SURVEY

from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.markers import Marker

__all__ = ["METADATA", "SURVEY", "TRACES"]

TRACES = [planned_trace(index) for index in range(len(POINTS))]
HALF = len(TRACES) // 2
# How many markers, annotations and reports are among the traces, at most.
MOST_ADDED = 5
WORDS = ("metal", "raíz", "tubo", "piedra", "日本", "=1+1", "a, b; c", '"', "\\u0041", "")


class Call(enum.Enum):
    """A call of the storage."""

    OPEN = "opening"
    STORE = "storing"
    MARK = "marking"
    UNMARK = "removing a marker"
    ANNOTATE = "annotating"
    REPORT = "reporting"
    INTERRUPT = "being shut down"
    REOPEN = "reopening"
    FINISH = "finishing"
    STOP = "stopping"


@dataclass(frozen=True)
class Step:
    """One call of the storage, with what it is to store.

    Attributes:
        call: The call.
        value: Index of the trace, values of the marker, id of the marker that is removed,
            values of the annotation, or the report.
        ended: Whether the survey has ended before.
    """

    call: Call
    value: Any = None
    ended: bool = False

    @property
    def phase(self) -> str:
        """What is being done, in words."""
        return f"{self.call.value} after the end" if self.ended else self.call.value


def whole_script(chance: random.Random) -> List[Step]:
    """Return a survey that is opened, interrupted, reopened, finished and added to later."""
    first = [Step(Call.STORE, index) for index in range(HALF)]
    present: List[str] = []
    begun = [Step(Call.OPEN), *_with_additions(chance, first, present), Step(Call.INTERRUPT)]
    return [*begun, *end_of_script(chance, present)]


def end_of_script(chance: random.Random, present: Sequence[str]) -> List[Step]:
    """Return what is left of a survey that was cut off, to its end and after it.

    Args:
        chance: Draws what is stored.
        present: Ids of the markers that the survey has.
    """
    known = list(present)
    # Those that are stored already are passed over.
    rest = [Step(Call.STORE, index) for index in range(len(TRACES))]
    steps = [Step(Call.REOPEN), *_with_additions(chance, rest, known), Step(Call.FINISH)]
    return [*steps, *(_addition(chance, known, ended=True) for _ in range(chance.randint(1, 4)))]


def some_step(steps: Sequence[Step], chance: random.Random) -> int:
    """Return the number of a step: of each phase as often, however many steps it has."""
    phase = chance.choice(sorted({one.phase for one in steps}))
    return chance.choice([number for number, one in enumerate(steps) if one.phase == phase])


def _with_additions(
    chance: random.Random, traces: Sequence[Step], present: List[str]
) -> List[Step]:
    steps: List[Step] = []
    places = sorted(chance.randint(0, len(traces)) for _ in range(chance.randint(1, MOST_ADDED)))
    for place, trace in enumerate([*traces, None]):
        steps += [_addition(chance, present) for one in places if one == place]
        steps += [trace] if trace is not None else []
    return steps


def _addition(chance: random.Random, present: List[str], ended: bool = False) -> Step:
    calls = [Call.MARK, Call.MARK, Call.ANNOTATE, *([Call.UNMARK] if present else [])]
    call = chance.choice(calls if ended else [*calls, Call.REPORT])
    if call is Call.UNMARK:
        return Step(call, present.pop(chance.randrange(len(present))), ended)
    value = {Call.MARK: new_marker, Call.ANNOTATE: new_annotation, Call.REPORT: _new_report}[call]
    step = Step(call, value(chance), ended)
    if call is Call.MARK:
        present.append(step.value["marker_id"])
    return step


def new_marker(chance: random.Random) -> Dict[str, Any]:
    """Return the values of a marker as a client sends it."""
    depth_mm = chance.choice([None, round(chance.uniform(0.0, 500.0), 1)])
    x_mm, y_mm = (round(chance.uniform(0.0, 800.0), 2) for _ in range(2))
    identity = str(uuid.UUID(int=chance.getrandbits(128), version=4))
    return asdict(Marker(identity, x_mm, y_mm, depth_mm, _text(chance), chance.choice(["", "Ana"])))


def new_annotation(chance: random.Random) -> Dict[str, Any]:
    """Return the values of an annotation."""
    place = Wgs84Position(chance.uniform(-90.0, 90.0), chance.uniform(-180.0, 180.0))
    notes = "\n".join(_text(chance) for _ in range(chance.randint(0, 4)))
    position = chance.choice([None, place])
    return Annotation("Ana", _text(chance), notes, position, name=_text(chance)).values()


def _new_report(chance: random.Random) -> Dict[str, Any]:
    return {"fault_suite": chance.getrandbits(48), "text": _text(chance)}


def _text(chance: random.Random) -> str:
    return " ".join(chance.choice(WORDS) for _ in range(chance.randint(1, 6))).strip()
