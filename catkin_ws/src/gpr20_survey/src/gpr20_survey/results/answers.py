"""What services of the robot answer, and what the daily check asks for, as records."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any, Dict, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.results.candidates import CandidateList, json_text, list_from
from gpr20_survey.trace.trace import Trace

AXES = ("x_mm", "y_mm", "depth_mm")


@dataclass(frozen=True)
class ReopenedSurvey:
    """A survey that was cut off or ended early, open again: the answer of reopen_survey.

    Attributes:
        recent: Those of the first traces of the plan that are stored, and the traces stored last,
            the latest last.
        repairs: What was repaired; the answer has it as a part of its sentence only.
    """

    survey_id: str
    path: str
    metadata_json: str
    report_json: str
    stored_indices: Tuple[int, ...]
    recent: Tuple[Trace, ...]
    repairs: Tuple[Message, ...] = ()
    interrupted: str = ""


@dataclass(frozen=True)
class AnalyzerTest:
    """What a test of the analyzer has found, up to its first failure; None: it had none.

    The calibration is the name of a `CalibrationStatus`; another version of the software may know
    more of them.
    """

    address: str
    identity: str = ""
    calibration: str = ""
    points: int = 0
    sweep_duration_s: float = 0.0
    level_db: float = 0.0
    failure: Optional[Message] = None


class Part(enum.Enum):
    """What the antennas see, numbered as in gpr20_msgs/DailyCheck."""

    EMPTY = "empty"
    PLATE = "plate"
    REFLECTOR = "reflector"


INSTRUCTIONS = {
    Part.EMPTY: Message(
        "Empty sweep: let the antennas see the sky or an absorber, and nothing else within 2 m."
    ),
    Part.PLATE: Message("Metal plate: put it below the antennas, at its mark."),
    Part.REFLECTOR: Message("Known reflector: take the plate away and put it at its mark."),
}


@dataclass(frozen=True)
class SurveySummary:
    """One survey of the data folder; an outcome, verdict or problem may be empty or None.

    A cell of the map is 100 [%] only if all of it is stored, and 0 only if none is.
    """

    folder: str
    survey_id: str = ""
    started: str = ""
    outcome: str = ""
    stored_traces: int = 0
    planned_traces: int = 0
    verdict: Optional[Message] = None
    complete: bool = False
    simulated: bool = False
    problem: Optional[Message] = None
    name: str = ""
    refines: str = ""
    width_mm: float = 0.0
    height_mm: float = 0.0
    map_columns: int = 0
    map_rows: int = 0
    map_percent: bytes = b""
    site: str = ""
    operator: str = ""


class ExportPart(enum.Enum):
    """One file of an export, as messages of ROS call it."""

    REPORT_HTML = "report-html"
    CANDIDATES_CSV = "candidates-csv"
    CANDIDATES_GEOJSON = "candidates-geojson"
    SURVEY_ZIP = "survey-zip"


@dataclass(frozen=True)
class Volume:
    """A mounted USB stick, or another removable volume; but for the device it is sent as it is.

    Attributes:
        device: Its number; another stick at the same place has another one. 0: not known, as on
            other computers.
    """

    path: str
    name: str
    free_bytes: int
    writable: bool
    device: int = 0


@dataclass(frozen=True)
class FocusedImage:
    """An image of a survey, or of the part that is stored so far, and the candidates in it.

    Its axes ascend.

    Attributes:
        levels_db: Level of the brighter polarization, float32 of shape (depth, Y, X), above the
            noise of its place [dB]; NaN where nothing was measured.
    """

    traces: int
    x_mm: np.ndarray
    y_mm: np.ndarray
    depth_mm: np.ndarray
    levels_db: np.ndarray
    found: CandidateList


def focus_fields(image: FocusedImage) -> Dict[str, Any]:
    return {
        "traces": image.traces,
        **{name: getattr(image, name).tolist() for name in AXES},
        "levels_db": image.levels_db.astype("<f4").tobytes(),
        "candidates_json": json_text(image.found),
    }


def image_from(fields: Any) -> FocusedImage:
    """Return the image of something that has these fields.

    Raises:
        InvalidValueError: Its parts contradict each other.
    """
    axes = {name: np.asarray(getattr(fields, name), np.float64) for name in AXES}
    shape = tuple(len(axes[name]) for name in reversed(AXES))
    ascending = all(
        axis.size and np.all(np.isfinite(axis)) and np.all(np.diff(axis) > 0.0)
        for axis in axes.values()
    )
    size = math.prod(shape)
    if not ascending or len(fields.levels_db) != 4 * size:
        raise InvalidValueError(Message("the focused image is not complete or not valid"))
    return FocusedImage(
        traces=fields.traces,
        **axes,
        levels_db=np.frombuffer(fields.levels_db, "<f4").reshape(shape),
        found=list_from(fields.candidates_json),
    )
