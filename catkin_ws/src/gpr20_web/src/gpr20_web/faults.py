"""What can go wrong on the page at a distance: faults, and errors with their HTTP status."""

from __future__ import annotations

from typing import ClassVar

from gpr20_common import faults as common
from gpr20_common.errors import Gpr20Error
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


class WebError(Gpr20Error):
    """The root of every error of this package.

    Attributes:
        status: HTTP status of the answer.
    """

    status: ClassVar[int] = 400
    fault = BAD_REQUEST


class BadRequestError(WebError, ValueError):
    """A request is not as the page sends it."""


class NotLoggedInError(WebError, PermissionError):
    """Nobody is logged in, or no longer."""

    status = 401
    fault = NOT_LOGGED_IN


class WrongLoginError(WebError, PermissionError):
    """Name or password is wrong; which of them is not said."""

    status = 401
    fault = WRONG_LOGIN


class TooManyLoginsError(WebError, PermissionError):
    """Logins failed too often; the next one is taken later."""

    status = 429
    fault = WRONG_LOGIN


class NotAllowedError(WebError, PermissionError):
    """The person has not the right."""

    status = 403
    fault = NOT_ALLOWED


class NotFoundError(WebError, LookupError):
    """There is nothing of this name."""

    status = 404


def no_survey(folder: str) -> NotFoundError:
    """Return that there is no survey in a folder of this name."""
    return NotFoundError(Message("there is no survey {survey}", survey=folder[:64]))


class NotNowError(WebError, RuntimeError):
    """The state of the robot does not allow it now."""

    status = 409
    fault = NOT_NOW


class BusyError(WebError, RuntimeError):
    """Too many requests wait."""

    status = 503
    fault = common.BUSY


class AccountError(WebError, ValueError):
    """A name, password or role is not allowed, or there is no such account."""

    fault = common.NOT_ALLOWED


class AccountsFileError(WebError, OSError):
    """The file of the accounts cannot be read or written."""

    status = 503
    fault = common.FILE_DAMAGED


class SetupError(WebError, OSError):
    """The folder, the certificate or the address of the page cannot be used."""

    status = 503
    fault = common.CONFIGURATION
