"""Skips tests that need what this machine does not allow: `@pytest.mark.needs("mounts")`.

A container, a chroot or an ordinary user may not be allowed to mount, or to make a network. Each
ability is tried once, when the tests are collected. A rostest names what it needs in its `.test`
file: `<arg name="needs" value="mounts"/>`.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from typing import Dict, List

import pytest

MARKER = "needs(ability...): skipped where the machine does not allow that"
LIMIT_S = 20.0
OPEN_TERMINAL = "import os; os.openpty()"
# A filter that lets no byte pass, attached as <asm-generic/socket.h> and <linux/filter.h> say.
ATTACH_FILTER = """
import ctypes, socket, struct
program = ctypes.create_string_buffer(struct.pack("=HBBI", 6, 0, 0, 0))
filters = struct.pack("@HP", 1, ctypes.addressof(program))
socket.socket().setsockopt(socket.SOL_SOCKET, 26, filters)
"""
NETWORK = """
ip netns add $TRY-a && ip netns add $TRY-b && ip netns exec $TRY-b true &&
    ip link add end0 netns $TRY-a type veth peer name end1 netns $TRY-b
status=$?
for end in a b; do [ ! -e /run/netns/$TRY-$end ] || ip netns del $TRY-$end; done
exit $status
"""
FIREWALL = """
ip netns add $TRY && ip netns exec $TRY nft add table inet gpr20_try
status=$?
[ ! -e /run/netns/$TRY ] || ip netns del $TRY
exit $status
"""
MOUNT = """
place=$(mktemp -d)
mount -t tmpfs -o size=1m tmpfs $place && umount $place
status=$?
rmdir $place
exit $status
"""
# What a marker may name, and the shell's commands that try it.
ABILITIES: Dict[str, str] = {
    "network namespaces": NETWORK,
    "firewall": FIREWALL,
    "terminals": f"{sys.executable} -c '{OPEN_TERMINAL}'",
    "tun": ": <>/dev/net/tun",
    "socket filters": f"{sys.executable} -c '{ATTACH_FILTER}'",
    "mounts": MOUNT,
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
        timeout=LIMIT_S,
    )
    return f"no {ability} here: {' '.join(ended.stderr.split())}" if ended.returncode else ""


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker."""
    config.addinivalue_line("markers", MARKER)


def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Skip the tests that need something that is not allowed."""
    for item in items:
        for marker in item.iter_markers("needs"):
            for reason in filter(None, map(reason_against, marker.args)):
                item.add_marker(pytest.mark.skip(reason=reason))
