"""The daily check of the radar: its sweeps, its history and its verdict."""

from __future__ import annotations

import contextlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Tuple

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import Analyzer
from gpr20_survey.files.json_lines import add_line, read_lines
from gpr20_survey.results.daily_check import (
    Figures,
    Part,
    Verdict,
    check_figures,
    figures_from,
    judge,
    recorded_figures,
)
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

FORMAT = "gpr20-daily-check/1"
# Below the data folder.
HISTORY = Path("daily_checks") / "history.jsonl"
CHECK_SWEEP = SweepSettings(600.0e6, 6.0e9, 501)
INSTRUCTIONS = {
    Part.EMPTY: Message(
        "Empty sweep: let the antennas see the sky or an absorber, and nothing else within 2 m."
    ),
    Part.PLATE: Message("Metal plate: put it below the antennas, at its mark."),
    Part.REFLECTOR: Message("Known reflector: take the plate away and put it at its mark."),
}


@dataclass(frozen=True)
class CheckedRobot:
    """Which robot is checked.

    Attributes:
        name: Its name.
        simulated: Whether it is simulated.
        address: Of its analyzer.
    """

    name: str
    simulated: bool
    address: str


@dataclass(frozen=True)
class MadeCheck:
    """The sweeps of a check.

    Attributes:
        identity: Of the analyzer.
        settings: What each sweep covered.
        figures: What they show.
    """

    identity: str
    settings: SweepSettings
    figures: Figures


def make_check(
    analyzer: Analyzer, address: str, instruct: Callable[[Part, Message], None]
) -> MadeCheck:
    """Sweep each part twice in a row, and leave the analyzer to its front panel.

    Args:
        analyzer: The analyzer.
        address: Where it is.
        instruct: Says what to put below the antennas, and returns when it is there; an error that
            it raises ends the check.

    Raises:
        DeviceError: The analyzer failed.
    """
    identity = analyzer.connect(address)
    try:
        analyzer.calibration()
        settings = analyzer.configure(CHECK_SWEEP).settings
        sweeps: Dict[Part, Tuple[Sweep, Sweep]] = {}
        for part, instruction in INSTRUCTIONS.items():
            instruct(part, instruction)
            sweeps[part] = (_sweep(analyzer), _sweep(analyzer))
    finally:
        # What failed before says more.
        with contextlib.suppress(DeviceError):
            analyzer.release()
    return MadeCheck(identity, settings, check_figures(sweeps))


def compare_with_history(
    check: MadeCheck, robot: CheckedRobot, data: Path, time: str
) -> Tuple[Verdict, int]:
    """Compare a check with those before, and add it to them.

    Args:
        check: The check.
        robot: Which robot was checked.
        data: The data folder.
        time: The time of day.

    Returns:
        The verdict, and how many lines of the history cannot be read.

    Raises:
        OSError: The disk refused.
    """
    path = data / HISTORY
    lines, damaged = read_lines(path)
    own = {
        "format": FORMAT,
        "robot": robot.name,
        "simulated": robot.simulated,
        "sweep": asdict(check.settings),
    }
    history: List[Figures] = []
    for line in lines:
        if line.get("good") is True and all(line.get(key) == own[key] for key in own):
            try:
                history.append(_figures(line))
            except ValueError:
                damaged += 1
    verdict = judge(check.figures, history)
    add_line(
        path,
        {
            **own,
            "time": time,
            "identity": check.identity,
            "good": verdict.good,
            "verdict": str(verdict.message),
            "figures": recorded_figures(check.figures),
        },
    )
    return verdict, damaged


def _figures(line: Mapping[str, Any]) -> Figures:
    figures = line.get("figures")
    if not isinstance(figures, dict):
        raise ValueError("no figures")
    return figures_from(figures)


def _sweep(analyzer: Analyzer) -> Sweep:
    unconfirmed = analyzer.sweep()
    analyzer.confirm(unconfirmed.number)
    return unconfirmed.sweep
