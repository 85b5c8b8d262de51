"""An analyzer of scikit-rf at the end of a VISA session.

scikit-rf and PyVISA are imported only when a `VisaLibrary` is made.
"""

from __future__ import annotations

import contextlib
import importlib
from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Tuple, Type, TypeVar

from gpr20_common.errors import os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message, verbatim
from gpr20_scikit_rf.errors import VnaLibraryError
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaDataError, VnaError

Result = TypeVar("Result")

PACKAGE = "skrf.vi.vna"
INSTALL = "scripts/setup.sh --scikit-rf"
RELEASE_LIMIT_S = 2.0
# What scikit-rf and PyVISA raise for an answer that they do not understand.
ANSWER_ERRORS = (
    ValueError,
    ArithmeticError,
    LookupError,
    AssertionError,
    AttributeError,
    TypeError,
)


@dataclass(frozen=True)
class VisaLimits:
    """Time limits of a VISA session.

    Attributes:
        answer_s: For one exchange [s].
        clear: Whether the instrument's buffers are emptied in a new session.
    """

    answer_s: float
    clear: bool


class VisaLibrary:
    """A class of scikit-rf and the VISA library that it uses."""

    def __init__(
        self, class_name: str, visa_library: str, limits: VisaLimits, needs: str = ""
    ) -> None:
        """Load both.

        Args:
            class_name: Class below `skrf.vi.vna`, such as keysight.PNA.
            visa_library: As PyVISA names it: "@py", or "@ivi" or the path of another one.
            limits: Time limits.
            needs: Module without which the installed scikit-rf is too old for the class.

        Raises:
            VnaLibraryError: One of them is not installed, or too old.
        """
        module, _dot, name = f"{PACKAGE}.{class_name}".rpartition(".")
        try:
            import pyvisa
            from skrf.vi.validators import ValidationError
            from skrf.vi.vna import VNA

            if needs:
                importlib.import_module(needs)
            self._class: Any = getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError) as error:
            raise VnaLibraryError(_missing(class_name, error)) from error
        self._pyvisa: Any = pyvisa
        self._validation_error: Type[Exception] = ValidationError
        self._base: Any = VNA
        try:
            pyvisa.ResourceManager(visa_library)
        except (ValueError, OSError, pyvisa.errors.Error) as error:
            raise VnaLibraryError(
                Message(
                    "the VISA library {library} cannot be used; install it, or change visa_library",
                    library=repr(visa_library),
                    details=error,
                )
            ) from error
        self._visa_library = visa_library
        self._limits = limits

    def connect(self, address: str) -> VisaLink:
        """Open a session to a VISA resource name.

        Raises:
            VnaConnectionError: Nothing answers there.
        """
        return VisaLink(self, address, self._limits)

    def open(self, address: str, opened: Callable[[Any], None]) -> Any:
        """Return the object of scikit-rf for the analyzer at an address.

        Args:
            address: The resource name.
            opened: Called with the session as soon as it is open, since what follows may fail.
        """

        def open_session(vna: Any, address: str, backend: str, timeout: Any = None) -> None:
            # The classes of scikit-rf leave the time unlimited.
            answer_ms = max(1, round(self._limits.answer_s * 1e3))
            self._base.__init__(vna, address, backend, timeout=answer_ms)
            opened(vna._resource)
            if self._limits.clear:
                self.if_supported(vna._resource.clear)

        # Each class calls the next one's constructor; this one comes after it and before its base.
        session = type("Session", (self._base,), {"__init__": open_session})
        return type(self._class.__name__, (self._class, session), {})(address, self._visa_library)

    def if_supported(self, call: Callable[[], Any]) -> None:
        """Make a call that neither the instrument nor the kind of session need support."""
        try:
            call()
        except NotImplementedError:
            return
        except self._pyvisa.errors.VisaIOError as error:
            codes = self._pyvisa.constants.StatusCode
            if error.error_code != codes.error_nonsupported_operation:
                raise

    def go_local(self, resource: Any) -> None:
        """Return the control to the front panel, where the kind of session can do that."""
        control = getattr(resource, "control_ren", None)
        if control is not None:
            mode = self._pyvisa.constants.RENLineOperation.address_gtl
            self.if_supported(lambda: control(mode))

    def translated(self, error: Exception, address: str, what: Message) -> VnaError:
        """Return what an error of the libraries means to the driver."""
        technical = f"{type(error).__name__}: {error}"[:200]
        if isinstance(error, (*ANSWER_ERRORS, self._validation_error)):
            return VnaDataError(
                Message(
                    "the VNA's answer was not understood ({what}); check that scikit_rf_class is "
                    "right for this instrument",
                    what=what,
                    details=technical,
                ),
                fault=CONFIGURATION,
            )
        return VnaConnectionError(
            Message(
                "communication with the VNA at {address} failed: {reason}; check the VNA and its "
                "cable",
                address=address,
                reason=self._reason(error),
                details=technical,
            )
        )

    def _reason(self, error: Exception) -> Message:
        if isinstance(error, self._pyvisa.errors.VisaIOError):
            if error.error_code == self._pyvisa.constants.StatusCode.error_timeout:
                return Message("no answer in time")
            return verbatim(str(error.description))
        if isinstance(error, OSError):
            return os_reason(error)
        return verbatim(str(error)[:80] or type(error).__name__)


class VisaLink:
    """One session; after any error it is dead."""

    def __init__(self, library: VisaLibrary, address: str, limits: VisaLimits) -> None:
        self._library = library
        self._address = address
        self._limits = limits
        self._open = True
        self._resources: List[Any] = []
        self._vna: Any = self._run(
            Message("connecting"), lambda: library.open(address, self._resources.append)
        )

    def call(
        self, what: Message, action: Callable[[Any], Result], limit_s: Optional[float] = None
    ) -> Result:
        """Do something with the object of scikit-rf.

        Args:
            what: What is done.
            action: Does it; few exchanges.
            limit_s: Time limit for one exchange [s], if it is not that of the link.

        Raises:
            VnaConnectionError: The instrument does not answer.
            VnaDataError: It answers something else than expected.
        """
        answer_s = self._limits.answer_s if limit_s is None else limit_s

        def timed() -> Result:
            timeout_ms = max(1, round(answer_s * 1e3))
            if self._vna.timeout != timeout_ms:
                self._vna.timeout = timeout_ms
            return action(self._vna)

        return self._run(what, timed)

    def release(self, action: Callable[[Any], None]) -> None:
        """Do something, then return the control to the front panel; no request limits it."""

        def released() -> None:
            self._vna.timeout = round(RELEASE_LIMIT_S * 1e3)
            action(self._vna)
            for resource in self._resources:
                self._library.go_local(resource)

        self._run(Message("returning to the front panel"), released)

    def close(self) -> None:
        """End the session. Never fails; ending a dead one does nothing."""
        if not self._open:
            return
        self._open = False
        for resource in self._resources:
            # Nobody uses it again, whatever a library says of a session that is dead.
            with contextlib.suppress(Exception):
                resource.close()

    def _run(self, what: Message, action: Callable[[], Result]) -> Result:
        if not self._open:
            raise VnaConnectionError(
                Message("the link to the VNA is closed; make a new one", details=what)
            )
        try:
            return action()
        except VnaError:
            self.close()
            raise
        # What the libraries may raise is not documented; every error ends the link.
        except Exception as error:
            self.close()
            raise self._library.translated(error, self._address, what) from error


def _missing(class_name: str, error: Exception) -> Message:
    name = getattr(error, "name", "") or ""
    library, version = _installed()
    if library and not name.startswith("pyvisa"):
        return Message(
            "scikit-rf {version} has no analyzer {name} that this driver can use; install a newer "
            "version ({command}), or choose another scikit_rf_class",
            version=version,
            name=class_name,
            command=INSTALL,
            details=error,
        )
    return Message(
        "analyzers of scikit-rf need {library}, which is not installed; install it with {command}",
        library="PyVISA" if library else "scikit-rf",
        command=INSTALL,
        details=error,
    )


def _installed() -> Tuple[bool, str]:
    try:
        import skrf
    except ImportError:
        return False, ""
    return True, str(skrf.__version__)
