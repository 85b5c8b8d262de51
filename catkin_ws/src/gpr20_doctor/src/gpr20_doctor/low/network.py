"""Addresses and ports."""

from __future__ import annotations

import socket
from typing import FrozenSet


def is_here(name: str) -> bool:
    """Return whether a name or an IPv4 address is that of this computer."""
    return any(map(_is_own, addresses_of(name)))


def _is_own(address: str) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Only an own address can be bound.
            probe.bind((address, 0))
        except OSError:
            return False
    return True


def addresses_of(name: str) -> FrozenSet[str]:
    """Return the IPv4 addresses of a name or address; none if nobody knows it."""
    try:
        return frozenset(str(one[4][0]) for one in socket.getaddrinfo(name, 0, socket.AF_INET))
    except (OSError, UnicodeError):
        return frozenset()
