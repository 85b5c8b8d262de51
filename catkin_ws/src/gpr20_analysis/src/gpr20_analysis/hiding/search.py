"""The map of where a target could hide: targets are put into a survey's spectra and searched for.

Every run puts targets at one depth on a lattice with a random origin into the spectra as measured,
and looks for each with the survey's own detector. So what a survey's own ground, heights, noise and
bodies hide is hidden here. The soil's permittivity is in turn the best, the lowest and the highest
likely one, while the detector uses the best, as it would. If one of these is that of the target, it
is taken, and the target is invisible.
"""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import work
from gpr20_analysis.candidates.focused import field_options
from gpr20_analysis.dataset import S21, S21_DIMS, X, Y, require
from gpr20_analysis.hiding.detector import Detector, Searched
from gpr20_analysis.hiding.runs import HidingOptions, Results, Runs, search_all
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.imaging.permittivity import Source
from gpr20_analysis.processing.antenna_step import require_measured
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.trial.statistics import detection_interval
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_survey.results.candidates import CandidateList
from gpr20_survey.results.hidden_target import Target
from gpr20_survey.results.hiding_map import HidingMap

# The nearest of that many targets count for a place.
COUNTED = 12
# Places are nearer to each other than the targets of one run.
PLACE_SHARE = 0.4
MOST_PLACES = 40
# Arrays as large as the spectra that are held at once by each thread.
COPIES = 6.0


def map_hidden(
    survey: xr.Dataset,
    detector: Detector,
    target: Target,
    options: HidingOptions,
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
    searched = Searched(survey, detector)
    runs = Runs(survey, searched, detector, target, options, antenna)
    results = search_all(runs, options, progress)
    return _counted(survey, searched.found, target, options, results, runs.apart_m)


def map_hidden_in_field(
    survey: xr.Dataset, permittivity: Optional[float], target: Target
) -> HidingMap:
    """Return where a target could hide, as the robot's window searches surveys.

    Args:
        survey: The survey as measured.
        permittivity: Relative permittivity of the ground; None: what the survey says.
        target: What is put into the spectra.

    Raises:
        AnalysisError: The survey cannot be imaged, or its surface echo is not clear.
    """
    detector = Detector(
        lambda one: process_survey(one, *DEFAULT_STEPS), field_options(permittivity, survey)
    )
    return map_hidden(survey, detector, target, HidingOptions())


def _counted(
    survey: xr.Dataset,
    listed: CandidateList,
    target: Target,
    options: HidingOptions,
    results: Results,
    apart_m: float,
) -> HidingMap:
    axes_m = [survey[name].values for name in (X, Y)]
    # The same for each seed.
    x_m, y_m = (_places(axis_m, PLACE_SHARE * apart_m) for axis_m in axes_m)
    shape = (len(options.depth_m), len(y_m), len(x_m))
    counts, hits, within_m = np.zeros(shape, int), np.zeros(shape, int), np.zeros(shape[0])
    for layer, depth_m in enumerate(options.depth_m):
        tried = results.tried[depth_m]
        if not tried:
            continue
        at_x_m, at_y_m = np.array([place_m for place_m, _ in tried]).T
        found = np.array([is_found for _, is_found in tried])
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
        checked=results.checked,
        agreed=results.agreed,
        by_whole_m=results.by_whole_m,
        notes=(*listed.notes, *_notes(listed, target)),
        position=listed.position,
    )


def _notes(listed: CandidateList, target: Target) -> Sequence[Message]:
    lowest, highest = listed.permittivity_lowest, listed.permittivity_highest
    known = Source(listed.permittivity_source).message
    notes = [Message("permittivity of the soil: {source}", source=known)]
    if target.permittivity is None or not lowest <= target.permittivity <= highest:
        return notes
    return [
        *notes,
        Message(
            "the soil may have the permittivity of the target, {value:g}, which is then invisible; "
            "measure that of the soil",
            value=target.permittivity,
        ),
    ]


def _places(axis_m: np.ndarray, step_m: float) -> np.ndarray:
    """Return the middles of the cells of a map along an axis [m]."""
    first_m, last_m = float(axis_m.min()), float(axis_m.max())
    count = min(max(1, int(np.ceil((last_m - first_m) / step_m))), MOST_PLACES)
    middles: np.ndarray = first_m + (np.arange(count) + 0.5) * (last_m - first_m) / count
    return middles
