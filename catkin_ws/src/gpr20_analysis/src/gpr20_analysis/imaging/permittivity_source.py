"""The permittivity of an image from the best source that there is, and from a buried reference.

The echo of an object that was buried at a known depth gives it. The traces are summed along the
hyperbola of a point below a place, for which the permittivity need not be known: with the delay of
the apex given, the delays at the other positions depend little on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import MM_PER_M, description_of
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.a_scans import gated_a_scans
from gpr20_analysis.imaging.permittivity import KnownPermittivity, Source
from gpr20_analysis.imaging.projection_scene import DISTANCE_STEP_M
from gpr20_analysis.imaging.records import Focus, Traces, antenna_offset_m
from gpr20_analysis.processing.antenna_step import ENDS, SURFACE_PERMITTIVITY, WIDEST_RATIO
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.folder.soil_note import soil_of_survey
from gpr20_survey.radar.depth import one_way_path_m, two_way_delay_s
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.radar.soils import ANY_SOIL, MAX_PERMITTIVITY, soil_of

if TYPE_CHECKING:
    from gpr20_analysis.imaging.image_options import ImageOptions

# How far the object may be from the place that was given.
AWAY_M = np.linspace(-0.03, 0.03, 5)
OPTICAL_STEP_M = 0.003
# Of depth and height as people and sensors measure them; twice that is the 95 % range.
DEPTH_DEVIATION_M, HEIGHT_DEVIATION_M = 0.003, 0.003
# Of the resolution in air: how well the delay of an echo is known.
OF_RESOLUTION = 0.2
# Of the median over all depths, and of the strongest echo.
CLEAR, STRONG = 4.0, 0.5
# Of the median of the strongest echoes at places beside it.
STANDS_OUT, BESIDE_M, BESIDE_STEP_M, FEWEST_BESIDE = 3.0, 0.12, 0.06, 3
TRIAL_PERMITTIVITY = 5.0
APERTURE_M = 0.22
APPARENT_DEPTH_M = 0.05


@dataclass(frozen=True)
class BuriedReference:
    """An object of metal that was buried on purpose.

    Attributes:
        x_m: Its middle along X [m].
        y_m: Its middle along Y [m].
        depth_m: Depth of its top below the surface [m].
    """

    x_m: float
    y_m: float
    depth_m: float


def permittivity_of(
    survey: xr.Dataset, traces: Sequence[Traces], focus: Focus, options: ImageOptions
) -> KnownPermittivity:
    """Return the permittivity of an image, and how it is known.

    Args:
        survey: The survey; after the step `antenna` its surface gives a permittivity, else its
            plan or its log may.
        traces: Its traces, one item per polarization.
        focus: Window and antenna separation.
        options: What a person gave; without anything, and without that of surface and survey,
            any soil is assumed.

    Raises:
        WrongDatasetError: The buried reference does not give it.
    """
    measured = _of_surface(survey)
    given, share = options.permittivity, options.permittivity_uncertainty
    if given is not None:
        known = KnownPermittivity.within(given, share, Source.GIVEN)
    elif options.soil is not None:
        known = KnownPermittivity.of_soil(options.soil.value, Source.SOIL)
    elif options.buried is not None:
        known = permittivity_of_reference(traces, focus, options.buried)
    else:
        return measured or _of_survey(survey, share)
    if measured is None:
        return known
    if known.lowest <= measured.highest and measured.lowest <= known.highest:
        return known
    contradiction = Message(
        "the surface reflects like soil of permittivity {lowest:.3g} to {highest:.3g}, but the "
        "image is made with {used:.3g}",
        lowest=measured.lowest,
        highest=measured.highest,
        used=known.permittivity,
    )
    return replace(known, notes=(contradiction,))


def _of_survey(survey: xr.Dataset, share: float) -> KnownPermittivity:
    noted = soil_of_survey(description_of(survey))
    if noted is None:
        return KnownPermittivity.of_soil(ANY_SOIL, Source.ASSUMED)
    soil, source = soil_of(noted.permittivity), Source(noted.source)
    if soil is not None:
        return KnownPermittivity.of_soil(soil.value, source)
    return KnownPermittivity.within(noted.permittivity, share, source)


def _of_surface(survey: xr.Dataset) -> Optional[KnownPermittivity]:
    if SURFACE_PERMITTIVITY not in survey.attrs:
        return None
    lowest, best, highest = (float(survey.attrs[SURFACE_PERMITTIVITY + end]) for end in ENDS)
    return KnownPermittivity(best, lowest, highest, Source.SURFACE)


def permittivity_of_reference(
    traces: Sequence[Traces], focus: Focus, reference: BuriedReference
) -> KnownPermittivity:
    """Return the permittivity that puts the echo of the reference at its depth.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: Window and antenna separation; its depths and permittivity are not used.
        reference: The object.

    Raises:
        WrongDatasetError: No trace is near it, or no clear echo of it.
    """
    if not all(_is_over(one, reference) for one in traces):
        raise _refused(Message("it is outside of the survey"), reference)
    level, optical_m = max(_echo(one, focus, reference) for one in traces)
    if not level >= CLEAR:
        raise _refused(Message("not one clear echo is below that place"), reference)
    band_hz = traces[0].sweep.step_hz * traces[0].sweep.count
    resolution_m = float(one_way_path_m(1.0 / band_hz))
    of_echo = float(np.hypot(OF_RESOLUTION * resolution_m, HEIGHT_DEVIATION_M)) / optical_m
    # The surface above it may be as much higher or lower as the heights differ.
    relief_m = max(float(np.std(one.height_m)) for one in traces)
    of_depth = float(np.hypot(DEPTH_DEVIATION_M, relief_m)) / reference.depth_m
    # Of the square of a quotient: twice its share; the range is two deviations.
    spread = 4.0 * float(np.hypot(of_echo, of_depth))
    permittivity = (optical_m / reference.depth_m) ** 2
    lowest, highest = max(permittivity / math.exp(spread), 1.0), permittivity * math.exp(spread)
    if not (permittivity > 1.0 and highest <= WIDEST_RATIO * lowest):
        raise _refused(Message("it is too shallow for the band and the heights"), reference)
    return KnownPermittivity(permittivity, lowest, highest, Source.BURIED)


def _is_over(traces: Traces, reference: BuriedReference) -> bool:
    at_m, reach_m = (reference.x_m, reference.y_m), float(AWAY_M[-1])
    axes_m = (traces.x_m, traces.y_m)
    return all(a.min() - reach_m <= at <= a.max() + reach_m for a, at in zip(axes_m, at_m))


def _beside(traces: Traces, reference: BuriedReference) -> List[Tuple[float, float]]:
    """Return places of the survey that are away from the reference."""
    x_m, y_m = (
        np.arange(axis_m.min(), axis_m.max() + 1e-9, BESIDE_STEP_M)
        for axis_m in (traces.x_m, traces.y_m)
    )
    return [
        (float(x), float(y))
        for x in x_m
        for y in y_m
        if np.hypot(x - reference.x_m, y - reference.y_m) > BESIDE_M
    ]


def _echo(traces: Traces, focus: Focus, reference: BuriedReference) -> Tuple[float, float]:
    """Return how far the strongest echo is above the others, and its depth times the index [m]."""
    deepest_m = reference.depth_m * np.sqrt(MAX_PERMITTIVITY)
    unambiguous_m = one_way_path_m(traces.sweep.unambiguous_s) - float(traces.height_m.max())
    optical_m = np.arange(
        0.8 * reference.depth_m, min(deepest_m, unambiguous_m / 2.0), OPTICAL_STEP_M
    )
    places = [
        (reference.x_m + x_m, reference.y_m + y_m)
        for x_m in (AWAY_M if len(traces.x_m) > 1 else [0.0])
        for y_m in (AWAY_M if len(traces.y_m) > 1 else [0.0])
    ]
    level = levels_at(traces, focus, places, optical_m).max(axis=0)
    # Residue of the surface or another body may be as strong: then they cannot be distinguished.
    inner = level[1:-1]
    tops = (inner > level[:-2]) & (inner >= level[2:]) & (inner >= STRONG * level.max())
    beside = _beside(traces, reference)
    if np.count_nonzero(tops) != 1 or len(beside) < FEWEST_BESIDE:
        return 0.0, 0.0
    first = 1 + int(np.argmax(tops))
    before, top, after = level[first - 1 : first + 2]
    around = levels_at(traces, focus, beside, optical_m).max(axis=1)
    # Where nothing was buried some echo is the strongest, too, but no stronger than elsewhere.
    if top < STANDS_OUT * np.median(around):
        return 0.0, 0.0
    offset = 0.5 * (after - before) / max(2.0 * top - before - after, 1e-300)
    return float(top / np.median(level)), float(optical_m[first] + offset * OPTICAL_STEP_M)


def _refused(reason: Message, reference: BuriedReference) -> WrongDatasetError:
    return WrongDatasetError(
        Message(
            "the buried reference at x {x_mm:.0f} mm, y {y_mm:.0f} mm gives no permittivity: "
            "{reason}; check its place, or give the permittivity",
            x_mm=MM_PER_M * reference.x_m,
            y_mm=MM_PER_M * reference.y_m,
            reason=reason,
        ),
        fault=NOT_ALLOWED,
    )


@dataclass(frozen=True)
class _Aligned:
    """What is shared by all places: the A-scans near them and a table of delays."""

    a_scans: np.ndarray
    sample_s: float
    x_m: np.ndarray
    y_m: np.ndarray
    higher_s: np.ndarray
    offset_m: Tuple[float, float]
    one_way_s: np.ndarray
    height_m: float


def levels_at(
    traces: Traces, focus: Focus, places: Sequence[Tuple[float, float]], optical_m: np.ndarray
) -> np.ndarray:
    """Return how well the traces add up (place, depth): the magnitude of their weighted sum.

    Args:
        traces: Traces of one polarization, without coupling and surface echo.
        focus: Window and antenna separation.
        places: X and Y of each place [m].
        optical_m: Depths times the refractive index [m].
    """
    shared = _aligned(traces, focus, np.array(places), optical_m)
    return np.stack([_level(shared, x_m, y_m) for x_m, y_m in places])


def _aligned(traces: Traces, focus: Focus, places: np.ndarray, optical_m: np.ndarray) -> _Aligned:
    x, y = (
        (axis_m >= of_places.min() - APERTURE_M) & (axis_m <= of_places.max() + APERTURE_M)
        for axis_m, of_places in zip((traces.x_m, traces.y_m), places.T)
    )
    grid_y, grid_x = np.meshgrid(traces.y_m[y], traces.x_m[x], indexing="ij")
    height_m = traces.height_m[np.ix_(y, x)].ravel()
    spectra = traces.s21[np.ix_(y, x)].reshape(-1, traces.sweep.count)
    mean_m = float(np.mean(height_m))
    distance_m = np.arange(0.0, APERTURE_M + focus.separation_m, DISTANCE_STEP_M)[:, None]
    depth_m = optical_m / np.sqrt(TRIAL_PERMITTIVITY)
    one_way_s = one_way_delay_s(mean_m, depth_m, distance_m, TRIAL_PERMITTIVITY)
    higher_s = two_way_delay_s(height_m - mean_m)
    longest_s = 2.0 * float(one_way_s.max()) + float(higher_s.max())
    a_scans, sample_s = gated_a_scans(spectra, traces.sweep, focus.window, longest_s)
    offset_m = antenna_offset_m(traces, focus)
    return _Aligned(
        a_scans, sample_s, grid_x.ravel(), grid_y.ravel(), higher_s, offset_m, one_way_s, mean_m
    )


def _level(shared: _Aligned, x_m: float, y_m: float) -> np.ndarray:
    """Return the level of each depth at a place."""
    away_m = np.hypot(shared.x_m - x_m, shared.y_m - y_m)
    near = np.flatnonzero(away_m <= APERTURE_M)
    delay_s = shared.higher_s[near][:, None]
    for side in (1.0, -1.0):
        leg_m = np.hypot(
            shared.x_m[near] + side * shared.offset_m[0] - x_m,
            shared.y_m[near] + side * shared.offset_m[1] - y_m,
        )
        row = np.minimum(np.rint(leg_m / DISTANCE_STEP_M).astype(int), len(shared.one_way_s) - 1)
        delay_s = delay_s + shared.one_way_s[row]
    place = np.maximum(delay_s / shared.sample_s, 0.0)
    index = np.minimum(place.astype(np.int64), shared.a_scans.shape[1] - 2)
    share = (place - index).astype(np.float32)
    rows = near[:, None]
    before = shared.a_scans[rows, index]
    values = before + share * (shared.a_scans[rows, index + 1] - before)
    # Spreading and an antenna pattern, each way; the source is a little below the surface.
    tangent = away_m[near] / (shared.height_m + APPARENT_DEPTH_M)
    weights = (1.0 / (1.0 + tangent**2) ** 2).astype(np.float32)
    total: np.ndarray = np.abs(weights @ values) / np.sqrt(np.sum(weights**2))
    return total
