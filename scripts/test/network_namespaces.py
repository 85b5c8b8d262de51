"""Two machines with a link of their own: network namespaces on this one, as docs/install.md says.

The simulated robot runs on both. Needs root.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass

from user_shell import LIMIT_S, NODES, ROOT, user_environment
from user_shell import printed_by as run
from wait_kit import wait_until

PAGE = (ROOT / "docs/install.md").read_text(encoding="utf-8")
# Further addresses of both, which the other one does not know.
ROBOT_STRANGER, SERVER_STRANGER = "10.20.0.9", "10.20.0.8"
# Prints the ports that took a connection.
CONNECT = """
import socket, sys
for port in sys.argv[3:]:
    try:
        socket.create_connection((sys.argv[2], int(port)), 1.0, (sys.argv[1], 0)).close()
        print(port)
    except OSError:
        pass
"""
TIME_SCALE = 50


def code_blocks(heading):
    """Return the code blocks of the section with a heading, up to the next heading."""
    section = re.search(rf"^#+ {re.escape(heading)}\n(.*?)(?=^#+ |\Z)", PAGE, re.M | re.S)
    assert section, f"the page has no section {heading}"
    return re.findall(r"^```\w*\n(.*?)^```$", section.group(1), re.M | re.S)


def firewall_commands():
    """Return the commands of the firewall, one a line."""
    (commands,) = code_blocks("Firewall")
    return commands.splitlines()


def remote_shell_rule(address):
    """Return the command that admits a remote shell from an address."""
    (rule,) = re.findall(r"`(nft add rule [^`]*YOUR_ADDRESS[^`]*)`", PAGE)
    return rule.replace("YOUR_ADDRESS", address)


ON_BOTH, ON_SERVER, ON_ROBOT = code_blocks("Two machines")
ROBOT, SERVER = (re.findall(rf"GPR20_{name}=(\S+)", ON_BOTH)[0] for name in ("ROBOT", "SERVER"))


@dataclass(frozen=True)
class Machine:
    """One network namespace."""

    name: str

    def run(self, *command):
        """Run a command in the namespace; return what it printed."""
        return run("ip", "netns", "exec", self.name, *command)

    def lose(self, percent):
        """Lose so many of the packets that arrive from now on, at random."""
        # The VNA has a cable of its own.
        rule = f"ct status dnat accept; iif != lo numgen random mod 100 <= {percent - 1} drop"
        chain = f"chain arriving {{ type filter hook input priority raw; {rule}; }}"
        again = "add table inet link; delete table inet link;"
        self.run("nft", f"{again} table inet link {{ {chain}; }}" if percent else again)

    def listening(self):
        """Return (address, port) of everything that listens by TCP, whatever its process."""
        lines = self.run("ss", "-Hltn4").splitlines()
        return {tuple(line.split()[3].rsplit(":", 1)) for line in lines}

    def reached(self, source, target, ports):
        """Return which ports of an address take connections from a source address here."""
        return set(self.run(sys.executable, "-c", CONNECT, source, target, *ports).split())

    def start(self, command, log, environment):
        """Start a command line in a new terminal that has sourced the workspace."""
        source = f"source {ROOT}/catkin_ws/devel/setup.bash"
        return subprocess.Popen(
            ["ip", "netns", "exec", self.name, "bash", "-c", f"{source} && exec {command}"],
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )


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


def share_loopback_port(server, robot, port):
    """Let a port of the loopback of the robot be reached on that of the server."""
    rule = f"tcp dport {port} dnat to"
    out = f"type nat hook output priority -100; ip daddr 127.0.0.1 {rule} {ROBOT}:{port}"
    back = "type nat hook postrouting priority 100; oifname server ip saddr 127.0.0.1 masquerade"
    into = f"type nat hook prerouting priority -100; iifname robot {rule} 127.0.0.1:{port}"
    for machine, chains in ((server, {"out": out, "back": back}), (robot, {"into": into})):
        machine.run("sysctl", "-qw", "net.ipv4.conf.all.route_localnet=1")
        for name, text in chains.items():
            machine.run("nft", f"table ip vna_{name} {{ chain {name} {{ {text}; }}; }}")


@contextlib.contextmanager
def launched(server, robot, folder):
    """Yield what starts a program on the robot, with both launch files running.

    Args:
        server: The machine of the master, the VNA, the storage and the survey.
        robot: The machine of the axes and the height sensor.
        folder: For surveys and everything that is printed.
    """
    environment = user_environment(
        folder / "surveys", GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, ROS_HOME=str(folder / "ros")
    )
    printed, started = folder / "printed.log", []
    with printed.open("wb") as log:

        def start(command, machine=robot):
            started.append(machine.start(command, log, environment))
            return started[-1]

        def ready():
            text = printed.read_text(errors="replace")
            return all(f"/{node} is ready" in text for node in NODES)

        def simulated_vna():
            return [port for address, port in robot.listening() if address.startswith("127.")]

        try:
            start(simulated(ON_SERVER), server)
            start(f"{simulated(ON_ROBOT)} ui:=false")
            wait_until(ready, alive=started)
            # It is behind the loopback of the robot, which a real one is not.
            wait_until(simulated_vna, alive=started)
            for port in simulated_vna():
                share_loopback_port(server, robot, port)
            yield start
        finally:
            # Ctrl-C in all of them, the last first.
            for process in reversed(started):
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGINT)
                    process.wait(LIMIT_S)


def simulated(command):
    """Return the page's command for the real robot as one for the simulated robot."""
    assert "robot:=gpr20" in command
    return command.strip().replace("robot:=gpr20", f"time_scale:={TIME_SCALE}")
