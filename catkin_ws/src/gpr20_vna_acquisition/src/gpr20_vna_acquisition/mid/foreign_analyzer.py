"""An analyzer whose class is in another package."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Mapping, Optional, Sequence, Type, TypeVar, cast

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_common.mid.extension import check_options, load_extension, options_refused
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.mid.analyzer import Analyzer, DrivenAnalyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

Result = TypeVar("Result")


def load_analyzer(parameters: VnaParameters) -> Type:
    """Return the class that the parameters name; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no analyzer, or has other options.
    """
    found = load_extension("analyzer", parameters.analyzer, Analyzer)
    check_options("analyzer_options", found, 2, parameters.analyzer_options)
    return found


def make_foreign_analyzer(parameters: VnaParameters, deadline: RequestDeadline) -> DrivenAnalyzer:
    """Return the analyzer that the parameters name; it has no link yet.

    Raises:
        InvalidValueError: See `load_analyzer`; or it cannot be made with its options.
        Gpr20Error: What the class itself says of its options.
    """
    found = load_analyzer(parameters)
    try:
        made = found(parameters, deadline, **parameters.analyzer_options)
    except Gpr20Error:
        raise
    except Exception as error:  # the class is not ours: it may raise anything
        raise options_refused(
            "analyzer_options", found, f"{type(error).__name__}: {error}"
        ) from error
    return ForeignAnalyzer(cast(Analyzer, made), deadline)


class ForeignAnalyzer:
    """Implements `Analyzer`: passes every call on, and trusts no exception.

    An exception that the driver does not know becomes a `VnaConnectionError`: the driver then makes
    a new link and tries again.
    """

    def __init__(self, analyzer: Analyzer, deadline: RequestDeadline) -> None:
        self._analyzer = analyzer
        self._deadline = deadline

    def connect(self, address: str) -> None:
        """Open a link to an address; an open one is closed."""
        self._guarded(lambda: self._analyzer.connect(address))

    def identify(self) -> str:
        """Return the identification."""
        return str(self._guarded(self._analyzer.identify))

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have."""
        self._analyzer.check_sweep(settings)

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        return self._guarded(lambda: self._analyzer.configure(settings))

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data."""
        return self._guarded(self._analyzer.sweep)

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`."""
        self._guarded(self._analyzer.confirm)

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration."""
        return CalibrationStatus(self._guarded(self._analyzer.calibration))

    def release(self) -> None:
        """Leave the instrument sweeping by itself; never fails."""
        with contextlib.suppress(Exception):
            self._analyzer.release()

    def disconnect(self) -> None:
        """End the link; never fails."""
        with contextlib.suppress(Exception):
            self._analyzer.disconnect()

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes [s]; None before `configure`."""
        return self._analyzer.trace_duration_s

    @property
    def remarks(self) -> Sequence[Message]:
        """What was learned about this instrument that a technician should know."""
        return self._analyzer.remarks

    @property
    def has_noise(self) -> bool:
        """Whether two of its sweeps always differ; true unless the class says otherwise."""
        return bool(getattr(self._analyzer, "has_noise", True))

    @property
    def temperature_c(self) -> Optional[float]:
        """Its temperature at the last `confirm` [degC]; None if the class does not say."""
        value = getattr(self._analyzer, "temperature_c", None)
        return None if value is None else float(value)

    def calibration_details(self) -> Mapping[str, Any]:
        """Return what else the class says of the calibration."""
        return dict(self._guarded(getattr(self._analyzer, "calibration_details", dict)))

    def forget(self) -> None:
        """Forget what was learned about the instrument, if the class can."""
        self._guarded(getattr(self._analyzer, "forget", lambda: None))

    def _guarded(self, action: Callable[[], Result]) -> Result:
        self._deadline.check()
        try:
            return action()
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise VnaConnectionError(
                Message(
                    "the VNA does not answer as it should; check its power and cable",
                    details=f"{type(error).__name__}: {error}",
                )
            ) from error
