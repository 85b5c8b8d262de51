"""The watchdog of systemd, which ends a service that no longer says that it works."""

from __future__ import annotations

import contextlib
import os
import socket
from typing import Mapping

MICRO = 1.0e6


class ServiceManager:
    """What this process says to the systemd that runs it as a part of a service (sd_notify(3)).

    Nothing is sent where systemd does not run it. The time limit is given with each message, not in
    the unit: a service that waits for a cable or for another machine has none yet.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        # A leading @ stands for the zero byte of an abstract address (unix(7)).
        self._address = "\0" + address[1:] if address.startswith("@") else address

    def keep_alive(self, limit_s: float) -> None:
        """Say that the service works; without the next message within the limit it is restarted."""
        self._send(f"WATCHDOG=1\nWATCHDOG_USEC={round(limit_s * MICRO)}")

    def release(self) -> None:
        """Say that no further message will come, because this process ends as it should."""
        self._send("WATCHDOG_USEC=0")

    def _send(self, text: str) -> None:
        if not self._address:
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.setblocking(False)
            # It is busy, and the next message says the same, or nobody listens any more.
            with contextlib.suppress(OSError):
                sender.sendto(text.encode(), self._address)


def service_manager() -> ServiceManager:
    """Return the systemd that runs this process, or one that hears nothing."""
    return ServiceManager(os.environ)
