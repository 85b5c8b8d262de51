"""A link between two network namespaces that delays, loses and cuts packets. Needs root.

usage: bad_link.py NAMESPACE ADDRESS NAMESPACE ADDRESS DELAY_S JITTER_S LOSS SEED

Each namespace gets a TUN device with its address; this process carries the packets between them.
Each line of standard input changes the link: `down` cuts it, `up` restores it. It ends with its
standard input. The kernel's own emulation (tc netem) is not part of every kernel.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import random
import select
import struct
import subprocess
import sys
import time
from collections import deque
from pathlib import Path
from typing import NamedTuple

DEVICE = "link"
TUN = Path("/dev/net/tun")
# From <linux/if_tun.h> and <linux/sched.h>.
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
CLONE_NEWNET = 0x40000000
MOST_BYTES = 65536


class LinkQuality(NamedTuple):
    """How bad a link is, in each direction; packets do not overtake each other."""

    # Half of the round trip, and up to this much more, at random.
    delay_s: float
    jitter_s: float
    # Part of the packets.
    loss: float
    seed: int


class BadLink:
    """A running link, as the test sees it.

    Args:
        ends: Names and addresses of the two namespaces.
        quality: How bad the link is.
    """

    def __init__(self, ends, quality):
        names = [word for end in ends for word in end]
        self._process = subprocess.Popen(
            [sys.executable, __file__, *names, *map(str, quality)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout.readline() == "ready\n", "the link could not be made"

    def cut(self):
        """Lose every packet from now on."""
        self._command("down")

    def restore(self):
        self._command("up")

    def wait(self, duration_s):
        """Return after a time [s], during which the link must stay alive."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(duration_s)
            raise AssertionError("the link has ended")

    def close(self):
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait(10.0)

    def _command(self, word):
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()


class Direction:
    """The packets on their way from one end to the other."""

    def __init__(self, source, target, quality, seed):
        self.source = source
        self._target = target
        self._quality = quality
        self._random = random.Random(seed)
        self._packets = deque()

    def take(self, now_s, is_up):
        """Read a packet; it is lost, or will arrive later."""
        packet = os.read(self.source, MOST_BYTES)
        lost = self._random.random() < self._quality.loss
        due_s = now_s + self._quality.delay_s + self._random.uniform(0.0, self._quality.jitter_s)
        if is_up and not lost:
            if self._packets:
                due_s = max(due_s, self._packets[-1][0])
            self._packets.append((due_s, packet))

    def deliver(self, now_s):
        """Write the packets that are due; return when the next one is [s], None if none waits."""
        while self._packets and self._packets[0][0] <= now_s:
            os.write(self._target, self._packets.popleft()[1])
        return self._packets[0][0] if self._packets else None


def enter(namespace):
    """Let this process be in a namespace from now on."""
    with open(f"/run/netns/{namespace}") as file:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.setns(file.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"setns {namespace}")


def open_end(namespace, address):
    """Make the device of one end and return its file descriptor."""
    enter(namespace)
    end = os.open(TUN, os.O_RDWR)
    fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH22x", DEVICE.encode(), IFF_TUN | IFF_NO_PI))
    for arguments in (["addr", "add", f"{address}/24", "dev"], ["link", "set", "up", "dev"]):
        subprocess.run(["ip", *arguments, DEVICE], check=True)
    return end


def carry(ends, quality):
    """Carry packets until the standard input ends."""
    first, second = ends
    directions = [
        Direction(first, second, quality, 2 * quality.seed),
        Direction(second, first, quality, 2 * quality.seed + 1),
    ]
    is_up = True
    commands = sys.stdin.fileno()
    while True:
        now_s = time.monotonic()
        due_s = [due_s for due_s in (one.deliver(now_s) for one in directions) if due_s is not None]
        wait_s = max(0.0, min(due_s) - now_s) if due_s else None
        readable, _, _ = select.select([first, second, commands], [], [], wait_s)
        for direction in directions:
            if direction.source in readable:
                direction.take(time.monotonic(), is_up)
        if commands in readable:
            words = os.read(commands, MOST_BYTES).decode().split()
            if not words:
                return
            is_up = words[-1] == "up"


def main(arguments):
    """Make both ends, say so, and carry packets."""
    ends = [open_end(*arguments[0:2]), open_end(*arguments[2:4])]
    delay_s, jitter_s, loss = map(float, arguments[4:7])
    print("ready", flush=True)
    carry(ends, LinkQuality(delay_s, jitter_s, loss, int(arguments[7])))


if __name__ == "__main__":
    main(sys.argv[1:])
