"""The image of a survey: every polarization by one method, and a record of how it was made."""

from __future__ import annotations

import enum
import json
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis import lazy
from gpr20_analysis.dataset import (
    ATTRIBUTES,
    DEPTH,
    IMAGE,
    MM_PER_M,
    NAMED,
    POLARIZATION,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    missing_samples,
    require,
    require_complete,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.focus_estimate import PermittivityEstimate, estimate_permittivity
from gpr20_analysis.imaging.kirchhoff import kirchhoff_image
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.processing.delay import ADVANCE, known_height
from gpr20_analysis.processing.polarization import DISPLAY_ONLY
from gpr20_analysis.processing.samples import FILLED
from gpr20_analysis.processing.sweep import FrequencyGrid, Window
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.sentences import first_of, sentence_of, with_notes
from gpr20_common.message import Message

# Height differences of level ground, by the noise of the height sensor.
NOTED_RELIEF_M = 0.01
# Spectra as measured, without missing samples, and in single precision while they are gated.
COPIES = 2.5
Volume = Tuple[np.ndarray, np.ndarray]
"""Image (depth, y, x) of one polarization and its depths [m]."""


class Method(enum.Enum):
    """How an image is computed."""

    PHASE_SHIFT = "phase-shift"
    BACK_PROJECTION = "back-projection"
    KIRCHHOFF = "kirchhoff"
    KIRCHHOFF_2D = "kirchhoff-2d"


@dataclass(frozen=True)
class ImageOptions:
    """The options of an image.

    Attributes:
        method: How the image is computed.
        permittivity: Relative permittivity of the soil; None: estimate it by focus.
        depth_m: Depths [m], ascending.
        height_m: One antenna height for all traces instead of the recorded ones [m].
        leave_out_missing: Make the image without the missing samples, instead of refusing.
        window: Weights over the band.
        widest_angle_deg: Widest angle to the vertical in air.
        separation_m: Distance between the antennas [m]; back-projection alone uses it.
        ground: Why the recorded heights differ; back-projection alone knows uneven ground.
    """

    method: Method = Method.PHASE_SHIFT
    permittivity: Optional[float] = None
    depth_m: Tuple[float, ...] = tuple(np.round(np.arange(0.0, 0.3001, 0.003), 6))
    height_m: Optional[float] = None
    leave_out_missing: bool = False
    window: Window = Window.HANN
    widest_angle_deg: float = 70.0
    separation_m: float = 0.0
    ground: Ground = Ground.LEVEL

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            WrongDatasetError: A value is not allowed.
        """
        depth_m = np.asarray(self.depth_m, dtype=np.float64)
        if depth_m.size < 2 or not np.all(np.diff(depth_m) > 0.0) or not depth_m[0] >= 0.0:
            raise WrongDatasetError(
                Message(
                    "the depths are {depths} m; they must be two or more, ascending, not negative",
                    depths=", ".join(f"{one:g}" for one in depth_m[:5]) or "-",
                )
            )
        _check(Message("the permittivity"), self.permittivity, 1.0, 100.0)
        _check(Message("the antenna height"), self.height_m, 0.001, 10.0, "m")
        _check(Message("the widest angle"), self.widest_angle_deg, 5.0, 89.0, "deg")
        _check(Message("the antenna separation"), self.separation_m, 0.0, 2.0, "m")
        if self.ground is Ground.UNEVEN and self.method is not Method.BACK_PROJECTION:
            raise WrongDatasetError(
                Message(
                    "the method {method} assumes level ground; uneven ground needs --method "
                    "{other}",
                    method=self.method.value,
                    other=Method.BACK_PROJECTION.value,
                )
            )


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


def traces_of(survey: xr.Dataset, options: ImageOptions) -> Tuple[List[Traces], List[Message]]:
    """Return the traces of each polarization, and notes on them.

    Raises:
        WrongDatasetError: The data are not spectra, or were changed for display.
        DamagedSurveyError: Samples or heights are missing, and that was not allowed.
    """
    changed = sentence_of(survey, DISPLAY_ONLY)
    if changed is not None:
        raise WrongDatasetError(
            Message(
                "the data were changed for display ({reason}), so no image can be made of them",
                reason=changed,
            )
        )
    recorded = require(survey, S21, S21_DIMS)
    lazy.require_room(recorded, COPIES, Message("an image"))
    measured = recorded.values
    present = usable(survey).transpose(*SAMPLE_DIMS).values & np.all(np.isfinite(measured), -1)
    if not options.leave_out_missing:
        require_complete(survey, Message("an image without --leave-out-missing"))
        if not np.all(present):
            raise WrongDatasetError(
                Message(
                    "{count} samples that are marked as good contain NaN from an earlier step; "
                    "check the recipe",
                    count=np.count_nonzero(~present),
                )
            )
    height_m = _heights(survey, options, present)
    sweep = FrequencyGrid.of(survey)
    spectra = np.where(present[..., None], measured, 0.0)
    if ADVANCE in survey:
        advance = np.nan_to_num(survey[ADVANCE].transpose(*SAMPLE_DIMS).values)
        spectra *= np.exp(-2j * np.pi * sweep.frequency_hz * advance[..., None])
    turns = survey[POLARIZATION].values
    x_m, y_m = (np.asarray(survey[name].values, dtype=np.float64) for name in (X, Y))
    traces = [
        Traces(spectra[turn], sweep, x_m, y_m, height_m[turn], float(turns[turn]))
        for turn in range(len(turns))
    ]
    for one in traces:
        if not np.any(one.s21):
            raise WrongDatasetError(
                Message(
                    "every trace at {rotation_deg:g} deg is zero, so no echo can be seen; check "
                    "the steps: the background of a single trace is the trace itself",
                    rotation_deg=one.rotation_deg,
                )
            )
    return traces, [*_notes(survey, present), *_uneven_notes(height_m, options)]


def _heights(survey: xr.Dataset, options: ImageOptions, present: np.ndarray) -> np.ndarray:
    if options.height_m is not None:
        return np.full(present.shape, options.height_m)
    height_m = known_height(survey).values
    if not np.any(present):
        raise WrongDatasetError(Message("no sample is usable, so there is nothing to image"))
    # A sample that is left out adds nothing, so its height does not matter.
    return np.where(present, height_m, float(np.mean(height_m[present])))


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


def _notes(survey: xr.Dataset, present: np.ndarray) -> List[Message]:
    notes = []
    absent = int(np.count_nonzero(~present))
    if absent:
        notes.append(
            Message(
                "{count} of {total} samples were left out of the image ({samples})",
                count=absent,
                total=present.size,
                samples=first_of(missing_samples(survey), NAMED),
            )
        )
    if FILLED in survey and bool(survey[FILLED].any()):
        notes.append(
            Message(
                "{count} samples of the image were not measured but interpolated",
                count=int(survey[FILLED].sum()),
            )
        )
    return notes


def _uneven_notes(height_m: np.ndarray, options: ImageOptions) -> List[Message]:
    range_m = float(np.ptp(height_m))
    if options.ground is Ground.UNEVEN or range_m <= NOTED_RELIEF_M:
        return []
    return [
        Message(
            "the recorded heights differ by {range_mm:.0f} mm, but the image assumes level ground; "
            "if the ground is uneven, echoes are misplaced: use --method back-projection --ground "
            "uneven",
            range_mm=MM_PER_M * range_m,
        )
    ]


def _estimate_attributes(estimate: PermittivityEstimate) -> Dict[str, object]:
    return {
        "permittivity_source": "estimated by focus",
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


def _check(
    name: Message, value: Optional[float], lowest: float, highest: float, unit: str = ""
) -> None:
    # Written so that NaN is refused too.
    if value is not None and not lowest <= value <= highest:
        raise WrongDatasetError(
            Message(
                "{name} is {value}; it must lie between {lower} and {upper}",
                name=name,
                value=f"{value:g} {unit}".rstrip(),
                lower=f"{lowest:g}",
                upper=f"{highest:g} {unit}".rstrip(),
            )
        )
