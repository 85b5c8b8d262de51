"""Skips tests that need what this machine does not allow: `@pytest.mark.needs("mounts")`.

A container, a chroot or an ordinary user may not be allowed to mount, or to make a network. Each
ability is tried once, when the tests are collected; the reason is in the last line of the run.
A rostest names what it needs in its `.test` file: `<arg name="needs" value="mounts"/>`.
"""

from __future__ import annotations

import ctypes
import functools
import os
import socket
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Callable, Dict, List

import pytest

MARKER = "needs(ability...): skipped where the machine does not allow that"
TUN = Path("/dev/net/tun")
# From <asm-generic/socket.h>, and a filter that lets no byte pass.
SO_ATTACH_FILTER = 26
DROP_ALL = struct.pack("=HBBI", 0x06, 0, 0, 0)
LIMIT_S = 20.0


class NotAllowedError(Exception):
    """The machine does not allow something; the text says what failed."""


def try_network_namespaces() -> None:
    """Make two network namespaces with a link, and run programs in them."""
    ends = [f"gpr20-try-{os.getpid()}-{end}" for end in ("a", "b")]
    try:
        for end in ends:
            _run("ip", "netns", "add", end)
            _run("ip", "netns", "exec", end, "true")
        link = ["type", "veth", "peer", "name", "end1", "netns", ends[1]]
        _run("ip", "link", "add", "end0", "netns", ends[0], *link)
    finally:
        for end in ends:
            if Path("/run/netns", end).exists():
                _run("ip", "netns", "del", end)


def try_firewall() -> None:
    """Load rules in a network namespace."""
    name = f"gpr20-try-{os.getpid()}-nft"
    _run("ip", "netns", "add", name)
    try:
        _run("ip", "netns", "exec", name, "nft", "add", "table", "inet", "gpr20_try")
    finally:
        _run("ip", "netns", "del", name)


def try_terminals() -> None:
    """Open a pseudo-terminal, for which a chroot needs /dev/pts."""
    try:
        ends = os.openpty()
    except OSError as error:
        raise NotAllowedError(f"/dev/pts: {error.strerror}") from error
    for end in ends:
        os.close(end)


def try_tun() -> None:
    """Open the device that makes network devices."""
    try:
        with TUN.open("r+b", buffering=0):
            pass
    except OSError as error:
        raise NotAllowedError(f"{TUN}: {error.strerror}") from error


def try_socket_filters() -> None:
    """Have the kernel drop what arrives at a socket."""
    program = ctypes.create_string_buffer(DROP_ALL, len(DROP_ALL))
    filters = struct.pack("@HP", 1, ctypes.addressof(program))
    try:
        with socket.socket() as end:
            end.setsockopt(socket.SOL_SOCKET, SO_ATTACH_FILTER, filters)
    except OSError as error:
        raise NotAllowedError(f"SO_ATTACH_FILTER: {error.strerror}") from error


def try_mounts() -> None:
    """Mount a small file system."""
    with tempfile.TemporaryDirectory(prefix="gpr20_try_") as place:
        try:
            _run("mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", place)
            _run("umount", place)
        except NotAllowedError as error:
            # The same reason in each worker, whatever the name of its folder is.
            raise NotAllowedError(str(error).replace(f" {place}:", "")) from error


def try_packages() -> None:
    """Have the tools that make packages, and the rights that install them."""
    _run("dpkg-scanpackages", "--version")
    if os.geteuid() != 0:
        raise NotAllowedError("only root installs them")


# What a marker may name.
ABILITIES: Dict[str, Callable[[], None]] = {
    "network namespaces": try_network_namespaces,
    "firewall": try_firewall,
    "terminals": try_terminals,
    "tun": try_tun,
    "socket filters": try_socket_filters,
    "mounts": try_mounts,
    "packages": try_packages,
}


@functools.lru_cache(maxsize=None)
def reason_against(ability: str) -> str:
    """Return why this machine lacks an ability; empty if it has it.

    Args:
        ability: A name in `ABILITIES`.
    """
    try:
        ABILITIES[ability]()
    except NotAllowedError as error:
        return f"no {ability} here: {error}"
    return ""


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker."""
    config.addinivalue_line("markers", MARKER)


def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Skip the tests that need something that is not allowed."""
    for item in items:
        for marker in item.iter_markers("needs"):
            for reason in filter(None, map(reason_against, marker.args)):
                item.add_marker(pytest.mark.skip(reason=reason))


def _run(*command: str) -> None:
    try:
        ended = subprocess.run(
            command,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=LIMIT_S,
            check=False,
        )
    except OSError as error:
        raise NotAllowedError(f"{command[0]}: {error.strerror}") from error
    if ended.returncode:
        # The first line: after it, mount suggests to read the kernel's log.
        printed = ended.stderr.decode(errors="replace").strip().splitlines()
        raise NotAllowedError(printed[0] if printed else f"status {ended.returncode}")
