"""The network analyzer for the survey: one fresh sweep, or a clear error."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import replace
from typing import Callable, Generator, NamedTuple, Optional, Tuple

import numpy as np

from gpr20_common.faults import BUSY
from gpr20_common.message import Message
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.trace.sweep import CalibrationStatus, Sweep, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaCalibrationError,
    VnaError,
    VnaNotReadyError,
    VnaOldDataError,
    VnaSettingError,
    VnaTimeoutError,
    not_configured,
    old_data,
)
from gpr20_vna_acquisition.mid.analyzers import DrivenAnalyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.trace_quality import (
    calibration_refusal,
    calibration_remarks,
    data_remarks,
    refuse_impossible,
    retry_remarks,
    stored_remarks,
)
from gpr20_vna_acquisition.mid.vna_link import VnaLink, VnaState
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# How long a shutdown waits for the request that runs [s].
LAST_REQUEST_S = 5.0


class SweepConfirmation(NamedTuple):
    """Remarks on the calibration of a sweep; temperature of the analyzer [degC], if it says it."""

    remarks: Tuple[str, ...]
    temperature_c: Optional[float]


class VNADriver:
    """Connects, sets up and sweeps; retries and reconnects within limits.

    All calls may come from any thread; the link carries one exchange at a time.
    """

    def __init__(
        self,
        analyzer: DrivenAnalyzer,
        parameters: VnaParameters,
        deadline: RequestDeadline,
        warn: Callable[[str], None],
    ) -> None:
        """Make a driver that is not connected.

        Args:
            analyzer: The instrument; only this driver uses it.
            parameters: The time limits, and what is expected of the data.
            deadline: Ends a request that takes too long; the analyzer has the same one.
            warn: Called with a sentence for attempts that are repeated.
        """
        self.parameters = parameters
        self._analyzer = analyzer
        self._link = VnaLink(analyzer, parameters, deadline, warn)
        self._lock = threading.RLock()
        # When the last request ended.
        self._last_used_s = deadline.now_s()
        self._number = 0
        # The sweep that may be confirmed, and how often settings had been restored before it: its
        # own are not known any more once that happens again.
        self._unconfirmed: Optional[Tuple[int, int]] = None
        # What the next sweep must differ from.
        self._last_sweep: Optional[Sweep] = None
        # How long a trace took when it was set up.
        self._promised_trace_s = 0.0
        self._news: Tuple[Message, ...] = ()

    @property
    def state(self) -> VnaState:
        """What the driver knows now; never waits for a running exchange."""
        return self._link.state

    @property
    def trouble(self) -> Optional[Message]:
        """What is wrong now; None if nothing is."""
        calibration = self.state.calibration
        refusal = None if calibration is None else self.calibration_refusal(calibration)
        return self.state.last_error or refusal

    def connect_to_vna(self, address: str) -> str:
        """Connect to the instrument at an address and return its identification.

        A previous connection is closed, and its configuration is forgotten; a request that still
        uses it ends.

        Raises:
            InvalidValueError: The address is not one of this kind of instrument.
        """
        self._link.deadline.abandon()
        with self._request():
            self._unconfirmed = self._last_sweep = None
            return self._link.connect(address)

    def disconnect_from_vna(self) -> None:
        """Release the instrument, close the link and forget the address; nothing without one.

        A sweep that is still waited for, perhaps for minutes, is given up.
        """
        self._link.deadline.abandon()
        with self._lock:
            self._unconfirmed = None
            self._link.deadline.begin(self.parameters.request_limit_s())
            self._link.forget()

    def shut_down(self) -> None:
        """End waiting requests, refuse new ones, close the link."""
        self._link.deadline.close()
        # A call that does not return, of a class of others, ends with the process.
        if self._lock.acquire(timeout=LAST_REQUEST_S):
            try:
                self.disconnect_from_vna()
            finally:
                self._lock.release()

    def check_idle_link(self) -> None:
        """Ask an instrument that was not used for a while for its calibration, once.

        So the diagnostics soon report that a cable was pulled, and that it is back, also where
        `connect_to_vna` failed. No sweep is made, because somebody may be calibrating. Never
        raises, never waits for a request.
        """
        idle_s = self._link.deadline.now_s() - self._last_used_s
        if idle_s < self.parameters.link_check_s or not self._lock.acquire(blocking=False):
            return
        try:
            with self._request():
                if self.state.address and not self.state.identity:
                    self._link.connect(self.state.address)
                calibration = self._link.linked().calibration()
                self._link.note(calibration=calibration, last_error=None)
        except VnaNotReadyError:
            pass  # nothing was connected
        except VnaError as error:
            self._link.failed(error)
        finally:
            self._lock.release()

    def check_calibration_status(self) -> CalibrationStatus:
        """Return the state of the instrument's calibration, accepted or not."""
        with self._request():
            (details, status), _failures = self._link.with_retries(
                Message("reading the VNA's calibration"),
                lambda analyzer: (self._analyzer.calibration_details(), analyzer.calibration()),
            )
            self._link.note(calibration=status, calibration_details=details)
            return status

    def calibration_refusal(self, status: CalibrationStatus) -> Optional[Message]:
        """Return why no sweep is made with this calibration; None if one is."""
        return calibration_refusal(status, self.parameters, self.state.calibration_details)

    def set_frequency_sweep(self, settings: SweepSettings) -> SweepSettings:
        """Set up what a sweep measures, and return what the instrument confirmed.

        Raises:
            InvalidValueError: A value is not allowed.
        """
        with self._request(extensible=True):
            self._analyzer.check_sweep(settings)
            # If this fails, it is unknown what the instrument would measure.
            self._link.note(sweep=None)
            self._unconfirmed = self._last_sweep = None
            accepted, _failures = self._link.with_retries(
                Message("setting up the VNA"),
                lambda analyzer: analyzer.configure(settings),
                final=(VnaSettingError,),
            )
            self._link.note_set_up(accepted)
            self._promised_trace_s = self.trace_duration_s
            self._news = tuple(self._analyzer.remarks)
            return accepted

    @property
    def trace_duration_s(self) -> float:
        """How long one trace takes, as measured when the sweep was set up [s]; 0 before."""
        return self._analyzer.trace_duration_s or 0.0

    @property
    def answered_within_s(self) -> float:
        """When a request is answered at the latest, whatever the instrument does [s].

        It stays as it is until the next set-up: callers rely on it.
        """
        return self.parameters.answered_within_s(self._promised_trace_s)

    def get_freq(self) -> np.ndarray:
        """Return the frequencies of the sweep that is set up [Hz, float64]."""
        return self._set_up_sweep().frequencies_hz()

    def get_trace(self) -> Sweep:
        """Return one sweep that was triggered after this call, confirmed."""
        with self._request(self._promised_trace_s):
            number, sweep = self.take_sweep()
            return replace(sweep, quality=(*sweep.quality, *self.confirm(number).remarks))

    def take_sweep(self) -> Tuple[int, Sweep]:
        """Return one sweep that was triggered after this call, and its number for `confirm`.

        The data are valid only once `confirm` has returned.
        """
        with self._request(self._promised_trace_s):
            sweep, failures = self._link.with_retries(Message("the VNA's sweep"), self._fresh_sweep)
            self._number += 1
            self._unconfirmed = self._number, self._link.restorations
            remarks = *data_remarks(sweep, self.parameters), *retry_remarks(failures), *self._news
            self._news = ()
            self._link.note(last_quality=remarks)
            quality = *sweep.quality, *stored_remarks(remarks)
            return self._number, replace(sweep, quality=quality)

    def confirm(self, number: int) -> SweepConfirmation:
        """Confirm the last sweep, by the number that `take_sweep` returned.

        Raises:
            VnaCalibrationError: The calibration of the sweep is not accepted.
            VnaSettingError: A setting was changed; the next sweep is set up again.
            VnaOldDataError: Its data were not all its own.
            VnaNotReadyError: It is not the last sweep, or the instrument was connected or set up
                again since.
        """
        with self._request():
            self._link.check_connected()
            unconfirmed, self._unconfirmed = self._unconfirmed, None
            if unconfirmed != (number, self._link.restorations):
                raise VnaNotReadyError(
                    Message("sweep {number} cannot be confirmed any more", number=number),
                    fault=CAN_RESUME,
                )
            calibration, _failures = self._link.with_retries(
                Message("confirming the VNA's settings"),
                _confirmed_calibration,
                # Another attempt would have nothing to compare with.
                final=(VnaSettingError, VnaOldDataError),
                # Settings that are made again would hide that they were different.
                restore=False,
            )
            self._link.note(calibration=calibration)
            refusal = self.calibration_refusal(calibration)
            # The link stays open: a new one would set up the sweep while somebody calibrates.
            if refusal:
                raise VnaCalibrationError(refusal)
            remarks = stored_remarks(calibration_remarks(calibration))
            return SweepConfirmation(remarks, self._analyzer.temperature_c)

    @contextmanager
    def _request(
        self, trace_duration_s: float = 0.0, extensible: bool = False
    ) -> Generator[None, None, None]:
        """Begin a request; its time limit includes the wait for another request."""
        deadline, arrived_s = self._link.deadline, self._link.deadline.now_s()
        limit_s = self.parameters.request_limit_s(trace_duration_s)
        if not self._lock.acquire(timeout=limit_s):
            raise VnaTimeoutError(
                Message(
                    "the VNA driver was busy with another request for {limit_s:.3g} s",
                    limit_s=limit_s,
                ),
                fault=BUSY,
            )
        try:
            deadline.begin(limit_s, deadline.now_s() - arrived_s, extensible)
            yield
        finally:
            self._last_used_s = deadline.now_s()
            self._lock.release()

    def _fresh_sweep(self, analyzer: DrivenAnalyzer) -> Sweep:
        self._set_up_sweep()
        sweep, before = analyzer.sweep(), self._last_sweep
        refuse_impossible(sweep)
        self._last_sweep = sweep
        if (
            before is not None
            and np.array_equal(sweep.s21_real, before.s21_real)
            and np.array_equal(sweep.s21_imag, before.s21_imag)
        ):
            raise old_data()
        return sweep

    def _set_up_sweep(self) -> SweepSettings:
        self._link.check_connected()
        if self.state.sweep is None:
            raise not_configured()
        return self.state.sweep


def _confirmed_calibration(analyzer: DrivenAnalyzer) -> CalibrationStatus:
    analyzer.confirm()
    return analyzer.calibration()
