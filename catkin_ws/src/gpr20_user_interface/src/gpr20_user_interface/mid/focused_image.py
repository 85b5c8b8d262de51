"""The focused image of a survey: how far above the noise the ground is, place by place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from gpr20_common.message import Message


@dataclass(frozen=True)
class CandidateMark:
    """A place of the candidate list of the analysis.

    Attributes:
        number: Its number in the list, from 1.
        x_mm: X of the place.
        y_mm: Y of the place.
        depth_mm: Below the surface.
        level_db: Above the noise.
        doubtful: Whether the analysis doubts it.
        remarks: What to know about it.
    """

    number: int
    x_mm: float
    y_mm: float
    depth_mm: float
    level_db: float
    doubtful: bool
    remarks: Tuple[Message, ...] = ()


@dataclass(frozen=True)
class FocusedImage:
    """An image of a survey, or of the part that is stored so far.

    Attributes:
        survey_id: Of the survey.
        traces: How many traces it was made of.
        permittivity: Of the ground, as assumed.
        simulated: Whether the robot was simulated.
        x_mm: X of the columns, ascending.
        y_mm: Y of the rows, ascending.
        depth_mm: Depth of the layers, ascending.
        levels_db: Float32 of shape (depth, Y, X): above the noise magnitude at that depth; NaN
            where nothing was measured.
        candidates: What the analysis found in it.
    """

    survey_id: str
    traces: int
    permittivity: float
    simulated: bool
    x_mm: np.ndarray
    y_mm: np.ndarray
    depth_mm: np.ndarray
    levels_db: np.ndarray
    candidates: Tuple[CandidateMark, ...] = ()


@dataclass(frozen=True)
class ImageFocused:
    """An image is ready."""

    image: FocusedImage


@dataclass(frozen=True)
class ImageFailed:
    """An image could not be made.

    Attributes:
        survey_id: Of the survey.
        reason: Why, and what to do.
    """

    survey_id: str
    reason: Message
