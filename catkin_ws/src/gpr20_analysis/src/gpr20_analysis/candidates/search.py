"""The candidates in an image: its maxima that noise alone would hardly have."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.candidates.earth import area_position
from gpr20_analysis.candidates.peaks import Groups, Peaks, find_peaks, grouped
from gpr20_analysis.candidates.rating import Rating
from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y, require
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.sentences import NOTES, sentences_of
from gpr20_common.message import Message
from gpr20_survey.results.candidates import DOUBTFUL, OMITTED, Candidate, CandidateList, Flag


def peak_places(volume: np.ndarray, axes: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return depth, y and x of local maxima between the voxels (maximum, 3) [m].

    Each is the maximum of a parabola through the logarithms of three voxels.

    Args:
        volume: Magnitudes (depth, y, x).
        axes: Depths, positions along Y, positions along X [m].
        places: Indices of the maxima (maximum, 3).
    """
    found_m = np.stack([axis[index] for axis, index in zip(axes, places.T)], axis=1)
    for number, axis in enumerate(axes):
        inner = (places[:, number] > 0) & (places[:, number] < len(axis) - 1)
        step = np.eye(3, dtype=int)[number]
        beside = [volume[tuple((places[inner] + one).T)] for one in (-step, 0, step)]
        bright = np.all(np.stack(beside) > 0.0, axis=0)
        before, top, after = (np.log(one[bright]) for one in beside)
        which = np.flatnonzero(inner)[bright]
        index = places[which, number]
        back_m, on_m = axis[index] - axis[index - 1], axis[index + 1] - axis[index]
        rise, fall = (top - before) / back_m, (after - top) / on_m
        curved = rise != fall
        # The slope is linear between the middles of the two intervals.
        share = rise[curved] / (rise - fall)[curved]
        first_m = axis[index[curved]] - back_m[curved] / 2.0
        found_m[which[curved], number] = first_m + share * (back_m + on_m)[curved] / 2.0
    return found_m


SIDELOBE_REACH_M = 0.5


@dataclass(frozen=True)
class CandidateOptions:
    """What is listed.

    Attributes:
        false_alarm_rate: Probability that noise alone leads to any candidate in an image, 0 to 1.
        most: Most candidates to list. All that are neither `DOUBTFUL` nor unrated are listed, even
            if there are more.
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
                ),
                fault=faults.OPTION,
            )
        if not 1 <= self.most <= 100_000:
            raise WrongDatasetError(
                Message(
                    "the longest list is {most}; it must have 1 to {highest} candidates",
                    most=self.most,
                    highest=100_000,
                ),
                fault=faults.OPTION,
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
    peaks = find_peaks(rating, options.false_alarm_rate)
    groups = grouped(peaks, rating, axes)
    place_m = _places_m(groups, rating, axes)
    flags = _flags(groups, peaks, place_m, rating, axes)
    # Doubtful ones last, otherwise the brightest first.
    doubtful = np.any([flags[one] for one in DOUBTFUL], axis=0)
    order = np.argsort(doubtful, kind="stable")
    omissible = np.any([flags[one] for one in OMITTED], axis=0)
    count = max(options.most, int(np.count_nonzero(~omissible)))
    listed = tuple(
        replace(
            _candidate(groups, one, place_m[one].tolist(), rating, image, options),
            id=f"C{number:02d}",
            rotations_deg=_rotations_deg(image, peaks.place[groups.members[one], 0]),
            flags=tuple(flag for flag, is_set in flags.items() if is_set[one]),
        )
        for number, one in enumerate(order[:count].tolist(), 1)
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
        omitted=len(order) - len(listed),
        candidates=listed,
        notes=tuple([*sentences_of(image, NOTES), *_notes(rating)]),
        position=area_position(image.attrs),
        omitted_primary=int(np.count_nonzero(~doubtful[order[count:]])),
    )


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


def _places_m(groups: Groups, rating: Rating, axes: Sequence[np.ndarray]) -> np.ndarray:
    """Return depth, y and x of each group (group, 3) [m]."""
    found_m = np.empty((len(groups.top), 3))
    for turn in range(rating.polarizations):
        own = groups.top[:, 0] == turn
        found_m[own] = peak_places(rating.magnitude(turn), axes, groups.top[own, 1:])
    return found_m


def _rotations_deg(image: xr.Dataset, turns: np.ndarray) -> Tuple[float, ...]:
    rotations_deg = image[POLARIZATION].values
    return tuple(float(rotations_deg[one]) for one in dict.fromkeys(turns.tolist()))


def _candidate(
    groups: Groups,
    which: int,
    place_m: Sequence[float],
    rating: Rating,
    image: xr.Dataset,
    options: CandidateOptions,
) -> Candidate:
    """Return a candidate without its flags and rotations."""
    depth_m, y_m, x_m = place_m
    above_noise_db = float(rating.above_noise_db(groups.level[which]))
    picked_m = rating.picking_m(above_noise_db)
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
        above_noise_db=above_noise_db,
        false_alarm_probability=rating.false_alarm_probability(float(groups.level[which])),
        rotations_deg=(),
        polarization_ratio_db=rating.polarization_ratio_db(groups.first[which, 1:].tolist()),
        flags=(),
    )


def _flags(
    groups: Groups,
    peaks: Peaks,
    place_m: np.ndarray,
    rating: Rating,
    axes: Sequence[np.ndarray],
) -> Dict[Flag, np.ndarray]:
    """Return for each flag whether the groups have it."""
    # It may be brighter beyond the last depth.
    at_edge = np.isin(groups.first[:, 1], (0, len(axes[0]) - 1))
    for at_m, axis, resolution_m in list(zip(place_m.T, axes, rating.resolution_m))[1:]:
        if len(axis) > 1:
            at_edge |= np.minimum(at_m - axis[0], axis[-1] - at_m) < resolution_m / 2.0
    turns = [np.unique(peaks.place[own, 0]).size for own in groups.members]
    residue = place_m[:, 0] < rating.resolution_m[0]
    return {
        Flag.SURFACE_RESIDUE: residue,
        Flag.EDGE: at_edge,
        Flag.ONE_POLARIZATION: (np.array(turns) == 1) & (rating.polarizations > 1),
        Flag.CLUTTER: rating.is_clutter(groups.first, groups.level),
        Flag.UNRATED: np.full(len(turns), not rating.is_rated),
        Flag.SIDELOBE: _sidelobes(groups, place_m, residue, rating),
    }


def _sidelobes(
    groups: Groups, place_m: np.ndarray, residue: np.ndarray, rating: Rating
) -> np.ndarray:
    """Return whether the brightest group near each is so much brighter that it may cause it.

    Residue of the surface hides no deeper body that way: it is no body with sidelobes around it.
    """
    above_noise_db = rating.above_noise_db(groups.level)
    bodies, everything = np.flatnonzero(~residue), np.arange(len(residue))
    brightest_db = np.where(
        residue,
        _brightest_near(above_noise_db, place_m, everything),
        _brightest_near(above_noise_db, place_m, bodies),
    )
    found: np.ndarray = brightest_db - above_noise_db >= rating.sidelobe_db
    return found


def _brightest_near(level_db: np.ndarray, place_m: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Return the highest level of some groups within the reach of sidelobes around each [dB].

    Args:
        level_db: Levels, the highest first.
        place_m: Depth, y and x (group, 3).
        among: Indices of those groups, ascending.
    """
    found_db = np.copy(level_db)
    left = np.arange(len(level_db))
    for one in among:
        near = np.hypot(*(place_m[left, 1:] - place_m[one, 1:]).T) <= SIDELOBE_REACH_M
        found_db[left[near]] = np.maximum(found_db[left[near]], level_db[one])
        left = left[~near]
        if left.size == 0:
            break
    return found_db


def _permittivity_range(image: xr.Dataset) -> Tuple[float, float]:
    value = float(image.attrs["permittivity"])
    lowest = float(image.attrs.get("permittivity_lowest", value))
    return max(lowest, 1.0), float(image.attrs.get("permittivity_highest", value))
