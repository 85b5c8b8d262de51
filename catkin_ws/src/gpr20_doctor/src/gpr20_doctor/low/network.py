"""Addresses and ports."""

from __future__ import annotations

import socket
from typing import FrozenSet


def is_own_address(address: str) -> bool:
    """Return whether this computer has an IPv4 address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Only an own address can be bound.
            probe.bind((address, 0))
        except (OSError, UnicodeError):
            return False
    return True


def addresses_of(name: str) -> FrozenSet[str]:
    """Return the IPv4 addresses of a name or address; none if nobody knows it."""
    try:
        return frozenset(str(one[4][0]) for one in socket.getaddrinfo(name, 0, socket.AF_INET))
    except (OSError, UnicodeError):
        return frozenset()


def connect(address: str, port: int, limit_s: float) -> None:
    """Return if a TCP port accepts connections.

    Raises:
        OSError: It does not, or not in time.
    """
    socket.create_connection((address, port), limit_s).close()
