"""What the storage has acknowledged of a survey, and what was asked of it besides."""

from __future__ import annotations

import collections
import enum
from dataclasses import dataclass, field
from typing import Any, Counter, Dict, Iterator, List, Mapping, Optional, Sequence, Set, Tuple

from trace_examples import assert_same_numbers

from fault_suite.script import SURVEY, TRACES, Call, Step

MARKER_KEYS = ("marker_id", "x_mm", "y_mm", "depth_mm", "text", "author")


class Kind(enum.Enum):
    """A kind of facts."""

    TRACE = "traces"
    MARKER = "markers"
    ANNOTATION = "annotations"
    REPORT = "reports"


KINDS = {
    Call.STORE: Kind.TRACE,
    Call.MARK: Kind.MARKER,
    Call.UNMARK: Kind.MARKER,
    Call.ANNOTATE: Kind.ANNOTATION,
    Call.REPORT: Kind.REPORT,
}


class Fault(enum.Enum):
    """What must not become of a fact."""

    LOST = "lost"
    DOUBLED = "doubled"
    WRONG = "wrong"


@dataclass(frozen=True)
class Difference:
    """A fact that is not as it was acknowledged."""

    fault: Fault
    fact: str
    text: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.fact} {self.fault.value} {self.text}".strip()


@dataclass
class Found:
    """What a survey's folder holds, as other readers see it."""

    traces: Dict[str, List[Any]] = field(default_factory=dict)
    """By the form: values of a JSON file, or messages."""
    markers: List[Dict[str, Any]] = field(default_factory=list)
    annotation: Optional[Dict[str, Any]] = None
    report: Optional[Dict[str, Any]] = None


@dataclass
class _Latest:
    """A fact that the next one of its kind replaces."""

    acknowledged: Optional[Dict[str, Any]] = None
    asked: List[Dict[str, Any]] = field(default_factory=list)
    """Asked since then; one of them may be stored."""


@dataclass
class _MarkerFact:
    values: Dict[str, Any]
    added: bool = False
    removal_asked: bool = False
    removed: bool = False


class Facts:
    """What was asked and acknowledged, compared with what is found."""

    def __init__(self) -> None:
        self.opened = self.finished = False
        self.counts: Counter[Kind] = collections.Counter()
        self._asked: Set[int] = set()
        self._stored: Set[int] = set()
        self._markers: Dict[str, _MarkerFact] = {}
        self._latest = {Kind.ANNOTATION: _Latest(), Kind.REPORT: _Latest()}

    def ask(self, step: Step) -> None:
        """Note that a call begins: what it is to store may be there from now on."""
        if step.call is Call.STORE:
            self._asked.add(step.value)
        elif step.call is Call.MARK:
            self._markers.setdefault(step.value["marker_id"], _MarkerFact(step.value))
        elif step.call is Call.UNMARK:
            self._markers[step.value].removal_asked = True
        elif step.call is Call.REOPEN:
            self.finished = False
        elif step.call in KINDS:
            self._latest[KINDS[step.call]].asked.append(step.value)

    def acknowledge(self, step: Step) -> None:
        """Note that a call succeeded: what it is to store must be there from now on."""
        if step.call in KINDS:
            self.counts[KINDS[step.call]] += 1
        if step.call is Call.OPEN:
            self.opened = True
        elif step.call is Call.FINISH:
            self.finished = True
        elif step.call is Call.STORE:
            self._stored.add(step.value)
        elif step.call is Call.MARK:
            self._markers[step.value["marker_id"]].added = True
        elif step.call is Call.UNMARK:
            self._markers[step.value].removed = True
        elif step.call in KINDS:
            self._latest[KINDS[step.call]] = _Latest(step.value)

    @property
    def stored(self) -> Set[int]:
        """Indices of the traces that were acknowledged."""
        return set(self._stored)

    def present_markers(self) -> List[str]:
        """Return the ids of the markers that are certainly there."""
        return [name for name, one in self._markers.items() if one.added and not one.removal_asked]

    def is_acknowledged(self, kind: Kind) -> bool:
        """Return whether there is an acknowledged fact of a kind of which the last one counts."""
        return self._latest[kind].acknowledged is not None

    def differences(self, found: Found, every_trace: bool) -> List[Difference]:
        """Return what is lost, doubled or wrong.

        Args:
            found: What is there.
            every_trace: Whether the survey was finished after the last acknowledgement, so that it
                has all traces.
        """
        needed = set(range(len(TRACES))) if every_trace else self._stored
        allowed = needed if every_trace else self._asked
        differences: List[Difference] = []
        for form, traces in found.traces.items():
            differences += _trace_differences(form, traces, needed, allowed)
        differences += self._marker_differences(found.markers)
        differences += self._latest_difference(Kind.ANNOTATION, found.annotation)
        differences += self._latest_difference(Kind.REPORT, found.report)
        return differences

    def trace_differences(self, found: Found) -> List[Difference]:
        """Return what is lost, doubled or wrong of the traces of a survey that was cut off."""
        differences: List[Difference] = []
        for form, traces in found.traces.items():
            differences += _trace_differences(form, traces, self._stored, self._asked)
        return differences

    def _marker_differences(self, markers: Sequence[Mapping[str, Any]]) -> Iterator[Difference]:
        by_id = collections.defaultdict(list)
        for one in markers:
            by_id[one.get("marker_id")].append(one)
        for name, fact in self._markers.items():
            title, entries = f"marker {name[:8]}", by_id.pop(name, [])
            if not entries:
                if fact.added:
                    yield Difference(Fault.LOST, title)
                continue
            if len(entries) > 1:
                yield Difference(Fault.DOUBLED, title)
            yield from _differences_of_marker(title, fact, entries[0])
        for unknown in by_id:
            yield Difference(Fault.WRONG, f"marker {str(unknown)[:8]}", "was never made")

    def _latest_difference(
        self, kind: Kind, value: Optional[Dict[str, Any]]
    ) -> Iterator[Difference]:
        latest, title = self._latest[kind], kind.value[:-1]
        if value in latest.asked or value == latest.acknowledged:
            return
        if value is None:
            yield Difference(Fault.LOST, title)
        else:
            yield Difference(Fault.WRONG, title, f"is {value}, was {latest.acknowledged}")


def _trace_differences(
    form: str, traces: Sequence[Any], needed: Set[int], allowed: Set[int]
) -> Iterator[Difference]:
    seen: Counter[int] = collections.Counter()
    for one in traces:
        index, survey = _index_of(one)
        title = f"trace {index}"
        seen[index] += 1
        if survey != SURVEY or index not in allowed:
            yield Difference(Fault.WRONG, title, f"in {form} was never measured")
            continue
        try:
            assert_same_numbers(TRACES[index], one)
        except (AssertionError, AttributeError, KeyError, TypeError, ValueError) as error:
            yield Difference(Fault.WRONG, title, f"in {form}: {error!r}"[:200])
    for index in sorted(needed - seen.keys()):
        yield Difference(Fault.LOST, f"trace {index}", f"in {form}")
    for index, count in seen.items():
        if count > 1:
            yield Difference(Fault.DOUBLED, f"trace {index}", f"in {form}: {count} times")


def _index_of(trace: Any) -> Tuple[int, str]:
    if isinstance(trace, dict):
        return trace.get("index", -1), trace.get("survey_id", "")
    return int(trace.index), str(trace.survey_id)


def _differences_of_marker(
    title: str, fact: _MarkerFact, entry: Mapping[str, Any]
) -> Iterator[Difference]:
    for key in MARKER_KEYS:
        if entry.get(key) != fact.values[key]:
            yield Difference(
                Fault.WRONG, title, f"{key} is {entry.get(key)!r}, was {fact.values[key]!r}"
            )
            return
    is_removed = bool(entry.get("removed"))
    if fact.removed and not is_removed:
        yield Difference(Fault.LOST, f"removal of {title}")
    elif is_removed and not fact.removal_asked:
        yield Difference(Fault.LOST, title, "is removed, but nobody removed it")
