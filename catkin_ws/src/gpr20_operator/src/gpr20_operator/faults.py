"""What can go wrong in the window and the terminal client, for programs."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

NO_DISPLAY = Fault(
    "window.no_display",
    Message("Log in on the screen and set DISPLAY to it, or launch with ui:=false."),
)
SETTINGS_LOST = Fault(
    "window.settings_lost",
    Message("Check the values on the screen before you use them, and save them again."),
)
STANDS_STILL = Fault(
    "window.stands_still",
    Message(
        "Look on ROBOT for a part with a fault. If there is none, press PAUSE and resume; STOP "
        "ends the survey, and what is stored is kept."
    ),
    Severity.WARNING,
)
ROBOT_MOVES = Fault(
    "window.robot_moves",
    Message("Keep your hands clear. STOP stops every axis, whoever moves it."),
    Severity.WARNING,
    may_move=True,
)
