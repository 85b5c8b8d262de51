"""In place of the storage, for what shows surveys: it is asked without an answer."""

from __future__ import annotations

from typing import Any, List, Tuple


class Storage:
    """Answers nothing, remembers what it was asked."""

    def __init__(self) -> None:
        self.asked: List[Tuple[Any, ...]] = []

    def of(self, kind: str) -> List[Tuple[Any, ...]]:
        """Return what was asked of a kind."""
        return [one[1:] for one in self.asked if one[0] == kind]

    def list_surveys(self, before: str) -> None:
        self.asked.append(("list", before))

    def read_survey(self, folder: str) -> None:
        self.asked.append(("survey", folder))

    def read_traces(self, survey: str, indices: Tuple[int, ...]) -> None:
        self.asked.append(("traces", survey, indices))
