"""A link to an MS2026C that goes wrong as it is asked to, at an instrument that does not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, List, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaNoAnswerError
from gpr20_vna_acquisition.mid.block_parser import whole_number
from gpr20_vna_acquisition.mid.display import DATA_QUERY
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.ms2026c_sweeps import (
    STATUS_QUERY,
    SWEEP_COMPLETE_BIT,
    TRIGGER,
)


@dataclass
class Trouble:
    """What goes wrong now, on every link to the instrument.

    Attributes:
        late_flag_s: How long after a trigger the bit is still that of the sweep before [s].
        late_memory_s: How long after the end of a sweep the data are those of the one before [s].
        silent: How many requests for data get no answer.
        drops: At how many requests for data the link is lost.
        during_sweep: Commands that are sent right after a trigger, and when the sweep has ended.
        replaced: What is replaced in every answer, and by what.
        shown: The data of former sweeps, and from when on the link shows them [s].
        triggered_s: When the last sweep was triggered [s].
        ended_s: When its end was seen [s]; None before.
    """

    late_flag_s: float = 0.0
    late_memory_s: float = 0.0
    silent: int = 0
    drops: int = 0
    during_sweep: Tuple[str, ...] = ()
    replaced: Tuple[bytes, bytes] = (b"", b"")
    shown: List[Tuple[float, bytes]] = field(default_factory=list)
    triggered_s: float = 0.0
    ended_s: Optional[float] = None
    links: List[Transport] = field(default_factory=list)


class FaultyTransport:
    """Implements `Transport`; what is not mentioned here is that of the real one."""

    def __init__(self, inner: Transport, trouble: Trouble, clock: Clock) -> None:
        self._inner = inner
        self._trouble = trouble
        self._clock = clock
        trouble.links.append(inner)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def write(self, command: str) -> None:
        """Send a command that has no answer."""
        if TRIGGER not in command:
            self._inner.write(command)
            return
        trouble = self._trouble
        if trouble.late_memory_s:
            shown_s = 0.0 if trouble.ended_s is None else trouble.ended_s + trouble.late_memory_s
            trouble.shown.append((shown_s, self._inner.ask_raw(DATA_QUERY)))
        trouble.ended_s = None
        self._inner.write(command)
        trouble.triggered_s = self._clock.now_s()
        self._send(trouble.during_sweep[:1])

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        """Send a query and return its answer."""
        if query == DATA_QUERY:
            answer = self._data(limit_s)
        elif query == STATUS_QUERY:
            answer = self._status(limit_s)
        else:
            answer = self._inner.ask_raw(query, limit_s)
        former, other = self._trouble.replaced
        return answer.replace(former, other) if former else answer

    def _status(self, limit_s: Optional[float]) -> bytes:
        trouble = self._trouble
        answer = self._inner.ask_raw(STATUS_QUERY, limit_s)
        ended = is_complete(answer)
        if ended and trouble.ended_s is None:
            trouble.ended_s = self._clock.now_s()
            self._send(trouble.during_sweep[1:])
        if self._clock.now_s() < trouble.triggered_s + trouble.late_flag_s:
            return str(SWEEP_COMPLETE_BIT).encode("ascii")
        return answer

    def _send(self, commands: Sequence[str]) -> None:
        for one in filter(None, commands):
            self._inner.write(one)

    def _data(self, limit_s: Optional[float]) -> bytes:
        trouble = self._trouble
        if trouble.silent:
            trouble.silent -= 1
            self._inner.close()
            raise VnaNoAnswerError(Message("no answer in time"))
        if trouble.drops:
            trouble.drops -= 1
            self._inner.close()
            raise VnaConnectionError(Message("the connection was closed by the other side"))
        answer = self._inner.ask_raw(DATA_QUERY, limit_s)
        now_s, late_s = self._clock.now_s(), trouble.late_memory_s
        if not late_s or (trouble.ended_s is not None and now_s >= trouble.ended_s + late_s):
            return answer
        former = [block for shown_s, block in trouble.shown if shown_s <= now_s]
        return former[-1] if former and len(former[-1]) == len(answer) else answer


def is_complete(answer: bytes) -> bool:
    """Return whether an answer to the query of the status has the bit of a completed sweep."""
    return bool(whole_number(answer.decode("latin-1").strip()) & SWEEP_COMPLETE_BIT)


def faulty(
    connect: Callable[[str], Transport], trouble: Trouble, clock: Clock
) -> Callable[[str], Transport]:
    """Return what opens links that go wrong."""
    return lambda address: FaultyTransport(connect(address), trouble, clock)
