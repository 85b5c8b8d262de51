"""The analyzer that a robot is configured for: an MS2026C, or a class of another package."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Optional, Sequence, Tuple, Type, TypeVar

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_common.mid.extension import load_extension, options_refused
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.mid.analyzer import Analyzer, DrivenAnalyzer
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C, STEP_MARGIN_S, VnaParameters

Result = TypeVar("Result")


def make_analyzer(
    parameters: VnaParameters, connect_vxi11: Callable[[str], Transport], deadline: RequestDeadline
) -> DrivenAnalyzer:
    """Return the analyzer that a robot is configured for; it has no link yet.

    Args:
        parameters: The configuration.
        connect_vxi11: Opens a VXI-11 link to an address.
        deadline: Ends a request that takes too long.

    Raises:
        InvalidValueError: A class outside this package cannot be used.
        Gpr20Error: What the class itself says of its options.
    """
    if parameters.analyzer != MS2026C:
        return make_foreign_analyzer(parameters, deadline)
    return Ms2026c(connect_vxi11, parameters, deadline)


def load_analyzer(parameters: VnaParameters) -> Type:
    """Return the class that the parameters name; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no analyzer, or has other options.
    """
    name, options = parameters.analyzer, parameters.analyzer_options
    return load_extension("analyzer", name, Analyzer, 2, options)


def make_foreign_analyzer(parameters: VnaParameters, deadline: RequestDeadline) -> DrivenAnalyzer:
    """Return an analyzer whose class is in another package; raises as `make_analyzer` does."""
    found = load_analyzer(parameters)
    with deadline.watched(f"{parameters.analyzer}.__init__", _usual_limit_s(parameters)):
        try:
            made = found(parameters, deadline, **parameters.analyzer_options)
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise options_refused(
                "analyzer_options", found, f"{type(error).__name__}: {error}"
            ) from error
    return ForeignAnalyzer(made, parameters, deadline)


@dataclass(frozen=True)
class _Known:
    """What the properties of an object were after its last call; the last two are optional."""

    trace_duration_s: Optional[float] = None
    remarks: Tuple[Message, ...] = ()
    has_noise: bool = True
    temperature_c: Optional[float] = None

    @classmethod
    def of(cls, analyzer: Analyzer) -> _Known:
        temperature_c = getattr(analyzer, "temperature_c", None)
        return cls(
            analyzer.trace_duration_s,
            tuple(analyzer.remarks),
            bool(getattr(analyzer, "has_noise", True)),
            None if temperature_c is None else float(temperature_c),
        )


class ForeignAnalyzer:
    """Implements `DrivenAnalyzer`: passes every call on, and trusts no exception and no type.

    An exception that the driver does not know becomes a `VnaConnectionError`: the driver then makes
    a new link and tries again. A call that does not return is seen by `RequestDeadline.overdue`.
    """

    def __init__(
        self, analyzer: Analyzer, parameters: VnaParameters, deadline: RequestDeadline
    ) -> None:
        self._analyzer = analyzer
        self._parameters = parameters
        self._deadline = deadline
        self._known = _Known()

    def connect(self, address: str) -> None:
        """Open a link to an address; an open one is closed."""
        self._call("connect", lambda: self._analyzer.connect(address))

    def identify(self) -> str:
        """Return the identification."""
        return str(self._call("identify", self._analyzer.identify))

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have."""
        self._call("check_sweep", lambda: self._analyzer.check_sweep(settings))

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        return self._call(
            "configure", lambda: _checked(self._analyzer.configure(settings), SweepSettings)
        )

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data."""
        duration_s = self._known.trace_duration_s
        limit_s = math.inf if duration_s is None else self._parameters.sweep_limit_s(duration_s)
        return self._call("sweep", lambda: _checked(self._analyzer.sweep(), Sweep), limit_s)

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`."""
        self._call("confirm", self._analyzer.confirm)

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration."""
        return self._call("calibration", lambda: CalibrationStatus(self._analyzer.calibration()))

    def release(self) -> None:
        """Leave the instrument sweeping by itself; never fails."""
        self._last_call("release", self._analyzer.release)

    def disconnect(self) -> None:
        """End the link; never fails."""
        self._last_call("disconnect", self._analyzer.disconnect)

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes [s]; None before `configure`."""
        return self._known.trace_duration_s

    @property
    def remarks(self) -> Sequence[Message]:
        """What was learned about this instrument that a technician should know."""
        return self._known.remarks

    @property
    def has_noise(self) -> bool:
        """Whether two of its sweeps always differ; true unless the class says otherwise."""
        return self._known.has_noise

    @property
    def temperature_c(self) -> Optional[float]:
        """Its temperature at the last `confirm` [degC]; None if the class does not say."""
        return self._known.temperature_c

    def calibration_details(self) -> Mapping[str, Any]:
        """Return what else the class says of the calibration."""
        return self._call(
            "calibration_details",
            lambda: dict(getattr(self._analyzer, "calibration_details", dict)()),
        )

    def forget(self) -> None:
        """Forget what was learned about the instrument, if the class can."""
        self._call("forget", getattr(self._analyzer, "forget", int))

    def _call(self, name: str, action: Callable[[], Result], sweep_s: float = 0.0) -> Result:
        self._deadline.check()
        try:
            with self._watched(name, sweep_s):
                result = action()
                self._known = _Known.of(self._analyzer)
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise VnaConnectionError(
                Message(
                    "the VNA does not answer as it should; check its power and cable",
                    details=f"{type(error).__name__}: {error}",
                )
            ) from error
        return result

    def _last_call(self, name: str, action: Callable[[], None]) -> None:
        with self._watched(name), contextlib.suppress(Exception):
            action()

    def _watched(self, name: str, sweep_s: float = 0.0) -> contextlib.AbstractContextManager:
        limit_s = _usual_limit_s(self._parameters) + sweep_s
        return self._deadline.watched(f"{self._parameters.analyzer}.{name}", limit_s)


def _usual_limit_s(parameters: VnaParameters) -> float:
    """Return how long a call may take that measures nothing [s]."""
    steps_s = 3.0 * parameters.connect_timeout_s + 2.0 * parameters.answer_timeout_s
    return steps_s + STEP_MARGIN_S


def _checked(value: Any, kind: Type[Result]) -> Result:
    if not isinstance(value, kind):
        raise TypeError(f"returned {type(value).__name__}, not {kind.__name__}")
    return value
