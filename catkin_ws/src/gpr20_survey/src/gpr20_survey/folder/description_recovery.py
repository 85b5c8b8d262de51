"""Which description of a survey is right, when its survey.json may be damaged."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

from gpr20_common.message import Message, in_a_row
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.description_copies import (
    agrees,
    latched_description,
    recorded_texts,
    sealed_description,
)
from gpr20_survey.folder.description_differences import Difference, constant_entries, differences

SHOWN = 10  # entries that are named in a repair
# How survey.json begins.
FIRST_KEYS = ("format", "survey_id", "started")
# The entries that change at the end, as they are before; then those that change earlier too.
NOT_ENDED: Dict[str, Any] = {
    "ended": None,
    "outcome": None,
    "reason": "",
    survey_metadata.REASON_MESSAGE: None,
    survey_metadata.FAULT_CODE: "",
}
START: Dict[str, Any] = {**NOT_ENDED, "stored_traces": 0}


class Basis(enum.Enum):
    """What vouches for a description."""

    CHECKSUM = "checksum"
    """The sealed copy in the MCAP, or the manifest."""
    AGREEMENT = "agreement"
    """Two copies without a checksum agree."""
    NOTHING = "nothing"
    """There is one copy only, or two that contradict each other."""


@dataclass(frozen=True)
class RecoveredDescription:
    """The description of a survey, as far as the folder alone can tell."""

    candidates: Tuple[Dict[str, Any], ...]
    """The whole descriptions that may be right, the most likely first; more than one only if
    nothing decides between them."""
    basis: Basis
    own: Optional[Dict[str, Any]]
    """The content of survey.json; None if it cannot be read."""
    later_damaged: bool
    """Whether entries that change during a survey differ from the manifest."""

    @property
    def best(self) -> Dict[str, Any]:
        """The most likely description."""
        return self.candidates[0]


def start_of(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return a description as it was when the survey began."""
    constant = constant_entries(description)
    first = {key: constant[key] for key in FIRST_KEYS if key in constant}
    return {**first, **START, **constant}


def repairs_of(recovered: RecoveredDescription, chosen: Dict[str, Any]) -> List[Message]:
    """Return what was wrong in survey.json, for people."""
    if recovered.own is None:
        return [
            Message(
                "wrote survey.json again as it was at the start, from a copy in the recordings; "
                "its list of failed samples is lost"
            ).with_fault(faults.REPAIRED)
        ]
    found: List[Message] = []
    changed = differences(recovered.own, chosen)
    if changed:
        found.append(
            Message(
                "corrected survey.json from the copy in the recordings: {entries}",
                entries=in_a_row([_correction(one) for one in changed[:SHOWN]]),
            ).with_fault(faults.REPAIRED)
        )
    if recovered.later_damaged and not changed:
        found.append(
            Message(
                "survey.json differs from the manifest: how the survey ended and its report may "
                "be damaged"
            ).with_fault(faults.REPAIRED)
        )
    if recovered.basis is Basis.NOTHING:
        found.append(
            Message(
                "no copy confirms survey.json: check its parameters; the stored traces do not "
                "contradict them"
            ).with_fault(faults.UNCONFIRMED)
        )
    return found


def recover_description(folder: Path) -> RecoveredDescription:
    """Return the description of a survey from survey.json and its copies.

    The manifest decides, then the sealed copy in the MCAP, then two copies that agree.

    Raises:
        SurveyRefusedError: survey.json cannot be read, and neither can a copy.
    """
    own, failure = _own(folder)
    vouched = _vouched(folder)
    if own is not None and vouched:
        return RecoveredDescription((own,), Basis.CHECKSUM, own, later_damaged=False)
    sealed = sealed_description(folder)
    later_damaged = own is not None and vouched is False
    if sealed is not None and _belongs(folder, sealed):
        best = sealed if own is None else survey_metadata.with_start_of(own, sealed)
        return RecoveredDescription((best,), Basis.CHECKSUM, own, later_damaged)
    candidates, basis = _by_agreement(folder, own)
    if not candidates and sealed is not None:
        return RecoveredDescription((sealed,), Basis.CHECKSUM, own, later_damaged)
    if not candidates:
        assert failure is not None
        # Resuming, which repairs it as long as there is a copy, does not help.
        raise SurveyRefusedError(failure.message, fault=faults.DESCRIPTION_LOST) from failure
    return RecoveredDescription(candidates, basis, own, later_damaged)


def _own(folder: Path) -> Tuple[Optional[Dict[str, Any]], Optional[SurveyRefusedError]]:
    try:
        return survey_metadata.read_description(folder / survey_folder.SURVEY_FILE), None
    except SurveyRefusedError as error:
        return None, error


def _vouched(folder: Path) -> Optional[bool]:
    """Return whether survey.json is as the manifest says; None without a valid manifest."""
    try:
        sealed = manifest.read_manifest(folder)
        present = file_sums.sum_of_file(folder / survey_folder.SURVEY_FILE)
    except (OSError, ManifestDamagedError):
        return None
    if sealed.matches(survey_folder.SURVEY_FILE, present):
        return True
    return None if sealed.reopened is not None else False


def _belongs(folder: Path, description: Dict[str, Any]) -> bool:
    return folder.name.endswith(f"_{description['survey_id'][:8]}")


def _by_agreement(
    folder: Path, own: Optional[Dict[str, Any]]
) -> Tuple[Tuple[Dict[str, Any], ...], Basis]:
    path = folder / survey_folder.SURVEY_FILE
    if own is None and path.exists() and not path.is_file():
        return (), Basis.NOTHING  # the copies could not take its place
    latched, texts = latched_description(folder), recorded_texts(folder)
    if latched is not None and not _belongs(folder, latched):
        latched = None
    copy = latched
    if copy is not None and own is not None:
        copy = survey_metadata.with_start_of(own, copy)
    elif copy is not None:
        copy = start_of(copy)
    present = tuple(one for one in (own, copy) if one is not None)
    # A survey.json with another survey's id does not hide a copy with the right one.
    candidates = tuple(one for one in present if _belongs(folder, one)) or present
    if len(candidates) == 2 and not differences(*candidates):
        return candidates[:1], Basis.AGREEMENT
    agreeing = tuple(one for one in candidates if agrees(one, texts))
    if agreeing:
        return agreeing[:1], Basis.AGREEMENT
    return candidates, Basis.NOTHING


def _correction(one: Difference) -> Message:
    return Message("{key} {wrong} to {right}", key=one.key, wrong=one.first, right=one.second)
