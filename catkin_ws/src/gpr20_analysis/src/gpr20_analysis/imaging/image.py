"""The image of a survey: every polarization by one method, and a record of how it was made."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Dict, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis.dataset import ATTRIBUTES, DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.kirchhoff import kirchhoff_image
from gpr20_analysis.imaging.permittivity_estimate import PermittivityEstimate, estimate_permittivity
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.sentences import with_notes
from gpr20_common.message import Message

Volume = Tuple[np.ndarray, np.ndarray]
"""Image (depth, y, x) of one polarization and its depths [m]."""


def image_survey(
    survey: xr.Dataset, options: ImageOptions, progress: Progress = no_progress
) -> xr.Dataset:
    """Return the image of a survey.

    Args:
        survey: Dataset with `s21`, without coupling and surface echo.
        options: How the image is made.
        progress: Shows which polarization is imaged.

    Returns:
        Dataset with `image` (polarization, depth, y, x), complex (real for the Kirchhoff
        methods), and attributes that describe how it was made and what was left out.

    Raises:
        WrongDatasetError: The data cannot be imaged by this method.
        DamagedSurveyError: Samples or heights are missing, and that was not allowed.
    """
    traces, notes = traces_of(survey, options)
    focus = Focus(
        permittivity=options.permittivity or 4.0,
        depth_m=np.asarray(options.depth_m, dtype=np.float64),
        window=options.window,
        widest_angle_deg=options.widest_angle_deg,
        separation_m=options.separation_m,
        ground=options.ground,
    )
    attributes: Dict[str, object] = {"permittivity_source": "given"}
    if options.permittivity is None:
        estimate = estimate_permittivity(traces, focus)
        focus = replace(focus, permittivity=estimate.permittivity)
        attributes = _estimate_attributes(estimate)
        notes = [*notes, *estimate.notes]
    _check_unambiguous(traces, focus)
    volumes = [_volume(one, focus, options.method) for one in progress(traces, len(traces))]
    coordinates = {
        POLARIZATION: survey[POLARIZATION],
        DEPTH: (DEPTH, volumes[0][1], ATTRIBUTES[DEPTH]),
        Y: survey[Y],
        X: survey[X],
    }
    values = np.stack([volume for volume, _ in volumes])
    image = xr.Dataset({IMAGE: ((POLARIZATION, DEPTH, Y, X), values)}, coordinates)
    image[IMAGE].attrs.update(units="1", long_name="image")
    described = with_notes(survey, notes)
    return image.assign_attrs({**described, **attributes, **_record(options, focus)})


def _check_unambiguous(traces: Sequence[Traces], focus: Focus) -> None:
    height_m = max(float(np.max(one.height_m)) for one in traces)
    path_m = height_m + float(focus.depth_m[-1]) * np.sqrt(focus.permittivity)
    longest_s, unambiguous_s = 2.0 * path_m / speed_of_light, traces[0].sweep.unambiguous_s
    if longest_s >= unambiguous_s:
        raise WrongDatasetError(
            Message(
                "echoes of the deepest layer have a delay of {longest_s:.3g} s, but a frequency "
                "step of {step_hz:g} Hz allows only {unambiguous_s:.3g} s; choose a smaller depth, "
                "or measure with more points",
                longest_s=longest_s,
                step_hz=traces[0].sweep.step_hz,
                unambiguous_s=unambiguous_s,
            )
        )
    band_hz = traces[0].sweep.step_hz * traces[0].sweep.count
    if longest_s * band_hz < 1.0:
        raise WrongDatasetError(
            Message(
                "a band of {band_hz:g} Hz resolves delays of {resolution_s:.3g} s, but the whole "
                "image covers {longest_s:.3g} s, so no echo can be seen; use a wider band",
                band_hz=band_hz,
                resolution_s=1.0 / band_hz,
                longest_s=longest_s,
            )
        )


def _volume(traces: Traces, focus: Focus, method: Method) -> Volume:
    if method is Method.BACK_PROJECTION:
        return back_projection_image(traces, focus), focus.depth_m
    if method is Method.PHASE_SHIFT:
        return phase_shift_image(traces, focus), focus.depth_m
    along = "x" if method is Method.KIRCHHOFF_2D else "xy"
    return kirchhoff_image(traces, focus, along)


def _estimate_attributes(estimate: PermittivityEstimate) -> Dict[str, object]:
    return {
        "permittivity_source": "estimated from echoes",
        "permittivity_lowest": estimate.lowest,
        "permittivity_highest": estimate.highest,
        "depth_uncertainty": estimate.depth_uncertainty,
    }


def _record(options: ImageOptions, focus: Focus) -> Dict[str, object]:
    record = {
        "method": options.method.value,
        "permittivity": focus.permittivity,
        "window": focus.window.value,
        "widest_angle_deg": focus.widest_angle_deg,
        "separation_m": focus.separation_m,
        "ground": focus.ground.value,
        "height_m": options.height_m,
        "leave_out_missing": options.leave_out_missing,
    }
    return {"permittivity": focus.permittivity, "method": options.method.value,
            "imaging": json.dumps(record)}  # fmt: skip
