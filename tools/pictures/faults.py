"""The window while a survey is paused by each fault of the simulated robot.

It fails if a sentence is not in the Spanish catalogue.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import List

import rospy
from robot_kit import simulated_robot
from window_kit import Operator, run_events

from gpr20_common.low.catalogue_file import FOLDER, read_translations
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ControlStatus
from gpr20_simulator.low.shared_state import AdcFault
from gpr20_simulator.mid.analyzer.vna_faults import VnaFault
from gpr20_simulator.mid.faults import ADC, VNA
from gpr20_simulator.srv import SetFault
from gpr20_user_interface.window.rail import TabName
from pictures.kit import Shown, shown_window, wait

# A survey of four seconds at 50 times the speed, whose second row leads past the endstop of x.
PARAMETERS = {"x_points": 3, "x_stop_mm": 600.0, "y_points": 3, "frequency_points": 51}
ENDED = (ControlStatus.FINISHED, ControlStatus.STOPPED, ControlStatus.FAILED)


@dataclass(frozen=True)
class Case:
    """A survey that meets a fault.

    Attributes:
        device: Whose fault it is.
        fault: Name of the fault.
        at_start: Whether it is switched on before the survey starts; else during it.
        drops: Whether the VNA closes its connections once: only a new one asks who is there.
    """

    device: str
    fault: str
    at_start: bool = False
    drops: bool = False


# Settings that stay as they are cannot be refused.
OF_SETTINGS = (VnaFault.REFUSE_SETTINGS, VnaFault.LOSES_CALIBRATION)
OF_IDENTITY = (VnaFault.WRONG_IDENTITY, VnaFault.OTHER_SERIAL)
# Of the endstops first: an axis is homed once, by the first survey that does not fail at it.
CASES = (
    *(Case(f"endstop_{axis}", "STUCK_OPEN", at_start=True) for axis in "xy"),
    Case("endstop_y", "STUCK_CLOSED", at_start=True),
    Case("endstop_x", "STUCK_CLOSED"),
    *(Case(ADC, one.name) for one in AdcFault if one is not AdcFault.NONE),
    *(Case(VNA, one.value, one in OF_SETTINGS, one in OF_IDENTITY) for one in VnaFault),
)


class LastStatus:
    """The status of main_control, with its message."""

    def __init__(self) -> None:
        self.status = ControlStatus()
        self._subscriber = rospy.Subscriber("control_status", ControlStatus, self._note)

    def is_new(self, former: str) -> bool:
        """Return whether another survey than a former one has begun to measure, or has halted."""
        begun = self.status.code == ControlStatus.SURVEYING or self.has_halted()
        return self.status.survey_id != former and begun

    def has_halted(self) -> bool:
        """Return whether the survey is paused or has ended."""
        return self.status.code in (ControlStatus.PAUSED, *ENDED)

    def ended(self, survey: str) -> bool:
        """Return whether a survey has ended."""
        return self.status.survey_id == survey and self.status.code in ENDED

    def _note(self, status: ControlStatus) -> None:
        self.status = status


class FaultPictures:
    """Meets each fault in a survey of its own, and takes pictures.

    Attributes:
        untranslated: Templates without a Spanish entry that were shown.
    """

    def __init__(self, folder: Path, shown: Shown) -> None:
        self._folder, self._shown = folder, shown
        self._operator, self._last = Operator(), LastStatus()
        self._spanish = read_translations(FOLDER / "es.po")
        self.untranslated: List[str] = []

    def meet(self, case: Case) -> None:
        """Run a survey that meets a fault, until it pauses or ends."""
        former = self._last.status.survey_id
        if case.at_start:
            self._set_fault(case.device, case.fault)
        # Other settings than before, so that there is one to refuse.
        points = {"frequency_points": 52} if case.at_start else {}
        self._operator.start(**{**PARAMETERS, **points})
        wait(partial(self._last.is_new, former), "a survey runs")
        survey = self._last.status.survey_id
        if not case.at_start:
            run_events(1.0)
            self._set_fault(case.device, case.fault)
        if case.drops:
            self._set_fault(case.device, "DROP", 1)
        wait(self._last.has_halted, f"{case} halts the survey")
        self._take(case)
        self._set_fault(case.device, "NONE")
        if self._last.status.code == ControlStatus.PAUSED:
            self._operator.stop()
        wait(partial(self._last.ended, survey), "the survey ends")

    def _take(self, case: Case) -> None:
        run_events(1.0)
        message = message_from(self._last.status)
        self.untranslated += [
            one.template for one in message.nested() if one.template not in self._spanish
        ]
        print(f"{case.device} {case.fault}: {message}", flush=True)
        self._shown.window.show_tab(TabName.ROBOT)
        self._shown.take(self._folder, f"{case.device}_{case.fault.lower()}")

    def _set_fault(self, device: str, fault: str, count: int = 0) -> None:
        self._operator.call(
            "simulator/set_fault", SetFault, device=device, fault=fault, count=count
        )


def make(folder: Path) -> None:
    """Meet every fault and take the pictures."""
    with simulated_robot("time_scale:=20") as robot, shown_window(robot.data) as shown:
        pictures = FaultPictures(folder, shown)
        for case in CASES:
            pictures.meet(case)
    if pictures.untranslated:
        raise SystemExit(f"without a Spanish entry: {sorted(set(pictures.untranslated))}")
