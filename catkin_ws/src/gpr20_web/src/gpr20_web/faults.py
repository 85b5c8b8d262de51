"""What can go wrong on the page at a distance, for programs."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

BAD_REQUEST = Fault("web.bad_request", Message("Load the page again."))
NOT_ALLOWED = Fault(
    "web.not_allowed", Message("Ask a person whose account may do it, or the administrator.")
)
NOT_ARMED = Fault(
    "web.not_armed",
    Message("Ask the person at the robot to allow remote control on the touchscreen."),
)
NOT_IN_CONTROL = Fault("web.not_in_control", Message("Take control first."))
NOT_LOGGED_IN = Fault("web.not_logged_in", Message("Log in."))
NOT_NOW = Fault("web.not_now", Message("Look at the state of the robot, then decide."))
NOT_NOTED = Fault(
    "web.not_noted",
    Message("Check disk and network of the computer with the page, then its log."),
    Severity.WARNING,
)
WRONG_LOGIN = Fault(
    "web.wrong_login",
    Message("Check name and password, wait if the message says so, then log in again."),
)
