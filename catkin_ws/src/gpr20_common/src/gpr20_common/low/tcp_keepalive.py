"""TCP connections whose other end may vanish: how long it has been silent, and when they end.

Every function raises an OSError if the connection is closed.
"""

from __future__ import annotations

import socket
import struct

# An idle connection is probed this often [s]; the other end's kernel answers, however busy
# its programs are.
PROBE_PERIOD_S = 1
# As many unanswered probes as Linux allows end the connection, after two minutes as in rospy:
# until then a cable that is plugged in again finds it alive.
MOST_PROBES = 127
# struct tcp_info of <linux/tcp.h>: when data and when an acknowledgement came last [ms ago].
TCP_INFO_BYTES = 104
LAST_RECEIVED = struct.Struct("=II")
LAST_RECEIVED_OFFSET = 52


def keep_alive(connection: socket.socket) -> None:
    """Have the kernel ask the other end for a sign of life every `PROBE_PERIOD_S`."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, PROBE_PERIOD_S)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, PROBE_PERIOD_S)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, MOST_PROBES)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)


def end_when_broken(connection: socket.socket, limit_s: float) -> None:
    """Have the kernel end the connection when the other end has not answered for a time [s].

    Without this limit a connection over a link that was down stays silent for as long again:
    Linux doubles the time between its attempts to send.
    """
    keep_alive(connection)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, round(1e3 * limit_s))


def silence_s(connection: socket.socket) -> float:
    """Return how long ago anything came from the other end [s]."""
    info = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, TCP_INFO_BYTES)
    return min(LAST_RECEIVED.unpack_from(info, LAST_RECEIVED_OFFSET)) * 1e-3
