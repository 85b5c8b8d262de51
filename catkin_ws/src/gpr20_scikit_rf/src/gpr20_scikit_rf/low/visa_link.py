"""An analyzer of scikit-rf at the end of a VISA session.

scikit-rf and PyVISA are imported only when a `VisaLibrary` is made.
"""

from __future__ import annotations

import contextlib
import importlib
from typing import Any, Callable, List, Optional, TypeVar

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message, verbatim
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaDataError, VnaError

Result = TypeVar("Result")

PACKAGE = "skrf.vi.vna"
INSTALL = "scripts/setup.sh --scikit-rf"
# What scikit-rf and PyVISA raise for an answer that they do not understand.
ANSWER_ERRORS = (
    ValueError,
    ArithmeticError,
    LookupError,
    AssertionError,
    AttributeError,
    TypeError,
)


class VisaLibrary:
    """A class of scikit-rf and the VISA library that it uses.

    Args:
        class_name: Class below `skrf.vi.vna`, such as keysight.PNA.
        visa_library: As PyVISA names it: "@py", or "@ivi" or the path of another one.
        answer_s: Time limit for one exchange [s].
        clear: Whether the instrument's buffers are emptied in a new session.

    Raises:
        VnaError: One of them is not installed, or too old.
    """

    def __init__(self, class_name: str, visa_library: str, answer_s: float, clear: bool) -> None:
        module, _dot, name = f"{PACKAGE}.{class_name}".rpartition(".")
        try:
            import pyvisa
            from skrf.vi.validators import ValidationError
            from skrf.vi.vna import VNA

            self._class: Any = getattr(importlib.import_module(module), name)
            pyvisa.ResourceManager(visa_library)
        # What a library raises that is not whole is not documented.
        except Exception as error:
            raise VnaError(
                Message(
                    "the analyzer {name} of scikit-rf with the VISA library {library} cannot be "
                    "used; install or update both with {command}, or choose others",
                    name=class_name,
                    library=repr(visa_library),
                    command=INSTALL,
                    details=error,
                ),
                fault=CONFIGURATION,
            ) from error
        self._pyvisa: Any = pyvisa
        self._base: Any = VNA
        self._not_understood = (*ANSWER_ERRORS, ValidationError)
        self._visa_library = visa_library
        self._clear = clear
        self.answer_s = answer_s

    def check_address(self, address: str) -> None:
        """Refuse what is no name of a VISA resource.

        Raises:
            InvalidValueError: It is not.
        """
        try:
            self._pyvisa.rname.ResourceName.from_string(address)
        except (self._pyvisa.rname.InvalidResourceName, ValueError) as error:
            raise InvalidValueError(
                Message(
                    "the VNA address is '{address}'; it must be the name of a VISA resource, such "
                    "as TCPIP0::192.168.1.10::inst0::INSTR",
                    address=address[:64],
                )
            ) from error

    def open(self, address: str, opened: Callable[[Any], None]) -> Any:
        """Return the object of scikit-rf for the analyzer at an address.

        Args:
            address: The resource name.
            opened: Called with the session as soon as it is open, since what follows may fail.
        """

        def open_session(vna: Any, address: str, backend: str, timeout: Any = None) -> None:
            # The classes of scikit-rf leave the time unlimited.
            self._base.__init__(vna, address, backend, timeout=1e3 * self.answer_s)
            opened(vna._resource)
            if self._clear:
                vna._resource.clear()

        # Each class calls the next one's constructor; this one comes after it and before its base.
        session = type("Session", (self._base,), {"__init__": open_session})
        return type(self._class.__name__, (self._class, session), {})(address, self._visa_library)

    def translated(self, error: Exception, address: str, what: Message) -> VnaError:
        """Return what an error of the libraries means to the driver."""
        technical = f"{type(error).__name__}: {error}"[:200]
        if isinstance(error, self._not_understood):
            return VnaDataError(
                Message(
                    "the VNA's answer was not understood ({what}); check that scikit_rf_class is "
                    "right for this instrument",
                    what=what,
                    details=technical,
                ),
                fault=CONFIGURATION,
            )
        timeout = self._pyvisa.constants.StatusCode.error_timeout
        is_silent = getattr(error, "error_code", None) == timeout
        return VnaConnectionError(
            Message(
                "communication with the VNA at {address} failed: {reason}; check the VNA and its "
                "cable",
                address=address,
                reason=Message("no answer in time") if is_silent else verbatim(str(error)[:80]),
                details=technical,
            )
        )


class VisaLink:
    """One session to a VISA resource name; after any error it is dead.

    Args:
        library: Opens it.
        address: The resource name.

    Raises:
        VnaConnectionError: Nothing answers there.
    """

    def __init__(self, library: VisaLibrary, address: str) -> None:
        self._library = library
        self._address = address
        self._resources: List[Any] = []
        self._vna: Any = None
        self._vna = self._run(
            Message("connecting"), lambda: library.open(address, self._resources.append)
        )

    def call(
        self, what: Message, action: Callable[[Any], Result], limit_s: Optional[float] = None
    ) -> Result:
        """Do something with the object of scikit-rf.

        Args:
            what: What is done.
            action: Does it; few exchanges.
            limit_s: Time limit for one exchange [s], if it is not that of the library.

        Raises:
            VnaConnectionError: The instrument does not answer, or the session has ended.
            VnaDataError: It answers something else than expected.
        """

        def timed() -> Result:
            self._vna.timeout = 1e3 * (self._library.answer_s if limit_s is None else limit_s)
            return action(self._vna)

        if self._vna is None:
            raise VnaConnectionError(
                Message("the link to the VNA is closed; make a new one", details=what)
            )
        return self._run(what, timed)

    def close(self) -> None:
        """End the session. Never fails; ending a dead one does nothing."""
        self._vna = None
        for resource in self._resources:
            # Nobody uses it again, whatever a library says of a session that is dead.
            with contextlib.suppress(Exception):
                resource.close()
        self._resources = []

    def _run(self, what: Message, action: Callable[[], Result]) -> Result:
        try:
            return action()
        # What the libraries may raise is not documented; every error ends the link.
        except Exception as error:
            self.close()
            raise self._library.translated(error, self._address, what) from error
