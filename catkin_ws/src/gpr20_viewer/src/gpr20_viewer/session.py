"""A survey that is being looked at: its data, its images, and what is said about them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Callable, Dict, Iterable, List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import work
from gpr20_analysis.candidates.answer import Answer, answer, default_steps, measured
from gpr20_analysis.dataset import (
    DEPTH,
    IMAGE,
    POLARIZATION,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    require,
    usable,
)
from gpr20_analysis.imaging.image_options import DEFAULT_STEPS, ImageOptions
from gpr20_analysis.imaging.image_traces import COPIES, traces_of
from gpr20_analysis.imaging.permittivity import Source, permittivity_range
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.processing.delay import delay_to_remove_s, recorded_separation_m
from gpr20_analysis.sentences import DOUBTS, LIST_ATTRIBUTES, NOTES, sentences_of
from gpr20_common.message import Message
from gpr20_survey.radar import decibels
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_viewer.positions import Line, Place, line_of

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


class ViewSession:
    """A survey in memory, its steps and its images.

    Args:
        survey: The survey after the steps that were chosen.
        options: How images are made; the permittivity and the last depth are the first shown.
        hiding: Where a mine could hide; None: not known.

    Attributes:
        survey: The survey in memory.
        options: How images are made.
        hiding: Where a mine could hide; None: not known.

    Raises:
        AnalysisError: It cannot be imaged, such as for missing samples, or does not fit.
    """

    def __init__(
        self,
        survey: xr.Dataset,
        options: ImageOptions,
        hiding: Optional[HidingMap] = None,
    ) -> None:
        spectra = require(survey, S21, S21_DIMS)
        _require_room(spectra, options)
        self.survey = survey.compute()
        if options.leave_out_missing:
            self.survey = measured(self.survey)
        self.hiding = hiding
        separation_m = options.separation_m or recorded_separation_m(survey)
        self.options = dataclasses.replace(options, separation_m=separation_m)
        traces_of(self.survey, self.options)
        self._data: Dict[bool, xr.Dataset] = {False: self.survey}
        self._usable = usable(self.survey).transpose(*SAMPLE_DIMS).values

    @property
    def simulated(self) -> bool:
        """Whether the survey was made by the simulated robot."""
        return bool(self.survey.attrs.get("simulated"))

    @property
    def rotations_deg(self) -> Tuple[float, ...]:
        """Rotation of each polarization [deg]."""
        return tuple(float(one) for one in self.survey[POLARIZATION].values)

    @property
    def notes(self) -> List[Message]:
        """What is missing, damaged or noted."""
        return [one for name in LIST_ATTRIBUTES for one in sentences_of(self.survey, name)]

    @property
    def doubts(self) -> List[Message]:
        """What of the survey may not be believed."""
        return sentences_of(self.survey, DOUBTS)

    @property
    def first_request(self) -> ImageRequest:
        """The answer of the survey, which is shown first."""
        subtracts = bool(default_steps(self.survey))
        return ImageRequest(None, background=subtracts)

    @property
    def deepest_m(self) -> float:
        """Depth of the deepest layer [m]."""
        return float(self.options.depth_m[-1])

    @property
    def axes(self) -> Tuple[str, ...]:
        """The axes with several positions: "x" and "y", or the one along a single line."""
        longer = tuple(axis for axis in (X, Y) if self.survey.sizes[axis] > 1)
        return longer or (X, Y)

    def axis_m(self, axis: str) -> np.ndarray:
        """Return the positions of the survey along "x" or "y" [m]."""
        return self.survey[axis].values.astype(np.float64)

    def middle(self) -> Place:
        """Return the place that is shown first: the middle of the area."""
        x_m, y_m = (self.axis_m(axis) for axis in (X, Y))
        depth_m = self.deepest_m / 3.0
        return Place(float(x_m[len(x_m) // 2]), float(y_m[len(y_m) // 2]), depth_m)

    def without_data(self, turn: int) -> np.ndarray:
        """Return the places (x, y) of a polarization without data [m]."""
        rows, columns = np.nonzero(~self._usable[turn])
        return np.column_stack((self.axis_m(X)[columns], self.axis_m(Y)[rows]))

    def data(self, background: bool) -> xr.Dataset:
        """Return the survey, with its background or without it."""
        if background not in self._data:
            self._data[background] = process_survey(self.survey, *DEFAULT_STEPS)
        return self._data[background]

    def compute(self, request: ImageRequest, loop: Callable[..., Iterable]) -> LiveImage:
        """Return the image of a request, and what is found in it.

        Raises:
            AnalysisError: The image cannot be made.
        """
        options = self.options
        if request.permittivity is not None:
            options = dataclasses.replace(
                options, permittivity=request.permittivity, soil=None, buried=None
            )
        data = self.data(request.background)
        return LiveImage(request, answer(data, options, loop, steps=()))

    def line(self, turn: int, along: str, at_m: float) -> Line:
        """Return the line of a polarization that is nearest to a position."""
        delay_s = delay_to_remove_s(self.survey, self.options.delay_s)
        return line_of(self.survey, turn, along, at_m, self.options.height_m, delay_s)


def _require_room(spectra: xr.DataArray, options: ImageOptions) -> None:
    # The survey, the same without background, and what an image needs of it.
    voxels = spectra.size // spectra.shape[-1] * len(options.depth_m)
    image_bytes = 4.0 * voxels * np.dtype(np.complex64).itemsize
    held = 1.0 if spectra.chunks is None else 2.0
    purpose = Message("the viewer, which keeps the whole survey in memory,")
    work.require_bytes((held + COPIES) * spectra.nbytes + image_bytes, purpose)
