"""What the group's formats share: which files are read, and a survey from their samples.

A value that cannot be right is refused by its file; what may be right is a decision in the log.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, List, Optional, Pattern, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DISPLAY_ONLY
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.sentences import with_decisions, with_notes, with_sentence
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.header import Header, no_files, refusal
from gpr20_survey.files.regular_files import regular_files

DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
LETTERS_DECIDED = Message(
    "the letters X and Y are rotations of 0 and 90 deg; the files do not name the direction of the "
    "rotation"
)
PHASE_DECIDED = Message(
    "the phase of a later echo falls faster with frequency, as a VNA measures it; no sign was "
    "changed"
)
NAMED = 3
LOWEST_STOP_HZ, HIGHEST_HZ = 1e7, 1e12
"""A sweep in GHz, MHz or kHz that is read as Hz ends below the first."""
MOST_POINTS, FARTHEST_MM = 100_000, 10_000.0
MOST_S21, PASSIVE_S21 = 1e6, 1.0
"""What no instrument measures, and what antennas without an amplifier do not exceed."""
ALIKE = Message("files that look like samples, but would not be read")
OTHERS = Message("other files of the folder, which were not read")
ZERO = Message("samples of only 0, which count as missing, for nothing was measured")
LARGE = Message(
    "samples with |S21| above 1, so with an amplifier or in dB where linear is read; they were kept"
)
COPIED = Message(
    "samples whose imaginary part is a copy of the real part, as an old version of the storage "
    "wrote it, so they cannot be imaged"
)


@dataclass
class Samples:
    """What files of the group hold, over frequency or over time.

    Attributes:
        names: Of the files of the samples, or of their places.
        positions: Rotation [deg], y and x [mm] (sample, 3).
        scans: Complex numbers (sample, point); those of only 0 become NaN.
        heights_m: NaN where not known.
        times: When the samples were measured; None: not known.
        decisions: What was decided where the files say nothing.
    """

    names: Sequence[str]
    positions: np.ndarray
    scans: np.ndarray
    heights_m: np.ndarray
    frequency_hz: Optional[np.ndarray] = None
    delay_s: Optional[np.ndarray] = None
    times: Optional[List[np.datetime64]] = None
    notes: List[Message] = field(default_factory=list)
    decisions: List[Message] = field(default_factory=list)


def survey_of(path: Path, found: Samples) -> xr.Dataset:
    """Return the Dataset of samples, with what is doubtful of them in the log.

    Raises:
        UnreadableFileError: No instrument measures such numbers, all are 0, or two have one place.
    """
    doubtful = _doubtful(found)
    if found.frequency_hz is not None:
        found.decisions.append(PHASE_DECIDED)
    data = on_grid(
        printable(path.name),
        found.positions,
        found.scans,
        found.heights_m.tolist(),
        found.frequency_hz,
        found.notes,
        delay_s=found.delay_s,
        times=found.times,
    )
    data = with_decisions(data, *doubtful, *found.decisions)
    copied = (found.scans.real == found.scans.imag).all(axis=1)
    if not copied.any():
        return data
    reason = _listed(COPIED, [found.names[one] for one in np.flatnonzero(copied)])
    data = data.assign_attrs(with_notes(data, [Message("WARNING: {sentence}", sentence=reason)]))
    return data.assign_attrs(with_sentence(data.attrs, DISPLAY_ONLY, reason))


def files_of_samples(
    folder: Path, rule: Pattern[str], ending: str, example: str, *beside: str
) -> Tuple[List[Path], List[Message]]:
    """Return the files of samples, in the order of their names, and what others there are.

    Hidden files are none of the user's: those of a desktop, or of the file system of a stick.

    Args:
        folder: Their folder.
        rule: Form of their names.
        ending: What names of samples contain.
        example: A name of that form.
        *beside: Names of files that are no samples, but are read too.

    Raises:
        UnreadableFileError: There is none, or others look like samples, but would not be read.
    """
    names = os.listdir(str(folder)) if folder.is_dir() else ()
    own = sorted(filter(rule.fullmatch, names))
    if not own:
        raise no_files(folder, example)
    read = {*beside, *own}
    others = [
        one for one in regular_files(folder) if one not in read and not re.search(r"(^|/)\.", one)
    ]
    alike = [one for one in others if ending in one.lower()]
    if alike:
        raise refusal(
            Message(
                "{folder}: {files}. Give them names such as {example} in this folder, or move them "
                "away",
                folder=folder.name,
                files=_listed(ALIKE, alike),
                example=example,
            )
        )
    return [folder / one for one in own], [_listed(OTHERS, others)] if others else []


def check_sweep(file: str, start_hz: float, stop_hz: float) -> None:
    """Refuse a sweep in another unit, or in another order.

    Raises:
        UnreadableFileError: It is one.
    """
    ends = Header(file, {"first frequency [Hz]": start_hz, "last frequency [Hz]": stop_hz})
    ends.number("last frequency [Hz]", LOWEST_STOP_HZ, HIGHEST_HZ)
    # The smallest that is above zero.
    ends.number("first frequency [Hz]", float(np.finfo(np.float64).tiny), stop_hz)


def _listed(what: Message, names: Sequence[str]) -> Message:
    """Return what files or samples are, with the first few of them."""
    files = ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
    return Message("{what}: {count}, {files}", what=what, count=len(names), files=files)


def _doubtful(found: Samples) -> List[Message]:
    names, scans = found.names, found.scans
    largest = np.maximum(np.abs(scans.real), np.abs(scans.imag)).max(axis=1)
    for one in np.flatnonzero(largest > MOST_S21)[:1]:
        allowed = Message("linear, at most 1 for antennas without an amplifier")
        raise Header(names[one], {"|S21|": f"{largest[one]:g}"}).refused("|S21|", allowed)
    zero = largest == 0.0
    if zero.all():
        raise refusal(_listed(ZERO, names))
    scans[zero] = complex(np.nan, np.nan)
    loud = np.flatnonzero(largest > PASSIVE_S21)
    kinds = (
        (ZERO, [names[one] for one in np.flatnonzero(zero)]),
        (LARGE, [f"{names[one]} ({largest[one]:g})" for one in loud]),
    )
    return [_listed(what, some) for what, some in kinds if some]
