"""The map of where a target could hide: targets are put into a survey's spectra and searched for.

Every run puts a few targets at one depth on a lattice with a random origin into the spectra as
measured, and searches all of it with the survey's own detector. So what a survey's own ground,
heights, noise and bodies hide is hidden here. The soil's permittivity is in turn the best, the
lowest and the highest likely one, while the detector uses the best, as it would. If one of these is
that of the target, it is taken, and the target is invisible.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.stats import beta

from gpr20_analysis import work
from gpr20_analysis.candidates.answer import answer
from gpr20_analysis.candidates.search import surveyed_m2
from gpr20_analysis.dataset import HEIGHT, S21, S21_DIMS, X, Y, require, usable
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.injection import of_model, of_surface, with_targets
from gpr20_analysis.hiding.scattering import Soil, echo_of
from gpr20_analysis.imaging.image_options import ImageOptions, check_range
from gpr20_analysis.imaging.permittivity import Source
from gpr20_analysis.processing.antenna_step import require_measured
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.work import Progress, no_progress, on_threads
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import SPEED_OF_LIGHT_M_S
from gpr20_survey.results.candidates import Candidate, CandidateList
from gpr20_survey.results.hiding_map import HidingMap, Target

# A candidate is the target if it is so near to it: across its rim, above its top, below its bottom.
NEAR_M, ABOVE_M, BELOW_M = 0.03, 0.03, 0.06
# Than a candidate that is there without the target.
STRONGER_DB = 1.0
# Targets of one run are apart by that, or by so many wavelengths in air; more would count as
# clutter.
APART_M, APART_WAVELENGTHS, AT_ONCE_PER_M2 = 0.2, 2.0, 8.0
# The nearest of that many targets count for a place.
COUNTED = 12
# Places are nearer to each other than the targets of one run.
PLACE_SHARE = 0.4
MOST_PLACES = 40
# Arrays as large as the spectra that are held at once by each thread.
COPIES = 6.0
OUTSIDE = 0.025  # of a 95 % interval, on each side
Place = Tuple[float, float]
"""X and Y [m]."""


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
    rounds: int = 16
    needed: float = 0.8
    loss_tangent: float = 0.05
    separation_m: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        rising = bool(self.depth_m) and bool(np.all(np.diff(self.depth_m) > 0.0))
        # Written so that NaN is refused too.
        if not (rising and self.depth_m[0] >= 0.0 and self.depth_m[-1] <= 1.0):
            raise WrongDatasetError(
                Message("the depths of the target must ascend, from 0 to 1 m"), fault=NOT_ALLOWED
            )
        check_range("rounds", self.rounds, 1, 100)
        check_range("needed", self.needed, 0.01, 1.0)
        check_range("loss_tangent", self.loss_tangent, 0.0, 1.0)
        check_range("seed", self.seed, 0, 2**32)


STANDARD = HidingOptions()


@dataclass(frozen=True)
class Detector:
    """How a survey is searched.

    Attributes:
        options: How the image is made, and the list cut.
        process: Applies the steps to a survey as measured; by default those of the method.
    """

    options: ImageOptions
    process: Callable[[xr.Dataset], xr.Dataset] = lambda survey: survey

    def search(self, survey: xr.Dataset) -> CandidateList:
        """Return the candidates of a survey as measured."""
        return answer(self.process(survey), self.options).found


def map_hidden(
    survey: xr.Dataset,
    detector: Detector,
    target: Target,
    options: HidingOptions = STANDARD,
    antenna: Optional[xr.Dataset] = None,
    progress: Progress = no_progress,
) -> HidingMap:
    """Return where a target could hide.

    Args:
        survey: The survey as measured.
        detector: Finds the candidates; the one that the survey was searched with.
        target: What is put into the spectra.
        options: How the map is made.
        antenna: Model of the antennas; None: the echo of the survey's surface gives their
            transmission.
        progress: Shows the progress.

    Raises:
        WrongDatasetError: The survey was changed, or its surface echo is not clear.
    """
    require_measured(survey)
    measured = require(survey, S21, S21_DIMS)
    work.require_bytes(COPIES * measured.nbytes, Message("a map of hidden targets"))
    survey = survey.assign({S21: measured.compute()})
    listed = detector.search(survey)
    soils = [Soil(one, options.loss_tangent) for one in _permittivities(listed, target)]
    transmissions = (
        [of_model(antenna)] * len(soils)
        if antenna is not None
        else of_surface(survey, options.separation_m, [one.permittivity for one in soils])
    )
    frequency_hz = FrequencyGrid.of(survey).frequency_hz
    height_m = float(survey[HEIGHT].where(usable(survey)).mean())
    reach_m = float(np.hypot(*(np.ptp(survey[name].values) for name in (X, Y))))
    echoes = {
        (depth_m, soil): echo_of(target, depth_m, soil, height_m, frequency_hz, reach_m)
        for depth_m in options.depth_m
        for soil in soils
    }

    def search(run: _Run) -> List[bool]:
        at = run.number % len(soils)
        echo = echoes[run.depth_m, soils[at]]
        injected = with_targets(
            survey,
            echo,
            run.places_m,
            soils[at].permittivity,
            transmissions[at],
            options.separation_m,
        )
        found = detector.search(injected)
        return [is_found(found, listed, one, run.depth_m, target) for one in run.places_m]

    middle_m = SPEED_OF_LIGHT_M_S / float(np.mean(frequency_hz))
    apart_m = max(APART_M, APART_WAVELENGTHS * middle_m, 2.0 * target.diameter_m)
    runs = _runs(survey, options, apart_m)
    tried: Dict[float, List[Tuple[Place, bool]]] = {one: [] for one in options.depth_m}
    for run, hits in zip(runs, on_threads(search, runs, progress)):
        tried[run.depth_m] += zip(run.places_m, hits)
    return _counted(survey, listed, target, options, tried, apart_m)


def _permittivities(listed: CandidateList, target: Target) -> List[float]:
    """Return what the soil may have: the best, the lowest and the highest likely permittivity."""
    if _may_be_invisible(listed, target):
        return [target.permittivity or 1.0]
    return [listed.permittivity, listed.permittivity_lowest, listed.permittivity_highest]


def _may_be_invisible(listed: CandidateList, target: Target) -> bool:
    """Return whether the soil may be like the target; what may be invisible is taken as that."""
    lowest, highest = listed.permittivity_lowest, listed.permittivity_highest
    return target.permittivity is not None and lowest <= target.permittivity <= highest


@dataclass(frozen=True)
class _Run:
    """A survey with targets in it that is searched.

    Attributes:
        depth_m: Depth of their tops [m].
        number: Of the run at that depth.
        places_m: X and Y of each target [m].
    """

    depth_m: float
    number: int
    places_m: Sequence[Place]


def _runs(survey: xr.Dataset, options: HidingOptions, apart_m: float) -> List[_Run]:
    """Return all runs that have targets: every time some of a lattice with a random origin."""
    axes_m = [survey[name].values for name in (X, Y)]
    at_once = max(1, int(AT_ONCE_PER_M2 * surveyed_m2(*axes_m)))
    found = []
    for layer, depth_m in enumerate(options.depth_m):
        for number in range(options.rounds):
            random = np.random.default_rng([options.seed, layer, number])
            x_m, y_m = (_lattice(axis_m, apart_m, random.random()) for axis_m in axes_m)
            places_m = [(float(one), float(other)) for other in y_m for one in x_m]
            every = max(1, -(-len(places_m) // at_once))
            found.append(_Run(depth_m, number, places_m[number % every :: every]))
    return [one for one in found if one.places_m]


def _lattice(axis_m: np.ndarray, apart_m: float, origin: float) -> np.ndarray:
    """Return places along an axis; of a single line its place."""
    if len(axis_m) == 1:
        return axis_m
    return np.arange(float(axis_m.min()) + origin * apart_m, float(axis_m.max()), apart_m)


def is_found(
    found: CandidateList, without: CandidateList, place_m: Place, top_m: float, target: Target
) -> bool:
    """Return whether a place to check is a target.

    Where the survey has a place without the target, too, it must be stronger with it: what changes
    nothing was not found.

    Args:
        found: The candidates with the target.
        without: Those of the survey without it.
        place_m: X and Y of the target [m].
        top_m: Depth of its top [m].
        target: What it is.
    """
    with_db, without_db = (
        max([-np.inf, *(one.above_clutter_db for one in listed.shown()
                        if _is_at(one, place_m, top_m, target))])
        for listed in (found, without)
    )  # fmt: skip
    return bool(with_db > without_db + STRONGER_DB)


def _is_at(one: Candidate, place_m: Place, top_m: float, target: Target) -> bool:
    away_m = np.hypot(one.x_m - place_m[0], one.y_m - place_m[1])
    return bool(
        away_m < NEAR_M + target.diameter_m / 2.0
        and -ABOVE_M < one.depth_m - top_m < target.height_m + BELOW_M
    )


def _counted(
    survey: xr.Dataset,
    listed: CandidateList,
    target: Target,
    options: HidingOptions,
    every: Dict[float, List[Tuple[Place, bool]]],
    apart_m: float,
) -> HidingMap:
    axes_m = [survey[name].values for name in (X, Y)]
    # The same for each seed.
    x_m, y_m = (_places(axis_m, PLACE_SHARE * apart_m) for axis_m in axes_m)
    shape = (len(options.depth_m), len(y_m), len(x_m))
    counts, hits, within_m = np.zeros(shape, int), np.zeros(shape, int), np.zeros(shape[0])
    for layer, tried in enumerate(every.values()):
        if not tried:
            continue
        at_x_m, at_y_m = np.array([place_m for place_m, _ in tried]).T
        found = np.array([is_hit for _, is_hit in tried])
        away_m = np.hypot(y_m[:, None, None] - at_y_m, x_m[:, None] - at_x_m)
        nearest = np.argsort(away_m, axis=-1, kind="stable")[..., :COUNTED]
        counts[layer], hits[layer] = nearest.shape[-1], found[nearest].sum(axis=-1)
        within_m[layer] = np.take_along_axis(away_m, nearest[..., -1:], axis=-1).max()
    limits = [detection_interval(int(k), int(n)) if n else (0.0, 1.0)
              for k, n in zip(hits.ravel(), counts.ravel())]  # fmt: skip
    lowest, highest = np.array(limits).T.reshape(2, *shape)
    return HidingMap(
        survey_id=listed.survey_id,
        simulated=listed.simulated,
        target=target,
        x_m=x_m,
        y_m=y_m,
        depth_m=np.asarray(options.depth_m),
        tried=counts,
        found=hits,
        lowest=lowest,
        highest=highest,
        needed=options.needed,
        within_m=within_m,
        permittivity=listed.permittivity,
        permittivity_range=(listed.permittivity_lowest, listed.permittivity_highest),
        loss_tangent=options.loss_tangent,
        seed=options.seed,
        notes=(*listed.notes, *_notes(listed, target)),
        position=listed.position,
    )


def detection_interval(found: int, targets: int) -> Tuple[float, float]:
    """Return the 95 % interval of a probability of detection (Clopper and Pearson, 1934)."""
    low = 0.0 if found == 0 else float(beta.ppf(OUTSIDE, found, targets - found + 1))
    high = 1.0 if found == targets else float(beta.ppf(1.0 - OUTSIDE, found + 1, targets - found))
    return low, high


def _notes(listed: CandidateList, target: Target) -> Sequence[Message]:
    known = Source(listed.permittivity_source).message
    notes = [Message("permittivity of the soil: {source}", source=known)]
    if _may_be_invisible(listed, target):
        notes.append(
            Message(
                "the soil may have the permittivity of the target, {value:g}, which is then "
                "invisible; measure that of the soil",
                value=target.permittivity,
            )
        )
    return notes


def _places(axis_m: np.ndarray, step_m: float) -> np.ndarray:
    """Return the middles of the cells of a map along an axis [m]."""
    first_m, last_m = float(axis_m.min()), float(axis_m.max())
    count = min(max(1, int(np.ceil((last_m - first_m) / step_m))), MOST_PLACES)
    middles: np.ndarray = first_m + (np.arange(count) + 0.5) * (last_m - first_m) / count
    return middles
