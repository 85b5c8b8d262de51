"""A folder that is a computer to gpr20-update: real dpkg, everything else played."""

from __future__ import annotations

import hashlib
import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import update_kit
from user_shell import printed_by

# The real dpkg, for this folder; the maintainer scripts see it in DPKG_ROOT.
DPKG = """exec /usr/bin/dpkg --root=$ROOT --force-script-chrootless --force-not-root \\
    --force-unsafe-io --log=/dev/null "$@"
"""
# Installs NAME=VERSION from the only source, with what these packages need; a simulation succeeds.
APT = """for word; do
    case $word in
        -oDir::Etc::sourcelist=*) list=${word#*sourcelist=} ;;
        --simulate | update) exit 0 ;;
    esac
done
cd "$(sed 's/.*file:\\(.*\\) .*/\\1/' "$list")" && exec dpkg --force-confold --install *.deb
"""
SYSTEMCTL = """case $1 in
    show) cat $ROOT/active ;;
    stop) printf 'inactive\\ninactive\\ninactive\\n' >$ROOT/active ;;
    --no-block) [ $2 != start ] || printf 'active\\nactive\\ninactive\\n' >$ROOT/active ;;
esac
"""
# The doctor of a release says what the file doctor-VERSION holds.
GPR20_RUN = """case $1 in
    doctor) exec cat $ROOT/doctor-$(cat $ROOT/opt/gpr20/current/release) ;;
    ros) cat $ROOT/code ;;
esac
"""
PROGRAMS = {
    "dpkg": DPKG,
    "dpkg-query": 'exec /usr/bin/dpkg-query --admindir=$ROOT/var/lib/dpkg "$@"\n',
    "apt-get": APT,
    "systemctl": SYSTEMCTL,
    "runuser": 'shift 3; exec "$@"\n',
    "gpr20-run": GPR20_RUN,
}
MAIN = """import os, signal, subprocess
from gpr20_update.high.command import main
from gpr20_update.mid import packages

events, last, begun = 0, int(os.environ.get("KILL_AT", "0")), False


def counted(function, path_of):
    def call(*arguments, **options):
        global events, begun
        begun = begun or str(path_of(arguments)).endswith("journal.json")
        events += begun
        if begun and events == last:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments, **options)
    return call


os.replace = counted(os.replace, lambda arguments: arguments[1])
subprocess.Popen = counted(subprocess.Popen, lambda arguments: "")
packages.LOCK_LIMIT_S = float(os.environ["LOCK_LIMIT_S"])
try:
    main(os.environ["ROOT"])
finally:
    print("events", events)
"""


@dataclass(frozen=True)
class World:
    """The folder, and the sticks that it can be updated from.

    Attributes:
        root: What is / of a real computer.
        sticks: Folder of the bundles.
        program: The program, with a __main__ that can be killed at any event.
    """

    root: Path
    sticks: Path
    program: Path

    @property
    def environment(self):
        path = f"{self.root}/programs:/usr/sbin:/usr/bin:/sbin:/bin"
        return {"PATH": path, "ROOT": str(self.root)}

    def begin(self, *arguments, kill_at=0, lock_limit_s=60.0):
        """Begin gpr20-update; return the process."""
        limits = {"KILL_AT": str(kill_at), "LOCK_LIMIT_S": str(lock_limit_s)}
        return subprocess.Popen(
            ["/usr/bin/python3", "-I", str(self.program), *map(str, arguments)],
            env={**self.environment, **limits},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def update(self, *arguments, status=0, **limits):
        """Run gpr20-update; return what it printed, "Killed" if it was; None: any status."""
        with self.begin(*arguments, **limits) as process:
            said = process.communicate()[0]
        assert status in (None, process.returncode), said
        return said + ("Killed" if process.returncode < 0 else "")

    def dpkg(self, *arguments, status=0):
        return printed_by("dpkg", *arguments, status=status, env=self.environment)

    def bundle(self, version):
        return self.sticks / f"gpr20-{version}"

    def doctor(self, version, *faults):
        """Let the doctor of a version find these faults."""
        found = [
            {"check": one, "fault_code": f"{one}.code", "level": "FAULT", "text": f"{one} is bad"}
            for one in faults
        ]
        (self.root / f"doctor-{version}").write_text(json.dumps({"findings": found}))

    def versions(self):
        """Return state and version of each package."""
        shown = "${Package}=${db:Status-Status} ${Version}\n"
        lines = printed_by("dpkg-query", "-W", "-f", shown, env=self.environment).splitlines()
        return dict(one.split("=") for one in lines)

    def release(self):
        """Return the version of the release in use, which is whole."""
        assert update_kit.slot_problems(self.root) == ""
        return (self.root / "opt/gpr20/current/release").read_text("utf-8").strip()

    def version(self):
        """Return the one version that everything has; fail if something is between two."""
        (version,) = {one for name, one in self.versions().items() if name.startswith("gpr20-")}
        assert version == f"installed {self.release()}"
        return self.release()

    def data(self):
        """Return the checksum of every file of the configuration and of the surveys."""
        return {
            str(one.relative_to(self.root)): hashlib.sha256(one.read_bytes()).hexdigest()
            for folder in ("etc/gpr20", "var/lib/gpr20")
            for one in sorted((self.root / folder).rglob("*"))
            # What a new version would like to have; it is not used.
            if one.is_file() and one.suffix != ".dpkg-dist"
        }

    def show_process(self, number):
        """Let the computer have a process of this one."""
        (self.root / "proc").mkdir()
        (self.root / "proc" / str(number)).symlink_to(f"/proc/{number}")

    def services_run(self):
        return (self.root / "active").read_text("utf-8").split()[:2] == ["active", "active"]

    def copy(self, place):
        """Return another computer in the same state."""
        # With the hard links between slots and what dpkg unpacked.
        printed_by("cp", "--archive", self.root, place)
        made = World(place, self.sticks, self.program)
        write_programs(place)
        return made


def write_programs(root):
    for name, text in PROGRAMS.items():
        file = root / "programs" / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(f"#!/bin/sh\nROOT={root}\n{text}", encoding="utf-8")
        file.chmod(0o755)


def make_sticks(place):
    """Make the program and bundles of the versions 1.0 and 2.0; return both."""
    place.mkdir()
    program = place / "gpr20-update"
    update_kit.make_program(program, MAIN)
    key = update_kit.make_key(place)
    for version in ("1.0", "2.0"):
        update_kit.make_bundle(place / "sticks", version, key, program)
    return World(place / "none", place / "sticks", program)


def make_world(sticks, root):
    """Make a computer on which version 1.0 was installed and is kept."""
    for folder in ("var/lib/dpkg/updates", "var/lib/dpkg/info", "run/systemd/system"):
        (root / folder).mkdir(parents=True)
    (root / "var/lib/dpkg/status").touch()
    write_programs(root)
    world = World(root, sticks.sticks, sticks.program)
    world.dpkg("--install", *sorted(world.bundle("1.0").glob("*.deb")))
    files = {
        "etc/gpr20/environment": "GPR20_LAUNCH_ARGUMENTS=ns:=robot1\n",
        "etc/gpr20/robot/axes.yaml": "x: 1\n",
        "etc/gpr20/robot/signing_key": "-----BEGIN OPENSSH PRIVATE KEY-----\n",
        "etc/gpr20/robot/signing_key.pub": "ssh-ed25519 AAAA\n",
        "var/lib/gpr20/.config/gpr20/plan.yaml": "x_points: 3\n",
        "var/lib/gpr20/surveys/first/survey.json": "{}",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    for version in ("1.0", "2.0"):
        world.doctor(version)
    (root / "code").write_text("1\n---\n")
    (root / "active").write_text("active\nactive\ninactive\n")
    world.update(world.bundle("1.0"))
    return world
