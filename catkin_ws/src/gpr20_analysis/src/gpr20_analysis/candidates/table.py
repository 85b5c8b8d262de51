"""A list of candidates as rows and lines of text, in the language of a catalogue."""

from __future__ import annotations

from typing import List, Sequence, Tuple

from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, numeral
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED, Candidate, CandidateList

NONE = "-"
X_COLUMN, Y_COLUMN, RATIO_COLUMN = 1, 2, 6
WEAKER_TITLE = Message("Weaker echoes: no stronger than clutter, but weak bodies look the same:")


def candidate_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of candidates."""
    return (
        catalogue.tr("id"),
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("strength"),
        catalogue.tr("above clutter dB"),
        catalogue.tr("polarization ratio dB"),
        catalogue.tr("details"),
    )


def candidate_row(candidate: Candidate, catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return a candidate as a row of a table below `candidate_heading`."""
    ratio_db = candidate.polarization_ratio_db
    return (
        candidate.id,
        *candidate.place_texts,
        catalogue.text(candidate.strength),
        catalogue.text(numeral(candidate.above_clutter_db, ".1f")),
        NONE if ratio_db is None else catalogue.text(numeral(round(ratio_db, 1) + 0.0, "+.1f")),
        ", ".join(catalogue.text(label) for label in candidate.labels) or NONE,
    )


def candidate_table(
    found: CandidateList, listed: Sequence[Candidate], catalogue: Catalogue = ENGLISH
) -> List[Tuple[str, ...]]:
    """Return heading and rows, without columns that are empty for all, or the same on a line."""
    empty = set()
    if all(one.polarization_ratio_db is None for one in listed):
        empty.add(RATIO_COLUMN)
    if found.length_m is not None:
        # Across a line a place is less certain, and the same for all.
        along_x = all(one.y_uncertainty_m >= one.x_uncertainty_m for one in listed)
        empty.add(Y_COLUMN if along_x else X_COLUMN)
    rows = [candidate_heading(catalogue), *(candidate_row(one, catalogue) for one in listed)]
    return [tuple(cell for at, cell in enumerate(row) if at not in empty) for row in rows]


def places_sentence(found: CandidateList) -> Message:
    """Return how many places there are to check, and where the list is cut."""
    extent = Message("area {area_m2:.3g} m2", area_m2=found.area_m2)
    if found.length_m is not None:
        extent = Message("length {length_m:.3g} m", length_m=found.length_m)
    return Message(
        "Places to check: {count} ({extent}). The list is cut at {least_db:.1f} dB above clutter, "
        "where ground without bodies has about {density:.2g} places per m2.",
        count=found.primary,
        extent=extent,
        least_db=found.least_db,
        density=found.false_alarms_per_m2,
    )


def weaker_sentence(found: CandidateList) -> Message:
    """Return how many echoes are below the cut."""
    return Message("{count} weaker echoes", count=found.weaker)


def candidate_lines(
    found: CandidateList, catalogue: Catalogue = ENGLISH, weaker: bool = False
) -> List[str]:
    """Return a list of candidates as lines of text, without the notes on the survey.

    Args:
        found: The list.
        catalogue: Language of the text.
        weaker: Whether the weaker echoes are listed too.
    """
    listed = found.candidates if weaker else found.shown()
    lines = text_lines(candidate_table(found, listed, catalogue), 0) if listed else []
    if found.primary < len(listed):
        lines.insert(1 + found.primary, catalogue.text(WEAKER_TITLE))
    elif found.weaker and not weaker:
        more = Message("{echoes}; show them with --weaker", echoes=weaker_sentence(found))
        lines.append(catalogue.text(more))
    first = [SIMULATED] if found.simulated else []
    head = [*first, NO_CLEARANCE, places_sentence(found)]
    return [*(catalogue.text(one) for one in head), *lines]


def text_lines(rows: Sequence[Sequence[str]], left: int) -> List[str]:
    """Return the rows of a table as lines of text.

    Args:
        rows: The rows, which are equally long.
        left: From this column on cells are at the left; 0: only the last one.
    """
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    left = left or len(widths) - 1
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if at >= left else cell.rjust(width)
            for at, (cell, width) in enumerate(zip(row, widths))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines
