"""What a report is made of, whatever its format."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, List, Sequence, Tuple

from gpr20_common.catalogue import Language

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass
class Section:
    """One part of a report.

    Attributes:
        title: Heading.
        notice: Sentence in a frame below it; empty: none.
        warnings: Sentences that are highlighted.
        lines: Other sentences.
        rows: Rows of a table.
        heading: Titles of its columns.
        figures: Captions and figures.
    """

    title: str
    notice: str = ""
    warnings: List[str] = field(default_factory=list)
    lines: List[str] = field(default_factory=list)
    rows: Sequence[Tuple[str, ...]] = ()
    heading: Tuple[str, ...] = ()
    figures: List[Tuple[str, Figure]] = field(default_factory=list)

    @property
    def empty(self) -> bool:
        """Whether there is nothing below the heading."""
        return not (self.notice or self.warnings or self.lines or self.rows or self.figures)


@dataclass(frozen=True)
class Report:
    """A report.

    Attributes:
        title: Its title.
        sections: What it shows, in order.
        language: Language of the texts.
        mark: Word in every caption, "SIMULATED" if the survey is simulated; else empty.
        banner: Sentence at the top of every page that says the same; else empty.
        footer: Sentence at the bottom of every page.
    """

    title: str
    sections: Sequence[Section]
    language: Language = Language.ENGLISH
    mark: str = ""
    banner: str = ""
    footer: str = ""

    def caption(self, text: str) -> str:
        """Return the caption of a figure with the mark."""
        return f"{text} ({self.mark})" if self.mark else text
