"""The guide's firewall rules let the other machine in and nobody else."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess

import pytest
from user_shell import ROOT, wait_until

SERVER, ROBOT, STRANGER = "10.20.0.2", "10.20.0.1", "10.20.0.9"
PORT = 11311
CONNECT = """
import socket, sys
with socket.socket() as probe:
    probe.bind((sys.argv[1], 0))
    probe.settimeout(2)
    print(probe.connect_ex((sys.argv[2], int(sys.argv[3]))))
"""

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces need root")


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@contextlib.contextmanager
def two_machines(names):
    """Two network namespaces with a link; the second has a further address, a stranger's."""
    inside, outside = names
    try:
        for name in names:
            run("ip", "netns", "add", name)
        link = ["type", "veth", "peer", "name", "outside", "netns", outside]
        run("ip", "link", "add", "inside", "netns", inside, *link)
        for name, device, addresses in (
            (inside, "inside", [SERVER]),
            (outside, "outside", [ROBOT, STRANGER]),
        ):
            for address in addresses:
                run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", device)
            for one in (device, "lo"):
                run("ip", "-n", name, "link", "set", one, "up")
        yield
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "del", name], check=False)


def reaches(namespace, source):
    """Return whether a connection from an address to the server's master is made."""
    command = ["ip", "netns", "exec", namespace, "python3", "-c", CONNECT]
    return run(*command, source, SERVER, str(PORT)).strip() == "0"


def test_the_rules_of_the_guide_shut_out_everybody_but_the_other_machine():
    names = [f"gpr20-{os.getpid()}-{place}" for place in ("server", "robot")]
    rules = re.findall(r"^nft .*$", (ROOT / "docs/guide.md").read_text(), re.MULTILINE)
    assert len(rules) == 5
    with two_machines(names):
        inside, outside = names
        server = subprocess.Popen(
            ["ip", "netns", "exec", inside, "python3", "-m", "http.server", str(PORT)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            wait_until(lambda: reaches(outside, STRANGER), server, limit_s=20.0)
            for rule in rules:
                run("ip", "netns", "exec", inside, "bash", "-c", rule)
            assert reaches(outside, ROBOT)
            assert reaches(inside, SERVER)
            assert not reaches(outside, STRANGER)
        finally:
            server.kill()
            server.wait()
