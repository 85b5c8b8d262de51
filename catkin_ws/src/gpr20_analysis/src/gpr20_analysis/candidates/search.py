"""The candidates in an image: its maxima that noise alone would hardly have."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis.candidates.candidate import AreaPosition, Candidate, CandidateList, Flag
from gpr20_analysis.candidates.rating import Rating
from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y, require
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.echoes import peak_place
from gpr20_analysis.read.annotation_attributes import HEADING, LATITUDE, LONGITUDE
from gpr20_analysis.sentences import NOTES, sentences_of
from gpr20_common.message import Message

SIDELOBE_REACH_M = 0.5


@dataclass(frozen=True)
class CandidateOptions:
    """What is listed.

    Attributes:
        false_alarm_rate: Probability that noise alone leads to any candidate in an image, 0 to 1.
        most: Most candidates to list.
        height_uncertainty_m: Standard deviation of the antenna height [m].
    """

    false_alarm_rate: float = 0.01
    most: int = 50
    height_uncertainty_m: float = 0.003

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            WrongDatasetError: A value is not allowed.
        """
        # Written so that NaN is refused too.
        if not 1e-12 <= self.false_alarm_rate <= 0.5:
            raise WrongDatasetError(
                Message(
                    "the false-alarm rate is {rate:g}; it must lie between {lowest:g} and "
                    "{highest:g}",
                    rate=self.false_alarm_rate,
                    lowest=1e-12,
                    highest=0.5,
                )
            )
        if not 1 <= self.most <= 100_000:
            raise WrongDatasetError(
                Message(
                    "the longest list is {most}; it must have 1 to {highest} candidates",
                    most=self.most,
                    highest=100_000,
                )
            )


DEFAULT_OPTIONS = CandidateOptions()


def find_candidates(
    image: xr.Dataset, options: CandidateOptions = DEFAULT_OPTIONS
) -> CandidateList:
    """Return the candidates of all polarizations as one list.

    Args:
        image: Dataset of `image_survey`.
        options: What is listed.

    Returns:
        The list, the brightest first.

    Raises:
        WrongDatasetError: The data are no image.
    """
    volume = np.abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)).values)
    rating = Rating(image, volume)
    axes = tuple(np.asarray(image[name].values, dtype=np.float64) for name in (DEPTH, Y, X))
    peaks = _peaks(rating, options)
    groups = _grouped(peaks, rating, axes)
    found = [_candidate(group, rating, axes, image, options) for group in groups]
    found = [replace(one, flags=_with_sidelobe(one, found, rating)) for one in found]
    found.sort(key=lambda one: one.is_secondary)
    listed = tuple(
        replace(one, id=f"C{number:02d}") for number, one in enumerate(found[: options.most], 1)
    )
    permittivity = float(image.attrs["permittivity"])
    lowest, highest = _permittivity_range(image)
    return CandidateList(
        survey_id=str(image.attrs.get("survey_id", "")),
        simulated=bool(image.attrs.get("simulated", False)),
        method=str(image.attrs["method"]),
        permittivity=permittivity,
        permittivity_range=(lowest, highest),
        area_m2=float(np.ptp(axes[1]) * np.ptp(axes[2])),
        false_alarm_rate=options.false_alarm_rate,
        omitted=len(found) - len(listed),
        candidates=listed,
        notes=tuple([*sentences_of(image, NOTES), *_notes(rating)]),
        position=_position(image),
        omitted_primary=sum(not one.is_secondary for one in found[options.most :]),
    )


def _position(image: xr.Dataset) -> Optional[AreaPosition]:
    names = (LATITUDE, LONGITUDE, HEADING)
    if not all(name in image.attrs for name in names):
        return None
    return AreaPosition(*(float(image.attrs[name]) for name in names))


def _notes(rating: Rating) -> List[Message]:
    if rating.is_rated:
        return []
    return [
        Message(
            "the noise could not be measured, because the sweep has too few frequencies for the "
            "depths of the image; any candidate may be noise: use a smaller depth, or measure "
            "with more points"
        )
    ]


@dataclass(frozen=True)
class _Peaks:
    """Local maxima, the brightest first.

    Attributes:
        place: Indices (peak, 4): polarization, depth, y, x.
        level: Magnitudes above noise.
    """

    place: np.ndarray
    level: np.ndarray


def _peaks(rating: Rating, options: CandidateOptions) -> _Peaks:
    places = []
    for turn in range(rating.polarizations):
        level, magnitude = rating.level(turn), rating.magnitude(turn)
        highest = maximum_filter(magnitude, size=3, mode="nearest")
        threshold = rating.threshold(options.false_alarm_rate)
        chosen = np.argwhere((magnitude == highest) & (magnitude > 0.0) & (level >= threshold))
        places.append(np.insert(chosen, 0, turn, axis=1))
    place = np.concatenate(places)
    levels = np.array([rating.level(turn)[depth, y, x] for turn, depth, y, x in place])
    order = np.argsort(-levels, kind="stable")
    return _Peaks(place[order], levels[order])


def _grouped(peaks: _Peaks, rating: Rating, axes: Sequence[np.ndarray]) -> List[np.ndarray]:
    """Return the peaks of each place (peak, 4), the brightest of each first."""
    if len(peaks.place) == 0:
        return []
    where_m = np.stack(
        [axis[peaks.place[:, number]] for number, axis in enumerate(axes, 1)], axis=1
    )
    scaled = where_m / rating.resolution_m
    left = np.ones(len(scaled), dtype=bool)
    groups = []
    for first in range(len(scaled)):
        if not left[first]:
            continue
        own = left & (np.sum((scaled - scaled[first]) ** 2, axis=1) <= 1.0)
        left &= ~own
        groups.append(peaks.place[own])
    return groups


def _candidate(
    group: np.ndarray,
    rating: Rating,
    axes: Sequence[np.ndarray],
    image: xr.Dataset,
    options: CandidateOptions,
) -> Candidate:
    turn, *place = (int(one) for one in group[0])
    # The noise varies over the image, so the voxel that is furthest above it is not the peak.
    top_turn, *top = max(group.tolist(), key=lambda one: rating.magnitude(one[0])[tuple(one[1:])])
    depth_m, y_m, x_m = peak_place(rating.magnitude(top_turn), axes, tuple(top))
    picked_m = rating.picking_m(rating.above_noise_db(turn, place))
    lowest, highest = _permittivity_range(image)
    permittivity = float(image.attrs["permittivity"])
    of_permittivity_m = depth_m * max(
        math.sqrt(permittivity / lowest) - 1.0, 1.0 - math.sqrt(permittivity / highest)
    )
    of_height_m = options.height_uncertainty_m / math.sqrt(permittivity)
    return Candidate(
        id="",
        x_m=x_m,
        y_m=y_m,
        depth_m=depth_m,
        x_uncertainty_m=float(picked_m[2]),
        y_uncertainty_m=float(picked_m[1]),
        depth_uncertainty_m=math.hypot(picked_m[0], of_height_m) + max(of_permittivity_m, 0.0),
        above_noise_db=rating.above_noise_db(turn, place),
        false_alarm_probability=rating.false_alarm_probability(turn, place),
        rotations_deg=tuple(
            float(image[POLARIZATION][one]) for one in dict.fromkeys(group[:, 0].tolist())
        ),
        polarization_ratio_db=rating.polarization_ratio_db(place),
        flags=_flags(group, (depth_m, y_m, x_m), rating, axes),
    )


def _flags(
    group: np.ndarray, place_m: Sequence[float], rating: Rating, axes: Sequence[np.ndarray]
) -> Tuple[Flag, ...]:
    turn, *place = (int(one) for one in group[0])
    resolution_m = rating.resolution_m
    at_edge = [
        len(axis) > 1 and min(at - axis[0], axis[-1] - at) < resolution_m[number] / 2.0
        for number, (at, axis) in enumerate(zip(place_m, axes))
        if number > 0
    ]
    flags = {
        Flag.SURFACE_RESIDUE: place_m[0] < resolution_m[0],
        # It may be brighter beyond the last depth.
        Flag.EDGE: any(at_edge) or place[0] in (0, len(axes[0]) - 1),
        Flag.ONE_POLARIZATION: rating.polarizations > 1 and len(set(group[:, 0])) == 1,
        Flag.CLUTTER: rating.is_clutter(turn, place),
        Flag.UNRATED: not rating.is_rated,
    }
    return tuple(flag for flag, is_set in flags.items() if is_set)


def _with_sidelobe(one: Candidate, others: Sequence[Candidate], rating: Rating) -> Tuple[Flag, ...]:
    for other in others:
        apart_m = math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)
        if apart_m <= SIDELOBE_REACH_M and (
            other.above_noise_db - one.above_noise_db >= rating.sidelobe_db
        ):
            return (*one.flags, Flag.SIDELOBE)
    return one.flags


def _permittivity_range(image: xr.Dataset) -> Tuple[float, float]:
    value = float(image.attrs["permittivity"])
    lowest = float(image.attrs.get("permittivity_lowest", value))
    return max(lowest, 1.0), float(image.attrs.get("permittivity_highest", value))
