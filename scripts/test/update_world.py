"""A folder that is a computer to gpr20-update: real apt and dpkg, everything else played."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

import update_kit
from user_shell import printed_by

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.faults import NOT_RUNNING
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import as_json

PROGRAMS = {
    # The real ones, for this folder; the maintainer scripts see it in DPKG_ROOT.
    "dpkg": """exec /usr/bin/dpkg --root=$ROOT --force-script-chrootless --force-not-root \\
    --force-unsafe-io --log=/dev/null "$@"
""",
    "dpkg-query": 'exec /usr/bin/dpkg-query --admindir=$ROOT/var/lib/dpkg "$@"\n',
    "apt-get": """exec /usr/bin/apt-get -oDir=$ROOT \\
    -oDir::State::status=$ROOT/var/lib/dpkg/status -oDir::Bin::dpkg=$ROOT/programs/dpkg \\
    -oDir::Bin::Methods=/usr/lib/apt/methods "$@"
""",
    "apt-cache": """exec /usr/bin/apt-cache -oDir=$ROOT "$@"
""",
    "systemctl": """case $1 in
    show) cat $ROOT/active ;;
    stop) printf 'inactive\\ninactive\\n' >$ROOT/active ;;
    --no-block) [ $2 != start ] || printf 'active\\nactive\\n' >$ROOT/active ;;
esac
""",
    "runuser": 'shift 3; exec "$@"\n',
    # The doctor of a release says what the file doctor-VERSION holds.
    "gpr20-run": """case $1 in
    config) mkdir -p $ROOT/etc/gpr20/robot; echo signing_key: >$ROOT/etc/gpr20/robot/storage.yaml ;;
    doctor) exec cat $ROOT/doctor-$(cat $ROOT/opt/gpr20/current/release) ;;
    ros) cat $ROOT/code ;;
esac
""",
}
MAIN = """import os, runpy, signal, subprocess
main = runpy.run_path(PROGRAM)["main"]
from gpr20_update import packages

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
FILES = {
    "etc/gpr20/robot.conf": "GPR20_LAUNCH_ARGUMENTS=ns:=robot1\n",
    "etc/gpr20/robot/axes.yaml": "x: 1\n",
    "etc/gpr20/robot/signing_key": "-----BEGIN OPENSSH PRIVATE KEY-----\n",
    "var/lib/gpr20/.config/gpr20/plan.yaml": "x_points: 3\n",
    "var/lib/gpr20/surveys/first/survey.json": "{}",
    "code": "1\n---\n",
    "active": "active\nactive\n",
}


@dataclass(frozen=True)
class World:
    """The folder, and the sticks that it can be updated from.

    Attributes:
        root: What is / of a real computer.
        sticks: Folder of the sticks.
        gpg: Folder of the key that signed them.
    """

    root: Path
    sticks: Path
    gpg: str

    @property
    def environment(self):
        path = f"{self.root}/programs:/usr/sbin:/usr/bin:/sbin:/bin"
        return {"PATH": path, "ROOT": str(self.root)}

    def begin(self, *arguments, kill_at=0, lock_limit_s=60.0):
        """Begin gpr20-update, which can be killed at any event; return the process."""
        limits = {"KILL_AT": str(kill_at), "LOCK_LIMIT_S": str(lock_limit_s)}
        main = MAIN.replace("PROGRAM", repr(str(update_kit.ROOT / "deploy/update")))
        return subprocess.Popen(
            ["/usr/bin/python3", "-IBc", main, *map(str, arguments)],
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

    def stick(self, version):
        return self.sticks / version

    def doctor(self, version, *faults):
        """Let the doctor of a version find these faults."""
        good = Finding.of("disk", Message("The disk has space"))
        bad = [Finding.of(one, Message("{name} is bad", name=one), NOT_RUNNING) for one in faults]
        said = as_json((good, *bad), read_catalogue(Language.ENGLISH))
        (self.root / f"doctor-{version}").write_text(said, encoding="utf-8")

    def release(self):
        """Return the version of the release in use, which is whole."""
        assert update_kit.slot_problems(self.root) == ""
        return (self.root / "opt/gpr20/current/release").read_text("utf-8").strip()

    def version(self):
        """Return the one version that everything has; fail if something is between two."""
        shown = "${db:Status-Status} ${Version}"
        asked = ("dpkg-query", "-W", "-f", shown, "gpr20")
        assert printed_by(*asked, env=self.environment) == f"installed {self.release()}"
        return self.release()

    def data(self):
        """Return the checksum of every file of the configuration and of the surveys."""
        return update_kit.data_of(self.root)

    def show_process(self, number):
        """Let the computer have a process of this one."""
        (self.root / "proc").mkdir()
        (self.root / "proc" / str(number)).symlink_to(f"/proc/{number}")

    def services_run(self):
        return (self.root / "active").read_text("utf-8") == FILES["active"]

    def copy(self, place):
        """Return another computer in the same state."""
        # With the hard links between slots and what dpkg unpacked.
        printed_by("cp", "--archive", self.root, place)
        made = World(place, self.sticks, self.gpg)
        made.write_programs()
        return made

    def write_programs(self):
        for name, text in PROGRAMS.items():
            file = self.root / "programs" / name
            file.parent.mkdir(exist_ok=True)
            file.write_text(f"#!/bin/sh\nROOT={self.root}\n{text}", encoding="utf-8")
            file.chmod(0o755)


def make_world(place):
    """Return a computer on which version 1.0 was installed and is kept."""
    gpg = update_kit.release_key(place)
    world = World(place / "first", place / "the sticks", gpg)
    for version in ("1.0", "2.0"):
        update_kit.make_stick(world.sticks, version, gpg)
    for folder in ("var/lib/dpkg/updates", "var/lib/dpkg/info", "run/systemd/system"):
        (world.root / folder).mkdir(parents=True)
    for folder in ("var/lib/apt", "var/log/apt", "etc/apt/preferences.d", "var/cache/apt"):
        (world.root / folder).mkdir(parents=True)
    (world.root / "var/lib/dpkg/status").touch()
    world.write_programs()
    world.dpkg("--install", *sorted(world.stick("1.0").glob("*.deb")))
    for name, text in FILES.items():
        (world.root / name).parent.mkdir(parents=True, exist_ok=True)
        (world.root / name).write_text(text, encoding="utf-8")
    key = (world.stick("1.0") / "release_key.asc").read_bytes()
    (world.root / "etc/gpr20/release_key.asc").write_bytes(key)
    for version in ("1.0", "2.0"):
        world.doctor(version)
    world.update(world.stick("1.0"))
    return world
