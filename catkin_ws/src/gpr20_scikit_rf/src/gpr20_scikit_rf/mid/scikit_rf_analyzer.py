"""The analyzers that scikit-rf can control (`skrf.vi.vna`), over a VISA session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Sequence, Tuple, TypeVar

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import record_from
from gpr20_scikit_rf.low.visa_link import VisaLibrary, VisaLink
from gpr20_scikit_rf.mid.scikit_rf_dialects import DIALECTS, Setting
from gpr20_survey.faults import VNA_DOUBTFUL, VNA_FAILED
from gpr20_survey.trace.sweep import (
    MAX_IF_BANDWIDTH_HZ,
    AnalyzerSettings,
    CalibrationStatus,
    Sweep,
    SweepSettings,
)
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaDataError,
    VnaError,
    VnaSettingError,
    VnaSweepError,
)
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.trace_quality import has_old_points, timed_sweep
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")
# A start above the previous stop may be refused until the new stop is set.
SETTING_PASSES = 2
COMPLETE = ("1", "+1")
# A trigger during a sweep may be ignored, so the first sweep after a setting shows nothing. The
# shortest of the others is the one that the computer disturbed least.
LEARNING_SWEEPS = 3
# No sweep ends before this part of its duration; how exactly that is measured depends on the
# computer [s].
EARLIEST_END, TOLERANCE_S = 0.5, 0.05
# Some analyzers state 9.91E37 for a value that they do not have.
LONGEST_SWEEP_S = 3600.0
RELEASE_LIMIT_S = 2.0


@dataclass(frozen=True)
class ScikitRfOptions:
    """The `analyzer_options` of an analyzer of scikit-rf.

    Attributes:
        scikit_rf_class: Which class of scikit-rf controls the instrument, of `DIALECTS`.
        visa_library: VISA library of PyVISA: "@py" is PyVISA-py, "@ivi" that of the instrument's
            maker.
    """

    scikit_rf_class: str
    visa_library: str = "@py"

    def __post_init__(self) -> None:
        if self.scikit_rf_class not in DIALECTS:
            raise InvalidValueError(
                Message(
                    "scikit_rf_class is {name}; it must be one of {names}",
                    name=repr(self.scikit_rf_class[:64]),
                    names=", ".join(DIALECTS),
                )
            )


class ScikitRfAnalyzer:
    """Implements `Analyzer`.

    It never resets the instrument. Whether it is calibrated is not known to scikit-rf.
    """

    def __init__(
        self, parameters: VnaParameters, deadline: RequestDeadline, **options: Any
    ) -> None:
        """Load the libraries; begin without a session.

        Args:
            parameters: What is expected of the instrument.
            deadline: Ends a request that takes too long.
            **options: The attributes of `ScikitRfOptions`.

        Raises:
            InvalidValueError: A value of the configuration is not allowed.
            VnaError: A library is not installed, or too old.
        """
        chosen = record_from(ScikitRfOptions, options, "analyzer_options")
        self._parameters = parameters
        self._deadline = deadline
        self._dialect = DIALECTS[chosen.scikit_rf_class]()
        self._library = VisaLibrary(
            chosen.scikit_rf_class,
            chosen.visa_library,
            parameters.answer_timeout_s,
            parameters.clear_on_connect,
        )
        self._library.check_address(parameters.address)
        self._sweep_s = 0.0
        # The last data that were read, of whatever sweep.
        self._shown: Optional[np.ndarray] = None
        self._link: Optional[VisaLink] = None
        self._identity = ""
        self._accepted: Optional[SweepSettings] = None
        self._remarks: List[Message] = []

    def connect(self, address: str) -> None:
        """Open a session to a VISA resource name; an open one is closed."""
        self._library.check_address(address)
        self.disconnect()
        self._deadline.check()
        self._link = VisaLink(self._library, address)

    def identify(self) -> str:
        """Return the identification: maker, model, serial number, firmware."""
        identity = str(self._call(Message("identification"), lambda vna: vna.id)).strip()
        self._parameters.check_identity(identity)
        # Each session needs it: the object of scikit-rf remembers the format.
        self._call(Message("the transfer format"), self._dialect.set_format)
        if identity != self._identity:
            self._accepted = None
        self._identity = identity
        return identity

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that scikit-rf cannot make; no link is needed."""
        self._parameters.check_sweep(settings)
        analyzer = settings.analyzer
        asked_hz = (settings.start_frequency_hz, settings.stop_frequency_hz)
        if any(one != round(one) for one in (*asked_hz, analyzer.if_bandwidth_hz)):
            raise InvalidValueError(
                Message("this VNA is set in whole hertz; use such frequencies and IF bandwidth")
            )
        if analyzer.output_power or analyzer.averages > 1:
            raise InvalidValueError(
                Message(
                    "this VNA makes one sweep for a trace, and its output power can only be set "
                    "by hand; leave both empty in the survey, and use a smaller IF bandwidth in "
                    "place of averages"
                )
            )

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        self._accepted, self._remarks = None, []
        self._apply(self._dialect.settings(settings))
        accepted = self._call(Message("the settings"), self._read_settings)
        # Written so that NaN is refused too.
        if not 0.0 <= accepted.analyzer.if_bandwidth_hz <= MAX_IF_BANDWIDTH_HZ:
            raise VnaDataError(
                Message(
                    "the VNA states an impossible IF bandwidth: {bandwidth_hz:g} Hz",
                    bandwidth_hz=accepted.analyzer.if_bandwidth_hz,
                )
            )
        self._learn(accepted)
        self._accepted = accepted
        return accepted

    def sweep(self) -> Sweep:
        """Trigger one sweep, wait for its end and return the data.

        The analyzer itself says when a sweep has ended: it answers `*OPC?` only then. An analyzer
        that answers earlier is refused, because its data would be those of the sweep before.
        """
        settings, sweep_s = self._configured(), self._sweep_s
        # A trigger could be ignored, and the sweep that runs began before the request.
        self._check([self._dialect.hold()])
        started_us, started_s = time_of_day_us(), self._deadline.now_s()
        taken_s = self._sweep_once(settings, self._parameters.sweep_limit_s(sweep_s))
        if _is_too_early(taken_s, sweep_s):
            raise VnaSweepError(_too_early(taken_s, sweep_s), fault=VNA_FAILED)
        duration_s = self._deadline.now_s() - started_s
        before, self._shown = self._shown, self._read(settings)
        if has_old_points(self._shown, before, to_the_last=False):
            raise errors.old_data()
        return timed_sweep(settings, self._shown, started_us, duration_s)

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`."""
        self._check(self._dialect.settings(self._configured()))

    def calibration(self) -> CalibrationStatus:
        """Return that it is not reported, from an instrument that answers."""
        self._call(Message("the state of the calibration"), lambda vna: vna.wait_for_complete())
        return CalibrationStatus.NOT_REPORTED

    def release(self) -> None:
        """Leave the instrument sweeping by itself, with its front panel usable."""
        if self._link is None:
            return
        try:
            # Without the deadline, which has ended when the driver is shut down.
            what = Message("returning to the front panel")
            self._link.call(what, self._dialect.release, RELEASE_LIMIT_S)
        except VnaError:
            # The session is dead: there is nobody to release.
            self.disconnect()

    def disconnect(self) -> None:
        """End the session; never fails, and does nothing without one."""
        link, self._link = self._link, None
        if link is not None:
            link.close()

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes, with its averages [s]; None before `configure`."""
        return self._sweep_s if self._accepted else None

    @property
    def remarks(self) -> Sequence[Message]:
        """What is not known about this instrument."""
        return self._remarks

    def _learn(self, settings: SweepSettings) -> None:
        """Measure how long a sweep takes; the instrument is set up and held."""
        claimed_s = self._call(
            Message("the sweep time"), lambda vna: float(self._dialect.part(vna).sweep_time)
        )
        # Written so that NaN is refused too.
        if not 0.0 <= claimed_s <= LONGEST_SWEEP_S:
            raise VnaDataError(
                Message("the VNA states a sweep time of {claimed_s:g} s", claimed_s=claimed_s)
            )
        nominal_s = max(claimed_s, self._parameters.nominal_trace_s(settings))
        limit_s = self._parameters.sweep_limit_s(nominal_s)
        self._deadline.extend(LEARNING_SWEEPS * limit_s)
        _first_s, *others_s = [self._sweep_once(settings, limit_s) for _ in range(LEARNING_SWEEPS)]
        self._sweep_s = min(others_s)
        if _is_too_early(self._sweep_s, claimed_s):
            raise VnaSettingError(_too_early(self._sweep_s, claimed_s), fault=VNA_FAILED)
        # The next trace is known to be new by its difference from this one.
        self._shown = self._read(settings)

    def _sweep_once(self, settings: SweepSettings, limit_s: float) -> float:
        """Take one sweep and return how long it took [s]."""
        begun_s = self._deadline.now_s()
        try:
            answer = self._call(Message("the sweep"), self._dialect.sweep, limit_s)
        except VnaConnectionError as error:
            if self._deadline.now_s() - begun_s < limit_s:
                raise
            raise errors.sweep_not_ended(settings.points, limit_s) from error
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
        if s21.shape != (settings.points,) or not np.isfinite(s21).all():
            raise VnaDataError(
                Message(
                    "the VNA gave {found} points; expected {points}, with finite numbers",
                    found=s21.size,
                    points=settings.points,
                )
            )
        return np.ascontiguousarray(s21).view(np.float64)

    def _call(
        self, what: Message, action: Callable[[Any], Result], limit_s: Optional[float] = None
    ) -> Result:
        self._deadline.check()
        if self._link is None:
            raise errors.not_connected()
        return self._link.call(what, action, limit_s)

    def _configured(self) -> SweepSettings:
        if self._accepted is None:
            raise errors.not_configured()
        return self._accepted

    def _read_settings(self, vna: Any) -> SweepSettings:
        part = self._dialect.part(vna)
        return SweepSettings(
            float(part.freq_start),
            float(part.freq_stop),
            int(part.npoints),
            AnalyzerSettings(self._dialect.if_bandwidth(0.0).read(vna), averages=1),
        )

    def _apply(self, wanted: Sequence[Setting]) -> None:
        """Make the settings that differ; remark those that the calibration may depend on."""
        differing = self._differing(wanted)
        changed = [one.name for one, _found in differing if one.matters_to_calibration]
        for _ in range(SETTING_PASSES):
            for setting, _found in differing:
                self._write(setting)
            differing = self._differing(wanted) if differing else []
        if differing:
            raise errors.settings_refused(_described(differing))
        if changed:
            self._remarks.append(
                Message(
                    "{settings} of the VNA changed when it was set up; it does not report whether "
                    "its calibration still applies",
                    settings=in_a_row(changed),
                ).with_fault(VNA_DOUBTFUL)
            )

    def _write(self, setting: Setting) -> None:
        try:
            self._call(setting.name, setting.write)
        except VnaDataError as error:
            raise VnaSettingError(
                Message(
                    "the VNA cannot set {setting} to {value}; if the plan has this value, correct "
                    "it there",
                    setting=setting.name,
                    value=setting.value,
                    details=error.message.details,
                ),
                fault=CONFIGURATION,
            ) from error

    def _check(self, wanted: Sequence[Setting]) -> None:
        changed = self._differing(wanted)
        if changed:
            raise errors.settings_changed(_described(changed))

    def _differing(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, Any]]:
        found = [(setting, self._call(setting.name, setting.read)) for setting in wanted]
        return [(setting, value) for setting, value in found if value != setting.value]


def _is_too_early(sweep_s: float, usual_s: float) -> bool:
    return sweep_s < EARLIEST_END * usual_s - TOLERANCE_S


def _too_early(sweep_s: float, usual_s: float) -> Message:
    return Message(
        "the VNA reports the end of a sweep after {reported_s:.3g} s, but a sweep takes "
        "{usual_s:.3g} s; its data would not be new",
        reported_s=sweep_s,
        usual_s=usual_s,
    )


def _described(differing: Sequence[Tuple[Setting, Any]]) -> Message:
    return in_a_row(
        Message(
            "{setting} is {found} instead of {expected}",
            setting=setting.name,
            found=repr(found)[:40],
            expected=setting.value,
        )
        for setting, found in differing
    )
