"""The candidates in an image: the places that are stronger than the clutter of their ground.

Echoes near each other are one place. The list is cut where ground without bodies has as many places
as the stated rate of false alarms: what is weaker is no stronger than clutter at that rate. Places
are ranked by how far their echoes together are above the clutter around them, because a mine is
wider than a fragment, and its echo is several.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterator, Tuple

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
from gpr20_survey.results.candidates import Candidate, CandidateList, Flag

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
    width_m, height_m = (float(np.ptp(image[axis].values)) for axis in (X, Y))
    strip_m2 = surveyed_m2(image[X].values, image[Y].values)
    maxima_per_m2 = len(echoes.above_db) / max(strip_m2, LEAST_M2)
    least_db = least_level_db(false_alarms_per_m2, maxima_per_m2)
    found = [_candidate(*place, echoes, image, least_db) for place in _places(echoes)]
    found.sort(
        key=lambda one: (one.is_doubtful, Flag.BRIGHTEST in one.flags, -one.above_clutter_db)
    )
    listed = found[: sum(not one.is_doubtful for one in found) + MOST_WEAKER]
    permittivity_lowest, permittivity_highest = permittivity_range(image)
    notes = [one for name in (DOUBTS, NOTES) for one in sentences_of(image, name)]
    if np.count_nonzero(~echoes.fitted) < FEWEST_ECHOES:
        notes.append(
            Message(
                "the clutter of so small an area or so coarse an image is known from a few echoes "
                "only; any candidate may be clutter"
            )
        )
    return CandidateList(
        survey_id=str(image.attrs.get("survey_id", "")),
        simulated=bool(image.attrs.get("simulated", False)),
        method=str(image.attrs["method"]),
        permittivity=float(image.attrs["permittivity"]),
        permittivity_lowest=permittivity_lowest,
        permittivity_highest=permittivity_highest,
        permittivity_source=str(image.attrs.get("permittivity_source", "")),
        area_m2=strip_m2 if is_line(image) else width_m * height_m,
        false_alarms_per_m2=false_alarms_per_m2,
        least_db=least_db,
        omitted=len(found) - len(listed),
        candidates=tuple(replace(one, id=f"C{number:02d}") for number, one in enumerate(listed, 1)),
        notes=tuple(notes),
        position=area_position(image.attrs),
        length_m=strip_m2 / STRIP_M if is_line(image) else None,
    )


class _Echoes:
    """The echoes of an image, as columns, the one furthest above clutter first.

    Attributes:
        turn: Number of the polarization of each.
        place_m: Depth, y and x (echo, 3) [m].
        above_db: Level above the clutter around it [dB].
        level_db: Level [dB].
        fitted: Whether it was fitted as a point; the others are weak.
        brightest: Which is the brightest; -1: none is brighter than noise.
    """

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
        weak_db = self.level_db[~self.fitted]
        self.brightest = -1
        if len(weak_db) and self.level_db.max() >= np.median(weak_db) + NOISE_DB:
            self.brightest = int(np.argmax(self.level_db))

    def near(self, one: int) -> np.ndarray:
        """Return which echoes are at the place of one."""
        away_m = np.hypot(*(self.place_m[:, 1:] - self.place_m[one, 1:]).T)
        found: np.ndarray = away_m <= PLACE_M
        return found


def _places(echoes: _Echoes) -> Iterator[Tuple[np.ndarray, int]]:
    """Yield the echoes of each place, the first furthest above clutter, and the one of the body."""
    left = np.ones(len(echoes.above_db), dtype=bool)
    for first in range(len(left)):
        if left[first]:
            own = left & echoes.near(first)
            strong = own & (echoes.above_db >= echoes.above_db[first] - NEARLY_DB)
            body = int(np.argmax(np.where(strong, echoes.level_db, -np.inf)))
            own |= left & echoes.near(body)
            left[own] = False
            yield np.flatnonzero(own), body


def _candidate(
    members: np.ndarray, body: int, echoes: _Echoes, image: xr.Dataset, least_db: float
) -> Candidate:
    """Return the candidate of the echoes at a place, without its name."""
    above_db, turns = echoes.above_db[members], echoes.turn[members]
    # What is below the cut adds nothing, unless all is.
    counted = above_db >= min(least_db, above_db[0])
    rotations_deg = image[POLARIZATION].values[list(dict.fromkeys(turns.tolist()))]
    ratio_db = None
    if image.sizes[POLARIZATION] == 2 and len(rotations_deg) == 2:
        first_db, second_db = (echoes.level_db[members[turns == one]].max() for one in (0, 1))
        ratio_db = float(first_db - second_db)
    depth_m, y_m, x_m = (float(one) for one in echoes.place_m[body])
    permittivity = float(image.attrs["permittivity"])
    of_permittivity_m = depth_m * depth_shares(permittivity, *permittivity_range(image))[0]
    across = str(image.attrs.get("across_lines", ""))
    of_depth_m = (
        OF_RESOLUTION * float(image.attrs["depth_resolution_m"]),
        HEIGHT_UNCERTAINTY_M / math.sqrt(permittivity),
        # The surface above a body may be as much higher or lower as the heights differ.
        float(image.attrs.get("relief_m", 0.0)),
        DEEPER_BESIDE_M if across else 0.0,
    )
    of_place_m = {
        name: math.hypot(OF_BODY_M, step_m / 2.0, BESIDE_LINE_M if name == across else 0.0)
        for name, step_m in ((X, _step_m(image[X].values)), (Y, _step_m(image[Y].values)))
    }
    return Candidate(
        id="",
        x_m=x_m,
        y_m=y_m,
        depth_m=depth_m,
        x_uncertainty_m=of_place_m[X],
        y_uncertainty_m=of_place_m[Y],
        depth_uncertainty_m=math.hypot(*of_depth_m) + max(of_permittivity_m, 0.0),
        above_clutter_db=10.0 * math.log10(np.sum(10.0 ** (above_db[counted] / 10.0))),
        rotations_deg=tuple(map(float, rotations_deg)),
        polarization_ratio_db=ratio_db,
        flags=_flags(members, body, echoes, image, least_db),
    )


def _flags(
    members: np.ndarray, body: int, echoes: _Echoes, image: xr.Dataset, least_db: float
) -> Tuple[Flag, ...]:
    """Return what to know about the echoes at a place."""
    depth_m, y_m, x_m = echoes.place_m[body]
    at_edge = depth_m in image[DEPTH].values[[0, -1]]
    for at_m, axis_m in ((x_m, image[X].values), (y_m, image[Y].values)):
        at_edge |= min(at_m - axis_m.min(), axis_m.max() - at_m) < _step_m(axis_m)
    turns = set(echoes.turn[members[echoes.above_db[members] >= least_db]].tolist())
    is_brightest = echoes.brightest in members
    lower_db = OF_SURFACE_DB if depth_m < SURFACE_M and not is_brightest else 0.0
    is_weak = echoes.above_db[members[0]] - lower_db < least_db
    away_m = np.hypot(*(echoes.place_m[:, 1:] - (y_m, x_m)).T)
    strongest_db = echoes.level_db[away_m <= SIDELOBE_REACH_M].max()
    flags = {
        Flag.SURFACE_RESIDUE: depth_m < float(image.attrs["depth_resolution_m"]),
        Flag.EDGE: at_edge,
        Flag.ONE_POLARIZATION: image.sizes[POLARIZATION] > 1 and len(turns) == 1,
        Flag.CLUTTER: is_weak and not is_brightest,
        Flag.SIDELOBE: not is_brightest and strongest_db >= echoes.level_db[body] + SIDELOBE_DB,
        Flag.BRIGHTEST: is_weak and is_brightest,
    }
    return tuple(flag for flag, is_set in flags.items() if is_set)


def _step_m(axis_m: np.ndarray) -> float:
    return float(np.ptp(axis_m)) / (len(axis_m) - 1) if len(axis_m) > 1 else 0.0
