"""Targets in the spectra of a survey, run by run, and which of them are found.

A run has targets at one depth on a lattice with a random origin. Each target is added to the image
of the survey (`detector.py`). At every depth some are searched by the whole detector, too, a few at
a time; where that has other answers, it searches that depth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.false_alarms import surveyed_m2
from gpr20_analysis.dataset import HEIGHT, X, Y, usable
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.detector import Detector, Searched, is_found
from gpr20_analysis.hiding.injection import with_targets
from gpr20_analysis.hiding.scattering import Echo, Soil, echo_of
from gpr20_analysis.hiding.transmission import SurfaceReference, of_model
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.work import Progress, in_stages, on_threads
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S
from gpr20_survey.results.hidden_target import Target

# Targets of one run are apart by that, or by so many wavelengths in air.
APART_M, APART_WAVELENGTHS = 0.2, 2.0
# Of the permittivities.
BEST = 0
# Of the targets that the whole detector searches, at once: more would count as clutter.
CHECKED_PER_M2, CHECKS = 5.0, 3
# Of the slow way, which gives a coarser map.
MOST_SLOW_ROUNDS = 8
# Of these, the share that must have the same answer, else the whole detector searches that depth.
ALIKE = 0.9


@dataclass(frozen=True)
class HidingOptions:
    """How a map is made.

    Attributes:
        depth_m: Depths of the target's top [m], ascending.
        rounds: How many lattices of targets are tried at each depth.
        needed: The share that must be found, else the target could hide.
        loss_tangent: Loss tangent of the soil; 0.05 is that of moist sand.
        separation_m: Distance between the antennas [m].
        seed: Of the random places.
    """

    depth_m: Tuple[float, ...] = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18)
    rounds: int = 12
    needed: float = 0.8
    loss_tangent: float = 0.05
    separation_m: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            WrongDatasetError: A value is not allowed.
        """
        depths_m = np.asarray(self.depth_m)
        right = {
            Message("the depths of the target must ascend, from 0 to 1 m"): len(depths_m) > 0
            and bool(np.all(np.diff(depths_m) > 0.0))
            and depths_m[0] >= 0.0
            and depths_m[-1] <= 1.0,
            Message("rounds must be 1 to 100"): 1 <= self.rounds <= 100,
            Message("the needed share must lie between 0.01 and 1"): 0.01 <= self.needed <= 1.0,
            Message("the loss tangent must lie between 0 and 1"): 0.0 <= self.loss_tangent <= 1.0,
            Message("the seed must not be negative"): self.seed >= 0,
        }
        for sentence, is_right in right.items():
            if not is_right:
                raise WrongDatasetError(sentence, fault=NOT_ALLOWED)


_Job = Tuple[float, int]
"""Depth of the targets [m], and number of the run at that depth."""
_Tried = Tuple[Tuple[float, float], bool]
"""X and Y of a target [m], and whether it was found."""


class Results(NamedTuple):
    """The targets by depth [m], and how many were searched in both ways, with the same answer."""

    tried: Dict[float, List[_Tried]]
    checked: int
    agreed: int
    by_whole_m: Tuple[float, ...]


class Runs:
    """The surveys with targets in them.

    Args:
        survey: The survey as measured.
        searched: The same, searched.
        detector: What it was searched with.
        target: What is put into the spectra.
        options: How many targets, and where.
        antenna: Model of the antennas; None: the survey's surface gives their transmission.

    Attributes:
        apart_m: Distance of the targets of one run [m].
        left: What a target leaves, by the depth of its top.
    """

    def __init__(
        self,
        survey: xr.Dataset,
        searched: Searched,
        detector: Detector,
        target: Target,
        options: HidingOptions,
        antenna: Optional[xr.Dataset],
    ) -> None:
        self._survey, self._target, self._options = survey, target, options
        self._searched, self._detector, listed = searched, detector, searched.found
        self.left: Dict[float, np.ndarray] = {}
        self._frequency_hz = FrequencyGrid.of(survey).frequency_hz
        lowest, highest = listed.permittivity_lowest, listed.permittivity_highest
        self._permittivities = [listed.permittivity, lowest, highest]
        if target.permittivity is not None and lowest <= target.permittivity <= highest:
            # What may be invisible is taken as invisible.
            self._permittivities = [target.permittivity]
        if antenna is None:
            surface = SurfaceReference(survey, options.separation_m)
            self._transmissions = [surface.transmission(one) for one in self._permittivities]
        else:
            self._transmissions = [of_model(antenna)] * len(self._permittivities)
        self._height_m = float(survey[HEIGHT].where(usable(survey)).mean())
        self._reach_m = float(np.hypot(*(np.ptp(survey[name].values) for name in (X, Y))))
        middle_m = SPEED_OF_LIGHT_M_S / float(np.mean(self._frequency_hz))
        self.apart_m = max(APART_M, APART_WAVELENGTHS * middle_m, 2.0 * target.diameter_m)
        # Of a lattice, so many are checked at once.
        area_m2 = surveyed_m2(*(survey[name].values for name in (X, Y)))
        at_once = max(1, int(CHECKED_PER_M2 * area_m2))
        self._every = -(-len(self._places_m(options.depth_m[0], 0)) // at_once) or 1
        self._echoes: Dict[Tuple[float, int], Echo] = {}

    def left_by(self, depth_m: float) -> np.ndarray:
        """Return what a target leaves; see `Searched.left_by`."""
        return self._searched.left_by(self._survey_with([self._searched.middle_m], depth_m, BEST))

    def added(self, job: _Job) -> List[_Tried]:
        """Return which targets of a run are found, each added to the image of the survey."""
        depth_m, number = job
        places_m = self._places_m(depth_m, number)
        if not places_m:
            return []
        image = self._searched.with_echo(self._survey_with(places_m, depth_m, number))
        left, target = self.left[depth_m], self._target
        return [(one, self._searched.finds(image, left, one, depth_m, target)) for one in places_m]

    def whole(self, job: _Job) -> List[_Tried]:
        """Return which of a few targets of a run are found by the whole detector."""
        depth_m, number = job
        places_m = self._places_m(depth_m, number)[:: self._every]
        if not places_m:
            return []
        found = self._detector.search(self._survey_with(places_m, depth_m, number))
        without, target = self._searched.found, self._target
        return [(one, is_found(found, without, one, depth_m, target)) for one in places_m]

    def _places_m(self, depth_m: float, number: int) -> List[Tuple[float, float]]:
        """Return the places of one run [m]."""
        options = self._options
        random = np.random.default_rng([options.seed, options.depth_m.index(depth_m), number])
        axes_m = [self._survey[name].values for name in (X, Y)]
        x_m, y_m = (self._lattice(axis_m, random.random()) for axis_m in axes_m)
        return [(float(one), float(other)) for other in y_m for one in x_m]

    def _survey_with(
        self, places_m: Sequence[Tuple[float, float]], depth_m: float, number: int
    ) -> xr.Dataset:
        """Return the survey with targets at places."""
        of_soil = number % len(self._permittivities)
        return with_targets(
            self._survey,
            self._echo(depth_m, of_soil),
            places_m,
            self._permittivities[of_soil],
            self._transmissions[of_soil],
            self._options.separation_m,
        )

    def _lattice(self, axis_m: np.ndarray, origin: float) -> np.ndarray:
        """Return places along an axis; of a single line its place."""
        if len(axis_m) == 1:
            return axis_m
        first_m, last_m = float(axis_m.min()), float(axis_m.max())
        return np.arange(first_m + origin * self.apart_m, last_m, self.apart_m)

    def _echo(self, depth_m: float, of_soil: int) -> Echo:
        # Two threads may compute the same echo, which is the same.
        if (depth_m, of_soil) not in self._echoes:
            soil = Soil(self._permittivities[of_soil], self._options.loss_tangent)
            self._echoes[depth_m, of_soil] = echo_of(
                self._target, depth_m, soil, self._height_m, self._frequency_hz, self._reach_m
            )
        return self._echoes[depth_m, of_soil]


def search_all(runs: Runs, options: HidingOptions, progress: Progress) -> Results:
    """Search all targets, at each depth by the faster way if both have the same answers."""
    depths, rounds = options.depth_m, range(options.rounds)
    checks = [(one, number) for one in depths for number in rounds[:CHECKS]]
    jobs = [(one, number) for one in depths for number in rounds]
    stages = in_stages([depths, checks, checks, jobs], progress)
    runs.left = dict(zip(depths, on_threads(runs.left_by, *next(stages))))
    fast, slow = (
        dict(zip(checks, on_threads(way, *next(stages)))) for way in (runs.added, runs.whole)
    )
    alike: Dict[float, List[bool]] = {one: [] for one in depths}
    for job in checks:
        answers = dict(fast[job])
        alike[job[0]] += [answers[place_m] == found for place_m, found in slow[job]]
    by_whole = [one for one in depths if sum(alike[one]) < ALIKE * len(alike[one])]

    def search(job: _Job) -> List[_Tried]:
        if job[0] in by_whole:
            if job in slow or job[1] >= MOST_SLOW_ROUNDS:
                return slow.get(job, [])
            return runs.whole(job)
        return fast[job] if job in fast else runs.added(job)

    tried: Dict[float, List[_Tried]] = {one: [] for one in depths}
    for job, result in zip(jobs, on_threads(search, *next(stages))):
        tried[job[0]] += result
    next(stages, None)
    every = [one for answers in alike.values() for one in answers]
    return Results(tried, len(every), sum(every), tuple(by_whole))
