"""The image of a survey: every polarization by one method, and a record of how it was made."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any, Dict, Hashable, List, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    ATTRIBUTES,
    CLUTTER,
    DEPTH,
    ECHOES,
    IMAGE,
    MM_PER_M,
    POLARIZATION,
    X,
    Y,
    described,
)
from gpr20_analysis.errors import TooLargeError, WrongDatasetError
from gpr20_analysis.imaging.echoes import (
    Echoes,
    PointEchoes,
    find_echoes,
    local_clutter,
    maxima_only,
)
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.methods import Method, Positions
from gpr20_analysis.imaging.permittivity_source import permittivity_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces, longer_m
from gpr20_analysis.processing.delay import delay_to_remove_s, recorded_separation_m
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.sentences import with_notes
from gpr20_analysis.work import MIB, Progress, available_bytes, in_stages, no_progress
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import delay_of_depth, one_way_path_m
from gpr20_survey.radar.frequency_to_delay import decibels

NOTED_DEPTH_M = 0.001
"""Error of depths by antennas that are apart above which an image has a note [m]."""
ECHO_VALUES = ("rotation_deg", "depth", "y", "x", "above_clutter_db", "level_db", "fitted")
"""Values of each echo of an image: rotation of the antennas, place [m], levels, and whether it is
a point that was fitted to the traces and taken away before the clutter was measured."""
VALUE = "value"
"""Coordinate: the names of the values of an echo, as `image.echoes.sel(value="depth")`."""
# Of the delay of the deepest voxel, since waves arrive aslant too.
LONGEST = 1.5
# -3 dB width with a Hann window, in units of the inverse of the band.
RESOLUTION = 1.44
VOXEL_BYTES = 8
# Of the image of each polarization: as computed, stacked with the others, and its magnitude. Of
# the one that is being computed two more.
COPIES, COPIES_OF_ONE = 2.5, 2.0
# Of a step: positions are read from axes that count steps of 0.01 mm.
ROUNDING = 1e-3


def image_survey(
    survey: xr.Dataset,
    options: ImageOptions,
    progress: Progress = no_progress,
    with_echoes: bool = True,
) -> xr.Dataset:
    """Return the image of a survey.

    Args:
        survey: Dataset with `s21`, without coupling and surface echo.
        options: How the image is made.
        progress: Shows the progress over all polarizations.
        with_echoes: Find the echoes and the clutter, without which there are no candidates.

    Returns:
        Dataset with `image` (polarization, depth, y, x), complex or
        real, and attributes that describe how it was made and what was left out. `echoes` (echo,
        value) has its maxima, see `ECHO_VALUES`, and `clutter` (polarization, depth) the standard
        magnitude of what is beside the strong ones in each plane.

    Raises:
        WrongDatasetError: The data cannot be imaged by this method.
        DamagedSurveyError: Samples or heights are missing, and that was not allowed.
        TooLargeError: An image with that grid step would not fit into the memory.
    """
    if not options.separation_m:
        options = replace(options, separation_m=recorded_separation_m(survey))
    x, y = _image_axes(survey, options)
    traces, notes = traces_of(survey, options)
    focus = Focus(
        permittivity=1.0,
        depth_m=np.asarray(options.depth_m, dtype=np.float64),
        window=options.window,
        widest_angle_deg=options.widest_angle_deg,
        separation_m=options.separation_m,
        ground=options.ground or Ground.LEVEL,
    )
    heights_m = float(np.mean([np.mean(one.height_m) for one in traces]))
    known = permittivity_of(survey, traces, focus, options)
    focus = replace(focus, permittivity=known.permittivity)
    attributes = known.attributes()
    notes = [*notes, *known.notes]
    notes += _separation_notes(heights_m, focus, options.method)
    _check_unambiguous(traces, focus)
    at = (None, None) if options.grid_step_m is None else (x.values, y.values)
    volumes = [
        options.method.image(one, focus, at, stage) for one, stage in in_stages(traces, progress)
    ]
    coordinates = {
        POLARIZATION: survey[POLARIZATION],
        DEPTH: (DEPTH, volumes[0][1], ATTRIBUTES[DEPTH]),
        Y: y,
        X: x,
    }
    values = np.stack([volume for volume, _ in volumes])
    image = xr.Dataset({IMAGE: ((POLARIZATION, DEPTH, Y, X), values)}, coordinates)
    if with_echoes:
        image = image.assign(_echoes(traces, focus, options.method, image, at))
        image = image.assign_coords({VALUE: list(ECHO_VALUES)})
    noted = with_notes(survey, notes)
    attributes["mean_height_m"] = heights_m
    attributes["across_lines"] = Y if image.sizes[Y] == 1 else X if image.sizes[X] == 1 else ""
    attributes["relief_m"] = float(np.mean([np.std(one.height_m) for one in traces]))
    attributes["depth_resolution_m"] = depth_resolution_m(traces[0].sweep, focus.permittivity)
    delay_s = delay_to_remove_s(survey, options.delay_s)
    record = _record(options, focus, delay_s)
    return described(image).assign_attrs({**noted, **attributes, **record})


def _separation_notes(height_m: float, focus: Focus, method: Method) -> List[Message]:
    """Return a note if the method ignores a separation that moves echoes."""
    if method.exact_paths:
        return []
    deeper_m = longer_m(height_m, focus.separation_m) / float(np.sqrt(focus.permittivity))
    if deeper_m < NOTED_DEPTH_M:
        return []
    return [
        Message(
            "the method {method} takes the antennas as one, but they are {separation_mm:.0f} mm "
            "apart: echoes appear up to {deeper_mm:.0f} mm too deep, which the uncertainty of "
            "depths does not contain; use --method {other}",
            method=method.name,
            separation_mm=MM_PER_M * focus.separation_m,
            deeper_mm=MM_PER_M * deeper_m,
            other=Method.BACK_PROJECTION.name,
        )
    ]


def _check_unambiguous(traces: Sequence[Traces], focus: Focus) -> None:
    height_m = max(float(np.max(one.height_m)) for one in traces)
    longest_s = float(delay_of_depth(float(focus.depth_m[-1]), height_m, focus.permittivity))
    unambiguous_s = traces[0].sweep.unambiguous_s
    if longest_s >= unambiguous_s:
        raise WrongDatasetError(
            Message(
                "echoes of the deepest layer have a delay of {longest_ns:.3g} ns, but a frequency "
                "step of {step_mhz:.4g} MHz allows only {unambiguous_ns:.3g} ns; choose a smaller "
                "depth, or measure with more points",
                longest_ns=longest_s * 1e9,
                step_mhz=traces[0].sweep.step_hz / 1e6,
                unambiguous_ns=unambiguous_s * 1e9,
            ),
            fault=NOT_ALLOWED,
        )
    band_hz = traces[0].sweep.step_hz * traces[0].sweep.count
    if longest_s * band_hz < 1.0:
        raise WrongDatasetError(
            Message(
                "a band of {band_mhz:.4g} MHz resolves delays of {resolution_ns:.3g} ns, but the "
                "whole image covers {longest_ns:.3g} ns, so no echo can be seen; use a wider band",
                band_mhz=band_hz / 1e6,
                resolution_ns=1e9 / band_hz,
                longest_ns=longest_s * 1e9,
            ),
            fault=faults.INPUT,
        )


def _echoes(
    traces: Sequence[Traces],
    focus: Focus,
    method: Method,
    image: xr.Dataset,
    at: Positions,
) -> Dict[Hashable, Any]:
    def imager(some: Traces) -> np.ndarray:
        return method.image(some, focus, at, no_progress)[0]

    axes_m = [np.asarray(image[name].values, dtype=np.float64) for name in (DEPTH, Y, X)]
    resolution_m = depth_resolution_m(traces[0].sweep, focus.permittivity)
    longest_s = LONGEST * float(
        delay_of_depth(
            float(axes_m[0][-1]),
            max(float(np.max(one.height_m)) for one in traces),
            focus.permittivity,
        )
    )
    rows, planes = [], []
    for turn, one in enumerate(traces):
        volume = image[IMAGE].values[turn]
        magnitude = np.abs(volume)
        if method.is_linear:
            points = PointEchoes(one, focus, longest_s)
            found = find_echoes(volume, axes_m, resolution_m, points, imager)
        else:
            found = maxima_only(magnitude, axes_m, resolution_m)
        rows.append(_rows(one.rotation_deg, found, method))
        bodies_m = found.place_m[found.fitted]
        clutter = local_clutter(magnitude, axes_m, resolution_m, bodies_m)
        planes.append(np.exp(np.mean(np.log(clutter), axis=(1, 2))))
    return {
        CLUTTER: ((POLARIZATION, DEPTH), np.stack(planes), {"factors": method.factors}),
        ECHOES: (("echo", VALUE), np.concatenate(rows)),
    }


def _rows(rotation_deg: float, found: Echoes, method: Method) -> np.ndarray:
    above_db = decibels(found.magnitude / found.clutter, 0.0) / method.factors
    level_db = decibels(found.magnitude, 0.0) / method.factors
    rotations_deg = np.full(len(level_db), rotation_deg)
    return np.column_stack([rotations_deg, found.place_m, above_db, level_db, found.fitted])


def depth_resolution_m(sweep: FrequencyGrid, permittivity: float) -> float:
    """Return the -3 dB width of an echo along depth with the default window [m]."""
    band_hz = sweep.step_hz * (sweep.count - 1)
    return RESOLUTION * float(one_way_path_m(1.0 / band_hz, permittivity))


def _record(options: ImageOptions, focus: Focus, delay_s: float) -> Dict[str, object]:
    record = {
        "method": options.method.name,
        "permittivity": focus.permittivity,
        "window": focus.window.value,
        "widest_angle_deg": focus.widest_angle_deg,
        "separation_m": focus.separation_m,
        "ground": focus.ground.value,
        "height_m": options.height_m,
        "grid_step_m": options.grid_step_m,
        "leave_out_missing": options.leave_out_missing,
        "delay_s": delay_s,
    }
    return {"permittivity": focus.permittivity, "method": options.method.name,
            "imaging": json.dumps(record)}  # fmt: skip


def _image_axes(survey: xr.Dataset, options: ImageOptions) -> Tuple[xr.DataArray, xr.DataArray]:
    """Return the positions of the image along X and along Y [m].

    Raises:
        TooLargeError: The image would not fit into the memory.
    """
    if options.grid_step_m is None:
        return survey[X], survey[Y]
    counts = [_count(survey[axis].values, options.grid_step_m) for axis in (X, Y)]
    _require_room(counts, len(options.depth_m), survey.sizes[POLARIZATION])
    x, y = (
        xr.DataArray(
            np.linspace(np.min(survey[axis].values), np.max(survey[axis].values), count),
            dims=axis,
            attrs=ATTRIBUTES[axis],
        )
        for axis, count in zip((X, Y), counts)
    )
    return x, y


def _count(position_m: np.ndarray, step_m: float) -> int:
    """Return how many positions cover the survey's from first to last, at most a step apart."""
    return 1 + math.ceil(float(np.ptp(position_m)) / step_m - ROUNDING)


def _require_room(counts: Sequence[int], depths: int, polarizations: int) -> None:
    copies = COPIES * polarizations + COPIES_OF_ONE
    needed = math.prod(counts) * depths * VOXEL_BYTES * copies
    if needed > available_bytes():
        raise TooLargeError(
            Message(
                "an image of {polarizations} x {depths} x {y} x {x} voxels needs "
                "{needed_mib:.0f} MiB of memory, but only {free_mib:.0f} MiB are free; use a "
                "larger --grid-step, fewer depths (--depth) or one polarization",
                x=counts[0],
                y=counts[1],
                depths=depths,
                polarizations=polarizations,
                needed_mib=needed / MIB,
                free_mib=available_bytes() / MIB,
            )
        )
