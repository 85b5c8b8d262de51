"""Two machines with a link of their own: network namespaces on this one. Needs root."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from dataclasses import dataclass

import install_page
from bad_link import BadLink
from user_shell import ROOT
from user_shell import printed_by as run

ROBOT, SERVER = install_page.addresses()
# Further addresses of both, which the other one does not know.
ROBOT_STRANGER, SERVER_STRANGER = "10.20.0.9", "10.20.0.8"
LISTENING = "0A"
# Prints the ports that took a connection; all are tried at once.
CONNECT = """
import asyncio, sys
async def reaches(port):
    opening = asyncio.open_connection(sys.argv[2], port, local_addr=(sys.argv[1], 0))
    try:
        _, writer = await asyncio.wait_for(opening, 3.0)
    except (OSError, asyncio.TimeoutError):
        return False
    writer.close()
    return True
async def main():
    ports = [int(one) for one in sys.argv[3:]]
    for port, reached in zip(ports, await asyncio.gather(*map(reaches, ports))):
        if reached:
            print(port)
asyncio.run(main())
"""


@dataclass(frozen=True)
class Machine:
    """One network namespace."""

    name: str

    @property
    def prefix(self):
        """The command that runs another one in the namespace."""
        return ["ip", "netns", "exec", self.name]

    def shut_out_others(self, commands):
        """Run the commands of a firewall, as root runs them from one script."""
        run(*self.prefix, "bash", "-ec", "\n".join(commands))

    def listening(self):
        """Return (address, port) of everything that listens by TCP, whatever its process."""
        lines = run(*self.prefix, "cat", "/proc/net/tcp").splitlines()[1:]
        found = set()
        for local, state in ((line.split()[1], line.split()[3]) for line in lines):
            if state == LISTENING:
                address, port = local.split(":")
                numbers = reversed(bytes.fromhex(address))
                found.add((".".join(map(str, numbers)), int(port, 16)))
        return found

    def reached(self, source, target, ports):
        """Return which ports of an address take connections from a source address here."""
        arguments = [sys.executable, "-c", CONNECT, source, target, *map(str, ports)]
        return {int(port) for port in run(*self.prefix, *arguments).split()}


@contextlib.contextmanager
def two_namespaces():
    """Yield the server and the robot, without a link."""
    server, robot = (Machine(f"gpr20-{os.getpid()}-{place}") for place in ("server", "robot"))
    try:
        for machine in (server, robot):
            run("ip", "netns", "add", machine.name)
            run("ip", "-n", machine.name, "link", "set", "lo", "up")
        yield server, robot
    finally:
        for machine in (server, robot):
            subprocess.run(["ip", "netns", "del", machine.name], check=False)


@contextlib.contextmanager
def two_machines():
    """Yield the server and the robot; each has a further address, a stranger's."""
    with two_namespaces() as (server, robot):
        link = ["type", "veth", "peer", "name", "robot", "netns", robot.name]
        run("ip", "link", "add", "server", "netns", server.name, *link)
        for machine, device, addresses in (
            (server, "server", [SERVER, SERVER_STRANGER]),
            (robot, "robot", [ROBOT, ROBOT_STRANGER]),
        ):
            for address in addresses:
                run("ip", "-n", machine.name, "addr", "add", f"{address}/24", "dev", device)
            run("ip", "-n", machine.name, "link", "set", device, "up")
        yield server, robot


@contextlib.contextmanager
def badly_linked_machines(quality):
    """Yield the server, the robot and the link between them."""
    with two_namespaces() as (server, robot):
        link = BadLink([(server.name, SERVER), (robot.name, ROBOT)], quality)
        try:
            yield server, robot, link
        finally:
            link.close()


@contextlib.contextmanager
def relayed(ports, inside, outside):
    """Let ports of the loopback of one machine be reached on the loopback of another."""
    script = [sys.executable, str(ROOT / "scripts/test/relay.py"), inside.name, outside.name]
    relays = [subprocess.Popen([*script, str(port)]) for port in ports]
    try:
        yield
    finally:
        for relay in relays:
            relay.terminate()
            relay.wait()
