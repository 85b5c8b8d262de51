"""Whether a survey's folder holds what was acknowledged, after a fault and when it is finished."""

from __future__ import annotations

import collections
import contextlib
import json
import shutil
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Counter, Iterable, List, Optional, Set

from storage_kit import Kit

from fault_suite.evidence import everything_of, log_of, survey_in, traces_of_torn
from fault_suite.facts import Difference, Facts, Found, Kind
from fault_suite.script import TRACES
from fault_suite.worker import COMPLETE
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE as INTACT
from gpr20_analysis.read.verification_result import Verification
from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS
from gpr20_vna_processing.mid.survey_archive import SurveyArchive

LAUNDERED = "laundered"
NAMED = "named"
UNSEEN = "unseen"
STUCK = "stuck"


@dataclass
class Result:
    """What the faults of one kind did.

    Attributes:
        name: The kind.
        times: How many faults there were.
        acknowledged: Facts of each kind.
        found: What became of facts and surveys, by the columns of the table.
        failed: Which faults have led to any of that.
        texts: One line for each of those.
        remark: Why something was not possible, or what else a reader should know.
    """

    name: str
    times: int = 0
    acknowledged: Counter[Kind] = field(default_factory=collections.Counter)
    found: Counter[str] = field(default_factory=collections.Counter)
    failed: Set[str] = field(default_factory=set)
    texts: List[str] = field(default_factory=list)
    remark: str = ""

    @property
    def has_faults(self) -> bool:
        """Whether anything is not as it must be; what is named is no fault."""
        return bool(self.failed)

    def note(self, column: str, what: str, text: str) -> None:
        """Note what became of a fact or a survey.

        Args:
            column: Of the table.
            what: After which fault.
            text: For a reader.
        """
        self.found[column] += 1
        self.texts.append(f"{column}: {what}: {text}")
        if column != NAMED:
            self.failed.add(what)


class Judge:
    """Judges the folder of a survey after a fault; works in copies of it.

    Args:
        result: Where the findings go.
        what: Which fault, for the reader of a finding.
        may_name: Whether a fact may be other than acknowledged if the verification says so: where a
            file was damaged behind the storage's back.
    """

    def __init__(self, result: Result, what: str, may_name: bool = False) -> None:
        self._result = result
        self._what = what
        self._may_name = may_name

    def note(self, column: str, text: str) -> None:
        """Note a finding."""
        self._result.note(column, self._what, text)

    def judge(self, data: Path, place: Path, facts: Facts) -> None:
        """Look for every fact as the files are now, and after the survey was finished.

        Args:
            data: The data folder; it stays as it is.
            place: Where the copy is made and removed.
            facts: What was acknowledged.
        """
        shutil.copytree(str(data), str(place), symlinks=True)
        try:
            self._judge(place, facts)
        except Exception:
            # Nothing that a fault leaves may break a reader.
            self.note(STUCK, traceback.format_exc())
        shutil.rmtree(str(place))

    def _judge(self, place: Path, facts: Facts) -> None:
        folder = survey_in(place)
        if folder is None:
            if facts.opened:
                self.note("lost", "the survey's folder")
            return
        if not self._may_name:
            self._note_all(facts.trace_differences(traces_of_torn(folder)))
        verified = _verified(folder)
        if verified is not None and verified.status == INTACT:
            self._check_intact(folder, facts)
        elif facts.finished and not self._may_name:
            reasons = "" if verified is None else list(map(str, verified.faults))
            self.note(STUCK, f"finished, but not complete and intact: {reasons}")
        if self._finish(
            folder, facts, is_intact=verified is not None and verified.status == INTACT
        ):
            self._check_finished(folder, facts)

    def _check_intact(self, folder: Path, facts: Facts) -> None:
        """Look for facts in a survey that is called complete and intact before any repair."""
        differences = _differences(folder, facts)
        if differences:
            self.note(LAUNDERED, f"called complete and intact: {_shown(differences)}")

    def _finish(self, folder: Path, facts: Facts, is_intact: bool) -> bool:
        """Reopen a survey and end it; return whether it has ended."""
        kit = Kit(folder.parent)
        try:
            stored = kit.processing.reopen_survey(folder.name).stored_indices
            for index in sorted(facts.stored.difference(stored)):
                self.note("lost", f"trace {index} is unknown when reopened")
            kit.finish(TRACES, stored)
        except ProcessingError as error:
            refused = isinstance(error, SurveyRefusedError)
            if refused and error.message.fault_code == COMPLETE and is_intact:
                return True
            if facts.opened:
                self.note(STUCK, f"cannot be finished: {error}")
            return False
        finally:
            with contextlib.suppress(ProcessingError):
                kit.processing.shut_down()
        return True

    def _check_finished(self, folder: Path, facts: Facts) -> None:
        verified = verify_survey(folder)
        differences = _differences(folder, facts)
        if verified.status == INTACT:
            self._note_all(differences)
            if differences:
                self.note(LAUNDERED, f"complete and intact after a repair: {_shown(differences)}")
            return
        reasons = ", ".join(map(str, verified.faults or verified.notes))
        # The files of a survey whose opening was cut off do not tell that from a lost log.
        if self._may_name or not (facts.opened or verified.faults):
            self.note(NAMED, _shown(differences) or reasons)
        else:
            self._note_all(differences)
            self.note(STUCK, f"not intact when finished: {reasons}")

    def _note_all(self, differences: Iterable[Difference]) -> None:
        for one in dict.fromkeys(differences):
            self.note(one.fault.value, str(one))


def _verified(folder: Path) -> Optional[Verification]:
    with contextlib.suppress(AnalysisError):
        return verify_survey(folder)
    return None


def _differences(folder: Path, facts: Facts) -> List[Difference]:
    """Return the differences of a survey that has ended, as others read it and as it is listed."""
    found, log = everything_of(folder), log_of(folder)
    differences = facts.differences(found, every_trace=True)
    if log is not None:
        differences += facts.differences(log, every_trace=True)
    listed = SurveyArchive(folder.parent).survey(folder.name).description
    shown = Found({}, listed.get(MARKERS, []), listed.get(ANNOTATION), found.report)
    differences += facts.differences(shown, every_trace=True)
    return differences


def _shown(differences: Iterable[Difference]) -> str:
    return ", ".join(map(str, dict.fromkeys(differences)))


def as_json(result: Result) -> str:
    """Return a result for programs."""
    return json.dumps(
        {
            "name": result.name,
            "times": result.times,
            "acknowledged": {one.value: count for one, count in result.acknowledged.items()},
            "failed": len(result.failed),
            "found": dict(result.found),
            "remark": result.remark,
        }
    )
