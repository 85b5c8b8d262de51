"""A list of candidates as rows and lines of text, in the language of a catalogue."""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, numeral
from gpr20_survey.results.candidates import (
    MOST_DOUBTFUL,
    NO_CLEARANCE,
    SIMULATED,
    Candidate,
    CandidateList,
)

NONE = "-"
DOUBTFUL_TITLE = Message(
    "Doubtful: clutter, or sidelobes of brighter candidates, but weak bodies look the same:"
)


def candidate_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of candidates."""
    return (
        catalogue.tr("id"),
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("above clutter dB"),
        catalogue.tr("false alarms per m2"),
        catalogue.tr("polarization ratio dB"),
        catalogue.tr("flags"),
    )


def candidate_row(candidate: Candidate, catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return a candidate as a row of a table below `candidate_heading`."""
    ratio_db, alarms = candidate.polarization_ratio_db, candidate.false_alarms
    return (
        candidate.id,
        *candidate.place_texts,
        catalogue.text(numeral(candidate.above_clutter_db, ".1f")),
        NONE if alarms is None else catalogue.text(alarms),
        NONE if ratio_db is None else catalogue.text(numeral(round(ratio_db, 1) + 0.0, "+.1f")),
        ", ".join(catalogue.text(label) for label in candidate.labels) or NONE,
    )


def head_sentences(found: CandidateList) -> List[Message]:
    """Return what comes before the table: what the list is not, and whether it is simulated."""
    return [*([SIMULATED] if found.simulated else []), NO_CLEARANCE]


def tail_sentences(found: CandidateList, shown: Sequence[Candidate]) -> List[Message]:
    """Return what comes after the table: how the candidates were found, and what is not shown."""
    total, primary = found.total, found.primary
    lowest, highest = found.permittivity_lowest, found.permittivity_highest
    extent = Message("area: {area_m2:.3g} m2", area_m2=found.area_m2)
    if found.length_m is not None:
        extent = Message("length: {length_m:.3g} m", length_m=found.length_m)
    sentences = [
        Message(
            "candidates: {primary}, doubtful (clutter or sidelobe): {secondary}, {extent}; "
            "method {method}",
            primary=primary,
            secondary=total - primary,
            extent=extent,
            method=found.method,
        )
    ]
    alarms = (found.false_alarms_per_m2, found.false_alarms_lowest, found.false_alarms_highest)
    if None not in alarms:
        sentences.append(
            Message(
                "of the clutter of this ground, about {density:.2g} echoes per m2 are as strong "
                "as a candidate must be ({fewest:.2g} to {most:.2g})",
                density=alarms[0],
                fewest=alarms[1],
                most=alarms[2],
            )
        )
    sentences.append(
        Message(
            "relative permittivity {permittivity:.3g}, {lowest:.3g} to {highest:.3g} are "
            "possible: the uncertainty of depths contains that",
            permittivity=found.permittivity,
            lowest=lowest,
            highest=highest,
        )
    )
    if found.omitted_primary:
        sentences.append(
            Message(
                "NOT shown, although NOT doubtful: {count}; list all with gpr20 candidates "
                "--most {total}",
                count=found.omitted_primary,
                total=total,
            )
        )
    elif total > len(shown):
        sentences.append(
            Message(
                "more doubtful ones that are not shown: {count}; list all with gpr20 candidates "
                "--most {total}",
                count=total - len(shown),
                total=total,
            )
        )
    if not found.candidates:
        sentences.append(Message("No candidate was found."))
    return sentences


def candidate_lines(
    found: CandidateList,
    catalogue: Catalogue = ENGLISH,
    most_doubtful: Optional[int] = MOST_DOUBTFUL,
) -> List[str]:
    """Return a list of candidates as lines of text, without the notes on the survey."""
    shown = found.shown(most_doubtful)
    # The brightest may be doubtful, but comes before others that are not.
    primary = max((row for row, one in enumerate(shown, 1) if not one.is_doubtful), default=0)
    rows = [candidate_row(one, catalogue) for one in shown]
    if rows:
        rows.insert(0, candidate_heading(catalogue))
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    lines = [
        "  ".join(cell.rjust(width) for cell, width in zip(row[:-1], widths)) + "  " + row[-1]
        for row in rows
    ]
    if primary < len(shown):
        lines.insert(1 + primary, catalogue.text(DOUBTFUL_TITLE))
    return [
        *(catalogue.text(one) for one in head_sentences(found)),
        *lines,
        *(catalogue.text(one) for one in tail_sentences(found, shown)),
    ]
