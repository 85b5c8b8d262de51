"""The candidates in an image: the places that are stronger than the clutter of their ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.false_alarms import STRIP_M, FalseAlarms, surveyed_m2
from gpr20_analysis.dataset import DEPTH, ECHOES, IMAGE, POLARIZATION, X, Y, is_line, require
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import ECHO_VALUES
from gpr20_analysis.imaging.permittivity import depth_shares, permittivity_range
from gpr20_analysis.read.survey_attributes import area_position
from gpr20_analysis.sentences import DOUBTS, NOTES, sentences_of
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.results.candidates import DOUBTFUL, OMITTED, Candidate, CandidateList, Flag

# Echoes nearer than that across are one place, to which a person goes: about the radius of a mine.
PLACE_M = 0.06
# A body's echo is its brightest among those that are nearly as far above the clutter as its first.
NEARLY_DB = 6.0
# What a stronger body near it may have left, where it is no point: that much below it.
SIDELOBE_DB, SIDELOBE_REACH_M = 40.0, 0.5
# Without a measured density, an echo must be so far above the clutter around it.
UNRATED_DB = 10.0
# The middle of a flat body is where its echo is strongest, or off it by a part of its radius.
OF_BODY_M = 0.012
# A line shows bodies beside it, and shows them deeper.
BESIDE_LINE_M, DEEPER_BESIDE_M = 0.07, 0.015
# Of two resolutions that are alike.
ALIKE = 0.7
# Of the depth resolution: how well the first edge of an echo is known.
OF_RESOLUTION = 0.25


@dataclass(frozen=True)
class CandidateOptions:
    """What is listed.

    Attributes:
        false_alarms_per_m2: How many echoes of the ground's own clutter may be as strong as the
            weakest candidate [1/m2].
        most: Most candidates to list. All that are neither `DOUBTFUL` nor unrated are listed, even
            if there are more.
        height_uncertainty_m: Standard deviation of the antenna height [m].
    """

    false_alarms_per_m2: float = 10.0
    most: int = 50
    height_uncertainty_m: float = 0.003

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            WrongDatasetError: A value is not allowed.
        """
        # Written so that NaN is refused too.
        if not 1e-3 <= self.false_alarms_per_m2 <= 1e3:
            raise WrongDatasetError(
                Message(
                    "the density of false alarms is {density:g} per m2; it must lie between "
                    "{lowest:g} and {highest:g}",
                    density=self.false_alarms_per_m2,
                    lowest=1e-3,
                    highest=1e3,
                ),
                fault=NOT_ALLOWED,
            )
        if not 1 <= self.most <= 100_000:
            raise WrongDatasetError(
                Message(
                    "the longest list is {most}; it must have 1 to {highest} candidates",
                    most=self.most,
                    highest=100_000,
                ),
                fault=NOT_ALLOWED,
            )


DEFAULT_OPTIONS = CandidateOptions()


def find_candidates(
    image: xr.Dataset,
    options: CandidateOptions = DEFAULT_OPTIONS,
    clean_ground: Optional[xr.Dataset] = None,
) -> CandidateList:
    """Return the candidates of all polarizations as one list.

    Args:
        image: Dataset of `image_survey`.
        options: What is listed.
        clean_ground: Image of ground of this kind without bodies, made in the same way, whose
            echoes give the density of false alarms. None: those of this ground do.

    Returns:
        The list: the brightest echo whatever its flags, then the others, the strongest above
        clutter first; what may be the rest of the surface after these, and doubtful ones last.

    Raises:
        WrongDatasetError: The data are no image, or one without its echoes; or the image of clean
            ground was made in another way.
    """
    echoes = _Echoes(image)
    area_m2 = surveyed_m2(image[X].values, image[Y].values)
    if clean_ground is None:
        alarms = FalseAlarms(echoes.above_db[~echoes.fitted], area_m2)
    else:
        alarms = _alarms_of(clean_ground, image)
    least_db = alarms.level_db(options.false_alarms_per_m2) if alarms.are_known else UNRATED_DB
    places = _places(echoes, least_db)
    flags = _flags(places, echoes, image, least_db, alarms.are_known)
    order = _order(places, echoes, flags)
    doubtful = np.any([flags[one] for one in DOUBTFUL], axis=0)
    omissible = np.any([flags[one] for one in OMITTED], axis=0)
    count = max([options.most, *(np.flatnonzero(~omissible[order]) + 1)])
    listed = tuple(
        replace(
            _candidate(places[one], echoes, image, options, alarms),
            id=f"C{number:02d}",
            flags=tuple(flag for flag, is_set in flags.items() if is_set[one]),
        )
        for number, one in enumerate(order[:count], 1)
    )
    permittivity_lowest, permittivity_highest = permittivity_range(image)
    false_alarms_lowest, false_alarms_highest = alarms.range_per_m2(least_db)
    return CandidateList(
        survey_id=str(image.attrs.get("survey_id", "")),
        simulated=bool(image.attrs.get("simulated", False)),
        method=str(image.attrs["method"]),
        permittivity=float(image.attrs["permittivity"]),
        permittivity_lowest=permittivity_lowest,
        permittivity_highest=permittivity_highest,
        permittivity_source=str(image.attrs.get("permittivity_source", "")),
        area_m2=area_m2,
        false_alarms_per_m2=alarms.per_m2(least_db),
        false_alarms_lowest=false_alarms_lowest,
        false_alarms_highest=false_alarms_highest,
        omitted=len(order) - len(listed),
        candidates=listed,
        notes=(
            *(one for name in (DOUBTS, NOTES) for one in sentences_of(image, name)),
            *_notes(alarms, clean_ground),
        ),
        position=area_position(image.attrs),
        omitted_primary=int(np.count_nonzero(~doubtful[order[count:]])),
        length_m=area_m2 / STRIP_M if is_line(image) else None,
    )


def _alarms_of(clean_ground: xr.Dataset, image: xr.Dataset) -> FalseAlarms:
    """Return the false alarms by all echoes of ground without bodies."""
    weak_db = _Echoes(clean_ground).above_db
    turns = {one.sizes[POLARIZATION] for one in (image, clean_ground)}
    methods = {one.attrs["method"] for one in (image, clean_ground)}
    finer = float(image.attrs["depth_resolution_m"]) / clean_ground.attrs["depth_resolution_m"]
    if len(turns) > 1 or len(methods) > 1 or not ALIKE < finer < 1.0 / ALIKE:
        raise WrongDatasetError(
            Message(
                "the image of clean ground was made in another way; make both with the same sweep, "
                "rotations, permittivity and method"
            ),
            fault=NOT_ALLOWED,
        )
    area_m2 = surveyed_m2(clean_ground[X].values, clean_ground[Y].values)
    return FalseAlarms(weak_db, area_m2)


class _Echoes:
    """The echoes of an image, as columns."""

    def __init__(self, image: xr.Dataset) -> None:
        require(image, IMAGE, (POLARIZATION, DEPTH, Y, X))
        if ECHOES not in image:
            raise WrongDatasetError(
                Message("the image has no list of its echoes; make it again with gpr20 image")
            )
        rows = np.asarray(image[ECHOES].values, dtype=np.float64)
        rows = rows[np.argsort(-rows[:, ECHO_VALUES.index("above_clutter_db")], kind="stable")]
        # Of an image of which one polarization was selected.
        known = np.asarray(image[POLARIZATION].values, dtype=np.float64)
        of_turn = np.isclose(rows[:, :1], known, equal_nan=True)
        rows, of_turn = rows[of_turn.any(axis=1)], of_turn[of_turn.any(axis=1)]
        self.turn = np.argmax(of_turn, axis=1)
        self.place_m = rows[:, 1:4]
        self.above_db, self.level_db = rows[:, 4], rows[:, 5]
        self.fitted = rows[:, 6] > 0.0


@dataclass(frozen=True)
class _Place:
    """Echoes at one place.

    Attributes:
        members: Indices of the echoes, the one furthest above clutter first.
        body: Index of the one that gives the place.
    """

    members: np.ndarray
    body: int


def _places(echoes: _Echoes, least_db: float) -> List[_Place]:
    left = np.ones(len(echoes.above_db), dtype=bool)
    found = []
    for first in range(len(left)):
        if not left[first]:
            continue
        own = left & _is_near(echoes, first)
        enough_db = max(least_db, echoes.above_db[first] - NEARLY_DB)
        strong = own & (echoes.above_db >= min(enough_db, echoes.above_db[first]))
        body = int(np.argmax(np.where(strong, echoes.level_db, -np.inf)))
        own |= left & _is_near(echoes, body)
        left[own] = False
        found.append(_Place(np.flatnonzero(own), body))
    return found


def _is_near(echoes: _Echoes, one: int) -> np.ndarray:
    near: np.ndarray = np.hypot(*(echoes.place_m[:, 1:] - echoes.place_m[one, 1:]).T) <= PLACE_M
    return near


def _order(places: Sequence[_Place], echoes: _Echoes, flags: Dict[Flag, np.ndarray]) -> List[int]:
    doubtful = np.any([flags[one] for one in DOUBTFUL], axis=0)
    brightest = int(np.argmax(echoes.level_db)) if places else -1
    return sorted(
        range(len(places)),
        key=lambda one: (
            brightest not in places[one].members,
            doubtful[one],
            flags[Flag.SURFACE_RESIDUE][one],
            -echoes.above_db[places[one].members[0]],
        ),
    )


def _notes(alarms: FalseAlarms, clean_ground: Optional[xr.Dataset]) -> List[Message]:
    if alarms.are_known:
        if clean_ground is None:
            return []
        name = str(clean_ground.attrs.get("survey_id", "")) or "-"
        return [Message("the density of false alarms is that of clean ground: {name}", name=name)]
    return [
        Message(
            "the clutter of so small an area or so coarse an image cannot be measured, so nothing "
            "is known of false alarms; any candidate may be clutter"
        )
    ]


def _candidate(
    place: _Place,
    echoes: _Echoes,
    image: xr.Dataset,
    options: CandidateOptions,
    alarms: FalseAlarms,
) -> Candidate:
    """Return a candidate without its name and flags."""
    depth_m, y_m, x_m = (float(one) for one in echoes.place_m[place.body])
    above_db = float(echoes.above_db[place.members[0]])
    permittivity = float(image.attrs["permittivity"])
    of_permittivity_m = depth_m * depth_shares(permittivity, *permittivity_range(image))[0]
    of_height_m = options.height_uncertainty_m / math.sqrt(permittivity)
    # The surface above a body may be as much higher or lower as the heights differ.
    of_relief_m = float(image.attrs.get("relief_m", 0.0))
    of_depth_m = OF_RESOLUTION * float(image.attrs["depth_resolution_m"])
    across = str(image.attrs.get("across_lines", ""))
    beside_m = {name: BESIDE_LINE_M if name == across else 0.0 for name in (X, Y)}
    of_place_m = {
        name: float(np.linalg.norm([OF_BODY_M, _step_m(image[name].values) / 2.0, beside_m[name]]))
        for name in (X, Y)
    }
    of_line_m = DEEPER_BESIDE_M if across else 0.0
    turns = [int(one) for one in dict.fromkeys(echoes.turn[place.members].tolist())]
    rotations_deg = [float(image[POLARIZATION].values[one]) for one in turns]
    return Candidate(
        id="",
        x_m=x_m,
        y_m=y_m,
        depth_m=depth_m,
        x_uncertainty_m=of_place_m[X],
        y_uncertainty_m=of_place_m[Y],
        depth_uncertainty_m=float(np.linalg.norm([of_depth_m, of_height_m, of_relief_m, of_line_m]))
        + max(of_permittivity_m, 0.0),
        above_clutter_db=above_db,
        false_alarms_per_m2=alarms.per_m2(above_db),
        rotations_deg=tuple(None if math.isnan(one) else one for one in rotations_deg),
        polarization_ratio_db=_polarization_ratio_db(place, echoes, image),
        flags=(),
    )


def _polarization_ratio_db(place: _Place, echoes: _Echoes, image: xr.Dataset) -> Optional[float]:
    """Return the level of the first polarization above the second [dB]."""
    if image.sizes[POLARIZATION] != 2:
        return None
    levels_db = [
        echoes.level_db[place.members[echoes.turn[place.members] == one]] for one in (0, 1)
    ]
    if min(len(one) for one in levels_db) == 0:
        return None
    return float(levels_db[0].max() - levels_db[1].max())


def _flags(
    places: Sequence[_Place],
    echoes: _Echoes,
    image: xr.Dataset,
    least_db: float,
    are_rated: bool,
) -> Dict[Flag, np.ndarray]:
    """Return for each flag whether the places have it."""
    body = np.array([one.body for one in places], dtype=int)
    above_db = np.array([echoes.above_db[one.members[0]] for one in places])
    place_m, level_db = echoes.place_m[body], echoes.level_db[body]
    depth_m = place_m[:, 0]
    at_edge = np.isin(depth_m, image[DEPTH].values[[0, -1]])
    for at_m, name in zip(place_m.T[1:], (Y, X)):
        axis_m = image[name].values
        if len(axis_m) > 1:
            nearest_m = np.minimum(at_m - axis_m.min(), axis_m.max() - at_m)
            at_edge |= nearest_m < _step_m(axis_m)
    seen = [
        len(set(echoes.turn[one.members[echoes.above_db[one.members] >= least_db]].tolist()))
        for one in places
    ]
    return {
        Flag.SURFACE_RESIDUE: depth_m < float(image.attrs["depth_resolution_m"]),
        Flag.EDGE: at_edge,
        Flag.ONE_POLARIZATION: (np.array(seen) == 1) & (image.sizes[POLARIZATION] > 1),
        Flag.CLUTTER: above_db < least_db,
        Flag.UNRATED: np.full(len(places), not are_rated),
        Flag.SIDELOBE: _beside_stronger(place_m, level_db),
    }


def _beside_stronger(place_m: np.ndarray, level_db: np.ndarray) -> np.ndarray:
    """Return whether each place is so near to a so much stronger one that it may be its rest."""
    found = np.zeros(len(level_db), dtype=bool)
    for one, (own_m, own_db) in enumerate(zip(place_m, level_db)):
        near = np.hypot(*(place_m[:, 1:] - own_m[1:]).T) <= SIDELOBE_REACH_M
        found[one] = bool(np.any(level_db[near] >= own_db + SIDELOBE_DB))
    return found


def _step_m(axis_m: np.ndarray) -> float:
    return float(np.ptp(axis_m)) / (len(axis_m) - 1) if len(axis_m) > 1 else 0.0
