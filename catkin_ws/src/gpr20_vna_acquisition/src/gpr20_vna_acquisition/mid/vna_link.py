"""The link to the network analyzer, which is made again after each failure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, List, Optional, Tuple, Type, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaDataError,
    VnaError,
    VnaIdentityError,
    VnaNotReadyError,
    VnaSettingError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c, Transport
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")


@dataclass(frozen=True)
class VnaState:
    """What the driver knows, for reports.

    Attributes:
        address: Where it is to be connected; empty if nowhere.
        identity: What answered there; empty if nothing did yet, which is tried again.
        linked: Whether a link is open now. After a failure there is none until the next use.
        sweep: The frequencies, as the instrument confirmed them; None if they are not set.
        trace_is_set: Whether the instrument is set up to give a trace of S21.
        sweeps: How many good sweeps were taken.
        repeats: How many attempts of any kind had to be repeated.
        last_sweep_s: How long the last sweep took [s].
        last_quality: Remarks on the last sweep.
        last_error: Why the last attempt failed; empty if it did not.
        link_error: Why the last test of the connection failed; empty if it did not.
        calibration: State of the calibration when it was last read; None before.
    """

    address: str = ""
    identity: str = ""
    linked: bool = False
    sweep: Optional[SweepSettings] = None
    trace_is_set: bool = False
    sweeps: int = 0
    repeats: int = 0
    last_sweep_s: float = 0.0
    last_quality: Tuple[str, ...] = ()
    last_error: str = ""
    link_error: str = ""
    calibration: Optional[CalibrationStatus] = None

    @property
    def trouble(self) -> str:
        """What is wrong now; empty if nothing is."""
        return self.link_error or self.last_error


class VnaLink:
    """The link to one instrument; after each failure a new one, set up like the former."""

    def __init__(
        self,
        connector: Callable[[str], Transport],
        parameters: VnaParameters,
        clock: Clock,
        warn: Callable[[str], None],
        utc_now_us: Callable[[], int],
    ) -> None:
        """Begin without a link; the arguments are those of `VNADriver`."""
        self.deadline = RequestDeadline(clock)
        self._connector = connector
        self._parameters = parameters
        self._warn = warn
        self._utc_now_us = utc_now_us
        self._instrument: Optional[Ms2026c] = None
        self._state = VnaState()

    @property
    def state(self) -> VnaState:
        """What is known now."""
        return self._state

    def note(self, **changes: Any) -> None:
        """Change what is known."""
        self._state = replace(self._state, **changes)

    def connect(self, address: str) -> str:
        """Make the first link to an address and return the instrument's identification.

        Raises:
            VnaError: Nothing, or another instrument, answers there.
        """
        self.drop()
        # The reports keep what was wrong until it is known better.
        self._state = VnaState(address, last_error=self._state.trouble)
        try:
            self._instrument, identity = self._open(address)
        except VnaError as error:
            self.note(last_error=str(error))
            raise
        self._state = VnaState(address, identity, linked=True)
        return identity

    def forget(self) -> None:
        """End the link and forget all that is known."""
        self.drop()
        self._state = VnaState()

    def drop(self) -> None:
        """End the link; the next use makes a new one."""
        instrument, self._instrument = self._instrument, None
        self.note(linked=False)
        if instrument is not None:
            instrument.close()

    def check_connected(self) -> None:
        """Do nothing if an instrument was connected, be there a link now or not.

        Raises:
            VnaNotReadyError: None was.
        """
        if not self._state.identity:
            raise VnaNotReadyError("the VNA is not connected; call the service connection first")

    def instrument(self) -> Ms2026c:
        """Return the instrument at the end of the link; make a link if there is none.

        Raises:
            VnaError: There can be none.
        """
        if self._instrument is None:
            self.check_connected()
            self._instrument = self._reopened()
            self.note(linked=True)
        return self._instrument

    def repeated(
        self,
        what: str,
        action: Callable[[Ms2026c], Result],
        final: Tuple[Type[VnaError], ...] = (),
    ) -> Tuple[Result, List[VnaError]]:
        """Do something with the instrument, again after a failure, each time on a new link.

        A failed exchange leaves it open which answers are still on their way; on a new link
        with emptied buffers there are none. All attempts share the time limit of the request, which
        the caller has begun.

        Args:
            what: What is done, for people.
            action: What is done.
            final: Failures after which it is not repeated.

        Returns:
            The result, and why the attempts before it failed.

        Raises:
            VnaError: It was given up.
        """
        failures: List[VnaError] = []
        while len(failures) < self._parameters.attempts:
            try:
                if failures:
                    self._pause_before_repeating(what, failures[-1])
                result = action(self.instrument())
            except (VnaClosedError, VnaNotReadyError):
                raise
            except VnaTimeoutError as error:
                text = f"{what} was given up: {error}"
                if failures:
                    text += f"; it failed before with: {failures[-1]}"
                raise self._failed(VnaTimeoutError(text)) from error
            except VnaError as error:
                failures.append(self._failed(error))
                if isinstance(error, final):
                    raise
            else:
                self.note(last_error="", link_error="")
                return result, failures
        text = f"{what} failed {len(failures)} times: {failures[-1]}"
        if isinstance(failures[-1], VnaDataError):
            text += "; look at the VNA's display, and switch it off and on if this goes on"
        raise VnaSweepError(text)

    def _failed(self, error: VnaError) -> VnaError:
        self.drop()
        self.note(last_error=str(error))
        return error

    def _pause_before_repeating(self, what: str, failure: VnaError) -> None:
        self.note(repeats=self._state.repeats + 1)
        self._warn(f"{what} failed and is repeated: {failure}")
        self.deadline.pause_s(self._parameters.retry_pause_s)

    def _reopened(self) -> Ms2026c:
        state = self._state
        instrument, identity = self._open(state.address)
        try:
            if identity != state.identity:
                raise VnaIdentityError(
                    f"the VNA at {state.address} is now '{identity}' and was "
                    f"'{state.identity}'; call the service connection again"
                )
            if state.sweep and instrument.set_frequency_sweep(state.sweep) != state.sweep:
                raise VnaSettingError("the instrument does not repeat the former sweep exactly")
            if state.trace_is_set:
                instrument.set_trace()
        except VnaError:
            instrument.close()
            raise
        return instrument

    def _open(self, address: str) -> Tuple[Ms2026c, str]:
        self.deadline.check()
        transport = self._connector(address)
        instrument = Ms2026c(transport, self._parameters, self.deadline, self._utc_now_us)
        try:
            return instrument, instrument.identify()
        except VnaError:
            instrument.close()
            raise
