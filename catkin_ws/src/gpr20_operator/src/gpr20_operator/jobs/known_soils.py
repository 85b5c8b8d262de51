"""The permittivity of the ground of each survey: one for all pages, and for what is exported."""

from __future__ import annotations

from typing import Dict, Optional, Set

NOT_KNOWN = 0.0
"""What is sent as the permittivity where none is known here: that of the stored survey is used."""


class KnownSoils:
    """Belongs to one thread."""

    def __init__(self) -> None:
        self._values: Dict[str, Optional[float]] = {}
        self._unstored: Set[str] = set()

    def of(self, survey_id: str) -> Optional[float]:
        """Return the permittivity of a survey; None: it is not known."""
        return self._values.get(survey_id)

    def asked(self, survey_id: str, permittivity: Optional[float]) -> float:
        """Return what the imaging node is asked with, for one answer: it reads what is stored."""
        is_stored = survey_id not in self._unstored and permittivity == self.of(survey_id)
        return NOT_KNOWN if is_stored or permittivity is None else permittivity

    def enter(self, survey_id: str, permittivity: Optional[float]) -> None:
        """Take what a person entered here; it is not stored with the survey yet."""
        self._values[survey_id] = permittivity
        self._unstored.add(survey_id)

    def take(self, survey_id: str, noted: Optional[float]) -> None:
        """Take what is stored with a survey; None: that it is not known.

        Somebody at another screen may have entered it. What was entered here and is not stored
        yet is newer.
        """
        if survey_id not in self._unstored:
            self._values[survey_id] = noted

    def is_unstored(self, survey_id: str) -> bool:
        """Return whether something was entered here that is not stored with the survey yet."""
        return survey_id in self._unstored

    def note_stored(self, survey_id: str) -> None:
        """Note that what was entered here is stored."""
        self._unstored.discard(survey_id)
