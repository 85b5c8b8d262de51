"""A computer is broken in each way of a table; the doctor finds it, and its advice ends it.

The commands of an advice are run as they are written. Those that would change the real computer
are stand-ins of the same name, first in PATH; files and mounts are real ones below a folder. What
needs masters and nodes is in test_doctor_program, the firewall in test_firewall_probe.
"""

import os
import re
import socket
import subprocess
import tempfile
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Callable, NamedTuple, Optional
from unittest import mock

import pytest
from test_probes import tree

from gpr20_common.message import Fault, Message
from gpr20_doctor.mid import machine_probe
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_request import REAL, ThisMachine
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse

pytestmark = pytest.mark.needs("mounts")

SIZE = "size=230m,nr_inodes=2500"
FOLLOWS = "x,y,1,0,{offset},0,0,0,0,0,0,0,0,{leap}"
NORMAL = FOLLOWS.format(offset="0.0001", leap="Normal")
COMMAND = re.compile(r"[Rr]un: (.+?)(?:\. [A-Z]|\.?$)")
PROGRAMS = {
    "sudo": 'exec "$@"',
    "chronyc": '[ "$1" != makestep ] || echo "{normal}" >{root}/chrony; cat {root}/chrony',
    "vcgencmd": "cat {root}/throttled",
    "rosrun": "cat {root}/problems",
    "raspi-config": 'touch "{root}/dev/spidev0.0"',
}


class Computer:
    """A Raspberry Pi with the services of the packages, as files and mounts below a folder."""

    def __init__(self, folder):
        self.root, self.logs, self.data = folder / "root", folder / "logs", folder / "data"
        self.settings = self.root / "etc/gpr20/environment"
        self.environment = {
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": str(self.logs),
            "GPR20_STATE": str(folder / "state"),
        }
        self.now_s = 0.0
        self.vna = socket.create_server(("127.0.0.1", 0))
        files = {
            "proc/device-tree/model": "Raspberry Pi 4",
            "proc/meminfo": "MemAvailable: 2000000 kB\n",
            "proc/vmstat": "oom_kill 0\n",
            "proc/net/tcp": "sl\n",
            "sys/class/thermal/thermal_zone0/temp": "50000",
            "dev/spidev0.0": "",
            "etc/group": "gpio:x:1:\nspi:x:2:\n",
            "lib/systemd/system/gpr20-robot.service": "",
            "robot/analyzer.yaml": "address: 127.0.0.1\n",
            "chrony": NORMAL,
            "throttled": "throttled=0x0",
            "problems": "[]",
        }
        tree(self.root, **files)
        self.set_addresses("127.0.0.1", "127.0.0.2")
        for name, script in PROGRAMS.items():
            path = folder / "bin" / name
            path.parent.mkdir(exist_ok=True)
            script = script.replace("{root}", str(self.root)).replace("{normal}", NORMAL)
            path.write_text(f"#!/bin/sh\n{script}\n")
            path.chmod(0o755)
        for place in (self.logs, self.data):
            place.mkdir()
            self.mount(place)
        state = folder / "state"
        DataFolder(DataFolderUse(self.data, state)).check()

    def write(self, name, text):
        tree(self.root, **{name: text})

    def set_addresses(self, robot, server):
        lines = [f"GPR20_ROBOT={robot}", f"GPR20_SERVER={server}", f"GPR20_DATA={self.data}"]
        lines.append(f"GPR20_CONFIG={self.root}/robot")
        self.write("etc/gpr20/environment", "\n".join(lines))

    def mount(self, place):
        subprocess.run(["mount", "-t", "tmpfs", "-o", SIZE, "tmpfs", str(place)], check=True)

    def look(self):
        """Return what is wrong, by check and code of its fault."""
        request = ThisMachine("pi", self.environment, self.root).request({}, robot=REAL)
        port = self.vna.getsockname()[1] if self.vna.fileno() >= 0 else 1
        late = mock.patch.object(machine_probe.time, "time", lambda: self.now_s or 4e9)
        patient = mock.patch.object(machine_probe, "DISK_LIMIT_S", 100.0)
        with late, patient, mock.patch.object(machine_probe, "PORTMAPPER", port):
            found = findings(None, machine_probe.probe_machine(request))
        bad = [one for one in found if one.level >= Level.WARNING]
        return {f"{one.check} {one.text.fault_code}": one for one in bad}


@contextmanager
def computer():
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        path = f"{name}/bin:{os.environ['PATH']}"
        stack.enter_context(mock.patch.dict(os.environ, {"PATH": path}))
        made = Computer(Path(name))
        for place in (made.logs, made.data):
            unmount = ["umount", "--lazy", str(place)]
            stack.callback(subprocess.run, unmount, check=False, stderr=subprocess.DEVNULL)
        stack.callback(lambda: made.vna.close())
        yield made


class State(NamedTuple):
    """A way to break a computer, check and code of what must be found, words of its advice.

    `act` does by hand what the advice says; without it the commands of the advice are run.
    """

    code: str
    words: str
    inject: Callable[[Computer], object]
    act: Optional[Callable[[Computer], object]] = None


def fill(one):
    with (one.logs / "large").open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, 225 << 20)


def crowd(one):
    for number in range(600):
        (one.logs / f"small-{number}").touch()


def clear(one):
    for path in one.logs.iterdir():
        path.unlink()


def remount_read_only(one):
    subprocess.run(["mount", "-o", "remount,ro", str(one.logs)], check=True)


def unmount(one):
    subprocess.run(["umount", str(one.data)], check=True)


def listen(one):
    one.vna = socket.create_server(("127.0.0.1", 0))


def swap(name, bad, good):
    """Return what breaks a computer by the text of a file, and what ends that."""
    return (lambda one: one.write(name, bad)), (lambda one: one.write(name, good))


def process(number, words, environment="ROS_MASTER_URI=http://localhost:11311"):
    """Return what starts a node without a launch above it, and what ends it."""

    def start(one):
        one.write(f"proc/{number}/environ", environment)
        one.write(f"proc/{number}/stat", f"{number} (node) S 1")
        one.write(f"proc/{number}/cmdline", words.replace(" ", "\0"))

    return start, lambda one: one.write(f"proc/{number}/cmdline", "")


def date(now_s):
    return lambda one: setattr(one, "now_s", now_s)


def addresses(*of_both):
    return lambda one: one.set_addresses(*of_both)


def listens_on(address):
    return lambda one: one.environment.update(ROS_IP=address)


ALONE = FOLLOWS.format(offset="0", leap="Not synchronised")
LATE = FOLLOWS.format(offset="2.0", leap="Normal")
MISTAKE = Message("axes.yaml, x/dir_pin and y/dir_pin use the same pin").with_fault(
    Fault("config.wrong", Message("Correct the file that the message names."))
)
STATES = {
    "two axes use one pin": State(
        *("config_files config.wrong", "Correct the file"),
        *swap("problems", f"[{MISTAKE.to_json()}]", "[]"),
    ),
    "the SPI bus is off": State(
        "spi computer.not_set_up", "raspi-config", lambda one: (one.root / "dev/spidev0.0").unlink()
    ),
    "chrony follows nobody": State("clock clock.wrong", "cable", *swap("chrony", ALONE, NORMAL)),
    "the clock is 2 s off": State("clock clock.wrong", "makestep", swap("chrony", LATE, "")[0]),
    "the clock starts in 1970": State("date clock.wrong", "sudo date -s", date(86400.0), date(4e9)),
    "a program was ended for lack of memory": State(
        *("memory robot.overloaded", "restart the computer"),
        *swap("proc/vmstat", "oom_kill 2\n", "oom_kill 0\n"),
    ),
    "the disk of the logs is read-only": State(
        "volumes disk.refuses", "remount,rw", remount_read_only
    ),
    "the disk of the logs is full": State("volumes disk.full", "copy surveys", fill, clear),
    "the disk of the logs takes no more files": State(
        "volumes disk.full", "copy surveys", crowd, clear
    ),
    "another disk is mounted in place of the surveys": State(
        *("data_folder storage.other_data_folder", "mount the disk"),
        *(lambda one: one.mount(one.data), unmount),
    ),
    "the VNA is off": State(
        "vna_port vna.no_answer", "switched on", lambda one: one.vna.close(), listen
    ),
    "the two addresses are those of other computers": State(
        *("addresses network.address", "etc/gpr20/environment"),
        *(addresses("192.0.2.5", "192.0.2.6"), addresses("127.0.0.1", "127.0.0.2")),
    ),
    "an address of the robot's parts is gone": State(
        *("addresses network.address", "Check the link"),
        *process(50, "node __name:=x", "ROS_IP=192.0.2.7"),
    ),
    "the launch of a part has ended": State(
        "launch robot.internal_error", "kill 60", *process(60, "node __name:=x __log:=/l")
    ),
    "ROS_IP is that of another computer": State(
        *("addresses network.address", "gpr20-run doctor"),
        *(listens_on("192.0.2.9"), listens_on("127.0.0.1")),
    ),
}


def test_each_broken_state_is_found_and_its_advice_ends_it():
    with computer() as one:
        # What is found on this machine whatever is done to it.
        healthy = set(one.look())
        for name, state in STATES.items():
            assert state.code not in healthy, name
            state.inject(one)
            found = one.look()
            assert set(found) - healthy == {state.code}, name
            advice = str(found[state.code].remedy)
            assert state.words in advice
            if state.act is not None:
                state.act(one)
            else:
                command = ["sh", "-ec", COMMAND.findall(advice)[0]]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            assert set(one.look()) == healthy, name
