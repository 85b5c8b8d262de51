"""scripts/setup.sh on machines that are made up: stubs instead of apt, sudo, pip and catkin."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from user_shell import ROOT

LIMIT_S = 60.0
STUBBED = ("sudo", "apt-get", "dpkg-query", "id", "catkin_make", "df")
NO_NETWORK = "E: Failed to fetch http://deb.debian.org/x.deb  Could not connect to deb.debian.org"
PACKAGE = "<package><name>{}</name></package>"


class Computer:
    """A checkout and the programs of a computer, all below a folder."""

    def __init__(self, place):
        self.place = place
        self.checkout = place / "gpr20"
        self.environment = {}

    @property
    def calls(self):
        """What the stubs were called with, a line each."""
        file = self.place / "calls"
        return file.read_text() if file.exists() else ""

    def stub(self, name, body, folder="bin"):
        """Make a program of shell lines that also notes how it was called."""
        file = self.place / folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f'#!/bin/bash\necho "{name} $*" >>{self.place}/calls\n{body}\n')
        file.chmod(0o755)

    def run(self, *options):
        """Run the setup without a terminal."""
        environment = {
            "HOME": str(self.place),
            "GPR20_ROS_PREFIX": str(self.place / "noetic"),
            **self.environment,
        }
        return subprocess.run(
            [str(self.checkout / "scripts/setup.sh"), *options],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """A folder with the programs of this computer that are no stubs."""
    folder = tmp_path_factory.mktemp("programs")
    for program in Path("/usr/bin").iterdir():
        if program.name not in STUBBED:
            (folder / program.name).symlink_to(program)
    return folder


@pytest.fixture
def computer(tmp_path, programs):
    """Root's computer without any of the packages; installing them works."""
    made = Computer(tmp_path)
    made.environment["PATH"] = f"{tmp_path}/bin:{programs}"
    scripts = made.checkout / "scripts"
    shutil.copytree(ROOT / "scripts", scripts, ignore=shutil.ignore_patterns("test"))
    shutil.copytree(ROOT / "requirements", made.checkout / "requirements")
    for package in ("gpr20", "gpr20_analysis", "gpr20_foreign_formats", "gpr20_viewer"):
        folder = made.checkout / "catkin_ws/src" / package
        folder.mkdir(parents=True)
        (folder / "package.xml").write_text(PACKAGE.format(package))
        (folder / "pyproject.toml").touch()
    made.stub("dpkg-query", "exit 1")
    made.stub("apt-get", "")
    made.stub("id", 'if [ "$1" = -u ]; then echo 0; else echo root; fi')
    made.stub("df", "echo head; echo disk 999999 1 999999 1% /")
    made.stub(
        "catkin_make",
        'mkdir -p "$2/build"\n'
        'echo "CMAKE_HOME_DIRECTORY:INTERNAL=$2/src" >"$2/build/CMakeCache.txt"',
    )
    venv = made.checkout / ".venv"
    made.stub("python", "", folder="gpr20/.venv/bin")
    (venv / "bin/activate").write_text(f'VIRTUAL_ENV="{venv}"\n')
    return made


def test_it_installs_builds_and_does_nothing_the_second_time_or_when_it_checks(computer):
    before = sorted(computer.place.rglob("*"))
    assert "not set up (missing Debian packages" in computer.run("--check", "--dev").stderr
    assert [one for one in sorted(computer.place.rglob("*")) if one.name != "calls"] == before
    ended = computer.run()
    assert ended.returncode == 0, ended.stderr
    assert [line.split(" ")[1] for line in ended.stdout.splitlines()] == [
        *("installing", "details", "installing", "building")
    ]
    assert "apt-get install -y --no-install-recommends cmake" in computer.calls
    computer.stub("dpkg-query", "echo install ok installed")
    (computer.place / "calls").unlink()
    assert (computer.run().stdout, "apt-get" in computer.calls) == ("", False)
    assert computer.run("--check").returncode == 0


def test_a_missing_python_package_is_seen_and_restored_in_a_new_environment(computer):
    venv = computer.checkout / ".venv"
    packages = venv / "lib/python3.11/site-packages"
    computer.stub("dpkg-query", "echo install ok installed")
    for name in ("mcap", "mcap-1.6.0.dist-info", "own"):
        (packages / name).mkdir(parents=True)
    assert computer.run().returncode == 0 and computer.run("--check").returncode == 0
    # Whatever pip knows of it.
    (packages / "mcap").rmdir()
    ended = computer.run("--check")
    assert ended.returncode == 1 and "missing: mcap" in ended.stderr
    assert "run scripts/setup.sh" in ended.stderr
    computer.stub(
        "system_python",
        'if [ "$1" = -c ]; then echo 3.11; exit; fi\n'
        f"mkdir -p {venv}/bin && cp {computer.place}/bin/pip {venv}/bin/python\n"
        f"echo 'VIRTUAL_ENV=\"{venv}\"' >{venv}/bin/activate",
    )
    computer.stub("pip", f'[ "$3" = --version ] && echo pip 23.0 || mkdir -p {packages}/mcap')
    computer.environment["GPR20_SYSTEM_PYTHON"] = str(computer.place / "bin/system_python")
    ended = computer.run()
    assert ended.returncode == 0, ended.stderr
    assert (packages / "mcap").is_dir() and not (packages / "own").exists()
    assert computer.run("--check").returncode == 0


@pytest.mark.parametrize(
    ("printed", "said"),
    [
        (NO_NETWORK, "The network did not answer"),
        ("E: Unable to locate package ros-base", "supported are Debian 12, and Ubuntu 20.04"),
        ("E: dpkg was interrupted, you must manually run", "dpkg --configure -a"),
        ("cp: write error: No space left on device", "The disk is full"),
    ],
)
def test_a_failure_of_apt_says_what_to_do_and_where_the_log_is(computer, printed, said):
    computer.stub("apt-get", f'[ "$1" = install ] || exit 0\necho "{printed}" >&2\nexit 100')
    ended = computer.run()
    assert ended.returncode == 1
    for text in (printed, said, f"the end of {computer.checkout}/setup.log"):
        assert text in ended.stderr
    assert printed in (computer.checkout / "setup.log").read_text()
