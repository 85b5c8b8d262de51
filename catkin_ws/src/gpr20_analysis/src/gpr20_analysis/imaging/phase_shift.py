"""Phase-shift migration through two layers: air above soil.

Gazdag's wavefield extrapolation with the exploding-reflector model: the spectrum over (kx, ky)
of all traces is moved down through the air and on into the soil by multiplying phases, and the
image is the sum over the frequencies at delay 0. Refraction is exact, because the phase of
each plane wave keeps its horizontal wavenumber across the surface.

It needs a regular grid of positions; one line is enough. Traces of other heights are moved to one
height by the phase of each plane wave, as in back-projection over level ground. That phase depends
on both the place and the wavenumber, so it is interpolated between a few heights, each with a
transform of its own; their number follows from a bound of the error.
"""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import scipy.fft
from numpy.polynomial.chebyshev import chebpts1

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.records import Focus, Traces, reach, weighted_gate
from gpr20_analysis.work import Progress, no_progress, on_threads
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import SPEED_OF_LIGHT_M_S, one_way_delay_s

# Positions are read from axes that count steps of 0.01 mm.
GRID_TOLERANCE = 0.02
# Samples of wavenumber and frequency that are moved down together; they fit a processor's cache.
SAMPLES_AT_ONCE = 60_000
THREADS = 2
# Of the amplitude of a wave of the highest frequency at the widest angle; all others are nearer.
TOLERANCE = 0.03
# Samples whose phases are computed at once where heights differ.
PHASES_AT_ONCE = 250_000


def phase_shift_image(traces: Traces, focus: Focus, progress: Progress = no_progress) -> np.ndarray:
    """Return the complex image (depth, y, x).

    Args:
        traces: Traces on a regular grid or line.
        focus: How to focus.
        progress: Shows the progress.

    Raises:
        WrongDatasetError: The positions do not form a regular grid.
    """
    step_m = _steps_m(traces)
    highest_m = float(np.max(traces.height_m))
    height_m = (highest_m + float(np.min(traces.height_m))) / 2.0
    in_air, in_soil = reach(focus)
    diagonal_m = math.hypot(np.ptp(traces.x_m), np.ptp(traces.y_m))
    reach_m = min(diagonal_m, highest_m * in_air + float(focus.depth_m[-1]) * in_soil)
    deepest_s = one_way_delay_s(highest_m, focus.depth_m[-1], reach_m, focus.permittivity)
    sweep, matrix = weighted_gate(traces.sweep, 2.0 * float(deepest_s), focus.window)
    flat = traces.s21.reshape(-1, traces.sweep.count).astype(np.complex64, copy=False)
    spectra = ((matrix / traces.height_m.size).T @ flat.T).reshape(-1, *traces.height_m.shape)
    # Padding for waves that leave the grid on one side, so that they do not enter on the other.
    rows, columns = (
        scipy.fft.next_fast_len(count + math.ceil(min(reach_m, count * step) / step))
        if count > 1
        else 1
        for count, step in zip(spectra.shape[1:], step_m)
    )
    padded = (rows, columns)
    air_rad_m = 4.0 * np.pi / SPEED_OF_LIGHT_M_S * sweep.frequency_hz
    along_y, along_x = (2.0 * np.pi * scipy.fft.fftfreq(n, d) for n, d in zip(padded, step_m))
    across_rad_m = np.hypot(along_y[:, None], along_x).ravel()
    spectra = _at_one_height(
        spectra, traces.height_m - height_m, padded, air_rad_m, across_rad_m, focus
    )
    image = _focused(spectra, air_rad_m, across_rad_m, height_m, focus, progress)
    image = image.reshape(-1, *padded)
    image = scipy.fft.ifft2(image, workers=THREADS, overwrite_x=True)
    return image[:, : len(traces.y_m), : len(traces.x_m)]


def _focused(
    spectra: np.ndarray,
    air_rad_m: np.ndarray,
    across_rad_m: np.ndarray,
    height_m: float,
    focus: Focus,
    progress: Progress,
) -> np.ndarray:
    """Return the image (depth, wavenumber); the wavenumbers are independent.

    Args:
        spectra: At the height of the antennas (frequency, wavenumber).
        air_rad_m: Two-way wavenumber in air of each frequency [rad/m], ascending.
        across_rad_m: Horizontal wavenumber [rad/m].
        height_m: Height of the antennas [m].
        focus: How to focus.
        progress: Shows the progress.
    """
    image = np.zeros((len(focus.depth_m), len(across_rad_m)), dtype=np.complex64)
    widest = math.sin(math.radians(focus.widest_angle_deg))
    steps_m = np.round(np.diff(focus.depth_m, prepend=focus.depth_m[0]), 9)

    def focus_into(part: np.ndarray) -> None:
        # The frequencies of each wavenumber are adjacent, so a sum over a run of the samples is the
        # sum over its frequencies.
        taken = across_rad_m[part, None] < air_rad_m * widest
        runs = np.concatenate(([0], np.cumsum(np.count_nonzero(taken, axis=1))[:-1]))
        air = np.broadcast_to(air_rad_m, taken.shape)[taken]
        across = np.broadcast_to(across_rad_m[part, None], taken.shape)[taken]
        down_air = np.sqrt(air**2 - across**2)
        down_soil = np.sqrt(focus.permittivity * air**2 - across**2)
        start_rad = down_air * height_m + down_soil * focus.depth_m[0]
        field = spectra[:, part].T[taken] * unit_phasor(start_rad)
        shifts = {0.0: np.ones(1, dtype=np.complex64)}
        for row, step_m in enumerate(steps_m):
            if step_m not in shifts:
                # The latest two are kept: depths may come in pairs.
                shifts = {key: shifts[key] for key in list(shifts)[-1:]}
                shifts[step_m] = unit_phasor(down_soil * step_m)
            field *= shifts[step_m]
            image[row, part] = np.add.reduceat(field, runs)

    counts = np.count_nonzero(across_rad_m < air_rad_m[:, None] * widest, axis=0)
    used = np.flatnonzero(counts)
    part_of = np.cumsum(counts[used]) // SAMPLES_AT_ONCE
    parts = np.split(used, np.flatnonzero(np.diff(part_of)) + 1) if used.size else []
    on_threads(focus_into, parts, progress)
    return image


def _steps_m(traces: Traces) -> Tuple[float, float]:
    """Return the steps along Y and X [m]; the axis across a line has that of the line.

    The waves of a line are taken to travel below it: its image is that of a vertical plane.

    Raises:
        WrongDatasetError: The positions along an axis are not evenly spaced, or there is only one.
    """
    axes = {"y": traces.y_m, "x": traces.x_m}
    found = {}
    for axis, position_m in axes.items():
        count = len(position_m)
        step_m = float(position_m[-1] - position_m[0]) / max(count - 1, 1)
        off_m = np.max(np.abs(position_m - position_m[0] - step_m * np.arange(count)))
        is_across = count == 1 < max(map(len, axes.values()))
        if not is_across and not (step_m > 0.0 and off_m <= GRID_TOLERANCE * step_m):
            raise WrongDatasetError(
                Message(
                    "the {count} positions along {axis} are not two or more, evenly spaced and "
                    "ascending: they differ by up to {off_mm:g} mm at a step of {step_mm:g} mm; "
                    "use --method back-projection",
                    count=count,
                    axis=axis,
                    off_mm=off_m * MM_PER_M,
                    step_mm=step_m * MM_PER_M,
                ),
                fault=NOT_ALLOWED,
            )
        found[axis] = step_m
    return found["y"] or found["x"], found["x"] or found["y"]


def _at_one_height(
    spectra: np.ndarray,
    higher_m: np.ndarray,
    padded: Tuple[int, int],
    air_rad_m: np.ndarray,
    across_rad_m: np.ndarray,
    focus: Focus,
) -> np.ndarray:
    """Return the spectra over wavenumber (frequency, wavenumber) at the middle height.

    Waves beyond the widest angle may be 0.

    Each plane wave of each trace gets the phase of its way from the height of the trace to the
    middle height: exp(i kz d), with kz the vertical wavenumber. Over the heights d of the traces
    that is interpolated by a polynomial through its values at Chebyshev points. Before that, the
    phase at the middle of all kz is taken out, because it is the same for all wavenumbers.

    Args:
        spectra: Spectra of the traces (frequency, y, x); may be overwritten.
        higher_m: How much higher than the middle each trace is (y, x) [m].
        padded: Size of the transform along Y and X.
        air_rad_m: Two-way wavenumber in air of each frequency [rad/m].
        across_rad_m: Horizontal wavenumber over the flat transform [rad/m].
        focus: How to focus.
    """
    cosine = math.cos(math.radians(focus.widest_angle_deg))
    most_m = float(np.max(np.abs(higher_m)))
    count = points_needed(most_m * float(air_rad_m[-1]) * (1.0 - cosine) / 2.0)
    middle_rad_m = air_rad_m * (1.0 + cosine) / 2.0 if count > 1 else air_rad_m
    if most_m > 0.0:
        spectra *= unit_phasor(middle_rad_m[:, None, None] * higher_m)
    if count == 1:
        return _transform(spectra, padded)
    points_m = most_m * chebpts1(count)
    # Of Lagrange's polynomials: the share of each point at each place.
    weights = [
        np.prod([(higher_m - one) / (own - one) for one in np.delete(points_m, index)], axis=0)
        for index, own in enumerate(points_m)
    ]
    found = np.zeros((len(spectra), len(across_rad_m)), dtype=np.complex64)
    widest = math.sin(math.radians(focus.widest_angle_deg))
    at_once = max(1, PHASES_AT_ONCE // len(across_rad_m))
    for start in range(0, len(spectra), at_once):
        part = slice(start, start + at_once)
        used = np.flatnonzero(across_rad_m < air_rad_m[part][-1] * widest)
        square = air_rad_m[part, None] ** 2 - across_rad_m[used] ** 2
        down = np.sqrt(np.maximum(square, 0.0)) - middle_rad_m[part, None]
        moved = np.zeros(down.shape, dtype=np.complex64)
        turns = [unit_phasor(down * point_m) for point_m in points_m[: count // 2]]
        # The points are symmetric, and one in the middle has no phase.
        middle = [np.ones((1, 1), dtype=np.complex64)] * (count % 2)
        turns = [*turns, *middle, *(turn.conj() for turn in reversed(turns))]
        for weight, turn in zip(weights, turns):
            moved += _transform(spectra[part] * weight.astype(np.float32), padded)[:, used] * turn
        found[part, used] = moved
    return found


def points_needed(most_rad: float) -> int:
    """Return how many points interpolate exp(i phase) for phases up to +- most, to the tolerance.

    The error of Chebyshev interpolation of degree n - 1 is at most most^n / (2^(n-1) n!).
    """
    count, error = 1, most_rad
    while error > TOLERANCE:
        count += 1
        error *= most_rad / (2.0 * count)
    return count


def _transform(spectra: np.ndarray, padded: Tuple[int, int]) -> np.ndarray:
    flat: np.ndarray = scipy.fft.fft2(spectra, s=padded, workers=THREADS)
    return flat.reshape(len(spectra), -1)


def unit_phasor(phase_rad: np.ndarray) -> np.ndarray:
    """Return exp(1j phase) in single precision, the phase taken modulo a turn in double."""
    small = np.remainder(phase_rad, 2.0 * np.pi).astype(np.float32)
    phasor = np.empty(small.shape, dtype=np.complex64)
    np.cos(small, out=phasor.real)
    np.sin(small, out=phasor.imag)
    return phasor
