"""The daily check of the radar: one request for each part, and the history of its figures."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import ASKED_FOR, DISK_REFUSES
from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.low.data_folder import data_folder, state_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain
from gpr20_main_control.errors import DeviceError, RequestRefusedError, StopRequested
from gpr20_main_control.mid.check_verdict import (
    Figures,
    Verdict,
    check_figures,
    figures_from,
    judge,
)
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.errors import ProcessingError
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.files.durable_files import add_line, lines_backwards, object_of
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse
from gpr20_survey.plan.robot_description import STORAGE
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_survey.trace.utc_time import iso_text

FORMAT = "gpr20-daily-check/1"
# Below the data folder.
HISTORY = Path("daily_checks") / "history.jsonl"
CHECK_SWEEP = SweepSettings(600.0e6, 6.0e9, 501)
# A check that was not ended within this time [s] is given up.
CHECK_LIMIT_S = 1800.0
STEPS = tuple(Part)


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


class RadarCheck:
    """Keeps the sweeps of the check in progress; the service slot lets in one step at a time."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        """Begin without a check."""
        self._robot = robot
        self._clock = clock
        self._begun_s = 0.0
        self._client = ""
        self._parts: Dict[Part, SweptPart] = {}

    def take(self, step: int, client: str, interruption: Interruption) -> Optional[Verdict]:
        """Sweep one part.

        Args:
            step: Number of the part; the first begins a new check.
            client: Node that asks; the parts of two do not make one check.
            interruption: What ends the step.

        Returns:
            The verdict after the last part.

        Raises:
            RequestRefusedError: A part before is missing or too old, and nothing was swept; or the
                analyzer was replaced since.
            DeviceError: The analyzer or the disk failed; the step can be repeated.
            StopRequested: A stop was requested; the step can be repeated.
            InvalidValueError: The parts of the robot have not described themselves.
        """
        part = self._expected(step, client)
        address = self._robot.description.analyzer_address()
        self._parts[part] = self._swept(address, interruption)
        return self._verdict() if part is STEPS[-1] else None

    def _expected(self, step: int, client: str) -> Part:
        if step == 0:
            self._parts.clear()
            self._begun_s, self._client = self._clock.now_s(), client
        elif self._clock.now_s() - self._begun_s > CHECK_LIMIT_S:
            self._parts.clear()
        missing = any(before not in self._parts for before in STEPS[:step])
        if step >= len(STEPS) or missing or client != self._client:
            raise RequestRefusedError(
                Message("a step before this one is missing, or too old"), fault=CHECK_ORDER
            )
        return STEPS[step]

    def _swept(self, address: str, interruption: Interruption) -> SweptPart:
        calls, analyzer = self._robot.analyzer_calls, self._robot.analyzer

        def sweep() -> Sweep:
            unconfirmed = calls.call(analyzer.sweep, interruption.check)
            calls.call(lambda: analyzer.confirm(unconfirmed.number), interruption.check)
            return unconfirmed.sweep

        try:
            identity = calls.call(lambda: analyzer.connect(address), interruption.check)
            calls.call(analyzer.calibration, interruption.check)
            setup = calls.call(lambda: analyzer.configure(CHECK_SWEEP), interruption.check)
            return SweptPart(identity, setup.settings, (sweep(), sweep()))
        except StopRequested as error:
            raise StopRequested(Message("the test was stopped"), fault=ASKED_FOR) from error
        finally:
            # Without waiting: behind a call that hangs it comes late, but before any later call.
            calls.begin(analyzer.release)

    def _verdict(self) -> Verdict:
        first, description = self._parts[STEPS[0]], self._robot.description
        own = first.identity, first.settings
        if any((one.identity, one.settings) != own for one in self._parts.values()):
            raise RequestRefusedError(
                Message("the VNA is not the same as at the beginning of the check"),
                fault=CHECK_ORDER,
            )
        check = {
            "format": FORMAT,
            "robot": description.site.robot,
            "simulated": description.config().simulated,
            "sweep": asdict(first.settings),
            "time": iso_text(time_of_day_us()),
            "identity": first.identity,
        }
        figures = check_figures({part: one.sweeps for part, one in self._parts.items()})
        nodes = description.nodes
        stored = nodes[STORAGE].configuration.get("data", "") if STORAGE in nodes else ""
        # The storage may be on another computer: then the history is in the folder of this one.
        folder = data_folder(stored if Path(stored).is_dir() else "", os.environ)
        try:
            verdict = compared(check, figures, DataFolderUse(folder, state_folder(os.environ)))
        except (ProcessingError, OSError) as error:
            reason = error.message if isinstance(error, ProcessingError) else str(error)
            raise DeviceError(
                Message("the check could not be made: {reason}", reason=reason), DISK_REFUSES
            ) from error
        self._parts.clear()
        return verdict


def compared(check: Mapping[str, Any], figures: Figures, use: DataFolderUse) -> Verdict:
    """Compare a check with those before of the same robot and sweep, and add it to them.

    Raises:
        SurveyRefusedError: It is not the data folder that was used before.
        OSError: The disk refused.
    """
    DataFolder(use).check()
    path = use.path / HISTORY
    lines = [object_of(line) for line in lines_backwards(path)]
    damaged = lines.count({})
    history: List[Figures] = []
    for line in reversed(lines):
        same = ("format", "robot", "simulated", "sweep")
        if line.get("good") is True and all(line.get(key) == check[key] for key in same):
            try:
                history.append(figures_from(line.get("figures")))
            except InvalidValueError:
                damaged += 1
    verdict = judge(figures, history)
    if damaged:
        message = verdict.message.with_details(f"{HISTORY}: {damaged} lines cannot be read")
        verdict = replace(verdict, message=message)
    judged = {"good": verdict.good, "verdict": str(verdict.message), "figures": plain(figures)}
    add_line(path, {**check, **judged})
    return verdict
