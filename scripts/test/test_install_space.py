"""A copy of an install space runs a survey where neither the sources nor its first folder exist."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sysconfig

import pytest
from robot_kit import end, free_port
from user_shell import ROOT, printed_by, user_environment
from wait_kit import wait_until

pytestmark = pytest.mark.release

AREA = "--x-start-mm 100 --x-stop-mm 120 --x-points 3 --y-start-mm 100 --y-stop-mm 120 --y-points 3"
# catkin_make is part of the script; `catkin build` installs the same, but takes a minute longer.
INSTALL = "scripts/install_space.sh"


def run(command, environment, folder=None):
    """Run a command line in a shell; return what it printed."""
    return printed_by("bash", "-c", command, folder=folder, env=environment)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A copy of an install space, read-only, and the revision of its sources, which are gone."""
    folder = tmp_path_factory.mktemp("install_space")
    sources, first, copy = folder / "sources", folder / "first", folder / "copy"
    # The messages of C++, Lisp and JavaScript would take as long as everything else.
    languages = "gencpp:geneus:genlisp:gennodejs"
    environment = user_environment(folder / "data", ROS_LANG_DISABLE=languages)
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(sources)], check=True)
    run(f"{INSTALL} {first} --no-venv", environment, sources)
    revision = run("git describe --always --tags", environment, sources).strip()
    # It does not keep the times of the files.
    shutil.copytree(first, copy, symlinks=True, copy_function=shutil.copy)
    shutil.rmtree(first)
    shutil.rmtree(sources)
    add_virtual_environment(copy)
    subprocess.run(["chmod", "-R", "a-w", str(copy)], check=True)
    yield copy, revision
    subprocess.run(["chmod", "-R", "u+w", str(copy)], check=True)


def add_virtual_environment(folder):
    """Make venv as the script does, but with the packages of this checkout's instead of pip's."""
    make = ["/usr/bin/python3", "-m", "venv", "--without-pip", "--system-site-packages"]
    subprocess.run([*make, str(folder / "venv")], check=True)
    (own,) = (folder / "venv").glob("lib/python3*/site-packages")
    # Not the editable installation of the analysis, which is a .pth file there.
    (own / "packages.pth").write_text(sysconfig.get_path("purelib") + "\n")


def sourced(folder, command):
    """Return a command line in a terminal that sourced an install space."""
    return f"source '{folder}/setup.bash' && {command}"


@pytest.fixture(scope="module")
def survey(installed, tmp_path_factory):
    """A survey that the copy ran, with its window: (its folder, the log of the launch)."""
    folder, _revision = installed
    home = tmp_path_factory.mktemp("home")
    data, log = home / "data", home / "launch.log"
    port = free_port()
    master = {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "QT_QPA_PLATFORM": "offscreen"}
    environment = user_environment(data, HOME=str(home), **master)
    start = sourced(folder, f"exec roslaunch -p {port} gpr20 survey.launch time_scale:=50")
    with log.open("w") as printed:
        launch = subprocess.Popen(
            ["bash", "-c", start],
            env=environment,
            stdout=printed,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            wait_until(lambda: "/main_control is ready" in log.read_text(), alive=[launch])
            run(sourced(folder, f"rosrun gpr20_user_interface run_survey {AREA}"), environment)
        finally:
            end(launch, signal.SIGINT)
    (stored,) = (one for one in data.iterdir() if one.is_dir())
    return stored, log.read_text()


def test_a_copy_runs_a_whole_survey_that_the_installed_command_verifies(installed, survey):
    folder, revision = installed
    stored, log = survey
    environment = user_environment(stored)
    said = run(sourced(folder, f"gpr20 verify {stored}"), environment)
    assert "complete and intact: all 18 planned traces" in said
    assert stored.name in run(sourced(folder, f"gpr20 info {stored}"), environment)
    run(sourced(folder, f"gpr20 verify {stored}"), environment)
    assert "process[user_interface-" in log
    for word in ("Traceback", "has died", "[ERROR]", "No module named"):
        assert word not in log, log
    software = json.loads((stored / "survey.json").read_text())["software_revision"]
    assert software.endswith(f" (git {revision})")
