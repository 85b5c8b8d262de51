"""The analyzer that a robot is configured for: an MS2026C, or a class of another package."""

from __future__ import annotations

import contextlib
import functools
from typing import Any, Callable, Mapping, Optional, Tuple, Type, TypeVar, cast

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
    return cast(DrivenAnalyzer, ForeignAnalyzer(made, parameters, deadline))


# What the calls that return something return.
RETURNS: Mapping[str, Callable[[Any], Any]] = {
    "identify": str,
    "configure": lambda found: _checked(found, SweepSettings),
    "sweep": lambda found: _checked(found, Sweep),
    "calibration": CalibrationStatus,
    "calibration_details": dict,
}
# What a class need not have.
OPTIONAL: Mapping[str, Callable[[], Any]] = {"calibration_details": dict, "forget": lambda: None}


class ForeignAnalyzer:
    """Makes the calls of `DrivenAnalyzer` on an object, and trusts no exception and no type.

    An exception that the driver does not know becomes a `VnaConnectionError`: the driver then makes
    a new link and tries again. A call that does not return is seen by `RequestDeadline.overdue`.
    """

    def __init__(
        self, analyzer: Analyzer, parameters: VnaParameters, deadline: RequestDeadline
    ) -> None:
        self._analyzer = analyzer
        self._parameters = parameters
        self._deadline = deadline
        # What its properties were after the last call.
        self.trace_duration_s: Optional[float] = None
        self.remarks: Tuple[Message, ...] = ()
        self.temperature_c: Optional[float] = None

    def __getattr__(self, name: str) -> Callable[..., Any]:
        return functools.partial(self._call, name)

    def release(self) -> None:
        """Leave the instrument sweeping by itself; never fails."""
        self._last_call("release")

    def disconnect(self) -> None:
        """End the link; never fails."""
        self._last_call("disconnect")

    def _call(self, name: str, *arguments: Any) -> Any:
        self._deadline.check()
        try:
            with self._watched(name):
                call: Any = getattr(self._analyzer, name, OPTIONAL.get(name))
                result = RETURNS.get(name, lambda _nothing: None)(call(*arguments))
                self.trace_duration_s = self._analyzer.trace_duration_s
                self.remarks = tuple(self._analyzer.remarks)
                temperature_c = getattr(self._analyzer, "temperature_c", None)
                self.temperature_c = None if temperature_c is None else float(temperature_c)
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

    def _last_call(self, name: str) -> None:
        with self._watched(name), contextlib.suppress(Exception):
            getattr(self._analyzer, name)()

    def _watched(self, name: str) -> contextlib.AbstractContextManager:
        limit_s = _usual_limit_s(self._parameters)
        if name == "sweep":
            # A class that does not say how long it takes has the time of a request.
            duration_s, longest_s = self.trace_duration_s, self._parameters.request_limit_s()
            limit_s += self._parameters.sweep_limit_s(duration_s) if duration_s else longest_s
        return self._deadline.watched(f"{self._parameters.analyzer}.{name}", limit_s)


def _usual_limit_s(parameters: VnaParameters) -> float:
    """Return how long a call may take that measures nothing [s]."""
    steps_s = 3.0 * parameters.connect_timeout_s + 2.0 * parameters.answer_timeout_s
    return steps_s + STEP_MARGIN_S


def _checked(value: Any, kind: Type[Result]) -> Result:
    if not isinstance(value, kind):
        raise TypeError(f"returned {type(value).__name__}, not {kind.__name__}")
    return value
