"""The candidates in an image: the places that are stronger than the clutter of their ground.

Echoes near each other are one place. Places are ranked by how far they are above the clutter around
them, and the list is cut where ground without bodies has as many as the stated rate of false
alarms: what is weaker cannot be told from clutter at that rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DEPTH, ECHOES, IMAGE, POLARIZATION, X, Y, is_line, require
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import ECHO_VALUES
from gpr20_analysis.imaging.permittivity import depth_shares, permittivity_range
from gpr20_analysis.read.survey_attributes import area_position
from gpr20_analysis.sentences import DOUBTS, NOTES, sentences_of
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import USUAL_FALSE_ALARMS_PER_M2
from gpr20_survey.results.candidates import DOUBTFUL, Candidate, CandidateList, Flag

# How many places per m2 of ground without its bodies are so far above the clutter around them,
# measured on every second scene of benchmarks/detection.py; between them the logarithm is linear.
CLUTTER_DB = (8.0, 12.0, 15.0, 20.0, 25.0, 30.0)
CLUTTER_PER_M2 = (20.0, 10.0, 6.0, 3.0, 1.5, 0.3)
# That holds for so many maxima per m2 of an image; where it has ten times as many, the highest are
# so much higher. Images with fewer or more than these were not scored.
USUAL_MAXIMA_PER_M2, OF_TEN_TIMES_DB = 1000.0, 6.5
SCORED_MAXIMA_PER_M2 = (100.0, 2500.0)
# Echoes nearer than that across are one place, to which a person goes: about the radius of a mine.
PLACE_M = 0.06
# A body's echo is its brightest among those that are nearly as far above the clutter as its first.
NEARLY_DB = 6.0
# An echo of the surface itself must be so much stronger to be a place in the ground.
SURFACE_M, OF_SURFACE_DB = 0.006, 9.0
# What a stronger body near it may have left, where it is no point: that much below it.
SIDELOBE_DB, SIDELOBE_REACH_M = 35.0, 0.5
# The brightest echo of an image of nothing but noise is not that far above the usual one.
NOISE_DB = 12.0
# Weaker echoes that are kept, and fewest echoes of which the clutter is known.
MOST_WEAKER, FEWEST_ECHOES = 50, 40
# Smallest area whose maxima are counted [m2].
LEAST_M2 = 0.01
# A single line sees that much of the ground beside it, and so does a narrow area.
STRIP_M = 0.3
# The middle of a flat body is where its echo is strongest, or off it by a part of its radius.
OF_BODY_M = 0.012
# A line shows bodies beside it, and shows them deeper.
BESIDE_LINE_M, DEEPER_BESIDE_M = 0.07, 0.015
# Of the depth resolution: how well the first edge of an echo is known.
OF_RESOLUTION = 0.25
# Standard deviation of the antenna height.
HEIGHT_UNCERTAINTY_M = 0.003


def least_level_db(false_alarms_per_m2: float, maxima_per_m2: float = USUAL_MAXIMA_PER_M2) -> float:
    """Return how far above the clutter so many places per m2 of ground without bodies are [dB].

    Args:
        false_alarms_per_m2: Rate of false alarms [1/m2].
        maxima_per_m2: Maxima of the image: a wide band and a fine grid have many, and the highest
            of many stand out more.
    """
    rates = np.log(CLUTTER_PER_M2[::-1])
    level_db = np.interp(math.log(false_alarms_per_m2), rates, CLUTTER_DB[::-1])
    fewest, most = SCORED_MAXIMA_PER_M2
    share = min(max(maxima_per_m2, fewest), most) / USUAL_MAXIMA_PER_M2
    return float(level_db + OF_TEN_TIMES_DB * math.log10(share))


def surveyed_m2(x_m: np.ndarray, y_m: np.ndarray) -> float:
    """Return the area of the ground that a survey sees, at least a strip as of a line [m2]."""
    shorter_m, longer_m = sorted(float(np.ptp(axis_m)) for axis_m in (x_m, y_m))
    return longer_m * max(shorter_m, STRIP_M)


def find_candidates(
    image: xr.Dataset, false_alarms_per_m2: float = USUAL_FALSE_ALARMS_PER_M2
) -> CandidateList:
    """Return the candidates of all polarizations as one list.

    Args:
        image: Dataset of `image_survey`.
        false_alarms_per_m2: Where the list is cut: so many places to check there are in a square
            metre of ground without bodies [1/m2].

    Returns:
        The list: the places to check, the strongest above clutter first, then the weaker echoes.
        The brightest echo is among the places, unless the image shows nothing but noise.

    Raises:
        WrongDatasetError: The data are no image, or one without its echoes.
    """
    echoes = _Echoes(image)
    area_m2 = surveyed_m2(image[X].values, image[Y].values)
    maxima_per_m2 = len(echoes.above_db) / max(area_m2, LEAST_M2)
    least_db = least_level_db(false_alarms_per_m2, maxima_per_m2)
    places = _places(echoes)
    flags = _flags(places, echoes, image, least_db)
    doubtful = np.any([flags[one] for one in DOUBTFUL], axis=0)
    score_db = np.array([one.score_db for one in places])
    order = np.lexsort((-score_db, flags[Flag.BRIGHTEST], doubtful))
    kept = order[: np.count_nonzero(~doubtful) + MOST_WEAKER]
    listed = tuple(
        replace(
            _candidate(places[one], echoes, image),
            id=f"C{number:02d}",
            flags=tuple(flag for flag, is_set in flags.items() if is_set[one]),
        )
        for number, one in enumerate(kept, 1)
    )
    permittivity_lowest, permittivity_highest = permittivity_range(image)
    return CandidateList(
        survey_id=str(image.attrs.get("survey_id", "")),
        simulated=bool(image.attrs.get("simulated", False)),
        method=str(image.attrs["method"]),
        permittivity=float(image.attrs["permittivity"]),
        permittivity_lowest=permittivity_lowest,
        permittivity_highest=permittivity_highest,
        permittivity_source=str(image.attrs.get("permittivity_source", "")),
        area_m2=area_m2,
        false_alarms_per_m2=false_alarms_per_m2,
        least_db=least_db,
        omitted=len(order) - len(listed),
        candidates=listed,
        notes=(
            *(one for name in (DOUBTS, NOTES) for one in sentences_of(image, name)),
            *_notes(echoes),
        ),
        position=area_position(image.attrs),
        length_m=area_m2 / STRIP_M if is_line(image) else None,
    )


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

    def near(self, one: int) -> np.ndarray:
        """Return which echoes are at the place of one."""
        away_m = np.hypot(*(self.place_m[:, 1:] - self.place_m[one, 1:]).T)
        found: np.ndarray = away_m <= PLACE_M
        return found


@dataclass(frozen=True)
class _Place:
    """Echoes at one place.

    Attributes:
        members: Indices of the echoes, the one furthest above clutter first.
        body: Index of the one that gives the place.
        score_db: What the place is ranked by: how far it is above the clutter [dB], less for an
            echo of the surface that is not the brightest of all.
    """

    members: np.ndarray
    body: int
    score_db: float


def _places(echoes: _Echoes) -> List[_Place]:
    left = np.ones(len(echoes.above_db), dtype=bool)
    brightest = int(np.argmax(echoes.level_db)) if len(left) else 0
    found = []
    for first in range(len(left)):
        if not left[first]:
            continue
        own = left & echoes.near(first)
        strong = own & (echoes.above_db >= echoes.above_db[first] - NEARLY_DB)
        body = int(np.argmax(np.where(strong, echoes.level_db, -np.inf)))
        own |= left & echoes.near(body)
        left[own] = False
        is_surface = echoes.place_m[body, 0] < SURFACE_M and not own[brightest]
        score_db = float(echoes.above_db[first]) - (OF_SURFACE_DB if is_surface else 0.0)
        found.append(_Place(np.flatnonzero(own), body, score_db))
    return found


def _flags(
    places: Sequence[_Place], echoes: _Echoes, image: xr.Dataset, least_db: float
) -> Dict[Flag, np.ndarray]:
    """Return for each flag whether the places have it."""
    body = np.array([one.body for one in places], dtype=int)
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
    is_weak = np.array([one.score_db for one in places]) < least_db
    is_sidelobe = _beside_stronger(place_m, level_db)
    brightest = _brightest(places, echoes)
    return {
        Flag.SURFACE_RESIDUE: depth_m < float(image.attrs["depth_resolution_m"]),
        Flag.EDGE: at_edge,
        Flag.ONE_POLARIZATION: (np.array(seen) == 1) & (image.sizes[POLARIZATION] > 1),
        Flag.CLUTTER: is_weak & ~brightest,
        Flag.SIDELOBE: is_sidelobe & ~brightest,
        Flag.BRIGHTEST: is_weak & brightest,
    }


def _brightest(places: Sequence[_Place], echoes: _Echoes) -> np.ndarray:
    """Return which place has the brightest echo; none if it is no brighter than noise."""
    found = np.zeros(len(places), dtype=bool)
    weak_db = echoes.level_db[~echoes.fitted]
    if places and len(weak_db):
        one = int(np.argmax(echoes.level_db))
        if echoes.level_db[one] >= np.median(weak_db) + NOISE_DB:
            found[:] = [one in place.members for place in places]
    return found


def _beside_stronger(place_m: np.ndarray, level_db: np.ndarray) -> np.ndarray:
    """Return whether each place is so near to a so much stronger one that it may be its rest."""
    found = np.zeros(len(level_db), dtype=bool)
    for one, (own_m, own_db) in enumerate(zip(place_m, level_db)):
        near = np.hypot(*(place_m[:, 1:] - own_m[1:]).T) <= SIDELOBE_REACH_M
        found[one] = bool(np.any(level_db[near] >= own_db + SIDELOBE_DB))
    return found


def _notes(echoes: _Echoes) -> List[Message]:
    if np.count_nonzero(~echoes.fitted) >= FEWEST_ECHOES:
        return []
    return [
        Message(
            "the clutter of so small an area or so coarse an image is known from a few echoes "
            "only; any candidate may be clutter"
        )
    ]


def _candidate(place: _Place, echoes: _Echoes, image: xr.Dataset) -> Candidate:
    """Return a candidate without its name and flags."""
    depth_m, y_m, x_m = (float(one) for one in echoes.place_m[place.body])
    permittivity = float(image.attrs["permittivity"])
    of_permittivity_m = depth_m * depth_shares(permittivity, *permittivity_range(image))[0]
    of_height_m = HEIGHT_UNCERTAINTY_M / math.sqrt(permittivity)
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
        above_clutter_db=float(echoes.above_db[place.members[0]]),
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


def _step_m(axis_m: np.ndarray) -> float:
    return float(np.ptp(axis_m)) / (len(axis_m) - 1) if len(axis_m) > 1 else 0.0
