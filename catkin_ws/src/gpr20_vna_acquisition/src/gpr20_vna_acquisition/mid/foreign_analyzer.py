"""An analyzer whose class is in another package."""

from __future__ import annotations

import contextlib
import math
import threading
from typing import (
    Any,
    Callable,
    Iterator,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    cast,
)

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.message import Message
from gpr20_common.mid.extension import load_extension, options_refused
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaNoAnswerError
from gpr20_vna_acquisition.low.call_thread import CallNotEndedError, CallThread
from gpr20_vna_acquisition.mid.analyzer import Analyzer, DrivenAnalyzer
from gpr20_vna_acquisition.mid.analyzer_instance import (
    AnalyzerInstance,
    Known,
    checked,
    request_check,
    unlimited,
)
from gpr20_vna_acquisition.mid.refusals import not_connected
from gpr20_vna_acquisition.mid.request_deadline import LentDeadline, RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import STEP_MARGIN_S, VnaParameters

Result = TypeVar("Result")
# Each of the calls that no request limits may take so long [s].
LAST_CALL_S = 2.0
# So many calls that have never returned are the most that may be left behind.
MOST_ABANDONED = 8


def load_analyzer(parameters: VnaParameters) -> Type:
    """Return the class that the parameters name; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no analyzer, or has other options.
    """
    name, options = parameters.analyzer, parameters.analyzer_options
    return load_extension("analyzer", name, Analyzer, 2, options)


def make_foreign_analyzer(parameters: VnaParameters, deadline: RequestDeadline) -> DrivenAnalyzer:
    """Return the analyzer that the parameters name; it has no link yet.

    Raises:
        InvalidValueError: See `load_analyzer`; or it cannot be made with its options.
        Gpr20Error: What the class itself says of its options.
    """
    found = load_analyzer(parameters)

    def make(lent: LentDeadline) -> Analyzer:
        try:
            return cast(Analyzer, found(parameters, lent, **parameters.analyzer_options))
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise options_refused(
                "analyzer_options", found, f"{type(error).__name__}: {error}"
            ) from error

    return ForeignAnalyzer(make, parameters, deadline)


class ForeignAnalyzer:
    """Implements `Analyzer`: passes every call on, and trusts no exception and no return.

    An exception that the driver does not know becomes a `VnaConnectionError`: the driver then makes
    a new link and tries again. A call that does not return in time is abandoned with its object;
    the next link is that of a new one.
    """

    def __init__(
        self,
        make: Callable[[LentDeadline], Analyzer],
        parameters: VnaParameters,
        deadline: RequestDeadline,
    ) -> None:
        """Make the first object.

        Args:
            make: Makes an object of the class.
            parameters: The configuration.
            deadline: Ends a request that takes too long.
        """
        self._make = make
        self._parameters = parameters
        self._deadline = deadline
        self._making = threading.Lock()
        self._abandoned: List[CallThread] = []
        self._known = Known()
        self._instance: Optional[AnalyzerInstance] = None
        self._present()

    def connect(self, address: str) -> None:
        """Open a link to an address; an open one is closed."""
        self._present()
        self._call("connect", lambda analyzer: analyzer.connect(address), self._usual_limit_s)

    def identify(self) -> str:
        """Return the identification."""
        return str(self._call("identify", lambda one: one.identify(), self._usual_limit_s))

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have."""
        analyzer = self._present().analyzer
        # Another request may occupy the object's own thread, and this one needs no link.
        thread = CallThread("check_sweep")
        try:
            with self._trusting_nothing("check_sweep", thread):
                thread.run(lambda: analyzer.check_sweep(settings), self._usual_limit_s, unlimited)
        finally:
            thread.end()

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        return self._call(
            "configure", lambda one: checked(one.configure(settings), SweepSettings), math.inf
        )

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data."""
        limit_s = math.inf
        if self._known.trace_duration_s is not None:
            sweep_s = self._parameters.sweep_limit_s(self._known.trace_duration_s)
            limit_s = sweep_s + self._usual_limit_s
        return self._call("sweep", lambda one: checked(one.sweep(), Sweep), limit_s)

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`."""
        self._call("confirm", lambda one: one.confirm(), self._usual_limit_s)

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration."""
        return self._call(
            "calibration", lambda one: CalibrationStatus(one.calibration()), self._usual_limit_s
        )

    def release(self) -> None:
        """Leave the instrument sweeping by itself; never fails."""
        self._last_call(lambda analyzer: analyzer.release())

    def disconnect(self) -> None:
        """End the link; never fails."""
        self._last_call(lambda analyzer: analyzer.disconnect())

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
            lambda one: dict(getattr(one, "calibration_details", dict)()),
            self._usual_limit_s,
        )

    def forget(self) -> None:
        """Forget what was learned about the instrument, if the class can."""
        if self._instance is not None:  # a new object knows nothing
            self._call("forget", lambda one: getattr(one, "forget", int)(), self._usual_limit_s)

    @property
    def _usual_limit_s(self) -> float:
        """How long a call may take that measures nothing [s]."""
        parameters = self._parameters
        steps_s = 3.0 * parameters.connect_timeout_s + 2.0 * parameters.answer_timeout_s
        return steps_s + STEP_MARGIN_S

    def _present(self) -> AnalyzerInstance:
        """Return the object; make one if the last one was abandoned."""
        with self._making:
            if self._instance is None:
                self._check_not_stuck()
                try:
                    self._instance = AnalyzerInstance(
                        self._make, self._deadline, self._usual_limit_s
                    )
                except CallNotEndedError as error:
                    raise self._silent("__init__", error) from error
            return self._instance

    def _check_not_stuck(self) -> None:
        # Each costs a thread and its memory, and there is one attempt every few seconds.
        self._abandoned = [one for one in self._abandoned if one.busy]
        if len(self._abandoned) >= MOST_ABANDONED:
            raise VnaConnectionError(
                Message(
                    "{count} calls of {analyzer} have never returned; no further one is made",
                    count=len(self._abandoned),
                    analyzer=self._parameters.analyzer,
                ),
                fault=INTERNAL,
            )

    def _call(self, name: str, action: Callable[[Analyzer], Result], limit_s: float) -> Result:
        self._deadline.check()
        instance = self._instance
        if instance is None:
            raise not_connected()

        def observed() -> Tuple[Result, Known]:
            return action(instance.analyzer), Known.of(instance.analyzer)

        with self._trusting_nothing(name, instance.thread):
            found = instance.thread.run(observed, limit_s, request_check(self._deadline))
        result, self._known = found
        return cast(Result, result)

    def _last_call(self, action: Callable[[Analyzer], None]) -> None:
        instance = self._instance
        if instance is None:
            return
        with contextlib.suppress(Exception):
            instance.thread.run(lambda: action(instance.analyzer), LAST_CALL_S, unlimited)
        self._abandon_if_busy(instance.thread)

    @contextlib.contextmanager
    def _trusting_nothing(self, name: str, thread: CallThread) -> Iterator[None]:
        try:
            yield
        except Gpr20Error:
            raise
        except CallNotEndedError as error:
            raise self._silent(name, error) from error
        except Exception as error:  # the class is not ours: it may raise anything
            raise VnaConnectionError(
                Message(
                    "the VNA does not answer as it should; check its power and cable",
                    details=f"{type(error).__name__}: {error}",
                )
            ) from error
        finally:
            self._abandon_if_busy(thread)

    def _abandon_if_busy(self, thread: CallThread) -> None:
        """Give up the object whose call still runs; what it returns later is seen by nobody."""
        if not thread.busy:
            return
        self._abandoned.append(thread)
        instance, self._instance = self._instance, None
        if instance is not None:
            instance.end()

    def _silent(self, name: str, error: CallNotEndedError) -> VnaNoAnswerError:
        return VnaNoAnswerError(
            Message(
                "the VNA does not answer; check its power and cable",
                details=f"{self._parameters.analyzer}.{name}: {error}",
            )
        )
