"""What a survey that returned to its first stop says about drift, repeatability and noise."""

from __future__ import annotations

import math
from typing import Any, List, Mapping, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import description_of, objects_of
from gpr20_common.message import Message, numeral, verbatim
from gpr20_survey.folder.log_record import Kind, log_values
from gpr20_survey.trace.utc_time import moment_text

Entry = Mapping[str, Any]
# A survey of two days, each hour at two rotations.
LISTED_ROWS = 100
HEADING = (
    Message("time"),
    Message("next trace"),
    Message("rotation [deg]"),
    Message("amplitude [dB]"),
    Message("phase [deg]"),
    Message("gain [dB]"),
    Message("delay [ps]"),
    Message("noise [dB]"),
)
FIGURES = {
    "amplitude_rms_db": ".3f",
    "phase_rms_deg": ".2f",
    "gain_db": "+.3f",
    "delay_ps": "+.2f",
    "noise_db": ".1f",
}


def drift_lines(survey: xr.Dataset) -> List[Message]:
    """Return drift, repeatability and noise floor in sentences, with the number of visits."""
    visits = _visits(survey)
    turns = [turn for _, turn in _turns(visits)]
    if not turns:
        return [Message("Drift was not measured: the survey did not return to its first stop.")]
    lines = [
        Message(
            "Visits of the first stop: {count}. The amplitude drifted by at most "
            "{amplitude_db} dB and the phase by at most {phase_deg} deg, root mean square over "
            "the band.",
            count=len(visits),
            amplitude_db=_text(max(_values(turns, "amplitude_rms_db")), ".3f"),
            phase_deg=_text(max(_values(turns, "phase_rms_deg")), ".2f"),
        ),
        Message(
            "Noise floor of one sweep below its signal, from two sweeps in a row at rest: at most "
            "{noise_db} dB (pairs: {count}).",
            noise_db=_text(max(_values(turns, "noise_db")), ".1f"),
            count=len(turns),
        ),
    ]
    if len(visits) > 1:
        lines.append(
            Message(
                "Repeatability from visit to visit, as standard deviation of {count} visits: "
                "gain {gain_db} dB, delay {delay_ps} ps.",
                count=len(visits),
                gain_db=_text(_spread(turns, "gain_db"), ".3f"),
                delay_ps=_text(_spread(turns, "delay_ps"), ".2f"),
            )
        )
    return lines


def drift_rows(survey: xr.Dataset) -> List[Tuple[Message, ...]]:
    """Return a row for each visit and rotation, the latest ones."""
    rows = [
        (
            moment_text(str(visit.get("time"))),
            verbatim(str(visit.get("next_index"))),
            numeral(_number(turn, "z_deg")),
            *(_text(_number(turn, name), form) for name, form in FIGURES.items()),
        )
        for visit, turn in _turns(_visits(survey))
    ]
    return rows[-LISTED_ROWS:]


def _visits(survey: xr.Dataset) -> Sequence[Entry]:
    return log_values(description_of(survey), Kind.DRIFT)


def _turns(visits: Sequence[Entry]) -> List[Tuple[Entry, Entry]]:
    return [(visit, turn) for visit in visits for turn in objects_of(visit, "rotations")]


def _number(entry: Entry, name: str) -> float:
    found = entry.get(name)
    return float(found) if isinstance(found, (int, float)) else math.nan


def _values(turns: Sequence[Entry], name: str) -> List[float]:
    """Return the known values, or NaN alone."""
    values = [_number(turn, name) for turn in turns]
    return [one for one in values if math.isfinite(one)] or [math.nan]


def _spread(turns: Sequence[Entry], name: str) -> float:
    """Return the largest standard deviation of any rotation."""
    angles = {_number(turn, "z_deg") for turn in turns}
    own = [[turn for turn in turns if _number(turn, "z_deg") == angle] for angle in angles]
    spreads = [
        float(np.std(values, ddof=1))
        for values in (_values(one, name) for one in own if one)
        if len(values) > 1
    ]
    return max(spreads, default=math.nan)


def _text(value: float, form: str) -> Message:
    return numeral(value, form) if math.isfinite(value) else verbatim("-")
