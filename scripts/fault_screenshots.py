"""Pictures of the window while a survey is paused by each fault of the simulated robot.

Started by `scripts/screenshots.sh --faults FOLDER`. It fails if a sentence is not in the Spanish
catalogue.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import List

import rospy
from PyQt5.QtWidgets import QApplication
from robot_kit import simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.high.graph_message import message_from
from gpr20_common.low.catalogue_file import FOLDER, read_translations
from gpr20_msgs.msg import ControlStatus
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault
from gpr20_simulator.mid.faults import ADC, VNA, VnaFault
from gpr20_simulator.srv import SetFault
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

# A survey of four seconds at 50 times the speed, whose second row leads past the endstop of x.
PARAMETERS = {"x_points": 3, "x_stop_mm": 600.0, "y_points": 3, "frequency_points": 51}
ENDED = (ControlStatus.FINISHED, ControlStatus.STOPPED, ControlStatus.FAILED)
LIMIT_S = 180.0
FAULTS = (
    *((VNA, one.value) for one in VnaFault),
    *((ADC, one.name) for one in AdcFault if one is not AdcFault.NONE),
    *(("endstop_x", one.name) for one in EndstopFault if one is not EndstopFault.NONE),
)


class LastStatus:
    """The status of main_control, with its message."""

    def __init__(self) -> None:
        self.status = ControlStatus()
        self._subscriber = rospy.Subscriber("control_status", ControlStatus, self._note)

    def ended(self, survey: str) -> bool:
        """Return whether a survey has ended."""
        return self.status.survey_id == survey and self.status.code in ENDED

    def _note(self, status: ControlStatus) -> None:
        self.status = status


def take_pictures(folder: Path, data: Path, application: QApplication) -> List[str]:
    """Meet each fault in a survey of its own; return the templates without a Spanish entry."""
    languages = Languages(application, Language.ENGLISH)
    spanish = read_translations(FOLDER / "es.po")
    interface = new_window(languages, data)
    interface.begin()
    operator, last = Operator(), LastStatus()
    untranslated = []
    for device, fault in FAULTS:
        operator.start(**PARAMETERS)
        run_until(lambda: last.status.code == ControlStatus.SURVEYING, "a survey runs", LIMIT_S)
        survey = last.status.survey_id
        run_events(1.0)
        operator.call("simulator/set_fault", SetFault, device=device, fault=fault, count=0)
        run_until(lambda: last.status.code in (ControlStatus.PAUSED, *ENDED), "it pauses", LIMIT_S)
        run_events(1.0)
        message = message_from(last.status)
        untranslated += [one.template for one in message.nested() if one.template not in spanish]
        print(f"{device} {fault}: {message}")
        for language in Language:
            languages.use(language)
            interface.window.show_tab(TabName.STATUS)
            run_events(1.0)
            interface.window.grab().save(
                str(folder / f"{device}_{fault.lower()}_{language.value}.png")
            )
        operator.call("simulator/set_fault", SetFault, device=device, fault="NONE", count=0)
        if last.status.code == ControlStatus.PAUSED:
            operator.stop()
        run_until(partial(last.ended, survey), "the survey ends", LIMIT_S)
    interface.end()
    languages.close()
    return untranslated


def main() -> None:
    """Take the pictures into the folder that is named."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with virtual_screen(), simulated_robot("time_scale:=20") as robot:
        application = QApplication([])
        rospy.init_node("fault_screenshots", disable_signals=True)
        untranslated = take_pictures(folder, robot.data, application)
        rospy.signal_shutdown("the pictures are taken")
    if untranslated:
        sys.exit(f"without a Spanish entry: {sorted(set(untranslated))}")


if __name__ == "__main__":
    main()
