"""The analyzers that scikit-rf can control (`skrf.vi.vna`), over a VISA session."""

from __future__ import annotations

from typing import Any, Callable, List, Optional, Sequence, Tuple, TypeVar

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import record_from
from gpr20_scikit_rf.low.visa_link import VisaLibrary, VisaLimits, VisaLink
from gpr20_scikit_rf.mid.scikit_rf_dialects import DIALECTS, Setting
from gpr20_scikit_rf.mid.scikit_rf_options import (
    ScikitRfOptions,
    check_parameters,
    visa_resource_name,
)
from gpr20_scikit_rf.mid.scikit_rf_sweeps import ScikitRfSweeps
from gpr20_survey.faults import VNA_DOUBTFUL, VNA_SETTINGS
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import (
    MAX_AVERAGES,
    MAX_IF_BANDWIDTH_HZ,
    AnalyzerSettings,
    SweepSettings,
)
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaDataError, VnaError, VnaSettingError
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.trace_quality import calibration_lost
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")
# A start above the previous stop may be refused until the new stop is set.
SETTING_PASSES = 2
CORRECTION_ON, CORRECTION_OFF = ("1", "+1", "ON"), ("0", "+0", "OFF")


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
            VnaLibraryError: A library is not installed, or too old.
        """
        self._options = record_from(ScikitRfOptions, options, "analyzer_options")
        check_parameters(parameters)
        self._parameters = parameters
        self._deadline = deadline
        self._dialect = DIALECTS[self._options.scikit_rf_class]()
        self._library = VisaLibrary(
            self._options.scikit_rf_class.value,
            self._options.visa_library,
            VisaLimits(
                answer_s=parameters.answer_timeout_s,
                clear=parameters.clear_on_connect,
            ),
            self._dialect.needs,
        )
        self._sweeps = ScikitRfSweeps(
            self._call, self._dialect, parameters, deadline, time_of_day_us
        )
        self._link: Optional[VisaLink] = None
        self._identity = ""
        self._accepted: Optional[SweepSettings] = None
        self._remarks: List[Message] = []

    def connect(self, address: str) -> None:
        """Open a session to a VISA resource name; an open one is closed."""
        visa_resource_name(Message("the VNA address"), address)
        self.disconnect()
        self._deadline.check()
        self._link = self._library.connect(address)

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
        for name, value_hz in (
            (Message("the start frequency"), settings.start_frequency_hz),
            (Message("the stop frequency"), settings.stop_frequency_hz),
            (Message("the IF bandwidth"), settings.analyzer.if_bandwidth_hz),
        ):
            if value_hz != round(value_hz):
                raise InvalidValueError(
                    Message(
                        "{name} is {value_hz} Hz; this VNA is set in whole hertz",
                        name=name,
                        value_hz=f"{value_hz:.12g}",
                    )
                )
        if settings.analyzer.output_power:
            raise InvalidValueError(
                Message(
                    "the output power of this VNA can only be set by hand; leave it empty in the "
                    "survey"
                )
            )

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        self._accepted, self._remarks = None, []
        before = self.calibration()
        written = self._apply(self._dialect.settings(settings))
        self._check_calibration_kept(before, written)
        accepted = self._call(Message("the settings"), self._read_settings)
        _check_analyzer_settings(accepted.analyzer)
        if not accepted.fulfils(settings):
            raise VnaSettingError(
                Message("the VNA's settings changed by themselves; do not operate it by hand"),
                fault=VNA_SETTINGS,
            )
        self._sweeps.learn(accepted)
        self._accepted = accepted
        return accepted

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data."""
        return self._sweeps.take(self._configured())

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`."""
        changed = self._differing(self._dialect.settings(self._configured()))
        if changed:
            raise errors.settings_changed(_described(changed))

    def calibration(self) -> CalibrationStatus:
        """Return NONE if the configured query says so; its accuracy is never reported."""
        query = self._options.correction_query
        what = Message("the state of the calibration")
        if not query:
            # The driver asks this to learn whether the instrument still answers.
            self._call(what, lambda vna: vna.wait_for_complete())
            return CalibrationStatus.NOT_REPORTED
        answer = str(self._call(what, lambda vna: vna.query(query))).strip().upper()
        if answer in CORRECTION_OFF:
            return CalibrationStatus.NONE
        if answer in CORRECTION_ON:
            return CalibrationStatus.NOT_REPORTED
        raise VnaDataError(
            Message(
                "the VNA answers {answer} to {query}; expected 0 or 1; check correction_query",
                answer=repr(answer[:40]),
                query=query,
            ),
            fault=CONFIGURATION,
        )

    def release(self) -> None:
        """Leave the instrument sweeping by itself, with its front panel usable."""
        if self._link is None:
            return
        try:
            self._link.release(self._dialect.release)
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
        return self._sweeps.trace_duration_s if self._accepted else None

    @property
    def remarks(self) -> Sequence[Message]:
        """What is not known about this instrument."""
        return self._remarks

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
        part = self._dialect.sweep_part(vna)
        return SweepSettings(
            float(part.freq_start),
            float(part.freq_stop),
            int(part.npoints),
            AnalyzerSettings(
                if_bandwidth_hz=self._dialect.if_bandwidth_hz(vna),
                averages=self._dialect.averages(vna),
            ),
        )

    def _apply(self, wanted: Sequence[Setting]) -> List[Setting]:
        """Make the settings that differ and return them."""
        differing = self._differing(wanted)
        written = [setting for setting, _found in differing]
        for _ in range(SETTING_PASSES):
            for setting, _found in differing:
                self._write(setting)
            differing = self._differing(wanted) if differing else []
        if differing:
            raise errors.settings_refused(_described(differing))
        return written

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

    def _differing(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, Any]]:
        found = [(setting, self._call(setting.name, setting.read)) for setting in wanted]
        return [(setting, value) for setting, value in found if value != setting.value]

    def _check_calibration_kept(
        self, before: CalibrationStatus, written: Sequence[Setting]
    ) -> None:
        changed = [setting.name for setting in written if setting.matters_to_calibration]
        if not changed or before is CalibrationStatus.NONE:
            return
        if not self._options.correction_query:
            self._remarks.append(
                Message(
                    "{settings} of the VNA changed when it was set up; it does not report whether "
                    "its calibration still applies",
                    settings=in_a_row(changed),
                ).with_fault(VNA_DOUBTFUL)
            )
        elif self.calibration() is CalibrationStatus.NONE:
            raise calibration_lost(changed)


def _check_analyzer_settings(found: AnalyzerSettings) -> None:
    # Written so that NaN is refused too.
    if not 0.0 <= found.if_bandwidth_hz <= MAX_IF_BANDWIDTH_HZ:
        name, value = Message("the IF bandwidth [Hz]"), f"{found.if_bandwidth_hz:g}"
    elif not 1 <= found.averages <= MAX_AVERAGES:
        name, value = Message("the number of averages"), str(found.averages)
    else:
        return
    raise VnaDataError(
        Message("the VNA states an impossible value: {name} is {value}", name=name, value=value)
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
