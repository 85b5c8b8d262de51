"""The answer of the imaging node as an image; every value is checked."""

from __future__ import annotations

import math
from typing import Protocol, Sequence, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_user_interface.mid.candidate_list import ShownCandidate, candidates_from
from gpr20_user_interface.mid.focused_image import CandidateMark, FocusedImage

MM_PER_M = 1e3
MOST_VOXELS = 100_000_000


class FocusFields(Protocol):
    """The fields of the answer of gpr20_msgs/FocusSurvey."""

    survey_id: str
    traces: int
    x_mm: Sequence[float]
    y_mm: Sequence[float]
    depth_mm: Sequence[float]
    levels_db: bytes
    candidates_json: str


def image_from(fields: FocusFields) -> FocusedImage:
    """Return the image of an answer.

    Raises:
        InvalidValueError: Its parts contradict each other.
    """
    x_mm, y_mm, depth_mm = (
        np.asarray(axis, np.float64) for axis in (fields.x_mm, fields.y_mm, fields.depth_mm)
    )
    shape = (len(depth_mm), len(y_mm), len(x_mm))
    ascending = all(
        axis.size and np.all(np.isfinite(axis)) and np.all(np.diff(axis) > 0.0)
        for axis in (x_mm, y_mm, depth_mm)
    )
    size = math.prod(shape)
    if not ascending or size > MOST_VOXELS or len(fields.levels_db) != 4 * size:
        raise InvalidValueError(Message("the focused image is not complete or not valid"))
    found = candidates_from(fields.candidates_json, fields.survey_id)
    return FocusedImage(
        survey_id=fields.survey_id,
        traces=fields.traces,
        permittivity=found.permittivity,
        simulated=found.simulated,
        x_mm=x_mm,
        y_mm=y_mm,
        depth_mm=depth_mm,
        levels_db=np.frombuffer(fields.levels_db, "<f4").reshape(shape),
        candidates=_marks(found.shown),
    )


def _marks(candidates: Sequence[ShownCandidate]) -> Tuple[CandidateMark, ...]:
    return tuple(
        CandidateMark(
            number=number,
            x_mm=MM_PER_M * one.x_m,
            y_mm=MM_PER_M * one.y_m,
            depth_mm=MM_PER_M * one.depth_m,
            level_db=math.nan if one.above_noise_db is None else one.above_noise_db,
            doubtful=one.is_secondary,
            remarks=one.flags,
        )
        for number, one in enumerate(candidates, 1)
    )
