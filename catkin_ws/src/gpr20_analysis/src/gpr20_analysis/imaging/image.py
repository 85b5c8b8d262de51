"""The image of a survey: every polarization by one method, and a record of how it was made."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Dict, List, Sequence

import numpy as np
import xarray as xr

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
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.echoes import Imager, PointEchoes, find_echoes, local_clutter
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.permittivity import permittivity_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces, longer_m
from gpr20_analysis.processing.delay import delay_to_remove_s, recorded_separation_m
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.sentences import with_notes
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import decibels, delay_of_depth, one_way_path_m

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
        progress: Shows the progress of each polarization.
        with_echoes: Find the echoes and the clutter, without which there are no candidates.

    Returns:
        Dataset with `image` (polarization, depth, y, x), complex, and attributes that describe how
        it was made and what was left out. `echoes` (echo, value) has its maxima, see `ECHO_VALUES`,
        and `clutter` (polarization, depth) the standard magnitude of what is beside the strong ones
        in each plane.

    Raises:
        WrongDatasetError: The data cannot be imaged by this method.
        DamagedSurveyError: Samples or heights are missing, and that was not allowed.
        TooLargeError: The traces do not fit into the memory.
    """
    if not options.separation_m:
        options = replace(options, separation_m=recorded_separation_m(survey))
    method = options.method
    traces, notes = traces_of(survey, options)
    focus = Focus(
        permittivity=1.0,
        depth_m=np.asarray(options.depth_m, dtype=np.float64),
        separation_m=options.separation_m,
        ground=options.ground or Ground.LEVEL,
    )
    known, contradictions = permittivity_of(survey, traces, focus, options)
    focus = replace(focus, permittivity=known.permittivity)
    notes = [*notes, *contradictions, *_separation_notes(traces, focus, method)]
    longest_s = _longest_s(traces, focus)
    volumes = [method.image(one, focus, progress) for one in traces]
    coordinates = {
        POLARIZATION: survey[POLARIZATION],
        DEPTH: (DEPTH, focus.depth_m, ATTRIBUTES[DEPTH]),
        Y: survey[Y],
        X: survey[X],
    }
    image = xr.Dataset({IMAGE: ((POLARIZATION, DEPTH, Y, X), np.stack(volumes))}, coordinates)
    image.attrs["depth_resolution_m"] = depth_resolution_m(traces[0].sweep, focus.permittivity)
    if with_echoes:

        def imager(some: Traces) -> np.ndarray:
            return method.image(some, focus, no_progress)

        points = [PointEchoes(one, focus, LONGEST * longest_s) for one in traces]
        image = _with_echoes(image, [one.rotation_deg for one in traces], points, imager)
    return described(image).assign_attrs(
        {
            **with_notes(survey, notes),
            **known.attributes(),
            **_record(options, focus, delay_to_remove_s(survey, options.delay_s)),
            "across_lines": Y if image.sizes[Y] == 1 else X if image.sizes[X] == 1 else "",
            "relief_m": float(np.mean([np.std(one.height_m) for one in traces])),
        }
    )


def _with_echoes(
    image: xr.Dataset,
    rotations_deg: Sequence[float],
    points: Sequence[PointEchoes],
    imager: Imager,
) -> xr.Dataset:
    """Return an image with its echoes, and its clutter.

    Args:
        image: The image.
        rotations_deg: Rotation of each polarization [deg].
        points: Fits points to the traces of each polarization.
        imager: Makes an image like this one of other traces.
    """
    axes_m = [np.asarray(image[name].values, dtype=np.float64) for name in (DEPTH, Y, X)]
    resolution_m = image.attrs["depth_resolution_m"]
    rows, planes = [], []
    for turn_deg, own, volume in zip(rotations_deg, points, image[IMAGE].values):
        found = find_echoes(volume, axes_m, resolution_m, own, imager)
        above_db = decibels(found.magnitude / found.clutter, 0.0)
        level_db = decibels(found.magnitude, 0.0)
        turns_deg = np.full(len(level_db), turn_deg)
        rows.append([turns_deg, *found.place_m.T, above_db, level_db, found.fitted])
        bodies_m = found.place_m[found.fitted]
        clutter = local_clutter(np.abs(volume), axes_m, resolution_m, bodies_m)
        planes.append(np.exp(np.mean(np.log(clutter), axis=(1, 2))))
    echoes = {
        CLUTTER: ((POLARIZATION, DEPTH), np.stack(planes)),
        ECHOES: (("echo", VALUE), np.concatenate(rows, axis=1).T),
    }
    return image.assign(echoes).assign_coords({VALUE: list(ECHO_VALUES)})


def _separation_notes(traces: Sequence[Traces], focus: Focus, method: Method) -> List[Message]:
    """Return a note if the method ignores a separation that moves echoes."""
    height_m = float(np.mean([np.mean(one.height_m) for one in traces]))
    deeper_m = longer_m(height_m, focus.separation_m) / float(np.sqrt(focus.permittivity))
    if method.exact_paths or deeper_m < NOTED_DEPTH_M:
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


def _longest_s(traces: Sequence[Traces], focus: Focus) -> float:
    """Return the delay of the deepest layer after a check that the sweep can measure it [s]."""
    height_m = max(float(np.max(one.height_m)) for one in traces)
    longest_s = float(delay_of_depth(float(focus.depth_m[-1]), height_m, focus.permittivity))
    sweep = traces[0].sweep
    resolution_s = 1.0 / (sweep.step_hz * sweep.count)
    if not resolution_s <= longest_s < sweep.unambiguous_s:
        raise WrongDatasetError(
            Message(
                "echoes of the deepest layer have a delay of {longest_ns:.3g} ns, but this sweep "
                "measures {resolution_ns:.3g} to {unambiguous_ns:.3g} ns; choose another depth, or "
                "measure with more points for longer delays, with a wider band for shorter ones",
                longest_ns=longest_s * 1e9,
                resolution_ns=resolution_s * 1e9,
                unambiguous_ns=sweep.unambiguous_s * 1e9,
            ),
            fault=NOT_ALLOWED,
        )
    return longest_s


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
        "leave_out_missing": options.leave_out_missing,
        "delay_s": delay_s,
    }
    return {"permittivity": focus.permittivity, "method": options.method.name,
            "imaging": json.dumps(record)}  # fmt: skip
