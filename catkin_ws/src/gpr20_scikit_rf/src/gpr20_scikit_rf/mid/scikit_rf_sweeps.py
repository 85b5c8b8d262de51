"""The sweeps of an analyzer of scikit-rf: trigger, wait for the end, read new data."""

from __future__ import annotations

from typing import Any, Callable, Optional, Protocol, TypeVar

import numpy as np

from gpr20_common.message import Message
from gpr20_scikit_rf.mid.scikit_rf_dialects import Dialect
from gpr20_survey.faults import VNA_FAILED, VNA_SETTINGS
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaDataError,
    VnaSettingError,
    VnaSweepError,
    old_data,
    sweep_not_ended,
)
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.trace_quality import has_old_points, timed_sweep
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")
COMPLETE = ("1", "+1")
# A trigger during a sweep may be ignored, so the first sweep after a setting shows nothing. The
# shortest of the others is the one that the computer disturbed least.
LEARNING_SWEEPS = 3
# No sweep ends before this part of its duration; how exactly that is measured depends on the
# computer [s].
EARLIEST_END, TOLERANCE_S = 0.5, 0.05
# Some analyzers state 9.91E37 for a value that they do not have.
LONGEST_SWEEP_S = 3600.0


class Call(Protocol):
    """Does something with the object of scikit-rf within a time limit."""

    def __call__(
        self, what: Message, action: Callable[[Any], Result], limit_s: Optional[float] = None
    ) -> Result:
        """Return what `action` returns."""


class ScikitRfSweeps:
    """Takes sweeps with the settings that were made before.

    The analyzer itself says when a sweep has ended: it answers `*OPC?` only then. An analyzer that
    answers earlier is refused, because its data would be those of the sweep before.
    """

    def __init__(
        self,
        call: Call,
        dialect: Dialect,
        parameters: VnaParameters,
        deadline: RequestDeadline,
        utc_now_us: Callable[[], int],
    ) -> None:
        self._call = call
        self._dialect = dialect
        self._parameters = parameters
        self._deadline = deadline
        self._utc_now_us = utc_now_us
        self._sweep_s: Optional[float] = None
        self._triggers = 1
        # The last data that were read, of whatever sweep.
        self._shown: Optional[np.ndarray] = None

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes [s]; None before `learn`."""
        return None if self._sweep_s is None else self._triggers * self._sweep_s

    def learn(self, settings: SweepSettings) -> None:
        """Measure how long a sweep takes; the instrument must be set up and held.

        Raises:
            VnaSweepError: A sweep did not end in time.
            VnaSettingError: The instrument does not wait for the end of its sweeps.
        """
        self._sweep_s = None
        self._triggers = self._call(
            Message("the number of averages"),
            lambda vna: self._dialect.triggers(vna, settings.analyzer.averages),
        )
        claimed_s = self._claimed_s()
        limit_s = self._parameters.sweep_limit_s(
            max(claimed_s, self._parameters.nominal_trace_s(settings))
        )
        self._deadline.extend(LEARNING_SWEEPS * limit_s)
        _first_s, *others_s = [self._sweep_once(settings, limit_s) for _ in range(LEARNING_SWEEPS)]
        sweep_s = min(others_s)
        if _is_too_early(sweep_s, claimed_s):
            raise VnaSettingError(_too_early(sweep_s, claimed_s), fault=VNA_FAILED)
        # The next trace is known to be new by its difference from this one.
        self._shown = self._read(settings)
        self._sweep_s = sweep_s

    def take(self, settings: SweepSettings) -> Sweep:
        """Return the data of a trace that is triggered now.

        Raises:
            VnaSweepError: A sweep did not end in time, or too early.
            VnaDataError: The data are incomplete, or not finite.
            VnaOldDataError: The data, or a part of them, are not new.
            VnaSettingError: The instrument is not held.
        """
        sweep_s = self._sweep_s
        assert sweep_s is not None
        self._check_held()
        started_us, started_s = self._utc_now_us(), self._deadline.now_s()
        if settings.analyzer.averages > 1:
            self._call(Message("a new average"), self._dialect.clear_averages)
        limit_s = self._parameters.sweep_limit_s(sweep_s)
        for _ in range(self._triggers):
            taken_s = self._sweep_once(settings, limit_s)
            if _is_too_early(taken_s, sweep_s):
                raise VnaSweepError(_too_early(taken_s, sweep_s), fault=VNA_FAILED)
        duration_s = self._deadline.now_s() - started_s
        before, self._shown = self._shown, self._read(settings)
        if has_old_points(self._shown, before, to_the_last=False):
            raise old_data()
        return timed_sweep(settings, self._shown, started_us, duration_s)

    def _claimed_s(self) -> float:
        """Return how long the instrument says that a sweep takes [s]."""
        claimed_s = self._call(Message("the sweep time"), self._dialect.sweep_time_s)
        # Written so that NaN is refused too.
        if not 0.0 <= claimed_s <= LONGEST_SWEEP_S:
            raise VnaDataError(
                Message("the VNA states a sweep time of {claimed_s:g} s", claimed_s=claimed_s)
            )
        return claimed_s

    def _check_held(self) -> None:
        hold = self._dialect.hold()
        if self._call(hold.name, hold.read) != hold.value:
            # A trigger could be ignored, and the sweep that runs began before the request.
            raise VnaSettingError(
                Message("the VNA sweeps by itself; do not operate it by hand during a survey"),
                fault=VNA_SETTINGS,
            )

    def _sweep_once(self, settings: SweepSettings, limit_s: float) -> float:
        """Take one sweep and return how long it took [s]."""
        begun_s = self._deadline.now_s()
        try:
            answer = self._call(Message("the sweep"), self._dialect.sweep, limit_s)
        except VnaConnectionError as error:
            if self._deadline.now_s() - begun_s < limit_s:
                raise
            raise sweep_not_ended(settings.points, limit_s) from error
        if answer not in COMPLETE:
            raise VnaDataError(
                Message(
                    "the VNA answers {answer} instead of 1 at the end of a sweep",
                    answer=repr(answer[:40]),
                    details="*OPC?",
                )
            )
        return self._deadline.now_s() - begun_s

    def _read(self, settings: SweepSettings) -> np.ndarray:
        """Return real and imaginary part of each point in turn."""
        s21 = self._call(Message("the data"), self._dialect.data)
        if s21.shape != (settings.points,):
            raise VnaDataError(
                Message(
                    "the VNA gave {found} points; expected {points}",
                    found=s21.size,
                    points=settings.points,
                )
            )
        numbers = np.ascontiguousarray(s21).view(np.float64)
        if not np.isfinite(numbers).all():
            raise VnaDataError(Message("the VNA gave numbers that are not finite"))
        return numbers


def _is_too_early(sweep_s: float, usual_s: float) -> bool:
    return sweep_s < EARLIEST_END * usual_s - TOLERANCE_S


def _too_early(sweep_s: float, usual_s: float) -> Message:
    return Message(
        "the VNA reports the end of a sweep after {reported_s:.3g} s, but a sweep takes "
        "{usual_s:.3g} s; its data would not be new",
        reported_s=sweep_s,
        usual_s=usual_s,
    )
