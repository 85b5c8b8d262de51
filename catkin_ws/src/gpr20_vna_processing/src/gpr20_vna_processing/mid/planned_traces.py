"""Whether the traces of a survey are those that its description plans."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Set

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.folder.description_recovery import Basis, RecoveredDescription
from gpr20_survey.plan.plan_fit import PlanFit
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import refusals


class _Candidate:
    """One of the descriptions that may be right."""

    def __init__(self, description: Dict[str, Any]) -> None:
        self.description = description
        self._misfits: Dict[bytes, List[Message]] = {}
        self._fit: Optional[PlanFit]
        try:
            self._fit = PlanFit(description)
        except InvalidValueError:
            self._fit = None  # surveys of other clients need not have a plan

    @property
    def has_plan(self) -> bool:
        """Whether its plan is known."""
        return self._fit is not None

    def note(self, trace: Trace) -> None:
        misfits = self._fit.misfits(trace) if self._fit is not None else []
        if misfits:
            self._misfits[trace.fingerprint()] = misfits

    def misfits(self, truth: Mapping[int, bytes]) -> List[Message]:
        """Return what is wrong with the true traces, in the order of the plan."""
        return [
            one
            for _index, fingerprint in sorted(truth.items())
            for one in self._misfits.get(fingerprint, ())
        ]


class PlannedTraces:
    """Compares every stored trace with each plan that the survey may have."""

    def __init__(self, folder: Path, recovered: RecoveredDescription) -> None:
        self._folder = folder
        self._recovered = recovered
        self._candidates = [_Candidate(one) for one in recovered.candidates]

    def note(self, trace: Trace) -> None:
        """Note a trace that is stored in one of the forms."""
        for one in self._candidates:
            one.note(trace)

    def damaged(self, truth: Mapping[int, bytes]) -> Set[int]:
        """Return the places in the plan whose traces do not fit it, if the plan is certain."""
        if self._recovered.basis is Basis.NOTHING:
            return set()
        (only,) = self._candidates
        return {index for index, own in truth.items() if only.misfits({index: own})}

    def description(self, truth: Mapping[int, bytes]) -> Dict[str, Any]:
        """Return the description that is right.

        Args:
            truth: Fingerprint of each trace that is true.

        Raises:
            SurveyRefusedError: A trace does not fit the plan, or nothing decides between two
                descriptions that contradict each other.
        """
        if len(self._candidates) > 1:
            return self._decide(truth)
        (only,) = self._candidates
        misfits = only.misfits(truth)
        if misfits:
            raise refusals.traces_not_planned(self._folder, misfits)
        unconfirmed = self._recovered.basis is Basis.NOTHING and self._recovered.own is None
        if unconfirmed and not only.has_plan:
            raise refusals.description_lost(self._folder)
        return only.description

    def _decide(self, truth: Mapping[int, bytes]) -> Dict[str, Any]:
        fitting = [one for one in self._candidates if one.has_plan and not one.misfits(truth)]
        if len(fitting) != 1 or not truth:
            first, second = self._recovered.candidates
            raise refusals.descriptions_differ(self._folder, differences(first, second))
        return fitting[0].description
