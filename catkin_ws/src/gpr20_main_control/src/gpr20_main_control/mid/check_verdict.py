"""The verdict of a daily check: its sweeps against the checks before of the same robot.

The antennas see nothing, then a metal plate, then a known reflector. Each is swept twice in a row.
What is compared with the median of former checks: the level of each, its noise, and the delay and
the level of the echo that plate and reflector add to the empty sweep.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import median
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message, numeral
from gpr20_common.mid.codec import record_from
from gpr20_main_control.mid.sweep_difference import finite, noise_db, s21_of
from gpr20_survey.radar.frequency_to_delay import (
    MAX_DELAY_S,
    Window,
    decibels,
    delay_kernel,
    unambiguous_s,
)
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.sweep import Sweep

NS = 1e9
# Delays between two samples of an echo, of the reciprocal of the bandwidth; the peak between them
# is found by a parabola.
SAMPLES_PER_RESOLUTION = 16
# An echo is one if it is so many times higher than any noise.
ECHO_FACTOR = 4.0
# So many of the latest good checks are compared with.
COMPARED_CHECKS = 30


PART_NAMES = {
    Part.EMPTY: Message("empty sweep"),
    Part.PLATE: Message("metal plate"),
    Part.REFLECTOR: Message("known reflector"),
}


@dataclass(frozen=True)
class Kind:
    """One kind of figure.

    Attributes:
        name: What it is.
        unit: Its unit.
        limit: Largest difference from the median.
        only_more: Whether less is better.
        advice: What to check if it differs.
    """

    name: Message
    unit: str
    limit: float
    advice: Message
    only_more: bool = False


_CABLES = Message("check the antenna cables, their connectors and the VNA's calibration")
_PLACE = Message("check the place of the target, the height of the antennas and the antenna cables")
KINDS = {
    "level_db": Kind(Message("level"), "dB", 1.0, _CABLES),
    "noise_db": Kind(
        Message("noise"),
        "dB",
        6.0,
        Message("look for transmitters nearby, and check cables and connectors"),
        only_more=True,
    ),
    "delay_ns": Kind(Message("delay of the echo"), "ns", 0.1, _PLACE),
    "echo_db": Kind(Message("level of the echo"), "dB", 1.5, _PLACE),
}

Figures = Mapping[Part, Mapping[str, Optional[float]]]
"""The figures of each part; None where a figure is not finite."""


def check_figures(sweeps: Mapping[Part, Tuple[Sweep, Sweep]]) -> Figures:
    """Return the figures of a check: two sweeps in a row of each part, at the same frequencies."""
    pairs = {part: [s21_of(one) for one in pair] for part, pair in sweeps.items()}
    frequency_hz = sweeps[Part.EMPTY][0].frequency_hz
    empty = sum(pairs[Part.EMPTY]) / 2.0
    found = {}
    for part, (first, second) in pairs.items():
        level = math.sqrt(float(np.mean(np.abs(first) ** 2)))
        figures = {"level_db": float(decibels(level)), "noise_db": noise_db(first, second)}
        if part is not Part.EMPTY:
            noise = (second - first) / math.sqrt(2.0)
            figures.update(_echo(frequency_hz, (first + second) / 2.0 - empty, noise))
        found[part] = {name: finite(value) for name, value in figures.items()}
    return found


def _echo(frequency_hz: np.ndarray, echo: np.ndarray, noise: np.ndarray) -> Dict[str, float]:
    """Return delay and level of the strongest echo; NaN if there is none above the noise."""
    step_s = 1.0 / (SAMPLES_PER_RESOLUTION * float(frequency_hz[-1] - frequency_hz[0]))
    delays_s = np.arange(0.0, min(MAX_DELAY_S, unambiguous_s(frequency_hz)), step_s)
    kernel = delay_kernel(frequency_hz, delays_s, Window.HANN)
    levels = np.abs(echo @ kernel)
    place = int(np.argmax(levels))
    # Rounding is no echo, where a simulated analyzer has no noise.
    floor = max(float(np.max(np.abs(noise @ kernel))), float(np.max(np.abs(echo))) * 1e-6, 1e-12)
    if levels[place] < ECHO_FACTOR * floor or not 0 < place < len(levels) - 1:
        return {"delay_ns": math.nan, "echo_db": math.nan}
    before, peak, after = (float(one) for one in levels[place - 1 : place + 2])
    shift = 0.5 * (before - after) / (before - 2.0 * peak + after)
    level = peak - 0.25 * (before - after) * shift
    return {
        "delay_ns": NS * (float(delays_s[place]) + shift * step_s),
        "echo_db": float(decibels(level)),
    }


@dataclass(frozen=True)
class Verdict:
    """What a check says.

    Attributes:
        good: Whether nothing differs; also true for the first check.
        message: In one sentence.
    """

    good: bool
    message: Message


def judge(figures: Figures, history: Sequence[Figures]) -> Verdict:
    """Compare a check with the good ones before of the same robot and sweep, the latest last."""
    unseen = [part for part, own in figures.items() if own.get("echo_db", 0.0) is None]
    if unseen:
        message = Message(
            "No echo of the {part} was found: check its place and the antenna cables, then repeat "
            "the check.",
            part=PART_NAMES[unseen[0]],
        )
        return Verdict(False, message)
    compared = history[-COMPARED_CHECKS:]
    if not compared:
        message = Message(
            "This is the first check of this robot with this sweep: later checks are compared "
            "with it."
        )
        return Verdict(True, message)
    worst, message = (
        1.0,
        Message(
            "Good: every figure agrees with the median of the checks before ({count}).",
            count=len(compared),
        ),
    )
    for part, own in figures.items():
        for name, value in own.items():
            kind, usual = KINDS[name], _median(compared, part, name)
            difference = 0.0 if value is None or usual is None else value - usual
            part_of_limit = (difference if kind.only_more else abs(difference)) / kind.limit
            if part_of_limit > worst:
                worst = part_of_limit
                message = Message(
                    "{part}, {name}: differs by {difference} {unit} from the median of the checks "
                    "before ({count}); {advice}.",
                    part=PART_NAMES[part],
                    name=kind.name,
                    difference=numeral(difference, "+.2f"),
                    unit=kind.unit,
                    count=len(compared),
                    advice=kind.advice,
                )
    return Verdict(worst <= 1.0, message)


def figures_from(recorded: Any) -> Figures:
    """Return figures as `plain` gave them.

    Raises:
        InvalidValueError: A part is unknown, or a figure is no number.
    """
    kind: Any = Figures
    return dict(record_from(kind, recorded, "figures"))


def _median(history: Sequence[Figures], part: Part, name: str) -> Optional[float]:
    found = (figures.get(part, {}).get(name) for figures in history)
    values = [one for one in found if one is not None]
    return median(values) if values else None
