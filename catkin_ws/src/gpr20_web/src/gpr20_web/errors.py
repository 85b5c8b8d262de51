"""The errors of the page at a distance; each has the HTTP status that a browser gets."""

from __future__ import annotations

from typing import ClassVar

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import BUSY, CONFIGURATION, FILE_DAMAGED
from gpr20_common.faults import NOT_ALLOWED as REFUSED
from gpr20_web import faults


class WebError(Gpr20Error):
    """The root of every error of this package.

    Attributes:
        status: HTTP status of the answer.
    """

    status: ClassVar[int] = 400
    fault = faults.BAD_REQUEST


class BadRequestError(WebError, ValueError):
    """A request is not as the page sends it."""


class NotLoggedInError(WebError, PermissionError):
    """Nobody is logged in, or no longer."""

    status = 401
    fault = faults.NOT_LOGGED_IN


class WrongLoginError(WebError, PermissionError):
    """Name or password is wrong; which of them is not said."""

    status = 401
    fault = faults.WRONG_LOGIN


class TooManyLoginsError(WebError, PermissionError):
    """Logins failed too often; the next one is taken later."""

    status = 429
    fault = faults.WRONG_LOGIN


class NotAllowedError(WebError, PermissionError):
    """The person has not the right."""

    status = 403
    fault = faults.NOT_ALLOWED


class NotFoundError(WebError, LookupError):
    """There is nothing of this name."""

    status = 404


class NotNowError(WebError, RuntimeError):
    """The state of the robot does not allow it now."""

    status = 409
    fault = faults.NOT_NOW


class BusyError(WebError, RuntimeError):
    """Too many requests wait."""

    status = 503
    fault = BUSY


class AccountError(WebError, ValueError):
    """A name, password or role is not allowed, or there is no such account."""

    fault = REFUSED


class AccountsFileError(WebError, OSError):
    """The file of the accounts cannot be read or written."""

    status = 503
    fault = FILE_DAMAGED


class SetupError(WebError, OSError):
    """The folder, the certificate or the address of the page cannot be used."""

    status = 503
    fault = CONFIGURATION
