"""A list of candidates as rows and lines of text, in the language of a catalogue."""

from __future__ import annotations

import math
from typing import List, Optional, Sequence, Tuple

from gpr20_analysis.candidates.candidate import NO_CLEARANCE, Candidate, CandidateList, Flag
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

NONE = "-"
FLAGS = {
    Flag.SURFACE_RESIDUE: Message("surface residue"),
    Flag.EDGE: Message("edge"),
    Flag.ONE_POLARIZATION: Message("one polarization"),
    Flag.CLUTTER: Message("clutter"),
    Flag.SIDELOBE: Message("sidelobe"),
    Flag.UNRATED: Message("not rated"),
}
SIMULATED = Message("SIMULATED: these are no measurements of real ground.")
# The model of the noise is not good enough to distinguish smaller ones.
SMALLEST_ALARM = 1e-6
MOST_SECONDARY = 10
SECONDARY_TITLE = Message(
    "Doubtful: clutter, or sidelobes of brighter candidates, but weak bodies look the same:"
)


def candidate_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of candidates."""
    return (
        catalogue.tr("id"),
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("above noise dB"),
        catalogue.tr("false alarm"),
        catalogue.tr("polarization ratio dB"),
        catalogue.tr("flags"),
    )


def candidate_row(candidate: Candidate, catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return a candidate as a row of a table below `candidate_heading`."""
    ratio_db = candidate.polarization_ratio_db
    unrated = math.isnan(candidate.above_noise_db)
    return (
        candidate.id,
        _with_uncertainty(candidate.x_m, candidate.x_uncertainty_m),
        _with_uncertainty(candidate.y_m, candidate.y_uncertainty_m),
        _with_uncertainty(candidate.depth_m, candidate.depth_uncertainty_m),
        NONE if unrated else f"{candidate.above_noise_db:.1f}",
        NONE if unrated else false_alarm_text(candidate.false_alarm_probability),
        NONE if ratio_db is None else f"{round(ratio_db, 1) + 0.0:+.1f}",
        ", ".join(catalogue.text(FLAGS[flag]) for flag in candidate.flags) or NONE,
    )


def false_alarm_text(probability: float) -> str:
    """Return the probability of a false alarm as text, such as "0.3 %"."""
    if probability < SMALLEST_ALARM:
        return f"< {100.0 * SMALLEST_ALARM:g} %"
    percent = 100.0 * probability
    return f"{percent:.0f} %" if percent >= 9.5 else f"{percent:.1g} %"


def head_sentences(found: CandidateList) -> List[Message]:
    """Return what comes before the table: what the list is not, and whether it is simulated."""
    return [*([SIMULATED] if found.simulated else []), NO_CLEARANCE]


def shown_candidates(
    found: CandidateList, most_secondary: Optional[int] = MOST_SECONDARY
) -> Tuple[Candidate, ...]:
    """Return the candidates that a person reads: all primary ones, then some secondary ones.

    Args:
        found: The list.
        most_secondary: Most secondary candidates; None: all that are listed.

    Returns:
        The first candidates of the list.
    """
    primary = sum(not one.is_secondary for one in found.candidates)
    last = None if most_secondary is None else primary + most_secondary
    return found.candidates[:last]


def tail_sentences(found: CandidateList, shown: Sequence[Candidate]) -> List[Message]:
    """Return what comes after the table: how the candidates were found, and what is not shown.

    Args:
        found: The list.
        shown: The candidates of the table.

    Returns:
        The sentences.
    """
    total = len(found.candidates) + found.omitted
    primary = sum(not one.is_secondary for one in found.candidates) + found.omitted_primary
    lowest, highest = found.permittivity_range
    sentences = [
        Message(
            "candidates: {primary}, doubtful (clutter or sidelobe): {secondary}, area: "
            "{area_m2:.3g} m2; noise alone gives a candidate in {false_alarm_percent:g} % of such "
            "images; method {method}",
            primary=primary,
            secondary=total - primary,
            area_m2=found.area_m2,
            false_alarm_percent=100.0 * found.false_alarm_rate,
            method=found.method,
        )
    ]
    if lowest == highest:
        sentences.append(
            Message(
                "relative permittivity {permittivity:.3g}, as given: depths have no uncertainty "
                "for it",
                permittivity=found.permittivity,
            )
        )
    else:
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
    most_secondary: Optional[int] = MOST_SECONDARY,
) -> List[str]:
    """Return a list of candidates as lines of text, without the notes on the survey.

    Args:
        found: The list.
        catalogue: Language of the lines.
        most_secondary: Most candidates that may be only clutter or sidelobes; None: all that are
            listed. The others are always shown.

    Returns:
        The lines.
    """
    shown = shown_candidates(found, most_secondary)
    primary = sum(not one.is_secondary for one in shown)
    rows = [candidate_row(one, catalogue) for one in shown]
    if rows:
        rows.insert(0, candidate_heading(catalogue))
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    lines = [
        "  ".join(cell.rjust(width) for cell, width in zip(row[:-1], widths)) + "  " + row[-1]
        for row in rows
    ]
    if primary < len(shown):
        lines.insert(1 + primary, catalogue.text(SECONDARY_TITLE))
    return [
        *(catalogue.text(one) for one in head_sentences(found)),
        *lines,
        *(catalogue.text(one) for one in tail_sentences(found, shown)),
    ]


def _with_uncertainty(value_m: float, uncertainty_m: float) -> str:
    # 2.00001 mm are 2 mm.
    about_mm = math.ceil(round(uncertainty_m * MM_PER_M, 2))
    return f"{value_m * MM_PER_M:.0f} ±{about_mm:d}"
