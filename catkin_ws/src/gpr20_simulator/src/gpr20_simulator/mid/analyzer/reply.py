"""The reply to one message, put together from the answers to its queries."""

from __future__ import annotations

import random
from typing import Callable, List, Union

from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.trace_reader import DataReply
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault

Answer = Union[str, DataReply]
Capture = Callable[[str, bytes], None]
# A query after that many bytes gets no answer.
MOST_BYTES = 1 << 20


class Reply:
    """The answers to one message, in their order."""

    def __init__(self) -> None:
        self._answers: List[Answer] = []
        self._size = 0

    @property
    def is_full(self) -> bool:
        """Whether no more queries are answered."""
        return self._size >= MOST_BYTES

    @property
    def answers(self) -> List[Answer]:
        """The answers."""
        return list(self._answers)

    def add(self, answer: Answer) -> None:
        """Add an answer."""
        self._answers.append(answer)
        self._size += len(answer if isinstance(answer, str) else answer.block)


class ReplyWriter:
    """Writes replies as bytes.

    Args:
        description: How they end.
        faults: What goes wrong now.
        capture: Gets the kind and the exact bytes of each reply with data.
    """

    def __init__(self, description: InstrumentScene, faults: FaultBoard, capture: Capture) -> None:
        self._description = description
        self._faults = faults
        self._capture = capture
        self._random = random.Random(0)

    def written(self, reply: Reply) -> bytes:
        """Return a reply as it is sent; empty if there is none."""
        answers = reply.answers
        if not answers or self._faults.strikes(VnaFault.SILENT):
            return b""
        parts = [one.encode("ascii") if isinstance(one, str) else one.block for one in answers]
        data = b";".join(parts)
        if isinstance(answers[-1], str) or self._description.trailing_newline:
            data += b"\n"
        if self._faults.strikes(VnaFault.GARBAGE):
            data = bytes(self._random.getrandbits(8) for _ in range(len(data)))
        for answer in answers:
            if isinstance(answer, DataReply):
                self._capture(answer.kind, data)
        return data
