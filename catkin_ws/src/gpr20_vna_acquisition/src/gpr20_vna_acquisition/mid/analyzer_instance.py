"""One object of a class outside this package, whose calls may never return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Optional, Tuple, Type, TypeVar

from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaError
from gpr20_vna_acquisition.low.call_thread import CallThread
from gpr20_vna_acquisition.mid.analyzer import Analyzer
from gpr20_vna_acquisition.mid.request_deadline import LentDeadline, RequestDeadline

Result = TypeVar("Result")
# When a request must end, its class may take so long to end it by itself [s].
OWN_END_S = 1.0


@dataclass(frozen=True)
class Known:
    """What the properties of an object were after its last call."""

    trace_duration_s: Optional[float] = None
    remarks: Tuple[Message, ...] = ()
    has_noise: bool = True
    temperature_c: Optional[float] = None

    @classmethod
    def of(cls, analyzer: Analyzer) -> Known:
        """Return them; the last two are optional for a class."""
        temperature_c = getattr(analyzer, "temperature_c", None)
        return cls(
            analyzer.trace_duration_s,
            tuple(analyzer.remarks),
            bool(getattr(analyzer, "has_noise", True)),
            None if temperature_c is None else float(temperature_c),
        )


class AnalyzerInstance:
    """One object of the class, made and called in a thread of its own."""

    def __init__(
        self, make: Callable[[LentDeadline], Analyzer], deadline: RequestDeadline, limit_s: float
    ) -> None:
        self.deadline = LentDeadline(deadline)
        self.thread = CallThread("analyzer")
        try:
            self.analyzer: Analyzer = self.thread.run(
                lambda: make(self.deadline), limit_s, unlimited
            )
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """Let it do nothing any more; a call that still runs is not waited for."""
        self.deadline.take_back()
        self.thread.end()


def request_check(deadline: RequestDeadline) -> Callable[[], None]:
    """Return a check that raises if the request must end, and the class does not end it."""
    begun_s: Optional[float] = None

    def check() -> None:
        nonlocal begun_s
        try:
            deadline.check()
        except VnaError:
            now_s = deadline.now_s()
            begun_s = now_s if begun_s is None else begun_s
            if now_s - begun_s >= OWN_END_S:
                raise

    return check


def checked(value: Any, kind: Type[Result]) -> Result:
    """Return a value that has the right type.

    Raises:
        TypeError: It has another one.
    """
    if not isinstance(value, kind):
        raise TypeError(f"returned {type(value).__name__}, not {kind.__name__}")
    return value


def unlimited() -> None:
    """Return: no request limits the call."""
