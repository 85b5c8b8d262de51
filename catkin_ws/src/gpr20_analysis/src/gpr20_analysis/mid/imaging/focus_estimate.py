"""The permittivity of the soil, estimated from how sharply the image focuses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.mid.imaging.phase_shift import phase_shift_image
from gpr20_analysis.mid.imaging.records import Focus, Traces

# Soils that such surveys meet, from dry sand to wet clay.
LOWEST, HIGHEST = 2.0, 16.0
TRIALS = 13
# The estimate could be anything within which the image is nearly as sharp.
NEARLY_AS_SHARP = 0.97
TOLERANCE = 0.01


@dataclass(frozen=True)
class PermittivityEstimate:
    """A permittivity and how well it is known.

    Attributes:
        permittivity: Where the image is sharpest.
        lowest: The image is nearly as sharp (97 %) down to here.
        highest: The same upwards.
    """

    permittivity: float
    lowest: float
    highest: float


def estimate_permittivity(traces: Sequence[Traces], focus: Focus) -> PermittivityEstimate:
    """Search the permittivity at which the echoes focus best.

    Sharpness is the mean of the fourth power over the square of the mean of the second power of
    the magnitude, which is large when few voxels hold the energy. Trials image equal optical
    depths, so they compare the same part of the traces.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: How to focus; its permittivity only fixes the optical depths.

    Raises:
        WrongDatasetError: The image only grows sharper towards the end of the range, so nothing
            in it says what the permittivity is.
    """
    optical_m = focus.depth_m * np.sqrt(focus.permittivity)

    def sharpness(logarithm: float) -> float:
        permittivity = float(np.exp(logarithm))
        trial = replace(focus, permittivity=permittivity, depth_m=optical_m / np.sqrt(permittivity))
        return sum(_sharpness(phase_shift_image(one, trial)) for one in traces)

    logarithms = np.linspace(np.log(LOWEST), np.log(HIGHEST), TRIALS)
    values = np.array([sharpness(one) for one in logarithms])
    best = int(np.argmax(values))
    if best in (0, TRIALS - 1):
        raise WrongDatasetError(
            f"the image is sharpest at the end of the range, permittivity "
            f"{np.exp(logarithms[best]):.3g}; the data do not say what it is: give it by option"
        )
    found = minimize_scalar(
        lambda logarithm: -sharpness(logarithm),
        bounds=(logarithms[best - 1], logarithms[best + 1]),
        method="bounded",
        options={"xatol": TOLERANCE},
    )
    limit = -NEARLY_AS_SHARP * float(found.fun)
    return PermittivityEstimate(
        float(np.exp(found.x)),
        float(np.exp(_crossing(logarithms[: best + 1], values[: best + 1], found.x, limit))),
        float(np.exp(_crossing(logarithms[best:][::-1], values[best:][::-1], found.x, limit))),
    )


def _sharpness(image: np.ndarray) -> float:
    power = image.real**2 + image.imag**2
    total = float(np.sum(power, dtype=np.float64))
    if total == 0.0:
        raise WrongDatasetError("the image is zero everywhere; nothing can be focused in it")
    return power.size * float(np.sum(np.square(power, dtype=np.float64))) / total**2


def _crossing(logarithms: np.ndarray, values: np.ndarray, best: float, limit: float) -> float:
    """Return where the values, which rise towards the best, pass the limit."""
    below = np.flatnonzero(values < limit)
    if below.size == 0:
        return float(logarithms[0])
    last = int(below[-1])
    if last + 1 == len(values):
        return best
    share = (limit - values[last]) / (values[last + 1] - values[last])
    return float(logarithms[last] + share * (logarithms[last + 1] - logarithms[last]))
