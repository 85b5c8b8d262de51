"""A folder that is a computer to gpr20-update, and signed sticks with small packages.

apt, dpkg, the program and the maintainer scripts of the package are the real ones, everything else
is played.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from user_shell import ROOT, printed_by

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.faults import NOT_RUNNING
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import as_json

SIGNER = "release@gpr20.example"
# A robot without a network may believe that it is earlier.
SIGNED_AT = "20380101T000000"
# Files of a release; enough that a cut hits the middle of them.
FILES_OF_RELEASE, SIZE_BYTES = 40, 20_000
UPDATER = {
    f"deploy/update/{one.relative_to(ROOT / 'deploy/update')}": one.read_bytes()
    for one in (ROOT / "deploy/update").rglob("*.py")
}


def release_files(version):
    """Return the files of a release by their path in a slot, the program among them."""
    files = {"release": f"{version}\n".encode(), **UPDATER}
    for number in range(FILES_OF_RELEASE):
        # No two versions have one alike.
        seed = hashlib.sha256(f"{version} {number}".encode()).digest()
        files[f"lib/folder{number % 3}/file{number}"] = seed * (SIZE_BYTES // len(seed))
    return files


def make_deb(folder, name, version, files, conffiles=(), scripts=(), **fields):
    """Make a package of files by path, and of maintainer scripts, whose endings say which."""
    tree = folder / f"tree_{name}"
    (tree / "DEBIAN").mkdir(parents=True)
    fields = {"Package": name, "Version": version, "Architecture": "all", **fields}
    fields = {"Installed-Size": "100", **fields, "Maintainer": SIGNER, "Description": "for a test"}
    lines = [f"{key}: {value}" for key, value in fields.items()]
    (tree / "DEBIAN/control").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tree / "DEBIAN/conffiles").write_text("".join(f"/{one}\n" for one in conffiles))
    for path, data in files.items():
        file = tree / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        file.chmod(0o755 if "bin/" in path else 0o644)
    for source in scripts:
        script = tree / "DEBIAN" / source.suffix[1:]
        script.write_text(source.read_text("utf-8").replace("#DEBHELPER#", ""), encoding="utf-8")
        script.chmod(0o755)
    deb = folder / f"{name}_{version}_all.deb"
    printed_by("dpkg-deb", "--root-owner-group", "-Znone", "--build", tree, deb)
    shutil.rmtree(tree)


def release_key(place):
    """Make a key that signs releases; return the folder of gpg."""
    (place / "gpg").mkdir(mode=0o700, parents=True)
    home = str(place / "gpg")
    gpg(home, "--passphrase", "", "--quick-generate-key", SIGNER, "ed25519", "sign", "never")
    return home


def gpg(home, *words):
    """Run gpg in its folder, at a time that is not that of the robot."""
    command = ("gpg", "--batch", "--yes", "--faked-system-time", SIGNED_AT, *words)
    try:
        printed_by(*command, GNUPGHOME=home)
    finally:
        printed_by("gpgconf", "--kill", "all", GNUPGHOME=home)


def sign(stick, home):
    """Write the index of a stick, and its signature, as scripts/stick.sh does."""
    index = "dpkg-scanpackages --multiversion . 2>/dev/null >Packages"
    printed_by("sh", "-ec", index, folder=stick)
    data = (stick / "Packages").read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    text = f"Date: Fri, 01 Jan 2038 00:00:00 UTC\nSHA256:\n {digest} {len(data)} Packages\n"
    (stick.parent / "Release").write_text(text, encoding="utf-8")
    gpg(home, "--output", stick / "InRelease", "--clearsign", stick.parent / "Release")
    gpg(home, "--output", stick / "release_key.asc", "--armor", "--export")


def make_stick(stick, version, home):
    """Make a stick with one version, signed with the key of a folder of gpg."""
    stick.mkdir(parents=True)
    program = ROOT / "deploy/root/usr/sbin/gpr20-update"
    files = {
        **{f"opt/gpr20/unpacked/{name}": one for name, one in release_files(version).items()},
        "etc/gpr20/robot.conf": f"# {version}\nGPR20_LAUNCH_ARGUMENTS=\n".encode(),
        "lib/systemd/system/gpr20.service": f"# {version}\n".encode(),
        "usr/sbin/gpr20-update": program.read_bytes(),
    }
    scripts = sorted((ROOT / "debian").glob("gpr20.p*"))
    needs = {"Depends": f"other-library (>= {version})", "Recommends": "not-on-the-stick"}
    make_deb(stick, "gpr20", version, files, ["etc/gpr20/robot.conf"], scripts, **needs)
    make_deb(stick, "other-library", version, {"usr/lib/other": version.encode()})
    sign(stick, home)


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
    """What is / of a real computer; the sticks for it; and the gpg of who has signed them."""

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
        main = MAIN.replace("PROGRAM", repr(str(ROOT / "deploy/update")))
        return subprocess.Popen(
            ["/usr/bin/python3", "-IBc", main, *map(str, arguments)],
            env={**self.environment, **limits},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
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
        slot = self.root / "opt/gpr20" / os.readlink(self.root / "opt/gpr20/current")
        version = (slot / "release").read_text("utf-8").strip()
        files = [one for one in slot.rglob("*") if one.is_file()]
        found = {str(one.relative_to(slot)): one.read_bytes() for one in files}
        assert found == release_files(version), f"{slot} is not {version}"
        return version

    def version(self):
        """Return the one version that everything has; fail if something is between two."""
        shown = "${db:Status-Status} ${Version}"
        asked = ("dpkg-query", "-W", "-f", shown, "gpr20")
        assert printed_by(*asked, env=self.environment) == f"installed {self.release()}"
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
    world = World(place / "first", place / "the sticks", release_key(place))
    for version in ("1.0", "2.0"):
        make_stick(world.stick(version), version, world.gpg)
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
