"""The link to the network analyzer, which is made again after each failure."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field, replace
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple, Type, TypeVar

from gpr20_common.message import Message
from gpr20_survey.trace.sweep import CalibrationStatus, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaCalibrationError,
    VnaClosedError,
    VnaConnectionError,
    VnaError,
    VnaNotReadyError,
    VnaOldDataError,
    VnaReplacedError,
    VnaSettingError,
    VnaSweepError,
    VnaTimeoutError,
    not_connected,
    replaced,
)
from gpr20_vna_acquisition.mid.analyzers import DrivenAnalyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")
# Failures that another attempt cannot undo.
ALWAYS_FINAL = (VnaReplacedError, VnaCalibrationError)


@dataclass(frozen=True)
class VnaState:
    """What the driver knows, for the diagnostics.

    Attributes:
        address: The requested address; empty without one.
        identity: Identification of the instrument there; empty until it answers.
        linked: Whether a link is open now. After a failure there is none until the next use.
        sweep: What is measured, as the instrument confirmed it; None if it is not set up.
        repeats: How many attempts of any kind had to be repeated.
        last_quality: Remarks on the last sweep.
        last_error: Why the last attempt failed; None if the instrument has answered since.
        calibration: State of the calibration when it was last read; None before.
        calibration_details: What else the instrument said of it when it was asked.
    """

    address: str = ""
    identity: str = ""
    linked: bool = False
    sweep: Optional[SweepSettings] = None
    repeats: int = 0
    last_quality: Tuple[Message, ...] = ()
    last_error: Optional[Message] = None
    calibration: Optional[CalibrationStatus] = None
    calibration_details: Mapping[str, Any] = field(default_factory=dict)


class VnaLink:
    """The link to one instrument; replaced after each failure, with the same configuration."""

    def __init__(
        self,
        analyzer: DrivenAnalyzer,
        parameters: VnaParameters,
        deadline: RequestDeadline,
        warn: Callable[[str], None],
    ) -> None:
        """Begin without a link; the arguments are those of `VNADriver`."""
        self.deadline = deadline
        self._analyzer = analyzer
        self._parameters = parameters
        self._warn = warn
        # Whether the instrument cannot have lost its settings since they were made or compared.
        self._settings_sure = False
        # How often a new link showed that the last sweep cannot be confirmed any more.
        self.restorations = 0
        self.state = VnaState()

    def note(self, **changes: Any) -> None:
        self.state = replace(self.state, **changes)

    def note_set_up(self, sweep: SweepSettings) -> None:
        """Note that the instrument at the end of the link is set up."""
        self.note(sweep=sweep)
        self._settings_sure = True

    def connect(self, address: str) -> str:
        """Make the first link to an address and return the instrument's identification."""
        self.drop()
        # The diagnostics report the old fault until the result is known.
        self.state = VnaState(last_error=self.state.last_error)
        try:
            identity = self._open(address)
        except VnaError as error:
            self.note(address=address, last_error=error.message)
            raise
        self.state = VnaState(address, identity, linked=True)
        return identity

    def forget(self) -> None:
        """Release the instrument, end the link and reset the state."""
        # After a lost link too it may hold its sweep; one that does not answer cannot be released.
        with contextlib.suppress(VnaError):
            self.linked()
        self._analyzer.release()
        self.drop()
        self.state = VnaState()

    def drop(self) -> None:
        """End the link; the next use makes a new one."""
        self._settings_sure = False
        self.note(linked=False)
        self._analyzer.disconnect()

    def check_connected(self) -> None:
        """Raise unless an instrument was connected, whether the link is open now or not."""
        if not self.state.identity:
            raise not_connected()

    def linked(self) -> DrivenAnalyzer:
        """Return the instrument at the end of the link; make a link if there is none.

        Its settings are neither compared nor made: somebody may be calibrating it.
        """
        state = self.state
        if state.linked:
            return self._analyzer
        self.check_connected()
        identity = self._open(state.address)
        if identity != state.identity:
            self.drop()
            raise replaced(identity, state.identity)
        self.note(linked=True)
        return self._analyzer

    def instrument(self, restore: bool = True) -> DrivenAnalyzer:
        """Return the instrument as it was set up, at the end of the link.

        On a new link its settings are compared; those that differ are made again, or refused.
        """
        analyzer, sweep = self.linked(), self.state.sweep
        if sweep is None or self._settings_sure:
            return analyzer
        try:
            analyzer.confirm()
        except VnaOldDataError:
            # The next attempt does not know it; the last sweep must not be confirmed any more.
            self.restorations += 1
            raise
        except (VnaNotReadyError, VnaSettingError):
            if not restore:
                raise
            self.restorations += 1
            if analyzer.configure(sweep) != sweep:
                raise VnaSettingError(
                    Message("the VNA did not accept exactly the same sweep as before")
                ) from None
        self._settings_sure = True
        return analyzer

    def with_retries(
        self,
        what: Message,
        action: Callable[[DrivenAnalyzer], Result],
        final: Tuple[Type[VnaError], ...] = (),
        restore: bool = True,
    ) -> Tuple[Result, List[VnaError]]:
        """Do something with the instrument; retry after a failure, each time on a new link.

        After a failed exchange, answers may still be on their way; a new link with empty buffers
        has none. All attempts share the time limit of the request, which the caller has begun.
        Without a link it is retried until that time limit; other failures are counted.

        Args:
            what: What is done.
            action: Does it.
            final: Failures that another attempt cannot undo, besides `ALWAYS_FINAL`.
            restore: Whether settings that differ are made again on a new link.

        Returns:
            The result, and why the attempts before it failed.
        """
        failures: List[VnaError] = []
        attempts = 0
        while attempts < self._parameters.attempts:
            try:
                if failures:
                    self._pause_before_retry(what, failures)
                result = action(self.instrument(restore))
            except (VnaClosedError, VnaNotReadyError):
                raise
            except VnaTimeoutError as error:
                # What failed says more about what to do than that no time is left.
                reason = failures[-1].message if failures else error.message
                text = Message("{what} was given up: {reason}", what=what, reason=reason)
                raise self.failed(VnaTimeoutError(text)) from error
            except VnaError as error:
                failures.append(self.failed(error))
                if isinstance(error, (*final, *ALWAYS_FINAL)):
                    raise
                attempts += not isinstance(error, VnaConnectionError)
            else:
                self.note(last_error=None)
                return result, failures
        raise VnaSweepError(
            Message(
                "{what} failed {attempts} times: {reason}; look at the VNA's display; power-cycle "
                "it if this persists",
                what=what,
                attempts=attempts,
                reason=failures[-1].message,
            )
        )

    def failed(self, error: VnaError) -> VnaError:
        """End the link after an error, which is noted and returned."""
        self.drop()
        self.note(last_error=error.message)
        return error

    def _pause_before_retry(self, what: Message, failures: Sequence[VnaError]) -> None:
        self.note(repeats=self.state.repeats + 1)
        # A link that is lost for long fails the same way many times.
        if len(failures) == 1:
            self._warn(f"{what} failed and is retried: {failures[0]}")
        self.deadline.pause_s(self._parameters.retry_pause_s)

    def _open(self, address: str) -> str:
        self.deadline.check()
        self._analyzer.connect(address)
        try:
            identity = self._analyzer.identify()
        except VnaError:
            self._analyzer.disconnect()
            raise
        return identity
