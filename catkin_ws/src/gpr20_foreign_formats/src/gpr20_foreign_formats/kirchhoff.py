"""Kirchhoff migration as the GPR-20 group publishes it: a compatibility mode.

It repeats the group's program (repository gdh-uniandes/GPR-Uniandes, folder APP-Procesamiento),
with all its properties, so that its images can be compared. Use the phase shift or the
back-projection for everything else. The properties:

- A-scans: Hamming window over the band; zeros below the band, so that the first frequency moves
  down to a multiple of the step; the mirror image of the spectrum repeats the sample at 0 Hz, so
  the real part, which alone is used, carries half a period of a cosine over the trace.
- Time: samples before the first time that is not below 0 are dropped. Rounding puts that of
  sample 0 just below 0 for about half of the sweeps (the 501 points of the GPR-20, for one); then
  the first sample is lost and every echo comes a sample too early. This is the cause of the depths
  that are 5 to 6 mm too small at permittivity 4. The sample time follows from the last time, which
  the file name holds in steps of 0.1 ns.
- An intended half derivative acts along the line instead of the time, so it is a gain over time.
- The mean height for all traces, one permittivity, antennas in one place, 3e8 m/s.
- The nearest of 256 angles in the soil, the nearest sample.
- Weight cos(angle in air) / sqrt(length of the path); trapezoidal sum over the line; magnitude.
- "Three-dimensional" is the product of the lines along X and the lines along Y: an echo must be
  bright in both, and amplitudes are products.
- Depths from the first on, in steps of the sample time times the speed in the soil, which is two
  samples of two-way time; the last depth is left out.

The group stores A-scans in single precision; that rounding alone is not repeated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import List, Tuple

import numpy as np
import scipy.fft

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.methods import Method, Positions, Volume
from gpr20_analysis.imaging.phase_shift import grid_step_m
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.progress import Progress
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.frequency_to_delay import Window

# The rounded value of the group's program.
SPEED_M_S = 3e8
ANGLES = 256
LINES_AT_ONCE = 4
S_PER_US = 1e-6
# Decimals of the last time in the names of the group's files [us].
NAME_DECIMALS = 4


@dataclass(frozen=True)
class GroupTime:
    """The time axis of the group's A-scans.

    Attributes:
        zeros: Number of zeros below the band.
        dropped: Number of samples dropped at the start.
        count: Number of samples left.
        step_s: Time between two samples, as the group's transform knows it [s].
        sample_s: The same, as the group's migration reads it from a file name [s].
    """

    zeros: int
    dropped: int
    count: int
    step_s: float
    sample_s: float

    @classmethod
    def of(cls, sweep: FrequencyGrid) -> GroupTime:
        """Return the time axis for a sweep."""
        stop_hz = sweep.start_hz + sweep.step_hz * (sweep.count - 1)
        zeros, half = 0, sweep.count
        if sweep.start_hz > 0.0:
            padded_hz = np.arange(0.0, stop_hz, sweep.step_hz)
            zeros, half = int(np.argmax(padded_hz >= sweep.start_hz)) - 1, len(padded_hz)
        step_s = 1.0 / (2 * half * sweep.step_hz)
        # Which sample counts as the first depends on the rounding of this very expression.
        time_s = np.arange(-half * step_s, (2 * half - 1) * step_s / 2, step_s)
        first = int(np.argmax(time_s >= 0.0))
        length = zeros + sweep.count
        count = 2 * length - first
        last_s = round(float(time_s[-1]) / S_PER_US, NAME_DECIMALS) * S_PER_US
        return cls(zeros, first - length, count, step_s, last_s / (count - 1))


def kirchhoff_image(
    traces: Traces, focus: Focus, along: str = "xy"
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the image (depth, y, x), real and not negative, and its depths [m].

    Args:
        traces: Traces on a regular grid.
        focus: Permittivity, and the first and last depth; the step follows from the sweep.
        along: "x": lines along X alone (2D); "y": along Y alone; "xy": the product (2.5D).

    Raises:
        WrongDatasetError: The depth range is smaller than the step of this method, or the
            positions do not form a regular grid.
    """
    for axis, place_m in (("x", traces.x_m), ("y", traces.y_m)):
        if axis in along:
            grid_step_m(place_m, axis)
    a_scans, sample_s = _real_a_scans(traces)
    speed_m_s = SPEED_M_S / np.sqrt(focus.permittivity)
    step_m = sample_s * speed_m_s
    depth_m = np.arange(focus.depth_m[0], focus.depth_m[-1], step_m)
    if len(depth_m) < 2:
        raise WrongDatasetError(
            Message(
                "the depths {first_m:g} to {last_m:g} m are less than the depth step of this "
                "method, {step_m:.3g} m; choose a larger range",
                first_m=focus.depth_m[0],
                last_m=focus.depth_m[-1],
                step_m=step_m,
            ),
            fault=NOT_ALLOWED,
        )
    height_m = float(np.mean(traces.height_m))
    image = np.ones((len(depth_m), *traces.height_m.shape))

    def lines(a_scans: np.ndarray, place_m: np.ndarray) -> np.ndarray:
        # Some lines at once, so that the parts of their sums stay small.
        bundles = np.split(a_scans, range(LINES_AT_ONCE, len(a_scans), LINES_AT_ONCE))
        own = (place_m, height_m, depth_m, sample_s, focus.permittivity)
        return np.concatenate([_lines(*own, bundle) for bundle in bundles], axis=1)

    if "x" in along:
        image *= lines(a_scans, traces.x_m)
    if "y" in along:
        image *= np.swapaxes(lines(np.swapaxes(a_scans, 0, 1), traces.y_m), 1, 2)
    return image, depth_m


def shallow_notes(sweep: FrequencyGrid, permittivity: float) -> List[Message]:
    """Return a note if the group's time axis makes the depths too small for this sweep."""
    time = GroupTime.of(sweep)
    if time.dropped == 0:
        return []
    early_m = time.dropped * time.step_s * SPEED_M_S / np.sqrt(permittivity) / 2.0
    return [
        Message(
            "this method repeats the GPR-20 group's program, which drops the first time sample of "
            "this sweep: echoes appear about {early_mm:.0f} mm too shallow",
            early_mm=MM_PER_M * early_m,
        )
    ]


def _real_a_scans(traces: Traces) -> Tuple[np.ndarray, float]:
    """Return real A-scans (y, x, delay) with the gain over time, and their sample time [s]."""
    time, count = GroupTime.of(traces.sweep), traces.sweep.count
    spectra = np.zeros((*traces.height_m.shape, 2 * (time.zeros + count)), dtype=np.complex128)
    measured = traces.s21 * np.hamming(count)
    spectra[..., time.zeros : time.zeros + count] = measured
    spectra[..., time.zeros + count : time.zeros + 2 * count] = measured[..., ::-1].conj()
    a_scans = scipy.fft.ifft(spectra, axis=-1, workers=2, overwrite_x=True).real
    a_scans = a_scans[..., time.dropped : time.dropped + time.count]
    misplaced_hz = np.linspace(-0.5 / time.sample_s, 0.5 / time.sample_s, time.count)
    return a_scans * np.sqrt(np.pi * np.abs(misplaced_hz)), time.sample_s


def _lines(
    place_m: np.ndarray,
    height_m: float,
    depth_m: np.ndarray,
    sample_s: float,
    permittivity: float,
    a_scans: np.ndarray,
) -> np.ndarray:
    """Migrate each line (line, position, delay) separately; return (depth, line, position)."""
    places = np.arange(len(place_m))
    offset_m = np.abs(place_m[:, None] - place_m[None, :])
    speed_m_s = SPEED_M_S / np.sqrt(permittivity)
    image = np.empty((len(depth_m), *a_scans.shape[:2]))
    for row, depth in enumerate(depth_m):
        angle_air, angle_soil = _angles(offset_m, height_m, depth, permittivity)
        air_m, soil_m = height_m / np.cos(angle_air), depth / np.cos(angle_soil)
        sample = np.rint(2.0 * (air_m / SPEED_M_S + soil_m / speed_m_s) / sample_s)
        sample = np.minimum(sample.astype(np.int64), a_scans.shape[2] - 1)
        weight = np.cos(angle_air) / np.sqrt(air_m + soil_m + 1e-9)
        kernel = weight * a_scans[:, places[None, :], sample]
        between = (kernel[:, :, 1:] + kernel[:, :, :-1]) / 2.0
        image[row] = np.abs(np.sum(between * np.diff(place_m), axis=2))
    return image


def _angles(
    offset_m: np.ndarray, height_m: float, depth_m: float, permittivity: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the angles to the vertical in air and soil, the best of a fixed set [rad]."""
    in_soil = np.linspace(0.0, np.pi / 2.0, ANGLES)
    in_air = np.arcsin(np.minimum(np.sqrt(permittivity) * np.sin(in_soil), 1.0))
    reached_m = depth_m * np.tan(in_soil) + height_m * np.tan(in_air)
    best = np.argmin(np.abs(offset_m[..., None] - reached_m), axis=-1)
    return in_air[best], in_soil[best]


def _two_lines(traces: Traces, focus: Focus, at: Positions, progress: Progress) -> Volume:
    return kirchhoff_image(traces, focus, "xy")


def _one_line(traces: Traces, focus: Focus, at: Positions, progress: Progress) -> Volume:
    return kirchhoff_image(traces, focus, "x")


# The group's program has its own window, and subtracts the mean.
KIRCHHOFF = Method(
    "kirchhoff",
    _two_lines,
    is_linear=False,
    factors=2,
    own_window=Window.HAMMING,
    any_positions=False,
    default_steps=("background:method=mean",),
    notes=shallow_notes,
)
KIRCHHOFF_2D = replace(KIRCHHOFF, name="kirchhoff-2d", image=_one_line, factors=1, lines_alone=True)
