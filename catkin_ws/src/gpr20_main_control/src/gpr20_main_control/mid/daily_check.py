"""The daily check of the radar: its sweeps, against the checks before of the same robot.

The antennas see nothing, then a metal plate, then a known reflector; each is one request, and is
swept twice in a row. What is compared with the median of former checks: the level of each, its
noise, and the delay and the level of the echo that plate and reflector add to the empty sweep.
"""

from __future__ import annotations

import contextlib
import math
import os
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import DISK_REFUSES
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.low.yaml_file import data_folder, state_folder
from gpr20_common.message import Message, numeral
from gpr20_common.mid.codec import plain, record_from
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.measured_again import finite, noise_db, s21_of
from gpr20_main_control.mid.service import analyzer_in_service, confirmed_sweep
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.errors import ProcessingError
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.files.durable_files import add_line, lines_backwards, object_of
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse
from gpr20_survey.plan.robot_description import STORAGE
from gpr20_survey.radar import MAX_DELAY_S, Window, decibels, delay_kernel, unambiguous_s
from gpr20_survey.results.answers import Part
from gpr20_survey.trace.sweep import Sweep, SweepSettings
from gpr20_survey.trace.utc_time import iso_text

FORMAT = "gpr20-daily-check/1"
# Below the data folder.
HISTORY = Path("daily_checks") / "history.jsonl"
CHECK_SWEEP = SweepSettings(600.0e6, 6.0e9, 501)
STEPS = tuple(Part)
# Samples of an echo in the reciprocal of the bandwidth: the delay is exact to a tenth of its limit.
SAMPLES_PER_RESOLUTION = 16
# An echo is one if it is so many times higher than any noise.
ECHO_FACTOR = 4.0
# So many of the latest good checks are compared with.
COMPARED_CHECKS = 30


@dataclass(frozen=True)
class Kind:
    """A kind of figure: its largest difference from the median, and what to check if it differs."""

    name: Message
    unit: str
    limit: float
    advice: Message
    # Whether less is better.
    only_more: bool = False


PART_NAMES = {
    Part.EMPTY: Message("empty sweep"),
    Part.PLATE: Message("metal plate"),
    Part.REFLECTOR: Message("known reflector"),
}
_CABLES = Message("check the antenna cables, their connectors and the VNA's calibration")
_PLACE = Message("check the place of the target, the height of the antennas and the antenna cables")
_NOISE = Message("look for transmitters nearby, and check cables and connectors")
KINDS = {
    "level_db": Kind(Message("level"), "dB", 1.0, _CABLES),
    "noise_db": Kind(Message("noise"), "dB", 6.0, _NOISE, only_more=True),
    "delay_ns": Kind(Message("delay of the echo"), "ns", 0.1, _PLACE),
    "echo_db": Kind(Message("level of the echo"), "dB", 1.5, _PLACE),
}

Pair = Tuple[Sweep, Sweep]
Figures = Mapping[Part, Mapping[str, Optional[float]]]
"""The figures of each part; None where a figure is not finite."""


@dataclass(frozen=True)
class Verdict:
    """What a check says in one sentence, and whether nothing differs, as in the first one."""

    good: bool
    message: Message


class DailyCheck:
    """Keeps the sweeps of the check in progress; only one step at a time is taken."""

    def __init__(self, robot: Robot) -> None:
        """Begin without a check."""
        self._robot = robot
        self._client = ""
        self._with: Tuple[object, ...] = ()
        self._sweeps: Dict[Part, Pair] = {}

    def take(self, step: int, client: str, interruption: Interruption) -> Optional[Verdict]:
        """Sweep one part; return the verdict after the last one.

        The first begins a new check, and the parts of two clients do not make one. A step that
        failed or was stopped can be repeated.
        """
        part = self._expected(step, client)
        self._sweep(part, self._robot.description.analyzer_address(), interruption)
        if part is not STEPS[-1]:
            return None
        verdict = self._verdict()
        self._sweeps.clear()
        return verdict

    def _expected(self, step: int, client: str) -> Part:
        if step == 0:
            self._client = client
            self._sweeps.clear()
        missing = any(before not in self._sweeps for before in STEPS[:step])
        if step >= len(STEPS) or missing or client != self._client:
            raise RequestRefusedError(
                Message("a step before this one is missing"), fault=CHECK_ORDER
            )
        return STEPS[step]

    def _sweep(self, part: Part, address: str, interruption: Interruption) -> None:
        analyzer = self._robot.analyzer
        with analyzer_in_service(self._robot, interruption) as call:
            identity = call(lambda: analyzer.connect(address))
            call(analyzer.calibration)
            swept_with = identity, call(lambda: analyzer.configure(CHECK_SWEEP)).settings
            if self._sweeps and swept_with != self._with:
                raise RequestRefusedError(
                    Message("the VNA is not the same as at the beginning of the check"),
                    fault=CHECK_ORDER,
                )
            self._with = swept_with
            self._sweeps[part] = confirmed_sweep(analyzer, call), confirmed_sweep(analyzer, call)

    def _verdict(self) -> Verdict:
        identity, settings = self._with
        description = self._robot.description
        check = {
            "format": FORMAT,
            "robot": description.site.robot,
            "simulated": description.config().simulated,
            "sweep": plain(settings),
            "time": iso_text(time_of_day_us()),
            "identity": identity,
        }
        nodes = description.nodes
        stored = nodes[STORAGE].configuration.get("data", "") if STORAGE in nodes else ""
        # The storage may be on another computer: then the history is in the folder of this one.
        folder = data_folder(stored if Path(stored).is_dir() else "", os.environ)
        use = DataFolderUse(folder, state_folder(os.environ))
        try:
            return compared(check, check_figures(self._sweeps), use)
        except (ProcessingError, OSError) as error:
            reason = error.message if isinstance(error, ProcessingError) else str(error)
            raise DeviceError(
                Message("the check could not be made: {reason}", reason=reason), DISK_REFUSES
            ) from error


def compared(check: Mapping[str, Any], figures: Figures, use: DataFolderUse) -> Verdict:
    """Compare a check with those before of the same robot and sweep, and add it to them."""
    DataFolder(use).check()
    path = use.path / HISTORY
    kind: Any = Figures
    history: List[Figures] = []
    for line in map(object_of, reversed(list(lines_backwards(path)))):
        same = all(line.get(key) == check[key] for key in ("format", "robot", "simulated", "sweep"))
        # What cannot be read is not compared with; the verdict has the number of the others.
        with contextlib.suppress(InvalidValueError):
            if same and line.get("good") is True:
                history.append(dict(record_from(kind, line.get("figures"), "figures")))
    verdict = judge(figures, history)
    judged = {"good": verdict.good, "verdict": str(verdict.message), "figures": plain(figures)}
    add_line(path, {**check, **judged})
    return verdict


def check_figures(sweeps: Mapping[Part, Pair]) -> Figures:
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
    if levels[place] < ECHO_FACTOR * floor:
        return {"delay_ns": math.nan, "echo_db": math.nan}
    echo_db = float(decibels(float(levels[place])))
    return {"delay_ns": 1e9 * float(delays_s[place]), "echo_db": echo_db}


def judge(figures: Figures, history: Sequence[Figures]) -> Verdict:
    """Compare a check with the good ones before of the same robot and sweep, the latest last."""
    for part, own in figures.items():
        if own.get("echo_db", 0.0) is None:
            message = Message(
                "No echo of the {part} was found: check its place and the antenna cables, then "
                "repeat the check.",
                part=PART_NAMES[part],
            )
            return Verdict(False, message)
    latest = history[-COMPARED_CHECKS:]
    if not latest:
        message = Message(
            "This is the first check of this robot with this sweep: later checks are compared "
            "with it."
        )
        return Verdict(True, message)
    differences = [
        (_difference(latest, part, name, value), part, KINDS[name])
        for part, own in figures.items()
        for name, value in own.items()
    ]
    difference, part, kind = max(differences, key=lambda one: _part_of_limit(one[0], one[2]))
    if _part_of_limit(difference, kind) <= 1.0:
        message = Message(
            "Good: every figure agrees with the median of the checks before ({count}).",
            count=len(latest),
        )
        return Verdict(True, message)
    message = Message(
        "{part}, {name}: differs by {difference} {unit} from the median of the checks "
        "before ({count}); {advice}.",
        part=PART_NAMES[part],
        name=kind.name,
        difference=numeral(difference, "+.2f"),
        unit=kind.unit,
        count=len(latest),
        advice=kind.advice,
    )
    return Verdict(False, message)


def _part_of_limit(difference: float, kind: Kind) -> float:
    return (difference if kind.only_more else abs(difference)) / kind.limit


def _difference(history: Sequence[Figures], part: Part, name: str, value: Optional[float]) -> float:
    """Return how much a figure differs from the median of those before; 0 without a value."""
    found = (figures.get(part, {}).get(name) for figures in history)
    values = [one for one in found if one is not None]
    return value - median(values) if values and value is not None else 0.0
