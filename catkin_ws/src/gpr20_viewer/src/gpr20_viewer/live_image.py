"""The image that the viewer shows, made again for each setting that changes it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.imaging.permittivity import Source, permittivity_range
from gpr20_analysis.sentences import NOTES, sentences_of
from gpr20_common.message import Message
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import decibels
from gpr20_survey.results.candidates import CandidateList

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
        deepest_m: Depth of the deepest layer [m].
        candidates: Whether candidates are searched.
    """

    permittivity: Optional[float]
    background: bool
    deepest_m: float
    candidates: bool = False

    def same_image(self, other: ImageRequest) -> bool:
        """Return whether another request leads to the same image."""
        return replace(self, candidates=False) == replace(other, candidates=False)


class LiveImage:
    """An image, and how it was made.

    Args:
        request: What it was made for.
        image: As `image_survey` returns it.
        remarks: What else to show with it.
        candidates: What was found in it; None: not searched.

    Attributes:
        magnitude: Magnitude (polarization, depth, y, x).
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        depth_m: Depths [m].
        source: Where its permittivity is from: `SLIDER`, or the value of a `Source`.
        caption: Method and permittivity, and where that is from.
    """

    def __init__(
        self,
        request: ImageRequest,
        image: xr.Dataset,
        remarks: Tuple[Message, ...] = (),
        candidates: Optional[CandidateList] = None,
    ) -> None:
        self.request = request
        self.candidates = candidates
        self.remarks = (*sentences_of(image, NOTES), *remarks)
        self.permittivity = float(image.attrs["permittivity"])
        self.method = str(image.attrs["method"])
        volume = image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X)
        self.magnitude = np.abs(volume.values).astype(np.float32)
        self.x_m, self.y_m, self.depth_m = (
            image[axis].values.astype(np.float64) for axis in (X, Y, DEPTH)
        )
        # Those that were asked for last: a cursor that moves needs the same again.
        self._levels: Optional[Tuple[Tuple[int, float], np.ndarray]] = None
        self._largest = self.magnitude.max(axis=(2, 3))
        known = Source(image.attrs.get("permittivity_source", Source.GIVEN.value))
        is_set = request.permittivity is not None
        self.source = SLIDER if is_set else known.value
        lowest, highest = permittivity_range(image)
        self.caption = Message(
            "{method}, permittivity {permittivity:.3g} ({lowest:.3g} to {highest:.3g}), {source}",
            method=self.method,
            permittivity=self.permittivity,
            source=Message("set with the slider") if is_set else known.message,
            lowest=lowest,
            highest=highest,
        )

    def gain_db(self, db_per_ns: float) -> np.ndarray:
        """Return the display gain of each depth [dB]."""
        return db_per_ns * NS_PER_S * two_way_delay_s(self.depth_m * np.sqrt(self.permittivity))

    def reference_db(self, db_per_ns: float) -> float:
        """Return the brightest level of all polarizations with a display gain [dB]."""
        return float(np.max(_decibels(self._largest) + self.gain_db(db_per_ns)))

    def levels_db(self, turn: int, db_per_ns: float) -> np.ndarray:
        """Return the levels of a polarization (depth, y, x) relative to the brightest [dB]."""
        if self._levels is None or self._levels[0] != (turn, db_per_ns):
            gain_db = self.gain_db(db_per_ns)[:, None, None] - self.reference_db(db_per_ns)
            levels_db = _decibels(self.magnitude[turn]) + gain_db.astype(np.float32)
            self._levels = ((turn, db_per_ns), levels_db)
        return self._levels[1]

    def level_at_db(self, turn: int, x_m: float, y_m: float, depth_m: float) -> float:
        """Return the level of the nearest voxel relative to the brightest one, without gain."""
        layer, row, column = (
            int(np.argmin(np.abs(axis - at)))
            for axis, at in ((self.depth_m, depth_m), (self.y_m, y_m), (self.x_m, x_m))
        )
        level = _decibels(self.magnitude[turn, layer, row, column])
        return float(level) - self.reference_db(0.0)


def _decibels(magnitude: np.ndarray) -> np.ndarray:
    return decibels(magnitude, float(np.finfo(np.float32).tiny))
