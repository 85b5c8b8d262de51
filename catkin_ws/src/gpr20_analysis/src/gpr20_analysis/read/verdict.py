"""The result of the verification of a survey's folder, and its verdict in one sentence."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple

from gpr20_analysis import errors
from gpr20_analysis.sentences import json_fields
from gpr20_common.message import Message
from gpr20_survey.faults import LOCKED, UNCONFIRMED

COMPLETE, INCOMPLETE, DAMAGED = 0, 1, 2
SHOWN = 5  # entries that are named in the verdict


@dataclass
class Verification:
    """The result of the verification of a survey's folder."""

    faults: List[Message] = field(default_factory=list)
    """What is damaged or contradictory."""
    doubts: List[Message] = field(default_factory=list)
    """What of the survey may not be believed."""
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
    unconfirmed: Tuple[str, ...] = ()
    """Names of what nothing vouches for."""
    writer: str = ""
    """Number of the process that writes the survey; empty: nobody does."""
    imported: Optional[Message] = None
    """From what an imported survey was made, which has no plan; None: a survey of the robot."""

    def record(self) -> Dict[str, Any]:
        """Return everything as JSON holds it, each sentence with the code of its fault."""
        return {
            "status": self.status,
            "planned": self.planned,
            "stored": self.stored,
            "imported": self.imported is not None,
            "unproven": self.unproven,
            "sealed": self.sealed,
            "closed": self.closed,
            "unconfirmed": list(self.unconfirmed),
            "being_written": bool(self.writer),
            "verdict": json_fields(self.verdict),
            "faults": [
                json_fields(one if one.cause else one.with_fault(errors.NOT_INTACT))
                for one in self.faults
            ],
            "doubts": [json_fields(one) for one in self.doubts],
            "notes": [json_fields(one) for one in self.notes],
        }

    @property
    def status(self) -> int:
        """0 complete and intact, 2 damaged or contradictory, 1 anything between.

        An imported survey is never 0: nothing says what was to be measured.
        """
        if self.faults:
            return DAMAGED
        doubted = self.unproven or self.unconfirmed
        return COMPLETE if self._is_whole and not doubted else INCOMPLETE

    @property
    def _is_whole(self) -> bool:
        stored = self.planned is not None and self.stored == self.planned
        return stored and self.sealed and self.closed

    @property
    def verdict(self) -> Message:
        """The result in one sentence, with the fault that it reports."""
        if self.faults:
            first = self.faults[0].fault
            if first is None or any(one.fault != first for one in self.faults):
                first = errors.NOT_INTACT if self.imported is None else errors.FILE_DAMAGED
            return Message(
                "DAMAGED or contradictory ({count} faults): {counted}",
                count=len(self.faults),
                counted=self._counted,
            ).with_fault(first)
        if self.writer:
            return Message(
                "BEING WRITTEN by process {process}: {counted} so far, without a fault",
                process=self.writer,
                counted=self._counted,
            ).with_fault(LOCKED)
        if self.imported is None and not self._is_whole:
            return self._incomplete.with_fault(errors.NOT_COMPLETE)
        if self.unproven:
            return Message(
                "POSITIONS NOT PROVEN: {counted}, but {count} of them refer to other zeros of the "
                "axes",
                counted=self._counted,
                count=self.unproven,
            ).with_fault(errors.ZEROS_UNPROVEN)
        if self.unconfirmed:
            return Message(
                "intact, except {count} entries UNCONFIRMED: {counted}, but nothing vouches for "
                "{names}",
                count=len(self.unconfirmed),
                counted=self._counted,
                names=", ".join(self.unconfirmed[:SHOWN]),
            ).with_fault(UNCONFIRMED)
        if self.imported is not None:
            return Message(
                "IMPORTED, files intact: {counted}, {imported}; it has no plan, so nothing says "
                "what is missing",
                counted=self._counted,
                imported=self.imported,
            )
        return Message(
            "complete and intact: all {planned} planned traces are stored and readable",
            planned=self.planned,
        )

    @property
    def _incomplete(self) -> Message:
        if not self.sealed:
            return Message(
                "INCOMPLETE, readable: {counted}, and the survey was not closed; without a "
                "manifest, changes to messages other than traces at the end of survey.mcap cannot "
                "be detected",
                counted=self._counted,
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
            return Message("{stored} traces are stored and readable", stored=self.stored)
        return Message(
            "{stored} of {planned} planned traces are stored and readable",
            stored=self.stored,
            planned=self.planned,
        )
