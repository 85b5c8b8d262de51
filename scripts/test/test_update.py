"""gpr20-update: it ends with the old or the new version, never between, and never during a survey.

A stick that it reads is whole and allowed, or nothing changes.

apt and dpkg are the real ones, in a folder; test_update_power_cuts.py does it with power cuts.
"""

from __future__ import annotations

import argparse
import fcntl
import os
import re
import shutil
import subprocess
import sys

import pytest
import update_world
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_doctor import add_arguments
from gpr20_survey.plan.survey_state import RUNNING
from gpr20_update import robot

pytestmark = pytest.mark.needs("packages")


def test_an_update_stays_if_the_doctor_finds_nothing_new(world):
    data = world.data()
    world.doctor("1.0", "vna")
    world.doctor("2.0", "vna")
    said = world.update(world.stick("2.0"))
    assert world.version() == "2.0"
    assert world.data() == data
    assert world.services_run()
    assert "2.0 is installed" in said
    assert "2.0" in world.update("--status")


@pytest.mark.parametrize("reason", ["axes is bad", "no judgement", "no installation"])
def test_what_fails_returns_the_version_before(world, reason):
    data = world.data()
    if reason == "axes is bad":
        # A fault that was there before does not hide a second one of its kind.
        world.doctor("1.0", "axes")
        world.doctor("2.0", "axes", "axes")
    elif reason == "no judgement":
        (world.root / "doctor-2.0").write_text("Traceback")
    else:
        apt = world.root / "programs/apt-get"
        text = apt.read_text().replace("exec", 'case "$*" in *--no-download*) exit 1 ;; esac\nexec')
        apt.write_text(text)
    said = world.update(world.stick("2.0"), status=1)
    assert (world.version(), world.data()) == ("1.0", data)
    assert world.services_run()
    if reason == "axes is bad":
        assert reason in said and reason in world.update("--status")


def test_with_the_version_before_returns_all_of_its_configuration(world):
    robot = world.root / "etc/gpr20/robot"
    (robot / "link").symlink_to("/srv/robot")
    data = world.data()
    # The new version changes, adds and removes files before its doctor finds a fault.
    program = world.root / "programs/gpr20-run"
    harm = f"echo 'x: 3' >{robot}/axes.yaml; touch {robot}/more.yaml; rm -f {robot}/link"
    text = program.read_text().replace(
        "doctor)", f"doctor) [ $(cat $ROOT/opt/gpr20/current/release) = 1.0 ] || {{ {harm}; }};"
    )
    program.write_text(text)
    world.doctor("2.0", "axes")
    world.update(world.stick("2.0"), status=1)
    assert (world.version(), world.data()) == ("1.0", data)
    assert os.readlink(robot / "link") == "/srv/robot"


def test_back_returns_to_the_version_before_and_keeps_the_configuration(world):
    world.update(world.stick("2.0"))
    (world.root / "etc/gpr20/robot/axes.yaml").write_text("x: 2\n")
    data = world.data()
    world.update("--back")
    assert (world.version(), world.data()) == ("1.0", data)
    assert "before 1.0" in world.update("--back", status=2)


def events(text):
    return int(re.search(r"events (\d+)", text).group(1))


@pytest.mark.release
def test_a_kill_at_any_event_ends_in_the_old_or_the_new_version(first, tmp_path):
    data = first.data()
    last = events(first.copy(tmp_path / "whole").update(first.stick("2.0")))
    ended = []
    for event in range(1, last + 2):
        world = first.copy(tmp_path / str(event))
        world.update(world.stick("2.0"), kill_at=event, status=-9 if event <= last else 0)
        world.release()
        # The return at boot is killed too.
        if event <= last and "Killed" in world.update("--continue", kill_at=event, status=None):
            world.release()
            assert "interrupted" in world.update(world.stick("2.0"), status=2)
        world.update("--continue")
        ended.append(world.version())
        assert world.data() == data, event
    assert last >= 8
    assert ended == ["1.0"] * last + ["2.0"]


def test_a_return_in_which_dpkg_fails_uses_the_whole_version_before_at_once(world):
    data = world.data()
    world.update(world.stick("2.0"), kill_at=6, status=-9)
    assert world.release() == "2.0"
    dpkg = world.root / "programs/dpkg"
    works = dpkg.read_text()
    dpkg.write_text("#!/bin/sh\nexit 1\n")
    assert "could not be installed again" in world.update("--continue", status=2)
    assert (world.release(), world.data()) == ("1.0", data)
    assert world.services_run()
    dpkg.write_text(works)
    world.update("--continue")
    assert world.version() == "1.0"


@pytest.mark.parametrize("name", ["lock", "lock-frontend"])
def test_what_another_program_installs_ends_before_anything_returns(world, name):
    world.update(world.stick("2.0"), kill_at=6, status=-9)
    assert "UNFINISHED: from version 1.0 to 2.0" in world.update("--status")
    before = {one: one.read_bytes() for one in (world.root / "var").rglob("*") if one.is_file()}
    hold = f"import fcntl; f = open({str(world.root / 'var/lib/dpkg' / name)!r}, 'ab'); "
    hold += "fcntl.lockf(f, fcntl.LOCK_EX); print(flush=True); input()"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", hold], **pipes) as other:
        other.stdout.readline()
        said = world.update("--continue", status=2, lock_limit_s=0.3)
        assert "another program has installed packages" in said
        assert not world.services_run()
        now = {one: one.read_bytes() for one in (world.root / "var").rglob("*") if one.is_file()}
        assert now == before
        with world.begin("--continue") as resumed:
            assert "returning" in resumed.stdout.readline()
            assert "waiting" in resumed.stdout.readline()
            other.communicate(b"\n")
            resumed.communicate()
        assert resumed.returncode == 0
    assert world.version() == "1.0"
    assert world.services_run()


@pytest.mark.parametrize("code", [4, 5, None])
def test_a_survey_refuses_update_and_return(world, code):
    (world.root / "code").write_text("no answer" if code is None else f"{code}\n---\n")
    for asked in (world.stick("2.0"), "--back"):
        assert "survey" in world.update(asked, status=2)
    assert world.version() == "1.0"


def test_the_states_of_a_survey_and_the_arguments_of_the_doctor_are_those_of_the_robot():
    assert {int(one) for one in RUNNING} == robot.SURVEY_CODES
    parser = argparse.ArgumentParser("doctor")
    add_arguments(parser)
    given = parser.parse_args([*robot.DOCTOR[1:], *robot.WAIT])
    assert given.json and given.wait == 60.0


def test_the_lock_of_a_survey_refuses_whatever_the_nodes_and_the_person_say(world, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/survey.json").touch()
    world.show_process(os.getpid())
    descriptor = os.open(tmp_path / "elsewhere", os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        said = world.update(world.stick("2.0"), "--no-survey", status=2)
        assert str(tmp_path / "elsewhere") in said
    finally:
        os.close(descriptor)
    world.update(world.stick("2.0"), "--no-survey")


def test_a_robot_launched_by_hand_refuses(world, tmp_path):
    program = tmp_path / "roslaunch"
    program.write_text("import sys\nprint(1, flush=True)\nsys.stdin.read()\n")
    with subprocess.Popen(
        [sys.executable, program], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as launch:
        launch.stdout.readline()
        world.show_process(launch.pid)
        said = world.update(world.stick("2.0"), "--no-survey", status=2)
        launch.stdin.close()
    assert str(launch.pid) in said


# The files of a stick.

# Every example damages what it has copied.
SAME_FOLDER = settings(
    max_examples=draws(10), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
# What apt reads of a stick; the rest is for people.
READ = ("InRelease", "Packages", "gpr20_2.0_all.deb", "other-library_2.0_all.deb")


@pytest.fixture
def stick(first, tmp_path):
    """A copy of the stick of version 2.0."""
    shutil.copytree(first.stick("2.0"), tmp_path / "stick")
    return tmp_path / "stick"


def refused(world, place, *words):
    """Update from there; it is refused with these words, and nothing has changed."""
    before = world.data()
    said = world.update(place, status=2)
    assert all(one in said for one in words), said
    assert (world.version(), world.data()) == ("1.0", before)
    assert "versions that are kept: 1.0\n" in world.update("--status")


@SAME_FOLDER
@given(data=st.data())
def test_a_stick_with_any_damage_is_refused(world, stick, data):
    name = data.draw(st.sampled_from(READ))
    whole = (stick / name).read_bytes()
    at = data.draw(st.integers(0, len(whole) - 1))
    damage = data.draw(st.sampled_from(["cut", "flip", "gone"]))
    changed = bytearray(whole)
    changed[at] ^= data.draw(st.integers(1, 255)) if damage == "flip" else 0
    if damage == "gone":
        (stick / name).unlink()
    else:
        (stick / name).write_bytes(changed[:at] if damage == "cut" else changed)
    try:
        # Not every bit of the armour of a signature has a meaning; a good one stays good.
        said = world.update(stick, status=None if name == "InRelease" else 2)
        assert world.version() == "1.0" or (name == "InRelease" and "good signature" in said)
        if world.version() == "2.0":
            world.update("--back")
    finally:
        (stick / name).write_bytes(whole)


def test_a_release_of_somebody_else_is_refused(world, stick, tmp_path):
    update_world.sign(stick, update_world.release_key(tmp_path))
    key = world.root / "etc/gpr20/release_key.asc"
    refused(world, stick, f"not signed with {key}")
    (stick / "InRelease").write_text((stick.parent / "Release").read_text("utf-8"))
    refused(world, stick, f"not signed with {key}")
    key.unlink()
    refused(world, world.stick("2.0"), f"{key} is missing")


def test_a_stick_that_this_computer_cannot_take_is_refused(world, stick):
    refused_sizes = {"Installed-Size": "9000000000"}
    needs = {"Depends": "other-library, nobody-has-it"}
    for fields, reason in ((needs, "nobody-has-it"), (refused_sizes, "MB free")):
        update_world.make_deb(stick, "gpr20", "2.0", {}, **fields)
        update_world.sign(stick, world.gpg)
        refused(world, stick, reason)


def test_a_version_to_which_no_way_leads_back_is_not_left(world):
    kept = world.root / "var/lib/gpr20-update/kept/1.0.deb"
    data = kept.read_bytes()
    for changed in (data[:-1], data[:-1] + b"x"):
        kept.write_bytes(changed)
        refused(world, world.stick("2.0"), "no way back")
    world.update(world.stick("1.0"))
    assert kept.read_bytes() == data
    world.update(world.stick("2.0"))


def test_a_configuration_that_could_not_return_is_refused(world):
    (world.root / "etc/gpr20/robot.conf").write_text("GPR20_CONFIG=/srv/robot\n")
    assert "/srv/robot" in world.update(world.stick("2.0"), status=2)
    assert world.version() == "1.0"


# The maintainer scripts of the package.

FORCED = ("--force-depends", "--force-confold")
# Whatever the scripts of the package call.
CALLED = ("cp", "mv", "ln", "sync", "rm", "mkdir", "readlink")


def deb(world, version):
    return world.stick(version) / f"gpr20_{version}_all.deb"


def install(world, version, **how):
    """Install the software alone, whatever others need."""
    return world.dpkg(*FORCED, "--install", deb(world, version), **how)


def slots(world):
    return {
        one.name: (one / "release").read_text("utf-8").strip()
        for one in (world.root / "opt/gpr20/slots").iterdir()
    }


@pytest.mark.release
def test_the_version_before_stays_in_the_other_slot_and_is_not_replaced_while_it_runs(world):
    assert slots(world) == {"a": "1.0"}
    install(world, "2.0")
    assert (world.release(), slots(world)) == ("2.0", {"a": "1.0", "b": "2.0"})
    used = {"PYTHONPATH": f"{world.root}/opt/gpr20/slots/a/lib"}
    with subprocess.Popen(["/bin/cat"], stdin=subprocess.PIPE, env=used) as service:
        assert f"process {service.pid}" in install(world, "1.0", status=1)
        assert (world.release(), slots(world)) == ("2.0", {"a": "1.0", "b": "2.0"})
        service.stdin.close()
    install(world, "1.0")
    assert (world.release(), slots(world)) == ("1.0", {"a": "1.0", "b": "2.0"})


@pytest.mark.release
def test_a_kill_before_any_command_of_the_scripts_leaves_a_whole_release(first, tmp_path):
    for number in range(1, 30):
        world = first.copy(tmp_path / str(number))
        count = world.root / "count"
        count.write_text("0")
        for name in CALLED:
            wrapper = world.root / "programs" / name
            wrapper.write_text(
                f"#!/bin/sh\nn=$(($(cat {count}) + 1)); echo $n >{count}\n"
                f'[ $n -ne {number} ] || kill -9 $PPID\nexec /usr/bin/{name} "$@"\n'
            )
            wrapper.chmod(0o755)
        killed = subprocess.run(
            ["dpkg", *FORCED, "--install", deb(world, "2.0")],
            env=world.environment,
            capture_output=True,
            check=False,
        )
        assert world.release() in ("1.0", "2.0")
        if int(count.read_text()) < number:
            break
        for name in CALLED:
            (world.root / "programs" / name).unlink()
        world.dpkg(*FORCED, "--configure", "--pending")
        if killed.returncode != 0:
            install(world, "2.0")
        assert world.release() == "2.0"
    assert number > 8
