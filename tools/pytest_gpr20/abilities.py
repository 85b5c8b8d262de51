"""Skips tests that need what this machine does not allow: `@pytest.mark.needs("mounts")`.

A container, a chroot or an ordinary user may not be allowed to mount, or to make a network. Each
ability is tried once, when the tests are collected.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from typing import List

import pytest

# A filter that lets no byte pass, attached as <asm-generic/socket.h> and <linux/filter.h> say.
ATTACH_FILTER = """
import ctypes, socket, struct
program = ctypes.create_string_buffer(struct.pack("=HBBI", 6, 0, 0, 0))
filters = struct.pack("@HP", 1, ctypes.addressof(program))
socket.socket().setsockopt(socket.SOL_SOCKET, 26, filters)
"""
IN_NETWORK = "ip netns add $TRY && {}; status=$?; ip netns del $TRY; exit $status"
# What a marker may name, and the shell's commands that try it.
ABILITIES = {
    "network namespaces": IN_NETWORK.format("ip -n $TRY link add end0 type veth peer name end1"),
    "firewall": IN_NETWORK.format("ip netns exec $TRY nft add table inet gpr20_try"),
    "tun": ": <>/dev/net/tun",
    "socket filters": f"{sys.executable} -c '{ATTACH_FILTER}'",
    "mounts": "cd $(mktemp -d) && mount -t tmpfs tmpfs . && umount -l . && rmdir $PWD",
    "debootstrap": "debootstrap --version",
    "packages": 'dpkg-scanpackages --version && [ "$(id -u)" = 0 ]',
}


@functools.lru_cache(maxsize=None)
def reason_against(ability: str) -> str:
    """Return why this machine lacks an ability; empty if it has it.

    Args:
        ability: A name in `ABILITIES`.
    """
    ended = subprocess.run(
        ["/bin/sh", "-c", ABILITIES[ability]],
        env={**os.environ, "TRY": f"gpr20-try-{os.getpid()}"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=20,
    )
    return f"no {ability} here: {' '.join(ended.stderr.split())}" if ended.returncode else ""


def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Skip the tests that need something that is not allowed."""
    for item in items:
        for marker in item.iter_markers("needs"):
            for reason in filter(None, map(reason_against, marker.args)):
                item.add_marker(pytest.mark.skip(reason=reason))
