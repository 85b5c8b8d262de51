"""The daily check of the radar: its sweeps, its history and its verdict."""

from __future__ import annotations

import contextlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.low.data_folder import data_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.check_verdict import (
    Figures,
    Verdict,
    check_figures,
    figures_from,
    judge,
)
from gpr20_main_control.mid.devices.robot import Analyzer
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.files.durable_files import add_line, lines_backwards, object_of
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse
from gpr20_survey.results.daily_check import INSTRUCTIONS, Part
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

FORMAT = "gpr20-daily-check/1"
# Below the data folder.
HISTORY = Path("daily_checks") / "history.jsonl"
CHECK_SWEEP = SweepSettings(600.0e6, 6.0e9, 501)


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


@dataclass(frozen=True)
class SweptPart:
    """Two sweeps in a row of one part.

    Attributes:
        identity: Of the analyzer.
        settings: What each sweep covered.
        sweeps: The two.
    """

    identity: str
    settings: SweepSettings
    sweeps: Tuple[Sweep, Sweep]


def sweep_part(
    analyzer: Analyzer, address: str, call: Callable[[Callable[[], Any]], Any]
) -> SweptPart:
    """Sweep what is below the antennas now; the caller releases the analyzer.

    Args:
        analyzer: The analyzer.
        address: Where it is.
        call: Calls one function of the analyzer and returns its result.

    Raises:
        DeviceError: The analyzer failed.
    """
    identity = call(lambda: analyzer.connect(address))
    call(analyzer.calibration)
    settings = call(lambda: analyzer.configure(CHECK_SWEEP)).settings

    def sweep() -> Sweep:
        unconfirmed = call(analyzer.sweep)
        call(lambda: analyzer.confirm(unconfirmed.number))
        return unconfirmed.sweep

    return SweptPart(identity, settings, (sweep(), sweep()))


def made_check(parts: Mapping[Part, SweptPart]) -> MadeCheck:
    """Return what the sweeps of all parts show.

    Raises:
        RequestRefusedError: Another analyzer, or other settings, in between.
    """
    first = parts[Part.EMPTY]
    own = first.identity, first.settings
    if any((one.identity, one.settings) != own for one in parts.values()):
        raise RequestRefusedError(
            Message("the VNA is not the same as at the beginning of the check"),
            fault=CHECK_ORDER,
        )
    return MadeCheck(
        first.identity, first.settings, check_figures({p: one.sweeps for p, one in parts.items()})
    )


def make_check(
    analyzer: Analyzer, address: str, instruct: Callable[[Part, Message], None]
) -> MadeCheck:
    """Sweep each part, and leave the analyzer to its front panel after each.

    Args:
        analyzer: The analyzer.
        address: Where it is.
        instruct: Says what to put below the antennas, and returns when it is there; an error that
            it raises ends the check.

    Raises:
        DeviceError: The analyzer failed.
        RequestRefusedError: It was replaced during the check.
    """
    parts: Dict[Part, SweptPart] = {}
    for part, instruction in INSTRUCTIONS.items():
        instruct(part, instruction)
        try:
            parts[part] = sweep_part(analyzer, address, lambda one: one())
        finally:
            # What failed before says more.
            with contextlib.suppress(DeviceError):
                analyzer.release()
    return made_check(parts)


def history_folder(stored: object, environment: Mapping[str, str]) -> Path:
    """Return the data folder that keeps the history.

    Args:
        stored: The data folder of the storage, which may be that of another computer: then the
            history is kept in that of this one.
        environment: The variables of the process.
    """
    folder = str(stored) if stored and Path(str(stored)).is_dir() else ""
    return data_folder(folder, environment)


def compare_with_history(
    check: MadeCheck, robot: CheckedRobot, use: DataFolderUse, time: str
) -> Tuple[Verdict, int]:
    """Compare a check with those before, and add it to them.

    Args:
        check: The check.
        robot: Which robot was checked.
        use: The data folder.
        time: The time of day.

    Returns:
        The verdict, and how many lines of the history cannot be read.

    Raises:
        SurveyRefusedError: It is not the data folder that was used before.
        OSError: The disk refused.
    """
    DataFolder(use).check()
    path = use.path / HISTORY
    lines = [object_of(line) for line in lines_backwards(path)]
    damaged = lines.count({})
    own = {
        "format": FORMAT,
        "robot": robot.name,
        "simulated": robot.simulated,
        "sweep": asdict(check.settings),
    }
    history: List[Figures] = []
    for line in reversed(lines):
        if line.get("good") is True and all(line.get(key) == own[key] for key in own):
            try:
                history.append(figures_from(line.get("figures")))
            except InvalidValueError:
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
            "figures": plain(check.figures),
        },
    )
    return verdict, damaged
