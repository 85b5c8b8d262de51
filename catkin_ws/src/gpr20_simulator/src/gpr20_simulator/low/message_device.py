"""A device that takes messages, and what may go wrong with the network to it."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol


class ClearSupport(enum.Enum):
    """What a server makes of device_clear."""

    FULL = "full"
    ERROR_8 = "error 8"
    NO_PROCEDURE = "no procedure"


class NetworkFault(enum.Enum):
    """What the network does wrong after something reached the device."""

    NONE = "none"
    ANSWER_LATE = "answer late"
    NO_REPLY = "no reply"
    DROP_CONNECTIONS = "drop connections"


@dataclass(frozen=True)
class Outcome:
    """What came of a message.

    Attributes:
        answer: What the client can read now; empty if the message asked nothing.
        fault: With ANSWER_LATE the answer can be read only after the next message, in front
            of what that one asked for.
    """

    answer: bytes = b""
    fault: NetworkFault = NetworkFault.NONE


class MessageDevice(Protocol):
    """A device with one name that several clients may talk to, each on its own thread."""

    def is_reachable(self) -> bool:
        """Return whether clients can connect; called for each connection."""

    def opened(self) -> NetworkFault:
        """Note that a client wants to talk to the device."""

    def execute(self, message: bytes) -> Outcome:
        """Carry out one complete message, with whatever terminator the client sent."""

    def clear(self) -> ClearSupport:
        """Forget half-done work; settings stay. Return whether the call is supported."""

    def set_remote(self, remote: bool) -> None:
        """Take control from the front panel, or give it back."""
