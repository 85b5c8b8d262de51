"""The focused image of a survey, as fields of the answer of gpr20_msgs/FocusSurvey and back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.results.candidates import CandidateList, json_text, list_from

AXES = ("x_mm", "y_mm", "depth_mm")


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
