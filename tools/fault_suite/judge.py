"""Whether a survey holds what was acknowledged, after an accident and when it is finished."""

from __future__ import annotations

import collections
import contextlib
import functools
import itertools
import json
import shutil
import tempfile
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Counter, Dict, Iterable, Iterator, List, Sequence, Set

from storage_kit import bag_traces, mcap_traces, torn_mcap_traces, with_bag
from trace_examples import SURVEY, assert_same_numbers

from fault_suite.worker import IS_COMPLETE, TRACES, Call, Event, Worker, new_storage
from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.folder.recovery import Fact, recover

PLACE = ("x_coord_mm", "y_coord_mm", "z_coord_deg")
# Others may be there as often as they were asked: a worker asks again after an error.
ONCE = (Kind.MARKER, *NOTES)
UNLIKE = (AssertionError, AttributeError, KeyError, TypeError, ValueError)


@dataclass
class Noted:
    """A fact that was asked so often."""

    fact: Fact
    asked: int = 0
    acknowledged: bool = False


class Ledger:
    """What was asked and acknowledged: indices of traces, and facts by their marks."""

    def __init__(self) -> None:
        self.asked: Set[int] = set()
        self.stored: Set[int] = set()
        self.opened = False
        self.notes: Dict[bytes, Noted] = {}

    def take_down(self, one: Worker) -> None:
        """Note what a worker said."""
        for event, number, _text in one.said:
            step, is_done = one.steps[number], event is Event.DONE
            if step.fact is not None:
                noted = self.notes.setdefault(step.mark, Noted(step.fact))
                noted.asked += event is Event.ASKED
                noted.acknowledged |= is_done
            elif step.call is Call.STORE:
                (self.stored if is_done else self.asked).add(step.trace)
            elif step.call is Call.OPEN:
                self.opened |= is_done

    def acknowledged(self) -> List[bytes]:
        """Return what the log must hold."""
        return [mark for mark, one in self.notes.items() if one.acknowledged]

    def of_traces(self, form: str, found: Iterable[Any], needed: Set[int]) -> Iterator[str]:
        """Compare the traces of a form, messages or values of JSON files."""
        seen: Counter[int] = collections.Counter()
        for one in found:
            get: Any = one.get if isinstance(one, dict) else functools.partial(getattr, one)
            index: int = get("index")
            seen[index] += 1
            right, title = TRACES.get(index), f"trace {index} in {form}"
            if right is None or index not in needed | self.asked:
                yield f"CHANGED: {title} was never measured"
                continue
            if [get(name) for name in PLACE] != [getattr(right, name) for name in PLACE]:
                yield f"MOVED: {title}"
            try:
                assert_same_numbers(right, one)
            except UNLIKE as error:
                yield f"CHANGED: {title}: {error!r}"
        yield from (f"LOST: trace {one} in {form}" for one in needed - seen.keys())
        yield from (f"DOUBLED: trace {one} in {form}" for one in seen if seen[one] > 1)

    def of_facts(self, records: Sequence[Fact]) -> Iterator[str]:
        """Compare the records of the log; the storage may add to what was asked, as a time."""
        asked = {one.fact.kind for one in self.notes.values()}
        left = [one for one in records if one.kind in asked]
        for one in self.notes.values():
            kind, values = one.fact
            same = [r for r in left if r.kind == kind and values.items() <= r.values.items()]
            left = [record for record in left if record not in same]
            if one.acknowledged and not same:
                yield f"LOST: {one.fact}"
            if len(same) > (1 if kind in ONCE else one.asked):
                yield f"DOUBLED: {one.fact}"
        yield from (f"CHANGED: {one} was never asked" for one in left)


def findings(folder: Path, ledger: Ledger, is_finished: bool) -> Iterator[str]:
    """Yield what is not as it was acknowledged, as others read it; nothing may lack if finished."""
    needed = set(TRACES) if is_finished else ledger.stored
    yield from ledger.of_traces("JSON", _json_traces(folder), needed)
    mcap, bag = folder / "survey.mcap", folder / "survey.bag"
    recorded = (mcap_traces if is_finished else torn_mcap_traces)(mcap) if mcap.exists() else ()
    yield from ledger.of_traces("MCAP", recorded, needed)
    if is_finished and bag.exists():
        yield from ledger.of_traces("bag", bag_traces(bag), needed)
    for mark, path in itertools.product(ledger.acknowledged(), folder.glob("log*.jsonl")):
        if mark not in path.read_bytes():
            yield f"LOST: {ledger.notes[mark].fact} in {path.name}"
    if is_finished:
        records = recover(folder).found.records
        # Those of former reports have no values.
        yield from ledger.of_facts([Fact(Kind(one.kind), one.values or {}) for one in records])


def _json_traces(folder: Path) -> Iterator[Any]:
    for path in sorted(folder.glob("traces/[!.]*.json")):
        with contextlib.suppress(ValueError):  # is no trace; one that was acknowledged is missed
            yield json.loads(path.read_text("utf-8"))


def judged(data: Path, ledger: Ledger, *workers: Worker) -> Iterator[str]:
    """Yield what is wrong in a copy of a data folder as it is, and when it was finished."""
    yield from (f"STUCK: {text}" for one in workers for text in one.texts(Event.BROKEN))
    with tempfile.TemporaryDirectory() as place:
        shutil.copytree(str(data), f"{place}/data")
        folders = [one.parent for one in Path(place).glob("data/*/traces")]
        if ledger.opened and not folders:
            yield "LOST: the folder"
        try:
            for folder in folders:
                yield from findings(folder, ledger, is_finished=False)
                yield from _verified(folder, ledger, is_finished=False)
                yield from _finished(folder, ledger)
                yield from _verified(folder, ledger, is_finished=ledger.opened)
        except ProcessingError as error:
            yield from [f"STUCK: not finished: {error}"] if ledger.opened else []
        except Exception:
            # Nothing that an accident leaves may break a reader.
            yield f"STUCK: {traceback.format_exc(limit=-2)}"


def _verified(folder: Path, ledger: Ledger, is_finished: bool) -> Iterator[str]:
    """Look for everything in a survey that is called complete, or must be as it is finished."""
    found = verify_survey(folder)
    if found.status == COMPLETE:
        yield from (f"LAUNDERED: {one}" for one in findings(folder, ledger, is_finished=True))
    elif is_finished:
        yield f"STUCK: finished, but {found.verdict}"


def _finished(folder: Path, ledger: Ledger) -> Iterator[str]:
    """Reopen a survey and end it, unless it is complete."""
    kit = new_storage(folder.parent)
    try:
        stored = kit.processing.reopen_survey(SURVEY).stored_indices
        lost = sorted(ledger.stored.difference(stored))
        yield from (f"LOST: trace {index}: unknown when reopened" for index in lost)
        kit.finish(TRACES.values(), stored)
    except ProcessingError as error:
        if error.message.fault_code != IS_COMPLETE:
            raise
    finally:
        with contextlib.suppress(ProcessingError):
            kit.processing.shut_down()
    with_bag(folder)
