"""A folder that looks like a machine to the install scripts, and what they do to it."""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

from user_shell import ROOT

ADDRESSES = ["--robot", "10.20.0.1", "--server", "10.20.0.2"]
ADMIN = ["--admin", "192.168.1.0/24"]
OS_RELEASE = 'PRETTY_NAME="Debian GNU/Linux 12 (bookworm)"\nVERSION_ID="12"\nID=debian\n'
UBUNTU = 'NAME="Ubuntu"\nVERSION_ID="20.04"\nID=ubuntu\nID_LIKE=debian\n'
CONFIG = "boot/firmware/config.txt"
# The lines of a run that name a change.
CHANGE = re.compile(r"^(?:done|would do): (.*)$", re.M)


@dataclass(frozen=True)
class MachineTree:
    """The folder and its script.

    Attributes:
        folder: What is / of a real machine.
        script: Name of the script of the machine.
        options: What the script is given to install it.
    """

    folder: Path
    script: str
    options: tuple

    def run(self, *arguments, status=0):
        """Run the script; return everything that it printed."""
        command = [str(ROOT / "scripts" / self.script), "--root", str(self.folder), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + done.stderr

    def install(self, *more):
        """Install the machine; return what was printed."""
        return self.run(*self.options, *more)

    def uninstall(self):
        """Remove what was installed; return what was printed."""
        return self.run("--uninstall")

    def write(self, path, text):
        """Write a file, with the folders above it."""
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text.encode())
        return file

    def contents(self):
        """Return path, mode and checksum, or target, of everything in the folder."""
        found = {}
        for path in sorted(self.folder.rglob("*")):
            name = str(path.relative_to(self.folder))
            if path.is_symlink():
                found[name] = os.readlink(path)
            elif path.is_dir():
                found[name] = oct(path.stat().st_mode)
            else:
                checksum = hashlib.sha256(path.read_bytes()).hexdigest()
                found[name] = f"{path.stat().st_mode:o} {checksum}"
        return found

    def unit(self, name):
        """Return (key, value) of every line of an installed unit."""
        text = (self.folder / f"etc/systemd/system/{name}.service").read_text("utf-8")
        lines = text.replace("\\\n", " ").splitlines()
        return [tuple(line.split("=", 1)) for line in lines if re.match(r"\w+=", line)]

    def unit_values(self, name, key):
        """Return the values of a key of a unit, in their order."""
        return [value for found, value in self.unit(name) if found == key]

    def unit_command(self, name):
        """Return the command line of a unit as its words."""
        (command,) = self.unit_values(name, "ExecStart")
        return shlex.split(command)

    def settings(self):
        """Return the variables of /etc/gpr20/environment."""
        text = (self.folder / "etc/gpr20/environment").read_text("utf-8")
        return dict(re.findall(r"^(\w+)=(.*)$", text, re.M))


def machine(folder, script, *options):
    """Return a bare machine of Debian 12 in an empty folder."""
    made = MachineTree(folder, script, options)
    made.write("etc/os-release", OS_RELEASE)
    made.write("lib/systemd/systemd", "").chmod(0o755)
    return made


def robot(folder):
    """Return a bare Raspberry Pi, to be one of two machines."""
    made = machine(folder, "install_robot.sh", *ADDRESSES, *ADMIN)
    made.write(CONFIG, "# Raspberry Pi\ndtparam=audio=on\n")
    return made


def one_machine(folder):
    """Return a bare Raspberry Pi, to be the only machine."""
    made = machine(folder, "install_robot.sh", "--one-machine")
    made.write(CONFIG, "[all]\n")
    return made


def server(folder):
    """Return a bare PC."""
    return machine(folder, "install_server.sh", *ADDRESSES, *ADMIN)
