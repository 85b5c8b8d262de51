"""The result of the verification of a survey's folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional

from gpr20_analysis import faults
from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields

COMPLETE, INCOMPLETE, DAMAGED = 0, 1, 2
UNCOVERED = Message(
    "entries of survey.json that change during a survey, messages that only one recording "
    "contains, and bytes outside the messages of an unfinished recording"
)


@dataclass
class Verification:
    """The result of the verification of a survey's folder."""

    faults: List[Message] = field(default_factory=list)
    """What is damaged or contradictory."""
    notes: List[Message] = field(default_factory=list)
    """What else a user should know."""
    planned: Optional[int] = None
    """Number of planned samples; None if unknown."""
    stored: int = 0
    """Number of planned samples that are stored and readable."""
    unproven: int = 0
    """Number of traces whose zeros of the axes nothing proves to be those of the others."""
    sealed: bool = False
    """Whether a manifest covers every file, so that no change could be unseen."""
    closed: bool = False
    """Whether the survey was closed, not cut off or interrupted."""

    def fault(self, message: Message) -> None:
        """Note what is damaged or contradictory."""
        self.faults.append(message)

    def note(self, message: Message) -> None:
        """Note what else a user should know."""
        self.notes.append(message)

    def record(self) -> Dict[str, Any]:
        """Return everything as JSON holds it, each sentence with the code of its fault."""
        return {
            "status": self.status,
            "planned": self.planned,
            "stored": self.stored,
            "unproven": self.unproven,
            "sealed": self.sealed,
            "closed": self.closed,
            "verdict": message_fields(self.verdict),
            "faults": [
                message_fields(one if one.cause else one.with_fault(faults.NOT_INTACT))
                for one in self.faults
            ],
            "notes": [message_fields(one) for one in self.notes],
        }

    @property
    def status(self) -> int:
        """0 complete and intact, 1 incomplete, unsealed or unproven, 2 damaged or contradictory."""
        if self.faults:
            return DAMAGED
        return COMPLETE if self._is_whole and not self.unproven else INCOMPLETE

    @property
    def _is_whole(self) -> bool:
        stored = self.planned is not None and self.stored == self.planned
        return stored and self.sealed and self.closed

    @property
    def verdict(self) -> Message:
        """The result in one sentence, with the fault that it reports."""
        if self.faults:
            of_manifest = all(one.fault_code == faults.MANIFEST.code for one in self.faults)
            return self._sentence.with_fault(faults.MANIFEST if of_manifest else faults.NOT_INTACT)
        if not self._is_whole:
            return self._sentence.with_fault(faults.NOT_COMPLETE)
        if self.unproven:
            return self._sentence.with_fault(faults.ZEROS_UNPROVEN)
        return self._sentence

    @property
    def _sentence(self) -> Message:
        if self.faults:
            return Message(
                "DAMAGED or contradictory ({count} faults): {counted}",
                count=len(self.faults),
                counted=self._counted,
            )
        if self._is_whole and self.unproven:
            return Message(
                "POSITIONS NOT PROVEN: all {planned} planned traces are stored and intact, but "
                "{count} of them refer to other zeros of the axes",
                planned=self.planned,
                count=self.unproven,
            )
        if self.status == COMPLETE:
            return Message(
                "complete and intact: all {planned} planned traces are stored and readable",
                planned=self.planned,
            )
        if not self.sealed:
            return Message(
                "INCOMPLETE, readable: {counted}, and the survey was not closed; without a "
                "manifest, changes to {uncovered} cannot be detected",
                counted=self._counted,
                uncovered=UNCOVERED,
            )
        if self.closed:
            return Message("INCOMPLETE, but intact: {counted}", counted=self._counted)
        return Message(
            "INCOMPLETE, but intact: {counted}, and the survey was interrupted",
            counted=self._counted,
        )

    @property
    def _counted(self) -> Message:
        if self.planned is None:
            return Message(
                "{stored} of an unknown number of planned traces are stored and readable",
                stored=self.stored,
            )
        return Message(
            "{stored} of {planned} planned traces are stored and readable",
            stored=self.stored,
            planned=self.planned,
        )
