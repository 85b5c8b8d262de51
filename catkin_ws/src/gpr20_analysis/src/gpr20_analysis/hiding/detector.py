"""The detector of a survey, and what it would list if a target were there besides.

An image is linear in the spectra. So the image of a target is added to that of the survey without
its strong echoes, and the target's echo there joins the echoes of the survey: from them the list is
made as ever, with its limits, flags and merging. The clutter around it is that of the survey and of
what a target leaves after its own strong echoes. That takes a thirtieth of a whole search, and each
target is judged alone, although many are in the spectra at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.search import DEFAULT_OPTIONS, CandidateOptions, find_candidates
from gpr20_analysis.dataset import DEPTH, ECHOES, IMAGE, POLARIZATION, S21, X, Y
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.echoes import between_voxels_m, local_clutter
from gpr20_analysis.imaging.image import ECHO_VALUES, REST, image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.frequency_to_delay import decibels
from gpr20_survey.results.candidates import Candidate, CandidateList
from gpr20_survey.results.hidden_target import Target

# A candidate is the target if it is so near to it: across its rim, above its top, below its bottom.
NEAR_M, ABOVE_M, BELOW_M = 0.03, 0.03, 0.06
# Than a candidate that is there without the target.
STRONGER_DB = 1.0
# The clutter around a target is within that of it, across.
AROUND_M = 0.36


@dataclass(frozen=True)
class Detector:
    """How a survey is searched.

    Attributes:
        process: Applies the steps to a survey as measured.
        options: How the image is made.
        listed: What is listed.
        clean_ground: Image of ground without bodies; None: the survey's own ground.
    """

    process: Callable[[xr.Dataset], xr.Dataset]
    options: ImageOptions
    listed: CandidateOptions = DEFAULT_OPTIONS
    clean_ground: Optional[xr.Dataset] = None

    def search(self, survey: xr.Dataset) -> CandidateList:
        """Return the candidates of a survey as measured."""
        return self.candidates(image_survey(self.process(survey), self.options))

    def candidates(self, image: xr.Dataset) -> CandidateList:
        """Return the candidates in an image."""
        return find_candidates(image, self.listed, self.clean_ground)


class Searched:
    """A survey that was searched, in which targets can be looked for.

    Attributes:
        found: The candidates of the survey.

    Raises:
        WrongDatasetError: The image is not linear in the spectra.
    """

    def __init__(self, survey: xr.Dataset, detector: Detector) -> None:
        if not detector.options.method.is_linear:
            raise WrongDatasetError(
                Message(
                    "images by the method {method} are no sums, so targets cannot be added to "
                    "them; use another --method",
                    method=detector.options.method.name,
                ),
                fault=NOT_ALLOWED,
            )
        self._detector, self._processed = detector, detector.process(survey)
        image = image_survey(self._processed, detector.options, with_rest=True)
        self.found = detector.candidates(image)
        self._rest = image[REST].values
        # What a list is made of.
        self._image = image.drop_vars(REST)
        known = float(image.attrs["permittivity"])
        self._options = replace(
            detector.options, permittivity=known, soil=None, buried=None, leave_out_missing=True
        )
        self._axes_m = [image[name].values for name in (DEPTH, Y, X)]

    @property
    def middle_m(self) -> Tuple[float, float]:
        """X and Y of the position in the middle [m]."""
        return float(self._axes_m[2][self._middle[1]]), float(self._axes_m[1][self._middle[0]])

    @property
    def _middle(self) -> Tuple[int, int]:
        return len(self._axes_m[1]) // 2, len(self._axes_m[2]) // 2

    def _added(self, injected: xr.Dataset) -> xr.Dataset:
        processed = self._detector.process(injected)
        return processed.assign({S21: processed[S21] - self._processed[S21]})

    def left_by(self, injected: xr.Dataset) -> np.ndarray:
        """Return what a target in the middle leaves after its own strong echoes.

        Args:
            injected: The survey as measured, with a target at `middle_m`.

        Returns:
            An image (polarization, depth, y, x).
        """
        added = self._added(injected)
        if not np.any(np.nan_to_num(added[S21].values)):
            return np.zeros_like(self._rest)
        left: np.ndarray = image_survey(added, self._options, with_rest=True)[REST].values
        return left

    def with_echo(self, injected: xr.Dataset) -> np.ndarray:
        """Return the image (polarization, depth, y, x) with targets, without the strong echoes.

        Args:
            injected: The survey as measured, with targets in it.
        """
        added = self._added(injected)
        if not np.any(np.nan_to_num(added[S21].values)):
            return self._rest  # the target is like the soil
        image: np.ndarray = image_survey(added, self._options, with_echoes=False)[IMAGE].values
        return self._rest + image

    def finds(
        self,
        image: np.ndarray,
        left: np.ndarray,
        place_m: Tuple[float, float],
        top_m: float,
        target: Target,
    ) -> bool:
        """Return whether a target in an image would be found.

        Args:
            image: Returned by `with_echo`.
            left: Returned by `left_by`.
            place_m: X and Y of the target [m].
            top_m: Depth of its top [m].
            target: What it is.
        """
        rows = self._rows(image, left, place_m, top_m, target)
        dims = self._image[ECHOES].dims
        echoes = np.concatenate([self._image[ECHOES].values, *rows])
        found = self._detector.candidates(
            self._image.assign({ECHOES: (dims, echoes, self._image[ECHOES].attrs)})
        )
        return is_found(found, self.found, place_m, top_m, target)

    def _rows(
        self,
        image: np.ndarray,
        left: np.ndarray,
        place_m: Tuple[float, float],
        top_m: float,
        target: Target,
    ) -> List[np.ndarray]:
        """Return the target's echo in each polarization, if it is a maximum."""
        reach_m = NEAR_M + target.diameter_m / 2.0
        middle_m = (top_m + 0.5 * (target.height_m + BELOW_M - ABOVE_M), *place_m[::-1])
        halves_m = (0.5 * (target.height_m + BELOW_M + ABOVE_M), reach_m, reach_m)
        part = [
            np.flatnonzero(np.abs(axis_m - middle) <= half)
            for axis_m, middle, half in zip(self._axes_m, middle_m, halves_m)
        ]
        rows: List[np.ndarray] = []
        for turn, volume in enumerate(image):
            near = np.abs(volume[np.ix_(*part)])
            if not near.size:
                continue
            at = np.unravel_index(int(np.argmax(near)), near.shape)
            index = np.array([own[one] for own, one in zip(part, at)])
            # Within a few voxels, so that only they are read.
            around = tuple(slice(max(one - 1, 0), one + 2) for one in index)
            if np.abs(volume[around]).max() > near[at]:
                continue
            own_m = between_voxels_m(np.abs(volume), self._axes_m, index[None])[0]
            clutter = self._clutter(turn, left[turn], index, own_m)
            levels_db = decibels(np.array([near[at] / clutter, near[at]]), 0.0)
            rotation_deg = float(self._image[POLARIZATION].values[turn])
            rows.append(np.array([[rotation_deg, *own_m, *levels_db, 1.0]]))
        assert all(row.shape[1] == len(ECHO_VALUES) for row in rows)
        return rows

    def _clutter(
        self, turn: int, left: np.ndarray, index: np.ndarray, place_m: np.ndarray
    ) -> float:
        """Return the clutter around a voxel, with what a target there leaves."""
        parts, moved = [], []
        for axis_m, at, middle in zip(self._axes_m[1:], index[1:], self._middle):
            within = np.flatnonzero(np.abs(axis_m - axis_m[at]) <= AROUND_M)
            parts.append(within)
            moved.append(within - at + middle)
        around = self._rest[turn][:, parts[0]][:, :, parts[1]].copy()
        inside = [(one >= 0) & (one < size) for one, size in zip(moved, left.shape[1:])]
        from_left = left[:, moved[0][inside[0]]][:, :, moved[1][inside[1]]]
        around[np.ix_(np.arange(len(around)), *(np.flatnonzero(one) for one in inside))] += (
            from_left
        )
        echoes = self._image[ECHOES].values
        rotation_deg = self._image[POLARIZATION].values[turn]
        own = np.isclose(echoes[:, 0], rotation_deg, equal_nan=True) & (echoes[:, 6] > 0.0)
        bodies_m = np.concatenate([echoes[own, 1:4], place_m[None]])
        axes_m = [self._axes_m[0], *(one[part] for one, part in zip(self._axes_m[1:], parts))]
        resolution_m = float(self._image.attrs["depth_resolution_m"])
        clutter = local_clutter(np.abs(around), axes_m, resolution_m, bodies_m)
        here = [int(np.searchsorted(part, one)) for part, one in zip(parts, index[1:])]
        return float(clutter[index[0], here[0], here[1]])


def is_found(
    found: CandidateList,
    without: CandidateList,
    place_m: Tuple[float, float],
    top_m: float,
    target: Target,
) -> bool:
    """Return whether a candidate that is not doubtful is a target.

    Where the survey has a candidate without the target, too, it must be stronger with it: what
    changes nothing was not found.

    Args:
        found: The candidates with the target.
        without: Those of the survey without it.
        place_m: X and Y of the target [m].
        top_m: Depth of its top [m].
        target: What it is.
    """
    with_db, without_db = (
        max([-np.inf, *(one.above_clutter_db for one in listed.candidates
                        if _is_at(one, place_m, top_m, target))])
        for listed in (found, without)
    )  # fmt: skip
    return bool(with_db > without_db + STRONGER_DB)


def _is_at(one: Candidate, place_m: Tuple[float, float], top_m: float, target: Target) -> bool:
    away_m = np.hypot(one.x_m - place_m[0], one.y_m - place_m[1])
    return bool(
        not one.is_doubtful
        and away_m < NEAR_M + target.diameter_m / 2.0
        and -ABOVE_M < one.depth_m - top_m < target.height_m + BELOW_M
    )
