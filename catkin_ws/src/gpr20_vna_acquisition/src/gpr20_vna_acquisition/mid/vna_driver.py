"""The network analyzer for the survey: one fresh sweep, or a clear error."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any, Callable, Optional, Tuple

import numpy as np

from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaCalibrationError,
    VnaDataError,
    VnaError,
    VnaNotReadyError,
    VnaSettingError,
)
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c, Transport
from gpr20_vna_acquisition.mid.trace_quality import (
    TraceQuality,
    calibration_refusal,
    refuse_impossible,
    stored_remarks,
)
from gpr20_vna_acquisition.mid.vna_link import VnaLink, VnaState
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters


class VNADriver:
    """Connects, sets up and sweeps; retries and reconnects within limits.

    All calls may come from any thread; the link carries one exchange at a time.
    """

    def __init__(
        self,
        connector: Callable[[str], Transport],
        parameters: VnaParameters,
        clock: Clock,
        warn: Callable[[str], None],
        utc_now_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        """Make a driver that is not connected.

        Args:
            connector: Opens a link to an address, or raises VnaConnectionError.
            parameters: Which instrument is expected, and the time limits.
            clock: Measures waiting.
            warn: Called with a sentence for every attempt that is repeated.
            utc_now_us: Returns the time of day [us since 1970, UTC].
        """
        self._parameters = parameters
        self._link = VnaLink(connector, parameters, clock, warn, utc_now_us)
        self._lock = threading.RLock()
        self._previous: Optional[Sweep] = None
        self._quality = TraceQuality(parameters)

    @property
    def parameters(self) -> VnaParameters:
        """The parameters with which the driver started."""
        return self._parameters

    @property
    def state(self) -> VnaState:
        """What the driver knows now; never waits for a running exchange."""
        return self._link.state

    @property
    def trouble(self) -> Optional[Message]:
        """What is wrong now; None if nothing is."""
        calibration = self.state.calibration
        refusal = None if calibration is None else self.calibration_refusal(calibration)
        return self.state.trouble or refusal

    @property
    def vna_connected(self) -> bool:
        """Whether a link is open now; after a failure there is none until the next use."""
        return self.state.linked

    @property
    def vna_ip(self) -> str:
        """The requested address; empty without one."""
        return self.state.address

    def connect_to_vna(self, address: str) -> str:
        """Connect to the instrument at an address and return its identification.

        A previous connection is closed, and its configuration is forgotten.

        Raises:
            InvalidValueError: The address is not four numbers.
            VnaError: Nothing, or another instrument, answers there.
        """
        ipv4_address(Message("the VNA address"), address)
        with self._lock:
            self._begin_request()
            return self._link.connect(address)

    def disconnect_from_vna(self) -> None:
        """Close the link and forget the address; does nothing without one."""
        with self._lock:
            self._link.forget()

    def shut_down(self) -> None:
        """End waiting requests, refuse new ones, close the link."""
        self._link.deadline.close()
        self.disconnect_from_vna()

    def test_connection(self) -> None:
        """Ask the instrument for its calibration, once, over a new link if there is none.

        Also where the last `connect_to_vna` failed.

        Raises:
            VnaError: It does not answer, or no connection was requested.
        """
        with self._lock:
            self._begin_request()
            try:
                if self.state.address and not self.state.identity:
                    self._link.connect(self.state.address)
                calibration = self._link.instrument().calibration_status()
            except VnaNotReadyError:
                raise
            except VnaError as error:
                self._link.drop()
                self._link.note(link_error=error.message)
                raise
            self._link.note(calibration=calibration, link_error=None)

    def check_idle_link(self) -> None:
        """Test the connection to an instrument that was not used for a while.

        So the diagnostics soon report that a cable was pulled, and that it is back. Never raises
        and never waits for a running request.
        """
        if self._link.deadline.since_begin_s() < self._parameters.link_check_s:
            return
        if not self._lock.acquire(blocking=False):
            return
        try:
            self.test_connection()
        except VnaError:
            pass  # the diagnostics report it
        finally:
            self._lock.release()

    def check_calibration_status(self) -> CalibrationStatus:
        """Return the state of the instrument's calibration, accepted or not.

        Raises:
            VnaError: It could not be read.
        """
        with self._lock:
            self._begin_request()
            status, _failures = self._link.with_retries(
                Message("reading the VNA's calibration"), Ms2026c.calibration_status
            )
            self._link.note(calibration=status)
            return status

    def calibration_refusal(self, status: CalibrationStatus) -> Optional[Message]:
        """Return why no sweep is made with this calibration; None if one is."""
        return calibration_refusal(status, self._parameters)

    def set_up(self, settings: SweepSettings) -> SweepSettings:
        """Do `set_frequency_sweep` and `set_trace` within the time limit of one request."""
        self._parameters.check_sweep(settings)
        with self._lock:
            self._begin_request()
            accepted = self._set_frequencies(settings)
            self._select_trace()
            return accepted

    def set_frequency_sweep(self, settings: SweepSettings) -> SweepSettings:
        """Set start, stop and number of points and return what the instrument confirmed.

        Raises:
            InvalidValueError: A value is not allowed.
            VnaError: The instrument did not accept one.
        """
        self._parameters.check_sweep(settings)
        with self._lock:
            self._begin_request()
            return self._set_frequencies(settings)

    def set_trace(self) -> None:
        """Select what a trace is: S21 over frequency, not averaged, in the transfer format.

        Raises:
            VnaError: The instrument did not accept a setting.
        """
        with self._lock:
            self._begin_request()
            self._select_trace()

    def get_freq(self) -> np.ndarray:
        """Return the frequencies of the sweep that is set up [Hz, float64].

        Raises:
            VnaNotReadyError: No sweep is set up.
        """
        return self._set_up_sweep().frequencies_hz()

    def get_trace(self) -> Sweep:
        """Return one sweep that was triggered after this call.

        Raises:
            VnaCalibrationError: The calibration of the sweep is not accepted.
            VnaError: No attempt gave complete, finite, new data.
        """
        with self._lock:
            points = self._set_up_sweep().points
            self._begin_request(points)
            (sweep, calibration), failures = self._link.with_retries(
                Message("the VNA's sweep"), self._fresh_sweep
            )
            self._previous = sweep
            self._check_calibration(calibration)
            remarks = self._quality.remarks(sweep, calibration, failures)
            self._link.note(
                sweeps=self.state.sweeps + 1,
                last_sweep_s=sweep.duration_s,
                last_quality=remarks,
            )
            return replace(sweep, quality=stored_remarks(remarks))

    def _begin_request(self, points: int = 0) -> None:
        self._link.deadline.begin(self._parameters.request_limit_s(points))

    def _set_frequencies(self, settings: SweepSettings) -> SweepSettings:
        # If this fails, it is unknown what the instrument would measure.
        self._link.note(sweep=None)
        # Another sweep has another usual duration.
        self._quality = TraceQuality(self._parameters)
        accepted: SweepSettings = self._set(
            lambda instrument: instrument.set_frequency_sweep(settings)
        )
        self._link.note(sweep=accepted)
        return accepted

    def _select_trace(self) -> None:
        self._link.note(trace_is_set=False)
        self._set(Ms2026c.set_trace)
        self._link.note(trace_is_set=True)

    def _fresh_sweep(self, instrument: Ms2026c) -> Tuple[Sweep, CalibrationStatus]:
        sweep = instrument.sweep(self._set_up_sweep())
        # Noise makes every sweep differ; identical bits come from an old buffer.
        if self._previous is not None and sweep.same_data(self._previous):
            raise VnaDataError(
                Message("the VNA gave exactly the same data as in the previous sweep")
            )
        refuse_impossible(sweep)
        return sweep, instrument.calibration_status()

    def _check_calibration(self, calibration: CalibrationStatus) -> None:
        self._link.note(calibration=calibration)
        refusal = self.calibration_refusal(calibration)
        # The link stays open: a new one would set up the sweep while somebody calibrates.
        if refusal:
            raise VnaCalibrationError(refusal)

    def _set_up_sweep(self) -> SweepSettings:
        self._link.check_connected()
        state = self.state
        if state.sweep is None or not state.trace_is_set:
            raise VnaNotReadyError(
                Message(
                    "the VNA's sweep is not configured; configure it first",
                    details="service freq_sweep_setup",
                )
            )
        return state.sweep

    def _set(self, action: Callable[[Ms2026c], Any]) -> Any:
        result, _failures = self._link.with_retries(
            Message("setting up the VNA"), action, final=(VnaSettingError,)
        )
        return result
