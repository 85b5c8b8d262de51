"""Two machines with a link of their own: network namespaces on this one, as docs/install.md says.

The simulated robot runs on both. Needs root.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass

from user_shell import ROOT, Terminal, is_ready, user_environment
from user_shell import printed_by as run
from wait_kit import wait_until

PAGE = ROOT / "docs/install.md"
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
TIME_SCALE = 50
CLIENT = "rosrun gpr20_user_interface run_survey --wait 60"


def code_blocks(heading):
    """Return the code blocks of the section with a heading, up to the next heading."""
    text = PAGE.read_text(encoding="utf-8")
    section = re.search(rf"^#+ {re.escape(heading)}\n(.*?)(?=^#+ |\Z)", text, re.M | re.S)
    assert section, f"the page has no section {heading}"
    return re.findall(r"^```\w*\n(.*?)^```$", section.group(1), re.M | re.S)


def two_machine_commands():
    """Return the code blocks that set up two machines: both, the server, the robot."""
    both, server, robot = code_blocks("Two machines")
    return both, server.strip(), robot.strip()


def addresses():
    exported = dict(re.findall(r"(GPR20_\w+)=(\S+)", two_machine_commands()[0]))
    return exported["GPR20_ROBOT"], exported["GPR20_SERVER"]


def firewall_commands():
    """Return the commands of the firewall, one a line."""
    (commands,) = code_blocks("Firewall")
    return commands.splitlines()


def remote_shell_rule(address):
    """Return the command that admits a remote shell from an address."""
    (rule,) = re.findall(r"`(nft add rule [^`]*YOUR_ADDRESS[^`]*)`", PAGE.read_text("utf-8"))
    return rule.replace("YOUR_ADDRESS", address)


ROBOT, SERVER = addresses()


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

    def lose(self, percent):
        """Lose so many of the packets that arrive from now on, at random."""
        chain = "chain arriving { type filter hook input priority raw; "
        chain += f"iif != lo numgen random mod 100 <= {percent - 1} drop; }}"
        run(*self.prefix, "nft", f"flush ruleset; table inet link {{ {chain}; }}")

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
def two_machines():
    """Yield the server and the robot; each has a further address, a stranger's."""
    server, robot = (Machine(f"gpr20-{os.getpid()}-{place}") for place in ("server", "robot"))
    try:
        for machine in (server, robot):
            run("ip", "netns", "add", machine.name)
            run("ip", "-n", machine.name, "link", "set", "lo", "up")
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
    finally:
        for machine in (server, robot):
            subprocess.run(["ip", "netns", "del", machine.name], check=False)


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


@contextlib.contextmanager
def launched(server, robot, folder):
    """Yield a terminal on each machine, with both launch files running.

    Args:
        server: The machine of the master, the VNA, the storage and the survey.
        robot: The machine of the axes and the height sensor.
        folder: For surveys and everything that is printed.
    """
    environment = user_environment(
        folder / "surveys", GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, ROS_HOME=str(folder / "ros")
    )
    _both, launch_server, launch_robot = two_machine_commands()
    with (folder / "printed.log").open("wb") as log:
        on_server = Terminal(log, environment, server.prefix)
        on_robot = Terminal(log, environment, robot.prefix)
        try:
            control = on_server.start(simulated(launch_server))
            axes = on_robot.start(f"{simulated(launch_robot)} ui:=false")
            wait_until(lambda: is_ready(folder / "printed.log"), alive=[control, axes])
            # The simulated VNA is behind the loopback of the robot, which a real one is not.
            wait_until(lambda: simulated_vna(robot), alive=[control, axes])
            with relayed(simulated_vna(robot), server, robot):
                yield on_server, on_robot
        finally:
            on_robot.close()
            on_server.close()


def simulated(command):
    """Return the page's command for the real robot as one for the simulated robot."""
    assert "robot:=gpr20" in command
    return command.replace("robot:=gpr20", f"time_scale:={TIME_SCALE}")


def simulated_vna(robot):
    """Return the port of the simulated VNA, as soon as it listens."""
    return [port for address, port in robot.listening() if address.startswith("127.")]


def survey_folder(folder):
    """Return the folder of the one survey; None before there is one."""
    found = [one.parent for one in folder.glob("surveys/*/survey.json")]
    assert len(found) <= 1
    return found[0] if found else None


def stored_traces(folder):
    """Return the indices of the stored traces of the one survey, each as often as it is stored."""
    survey = survey_folder(folder)
    names = [] if survey is None else [one.name for one in survey.glob("traces/*.json")]
    return Counter(int(name.split("_")[0]) for name in names)


def statuses(folder):
    """Return (state, message) of each status that the main control has logged."""
    text = (folder / "printed.log").read_text(errors="replace")
    return re.findall(r"\[INFO\] \[[\d.]+\]: ([A-Z]+): (.*)", text)


def outcome(folder):
    return json.loads((survey_folder(folder) / "survey.json").read_text())["outcome"]
