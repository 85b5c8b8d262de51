"""What a VXI-11 server serves: something that takes messages and answers them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol


class Conduct(enum.Enum):
    """How the network side behaves after something reached the device."""

    REPLY = "reply"
    ANSWER_LATE = "answer late"
    NO_REPLY = "no reply"
    DROP_CONNECTIONS = "drop connections"
    GO_SILENT = "go silent"


@dataclass(frozen=True)
class Outcome:
    """What came of a message.

    Attributes:
        answer: What the client can read now; empty if the message asked nothing.
        conduct: Anything but REPLY is a fault. With ANSWER_LATE the answer can be read only
            after the next message, in front of what that one asked for.
    """

    answer: bytes = b""
    conduct: Conduct = Conduct.REPLY


class MessageDevice(Protocol):
    """A device with one name that several clients may talk to, each on its own thread."""

    def opened(self) -> Conduct:
        """Note that a client wants to talk to the device."""

    def execute(self, message: bytes) -> Outcome:
        """Carry out one complete message, with whatever terminator the client sent."""

    def clear(self) -> None:
        """Forget half-done work; settings stay."""
