"""The permittivity of the soil, estimated from the shape of echoes.

The delay of an echo grows with the distance of the antennas, the more slowly the lower the
permittivity and the larger the body. Each echo that is clearly above noise is compared with
spheres, points and discs of all sizes in soil of each permittivity (`echo_fit`). A permittivity is
compatible with the data if some body explains them nearly as well as the best one does. The
reported range holds all compatible values. It is a 95 % range: the difference of the log
likelihoods, with the measured noise and what the best body leaves unexplained, is below that which
chance exceeds in 5 % of cases. Where the data leave too much open, the estimate is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import List, Sequence, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.permittivity.echo_cells import Cells, cells_around
from gpr20_analysis.imaging.permittivity.echo_fit import PERMITTIVITIES, EchoFit, fit_echo
from gpr20_analysis.imaging.permittivity.echo_search import Apex, find_apexes, noise_power
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_common.message import Message
from gpr20_survey.radar.depth import one_way_path_m

# Of the log likelihood, for one unknown: half of the 95 % quantile of chi-squared.
COMPATIBLE = 1.92
# Sums of noise alone stay below both: the largest of thousands is 10 dB above its median.
ABOVE_NOISE_DB = 15.0
ABOVE_CLUTTER_DB = 13.0
# An echo that leaves more of its energy unexplained is not that of one compact body.
MOST_LEFT_OVER = 0.1
# Depths are then known to a factor of 1.5.
WIDEST_RATIO = 2.25
# Bodies at the depths of the image are searched in soil of up to this permittivity.
SEARCHED_PERMITTIVITY = 9.0
SAME_BODY_M = 0.06
# Steps from one trial value of the permittivity to the next.
BETWEEN = 6
# Of the unambiguous range of delays; the rest shows the noise.
SEARCHED_SHARE = 0.55
_LEVEL_BODIES = Message(
    "the permittivity is estimated from the shape of echoes: a level body, as many mines are, "
    "looks like a smaller one in soil of a lower permittivity, so depths may be too large; measure "
    "the permittivity and give it"
)
_ONE_LINE = Message(
    "the survey is a single line: the permittivity range is valid only if no long object crosses "
    "the line at a slant"
)


@dataclass(frozen=True)
class PermittivityEstimate:
    """A permittivity and how well it is known.

    Attributes:
        permittivity: Mean of the compatible values, by their likelihood.
        lowest: Lowest compatible value (95 % range).
        highest: Highest compatible value.
        bodies: Number of bodies whose echoes were used.
        notes: What the range assumes.
    """

    permittivity: float
    lowest: float
    highest: float
    bodies: int
    notes: Tuple[Message, ...] = ()

    @property
    def depth_uncertainty(self) -> float:
        """Relative uncertainty of depths, which scale with 1 / sqrt(permittivity)."""
        return max(
            np.sqrt(self.permittivity / self.lowest) - 1.0,
            1.0 - np.sqrt(self.permittivity / self.highest),
        )


def estimate_permittivity(traces: Sequence[Traces], focus: Focus) -> PermittivityEstimate:
    """Estimate the permittivity from all echoes that are clearly above noise.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: Window, antenna separation and the range of depths; its permittivity is not used.

    Raises:
        WrongDatasetError: The data do not determine the permittivity.
    """
    echoes = [echo for one in traces for echo in _clear_echoes(one, focus)]
    if not echoes:
        raise WrongDatasetError(
            Message(
                "no echo is clearly above noise and clutter, so the permittivity cannot be "
                "estimated; {advice}",
                advice=_advice(),
            ),
            fault=faults.NO_PERMITTIVITY,
        )
    fits = [fit for fit in (fit_echo(*echo) for echo in echoes) if fit is not None]
    fits = [fit for fit in fits if fit.left_over <= MOST_LEFT_OVER]
    if not fits:
        raise WrongDatasetError(
            Message(
                "{count} echoes are above noise, but none has the shape of the echo of one compact "
                "body, so the permittivity cannot be estimated; {advice}",
                count=len(echoes),
                advice=_advice(),
            ),
            fault=faults.NO_PERMITTIVITY,
        )
    estimate = _range_of(_of_same_body(fits))
    one_line = all(min(len(one.x_m), len(one.y_m)) == 1 for one in traces)
    return replace(estimate, notes=(_LEVEL_BODIES, *((_ONE_LINE,) if one_line else ())))


def _advice() -> Message:
    return Message(
        "give the permittivity: measure it with a soil probe, or bury a metal object at a known "
        "depth and choose the value that shows it there"
    )


def _clear_echoes(traces: Traces, focus: Focus) -> List[Tuple[Cells, Apex, float]]:
    deepest_m = float(focus.depth_m[-1]) * np.sqrt(SEARCHED_PERMITTIVITY)
    height_m = float(traces.height_m.max())
    unambiguous_m = one_way_path_m(traces.sweep.unambiguous_s)
    deepest_m = min(deepest_m, SEARCHED_SHARE * unambiguous_m - height_m)
    noise = noise_power(traces, focus, deepest_m)
    return [
        (cells_around(traces, focus, apex), apex, noise)
        for apex in find_apexes(traces, focus, deepest_m)
        if apex.level >= 10.0 ** (ABOVE_NOISE_DB / 20.0) * np.sqrt(noise)
        and apex.level >= 10.0 ** (ABOVE_CLUTTER_DB / 20.0) * apex.clutter
    ]


def _of_same_body(fits: Sequence[EchoFit]) -> List[np.ndarray]:
    """Return how much worse each permittivity is, one item per body.

    Both polarizations see the same body with the same errors of the model, so they count as one.
    """
    bodies: List[List[EchoFit]] = []
    for fit in fits:
        for body in bodies:
            if np.hypot(body[0].x_m - fit.x_m, body[0].y_m - fit.y_m) < SAME_BODY_M:
                body.append(fit)
                break
        else:
            bodies.append([fit])
    return [np.mean([fit.worse for fit in body], axis=0) for body in bodies]


def _range_of(bodies: Sequence[np.ndarray]) -> PermittivityEstimate:
    from scipy.interpolate import PchipInterpolator  # its import takes 0.2 s

    # Monotonic between the trial values: a spline would be below them beside a steep rise.
    logarithm = np.log(PERMITTIVITIES)
    fine = np.linspace(logarithm[0], logarithm[-1], BETWEEN * (len(logarithm) - 1) + 1)
    worse = PchipInterpolator(logarithm, np.sum(bodies, axis=0))(fine)
    least = float(worse.min())
    # Bodies that contradict each other by more than the model allows widen the range.
    contradiction = max(1.0, least / max(len(bodies) - 1, 1))
    worse = (worse - least) / contradiction
    compatible = np.flatnonzero(worse <= COMPATIBLE)
    first, last = int(compatible[0]), int(compatible[-1])
    # The best value may lie between two trial values, by half a step at most.
    lowest = float(np.exp(fine[max(first - BETWEEN // 2, 0)]))
    highest = float(np.exp(fine[min(last + BETWEEN // 2, len(fine) - 1)]))
    if first == 0 or last == len(worse) - 1 or highest > WIDEST_RATIO * lowest:
        raise WrongDatasetError(
            Message(
                "the echoes agree with every permittivity from {lowest:.3g} to {highest:.3g}, "
                "which is too wide a range for an image (bodies: {count}); {advice}",
                count=len(bodies),
                lowest=lowest,
                highest=highest,
                advice=_advice(),
            ),
            fault=faults.NO_PERMITTIVITY,
        )
    likelihood = np.exp(-worse)
    mean = float(np.exp(np.sum(likelihood * fine) / np.sum(likelihood)))
    return PermittivityEstimate(mean, lowest, highest, len(bodies))
