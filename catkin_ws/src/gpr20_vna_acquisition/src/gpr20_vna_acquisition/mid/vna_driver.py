"""The network analyzer as the survey needs it: one fresh sweep, or a clear error."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Callable, List, Optional, Tuple, Type, TypeVar

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_common.mid.checks import ipv4_address
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaCalibrationError,
    VnaClosedError,
    VnaDataError,
    VnaError,
    VnaIdentityError,
    VnaNotReadyError,
    VnaSettingError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.low.time_of_day import TimeOfDay
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.patience import Patience
from gpr20_vna_acquisition.mid.trace_quality import (
    TraceQuality,
    calibration_refusal,
    refuse_impossible,
)
from gpr20_vna_acquisition.mid.transport import Connector
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_acquisition.mid.vna_state import VnaState

Result = TypeVar("Result")


class VNADriver:
    """Connects, configures and sweeps; repeats and reconnects within limits.

    All calls may come from any thread; the link carries one exchange at a time.
    """

    def __init__(
        self,
        connector: Connector,
        parameters: VnaParameters,
        clock: Clock,
        time_of_day: TimeOfDay,
        warn: Callable[[str], None],
    ) -> None:
        """Make a driver that is not connected.

        Args:
            connector: Opens a link to an address.
            parameters: Which instrument is expected and how patiently it is treated.
            clock: Measures waiting.
            time_of_day: Gives the time stamps.
            warn: Told of every attempt that is repeated.
        """
        self._connector = connector
        self._parameters = parameters
        self._patience = Patience(clock)
        self._time_of_day = time_of_day
        self._warn = warn
        self._lock = threading.RLock()
        self._instrument: Optional[Ms2026c] = None
        self._previous: Optional[Sweep] = None
        self._quality = TraceQuality(parameters.quality_limits)
        self._state = VnaState()

    @property
    def state(self) -> VnaState:
        """What the driver knows now; never waits for a running exchange."""
        return self._state

    def connect(self, address: str) -> str:
        """Connect to the instrument at an address and return its identification.

        A former connection is closed, and with it the configuration is forgotten.

        Raises:
            InvalidValueError: The address is not four numbers.
            VnaError: Nothing, or another instrument, answers there.
        """
        ipv4_address("VNA address", address)
        with self._lock:
            trouble = self._state.trouble
            self.disconnect()
            # What was wrong stands in the reports until it is known better.
            self._state = VnaState(last_error=trouble)
            self._patience.begin(self._parameters.request_limit_s())
            return self._connect_anew(address)

    def disconnect(self) -> None:
        """Close the link and forget the address; does nothing without one."""
        with self._lock:
            self._drop()
            self._state = VnaState()

    def shut_down(self) -> None:
        """End whatever waits, refuse what comes, close the link."""
        self._patience.close()
        self.disconnect()

    def configure(self, sweep: SweepSettings) -> SweepSettings:
        """Set up the sweep and return what the instrument confirmed.

        Raises:
            InvalidValueError: A value is not allowed.
            VnaError: The instrument did not take one.
        """
        self._parameters.check_sweep(sweep)
        with self._lock:
            # If this fails, nobody knows what the instrument would measure.
            self._state = replace(self._state, sweep=None)
            self._patience.begin(self._parameters.request_limit_s())
            accepted, _failures = self._repeated(
                "setting up the VNA", lambda instrument: instrument.configure(sweep),
                final=(VnaSettingError,),
            )  # fmt: skip
            self._state = replace(self._state, sweep=accepted)
            # Another sweep has another usual duration.
            self._quality = TraceQuality(self._parameters.quality_limits)
            return accepted

    def frequencies_hz(self) -> np.ndarray:
        """Return the frequencies of the configured sweep [Hz, float64].

        Raises:
            VnaNotReadyError: No sweep is configured.
        """
        return self._configured_sweep().frequencies_hz()

    def calibration_status(self) -> CalibrationStatus:
        """Return the state of the instrument's calibration, accepted or not.

        Raises:
            VnaError: It could not be read.
        """
        with self._lock:
            self._patience.begin(self._parameters.request_limit_s())
            status, _failures = self._repeated(
                "reading the VNA's calibration", Ms2026c.calibration_status
            )
            self._state = replace(self._state, calibration=status)
            return status

    def calibration_refusal(self, status: CalibrationStatus) -> str:
        """Say why no sweep is given with this calibration; empty if one is."""
        return calibration_refusal(status, self._parameters.accepted_calibrations)

    def sweep(self) -> Sweep:
        """Return one sweep that was triggered after this call.

        Raises:
            VnaCalibrationError: It was made with a calibration that is not accepted.
            VnaError: None of the attempts gave complete, finite, new data.
        """
        with self._lock:
            points = self._configured_sweep().points
            self._patience.begin(self._parameters.request_limit_s(points))
            (sweep, calibration), failures = self._repeated("the VNA's sweep", self._fresh_sweep)
            self._previous = sweep
            self._check_calibration(calibration)
            quality = self._quality.remarks(sweep, calibration, failures)
            self._state = replace(
                self._state,
                sweeps=self._state.sweeps + 1,
                last_sweep_s=sweep.duration_s,
                last_quality=quality,
            )
            return replace(sweep, quality=quality)

    def check_idle_link(self) -> None:
        """Ask an instrument that nobody used for a while for its calibration.

        So the reports say soon that a cable was pulled, and that it is back; also where the last
        `connect` failed. Never raises and never waits for a running request; does nothing while
        nobody wants a connection.
        """
        if self._patience.since_begin_s() < self._parameters.link_check_s:
            return
        if not self._lock.acquire(blocking=False):
            return
        try:
            if not (self._state.address or self._state.wanted):
                return
            self._patience.begin(self._parameters.request_limit_s())
            if self._state.wanted:
                self._connect_anew(self._state.wanted)
            calibration = self._linked_instrument().calibration_status()
            self._state = replace(self._state, calibration=calibration, link_error="")
        except VnaClosedError:
            self._drop()
        except VnaError as error:
            self._drop()
            self._state = replace(self._state, link_error=str(error))
        finally:
            self._lock.release()

    def _fresh_sweep(self, instrument: Ms2026c) -> Tuple[Sweep, CalibrationStatus]:
        sweep = instrument.sweep(self._configured_sweep())
        # Noise makes every sweep differ; the same bits again are an old buffer.
        if self._previous is not None and sweep.same_data(self._previous):
            raise VnaDataError("the instrument gave the very same data as for the sweep before")
        refuse_impossible(sweep)
        return sweep, instrument.calibration_status()

    def _check_calibration(self, calibration: CalibrationStatus) -> None:
        refusal = self.calibration_refusal(calibration)
        self._state = replace(self._state, calibration=calibration, last_error=refusal)
        # The link is kept: making a new one would set up the sweep while somebody calibrates.
        if refusal:
            raise VnaCalibrationError(refusal)

    def _configured_sweep(self) -> SweepSettings:
        state = self._state
        if not state.address:
            raise VnaNotReadyError("the VNA is not connected; call the service connection first")
        if state.sweep is None:
            raise VnaNotReadyError(
                "no sweep is configured; call the service freq_sweep_setup first"
            )
        return state.sweep

    def _repeated(
        self,
        what: str,
        action: Callable[[Ms2026c], Result],
        final: Tuple[Type[VnaError], ...] = (),
    ) -> Tuple[Result, List[VnaError]]:
        """Do something with the instrument, again after a failure, each time on a new link.

        A failed exchange leaves it open which answers are still on their way; on a new link
        with emptied buffers there are none.

        Returns:
            The result, and why the attempts before it failed.
        """
        failures: List[VnaError] = []
        while len(failures) < self._parameters.attempts:
            try:
                if failures:
                    self._warn_of_repetition(what, failures[-1])
                    self._patience.pause_s(self._parameters.retry_pause_s)
                result = action(self._linked_instrument())
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
                self._state = replace(self._state, last_error="", link_error="")
                return result, failures
        text = f"{what} failed {len(failures)} times: {failures[-1]}"
        if isinstance(failures[-1], VnaDataError):
            text += "; look at the VNA's display, and switch it off and on if this goes on"
        raise VnaSweepError(text)

    def _failed(self, error: VnaError) -> VnaError:
        self._drop()
        self._state = replace(self._state, last_error=str(error))
        return error

    def _warn_of_repetition(self, what: str, failure: VnaError) -> None:
        self._state = replace(self._state, repeats=self._state.repeats + 1)
        self._warn(f"{what} failed and is repeated: {failure}")

    def _linked_instrument(self) -> Ms2026c:
        if self._instrument is None:
            self._instrument = self._reopened()
            self._state = replace(self._state, linked=True)
        return self._instrument

    def _reopened(self) -> Ms2026c:
        state = self._state
        if not state.address:
            raise VnaNotReadyError("the VNA is not connected; call the service connection first")
        instrument, identity = self._open(state.address)
        try:
            if identity != state.identity:
                raise VnaIdentityError(
                    f"the VNA at {state.address} is now '{identity}' and was "
                    f"'{state.identity}'; call the service connection again"
                )
            if state.sweep is not None and instrument.configure(state.sweep) != state.sweep:
                raise VnaSettingError("the instrument does not repeat the former sweep exactly")
        except VnaError:
            instrument.close()
            raise
        return instrument

    def _connect_anew(self, address: str) -> str:
        try:
            self._instrument, identity = self._open(address)
        except VnaError as error:
            # Whoever looks at the reports must see more than that nothing is connected.
            self._state = VnaState(wanted=address, last_error=str(error))
            raise
        self._state = VnaState(address, identity, linked=True)
        return identity

    def _open(self, address: str) -> Tuple[Ms2026c, str]:
        self._patience.check()
        instrument = Ms2026c(
            self._connector(address), self._parameters, self._patience, self._time_of_day
        )
        try:
            return instrument, instrument.identify()
        except VnaError:
            instrument.close()
            raise

    def _drop(self) -> None:
        instrument, self._instrument = self._instrument, None
        self._state = replace(self._state, linked=False)
        if instrument is not None:
            instrument.close()
