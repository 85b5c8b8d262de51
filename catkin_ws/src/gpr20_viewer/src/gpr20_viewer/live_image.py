"""The image that the viewer shows, made again for each setting that changes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

from gpr20_analysis.candidates.answer import Answer
from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.imaging.permittivity import Source, permittivity_range
from gpr20_analysis.sentences import NOTES, sentences_of
from gpr20_common.message import Message
from gpr20_survey.radar import decibels

NS_PER_S = 1e9


SLIDER = "slider"
"""Where a permittivity is from, besides the sources of images."""


@dataclass(frozen=True)
class ImageRequest:
    """What the image depends on.

    Attributes:
        permittivity: Relative permittivity that was set with the slider; None: that of the options,
            or the value found in the data.
        background: Whether the background is subtracted.
    """

    permittivity: Optional[float]
    background: bool


class LiveImage:
    """An image, and how it was made.

    Args:
        request: What it was made for.
        found: What the survey shows with that.

    Attributes:
        candidates: What was found in it.
        notes: What is noted about it and the survey.
        levels_db: Levels (polarization, depth, y, x) relative to the brightest [dB].
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        depth_m: Depths [m].
        source: Where its permittivity is from: `SLIDER`, or the value of a `Source`.
        caption: Method and permittivity, and where that is from.
    """

    def __init__(self, request: ImageRequest, found: Answer) -> None:
        self.request, self.candidates, image = request, found.found, found.image
        self.notes = sentences_of(image, NOTES)
        self.permittivity = float(image.attrs["permittivity"])
        volume = image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X)
        magnitude = np.abs(volume.values).astype(np.float32)
        levels_db = decibels(magnitude, float(np.finfo(np.float32).tiny))
        self.levels_db = levels_db - levels_db.max()
        self.x_m, self.y_m, self.depth_m = (
            image[axis].values.astype(np.float64) for axis in (X, Y, DEPTH)
        )
        known = Source(image.attrs.get("permittivity_source", Source.GIVEN.value))
        is_set = request.permittivity is not None
        self.source = SLIDER if is_set else known.value
        lowest, highest = permittivity_range(image)
        self.caption = Message(
            "{method}, permittivity {permittivity:.3g} ({lowest:.3g} to {highest:.3g}), {source}",
            method=str(image.attrs["method"]),
            permittivity=self.permittivity,
            source=Message("set with the slider") if is_set else known.message,
            lowest=lowest,
            highest=highest,
        )
