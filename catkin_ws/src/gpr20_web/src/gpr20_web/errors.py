"""The errors of the page at a distance; each has the HTTP status that a browser gets."""

from __future__ import annotations

from typing import ClassVar

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import BUSY, CONFIGURATION, DISK_REFUSES, FILE_DAMAGED, NOT_ALLOWED
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

    fault = faults.BAD_REQUEST


class NotLoggedInError(WebError, PermissionError):
    """Nobody is logged in, or no longer."""

    status = 401
    fault = faults.NOT_LOGGED_IN


class WrongLoginError(WebError, PermissionError):
    """Name or password is wrong; which of them is not said."""

    status = 401
    fault = faults.WRONG_LOGIN


class NotAllowedError(WebError, PermissionError):
    """The person has not the right."""

    status = 403
    fault = faults.NOT_ALLOWED


class NotFoundError(WebError, LookupError):
    """There is nothing of this name."""

    status = 404
    fault = faults.BAD_REQUEST


class NotNowError(WebError, RuntimeError):
    """The state of the robot does not allow it now."""

    status = 409
    fault = faults.NOT_NOW


class TooManyLoginsError(WebError, PermissionError):
    """Logins failed too often; the next one is taken later."""

    status = 429
    fault = faults.WRONG_LOGIN


class AccountError(WebError, ValueError):
    """A name, password or role is not allowed, or there is no such account."""

    fault = NOT_ALLOWED


class AccountsFileError(WebError, OSError):
    """The file of the accounts cannot be read or written."""

    status = 503
    fault = FILE_DAMAGED


class FolderError(WebError, OSError):
    """The folder of the page cannot be made, or is not its own."""

    status = 503
    fault = CONFIGURATION


class CertificateError(WebError, OSError):
    """Key and certificate cannot be made or read."""

    fault = CONFIGURATION


class PortTakenError(WebError, OSError):
    """The page cannot listen at its address."""

    fault = CONFIGURATION


class BusyError(WebError, RuntimeError):
    """Too many requests wait."""

    status = 503
    fault = BUSY


class AuditFileError(WebError, OSError):
    """The file that says who did what cannot be read."""

    status = 503
    fault = DISK_REFUSES


class NotSentError(WebError, OSError):
    """A notice did not reach the service that carries it."""

    fault = faults.NOT_SENT


class BundleError(WebError, OSError):
    """The doctor has not made a bundle."""

    status = 503
    fault = faults.BUNDLE
