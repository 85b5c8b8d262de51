"""Whether a survey holds what was acknowledged, after an accident and when it is finished."""

from __future__ import annotations

import collections
import contextlib
import enum
import functools
import itertools
import json
import shutil
import tempfile
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Counter, Dict, Iterable, Iterator, List, Sequence, Set, Tuple

from stock_readers import bag_traces, mcap_traces, torn_mcap_traces
from storage_kit import with_bag
from trace_examples import SURVEY, assert_same_numbers

from fault_suite.worker import IS_COMPLETE, TRACES, Call, Event, Worker, new_storage
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.verdict import COMPLETE, DAMAGED
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.folder.recovery import Fact, recover

PLACE = ("x_coord_mm", "y_coord_mm", "z_coord_deg")
# Others may be there as often as they were asked: a worker asks again after an error.
ONCE = (Kind.MARKER, *NOTES)
UNLIKE = (AssertionError, AttributeError, KeyError, TypeError, ValueError)

# What must not become of a trace, a fact or a survey; only to be named is no failure.
Became = enum.Enum("Became", "LOST DOUBLED MOVED CHANGED LAUNDERED UNSEEN STUCK NAMED")
Finding = Tuple[Became, str]


@dataclass
class Result:
    """How many accidents of one kind there were, of each sort, and what came of them."""

    kind: str
    remark: str = ""
    acknowledged: int = 0
    sorts: Counter[str] = field(default_factory=collections.Counter)
    found: Counter[Became] = field(default_factory=collections.Counter)
    failures: List[str] = field(default_factory=list)


@dataclass
class Noted:
    """A fact that was asked so often."""

    fact: Fact
    asked: int = 0
    acknowledged: bool = False


class Ledger:
    """What was asked and acknowledged: indices of right traces, and facts by their marks."""

    def __init__(self) -> None:
        self.expected = dict(TRACES)
        self.asked: Set[int] = set()
        self.stored: Set[int] = set()
        self.opened = False
        self.notes: Dict[bytes, Noted] = {}

    def take_down(self, one: Worker) -> None:
        """Note what a worker said; an answer that came while its power was cut does not count."""
        asked_s = 0.0
        for event, number, time_s, _text in one.said:
            step, asks = one.steps[number], event is Event.ASKED
            asked_s = time_s if asks else asked_s
            is_dark = asked_s < one.dark_s[1] and time_s > one.dark_s[0]
            is_done = event is Event.DONE and not is_dark
            if step.fact is not None:
                noted = self.notes.setdefault(step.mark, Noted(step.fact))
                noted.asked += asks
                noted.acknowledged |= is_done
            elif step.call is Call.STORE:
                (self.stored if is_done else self.asked).add(step.trace)
            elif step.call is Call.OPEN:
                self.opened |= is_done

    def acknowledged(self) -> List[bytes]:
        """Return what the log must hold."""
        return [mark for mark, one in self.notes.items() if one.acknowledged]

    def of_traces(self, form: str, found: Iterable[Any], needed: Set[int]) -> Iterator[Finding]:
        """Compare the traces of a form, messages or values of JSON files."""
        seen: Counter[int] = collections.Counter()
        for one in found:
            get: Any = one.get if isinstance(one, dict) else functools.partial(getattr, one)
            index: int = get("index")
            seen[index] += 1
            right, title = self.expected.get(index), f"trace {index} in {form}"
            if right is None or index not in needed | self.asked:
                yield Became.CHANGED, f"{title}: was never measured"
                continue
            if [get(name) for name in PLACE] != [getattr(right, name) for name in PLACE]:
                yield Became.MOVED, title
            try:
                assert_same_numbers(right, one)
            except UNLIKE as error:
                yield Became.CHANGED, f"{title}: {error!r}"
        yield from ((Became.LOST, f"trace {one} in {form}") for one in needed - seen.keys())
        yield from ((Became.DOUBLED, f"trace {one} in {form}") for one in seen if seen[one] > 1)

    def of_facts(self, records: Sequence[Fact]) -> Iterator[Finding]:
        """Compare the records of the log; the storage may add to what was asked, as a time."""
        asked = {one.fact.kind for one in self.notes.values()}
        left = [one for one in records if one.kind in asked]
        for one in self.notes.values():
            kind, values = one.fact
            same = [r for r in left if r.kind == kind and values.items() <= r.values.items()]
            left = [record for record in left if record not in same]
            if one.acknowledged and not same:
                yield Became.LOST, str(one.fact)
            if len(same) > (1 if kind in ONCE else one.asked):
                yield Became.DOUBLED, str(one.fact)
        yield from ((Became.CHANGED, f"{one} was never asked") for one in left)


def findings(folder: Path, ledger: Ledger, is_finished: bool) -> Iterator[Finding]:
    """Yield what is not as it was acknowledged, as others read it; nothing may lack if finished."""
    needed = set(ledger.expected) if is_finished else ledger.stored
    yield from ledger.of_traces("JSON", _json_traces(folder), needed)
    mcap, bag = folder / "survey.mcap", folder / "survey.bag"
    recorded = (mcap_traces if is_finished else torn_mcap_traces)(mcap) if mcap.exists() else ()
    yield from ledger.of_traces("MCAP", recorded, needed)
    if is_finished and bag.exists():
        yield from ledger.of_traces("bag", bag_traces(bag), needed)
    for mark, path in itertools.product(ledger.acknowledged(), folder.glob("log*.jsonl")):
        if mark not in path.read_bytes():
            yield Became.LOST, f"{ledger.notes[mark].fact} in {path.name}"
    if is_finished:
        records = recover(folder).found.records
        # Those of former reports have no values.
        yield from ledger.of_facts([Fact(Kind(one.kind), one.values or {}) for one in records])


def _json_traces(folder: Path) -> Iterator[Any]:
    for path in sorted(folder.glob("traces/[!.]*.json")):
        with contextlib.suppress(ValueError):  # is no trace; one that was acknowledged is missed
            yield json.loads(path.read_text("utf-8"))


def verdict_of(folder: Path) -> Tuple[int, str]:
    """Return the status and the sentence of the verification."""
    try:
        verified = verify_survey(folder)
        return verified.status, str(verified.verdict)
    except AnalysisError as error:
        return DAMAGED, str(error)


@dataclass
class Judge:
    """Judges a survey; if a file was damaged, what the verification names may be other."""

    result: Result
    what: str
    is_damaged: bool = False

    def note(self, found: Iterable[Finding]) -> None:
        """Note findings, each once."""
        for became, text in dict.fromkeys(found):
            self.result.found[became] += 1
            if became is not Became.NAMED:
                self.result.failures.append(f"{became.name}: {self.what}: {text}")

    def judge(self, data: Path, ledger: Ledger, *workers: Worker) -> None:
        """Look for everything in a copy of a data folder as it is, and when it was finished."""
        self.note((Became.STUCK, text) for one in workers for text in one.texts(Event.BROKEN))
        with tempfile.TemporaryDirectory() as place:
            shutil.copytree(str(data), f"{place}/data")
            folders = [one.parent for one in Path(place).glob("data/*/traces")]
            try:
                for folder in folders:
                    if not self.is_damaged:
                        self.note(findings(folder, ledger, is_finished=False))
                    self.check(folder, ledger, is_finished=False)
                    self._finish(folder, ledger)
                    self.check(folder, ledger, is_finished=True)
                if ledger.opened and not folders:
                    self.note([(Became.LOST, "the folder")])
            except ProcessingError as error:
                self.note([(Became.STUCK, f"not finished: {error}")] if ledger.opened else [])
            except Exception:
                # Nothing that an accident leaves may break a reader.
                self.note([(Became.STUCK, traceback.format_exc(limit=-2))])

    def check(self, folder: Path, ledger: Ledger, is_finished: bool) -> None:
        """Look for everything in a survey that is called intact, or must be as it is finished."""
        status, verdict = verdict_of(folder)
        # The files of a survey whose opening was cut off do not tell that from a lost log.
        is_named = self.is_damaged or not ledger.opened
        if status == COMPLETE or (is_finished and not is_named):
            found = list(findings(folder, ledger, is_finished=True))
            self.note(found)
            if status != COMPLETE:
                self.note([(Became.STUCK, f"finished, but {verdict}")])
            self.note((Became.LAUNDERED, text) for _, text in found[:1] if status == COMPLETE)
        elif is_finished:
            self.note([(Became.NAMED, verdict)])

    def _finish(self, folder: Path, ledger: Ledger) -> None:
        """Reopen a survey and end it, unless it is complete."""
        kit = new_storage(folder.parent)
        try:
            stored = kit.processing.reopen_survey(SURVEY).stored_indices
            lost = sorted(ledger.stored.difference(stored))
            self.note((Became.LOST, f"trace {index}: unknown when reopened") for index in lost)
            kit.finish(TRACES.values(), stored)
        except ProcessingError as error:
            if error.message.fault_code != IS_COMPLETE:
                raise
        finally:
            with contextlib.suppress(ProcessingError):
                kit.processing.shut_down()
        with_bag(folder)
