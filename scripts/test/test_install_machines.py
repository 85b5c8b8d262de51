"""The install scripts in a folder: what they change, that they change it once, and back."""

from __future__ import annotations

import random
import re
import subprocess

import machine_tree
import pytest
from machine_tree import ADDRESSES, ADMIN, CHANGE, CONFIG, UBUNTU
from user_shell import ROOT

MACHINES = [machine_tree.robot, machine_tree.one_machine, machine_tree.server]


@pytest.fixture(params=MACHINES, ids=lambda make: make.__name__)
def bare(request, tmp_path):
    return request.param(tmp_path)


@pytest.fixture
def robot(tmp_path):
    return machine_tree.robot(tmp_path)


def test_a_dry_run_prints_every_change_and_makes_none(bare):
    before = bare.contents()
    planned = CHANGE.findall(bare.install("--dry-run"))
    assert bare.contents() == before
    assert planned == CHANGE.findall(bare.install())
    installed = bare.contents()
    bare.run("--uninstall", "--dry-run")
    assert bare.contents() == installed


def test_a_second_run_changes_nothing(bare):
    bare.install()
    installed = bare.contents()
    again = bare.install()
    assert bare.contents() == installed
    assert CHANGE.findall(again) == []
    assert "0 changes made" in again


def some_files(machine, draw):
    """Write what a machine may have before; return nothing."""
    lines = ["dtparam=audio=on", "[pi4]", "[cm4]", "#dtparam=spi=on", "dtparam=spi=off", "", "é"]
    text = draw.choice(["\n", "\r\n"]).join(draw.choices(lines, k=draw.randrange(12)))
    machine.write(draw.choice([CONFIG, "boot/config.txt"]), text + draw.choice(["", "\n", "\n\n"]))
    for path, text in {
        "etc/group": "root:x:0:\nspi:x:995:pi\n",
        "etc/chrony/chrony.conf": draw.choice(["pool x\n", "confdir /etc/chrony/conf.d", "x"]),
        "etc/chrony/conf.d/mine.conf": "makestep 1 3\n",
        "etc/security/limits.d/audio.conf": "@audio - rtprio 95\n",
        "etc/systemd/system/multi-user.target.wants/ssh.service": "[Unit]\n",
        "var/log/syslog": "line\n",
        "var/lib/gpr20/surveys/20250101/survey.json": "{}",
        "etc/gpr20/robot/site.yaml": "site: x\n",
    }.items():
        if draw.random() < 0.5:
            machine.write(path, text)


@pytest.mark.parametrize("seed", range(2))
def test_uninstalling_restores_what_was_there_byte_for_byte(bare, seed):
    some_files(bare, random.Random(seed))
    before = bare.contents()
    bare.install()
    assert bare.contents() != before
    bare.uninstall()
    assert bare.contents() == before
    assert "nothing is installed" in bare.uninstall()


def test_what_was_added_to_a_file_since_stays_when_the_lines_are_removed(robot):
    robot.write(CONFIG, "before")
    robot.install()
    with (robot.folder / CONFIG).open("a") as file:
        file.write("after\n")
    robot.uninstall()
    assert (robot.folder / CONFIG).read_text() == "before\nafter\n"


def test_data_configuration_and_what_was_changed_by_hand_stay_and_are_named(robot):
    robot.install()
    survey = robot.write("var/lib/gpr20/surveys/s/survey.json", "{}")
    axes = robot.write("etc/gpr20/robot/axes.yaml", "x: {}")
    settings = robot.write("etc/gpr20/environment", "GPR20_LAUNCH_ARGUMENTS=ns:=robot1\n")
    printed = robot.uninstall()
    assert survey.exists() and axes.exists() and settings.exists()
    for left in ("/var/lib/gpr20/surveys", "/etc/gpr20", "/etc/gpr20/environment, changed by"):
        assert f"left: {left}" in printed
    assert not (robot.folder / "etc/systemd/system/gpr20-robot.service").exists()


def test_a_file_that_was_changed_by_hand_is_not_overwritten(robot):
    robot.install()
    unit = robot.write("etc/systemd/system/gpr20-robot.service", "mine")
    assert "left: /etc/systemd/system/gpr20-robot.service" in robot.install()
    assert unit.read_text() == "mine"


def test_a_run_that_was_interrupted_is_completed_by_the_next_one(robot):
    before = robot.contents()
    robot.install()
    manifest = robot.folder / "etc/gpr20/installed"
    # The last file was written, but not recorded; the links of its unit are missing.
    lines = manifest.read_text().splitlines(keepends=True)
    manifest.write_text("".join(one for one in lines if "gpr20-window.service" not in one))
    (robot.folder / "etc/systemd/system/multi-user.target.wants/gpr20-window.service").unlink()
    assert CHANGE.findall(robot.install()) == [
        "link /etc/systemd/system/multi-user.target.wants/gpr20-window.service"
    ]
    robot.uninstall()
    assert robot.contents() == before


def test_other_addresses_are_set_in_the_settings_and_the_rest_of_them_stays(robot):
    robot.install("--data", "/srv/surveys")
    file = robot.folder / "etc/gpr20/environment"
    file.write_text(file.read_text().replace("ARGUMENTS=\n", "ARGUMENTS=ns:=robot1\n", 1))
    robot.run("--robot", "10.9.0.1", "--server", "10.9.0.2", *ADMIN)
    found = robot.settings()
    assert (found["GPR20_ROBOT"], found["GPR20_SERVER"]) == ("10.9.0.1", "10.9.0.2")
    assert found["GPR20_DATA"] == "/srv/surveys"
    assert found["GPR20_LAUNCH_ARGUMENTS"] == "ns:=robot1"
    assert "10.9.0.1, 10.9.0.2" in (robot.folder / "etc/gpr20/firewall.nft").read_text()
    assert "left: /etc/gpr20/environment" in robot.uninstall()


@pytest.mark.parametrize("configured", ["", "data: '/mnt/other'  # an SSD\n", "#data: /mnt/no\n"])
def test_the_services_wait_for_the_disk_of_the_surveys(robot, configured):
    robot.write("etc/gpr20/robot/storage.yaml", configured)
    robot.install("--data", "/srv/surveys")
    folder = "/mnt/other" if "other" in configured else "/srv/surveys"
    assert robot.unit_values("gpr20-robot", "RequiresMountsFor") == [folder]


def test_a_data_folder_that_is_gone_is_not_made_again(robot):
    robot.install("--data", "/srv/disk/surveys")
    (robot.folder / "srv/disk/surveys").rmdir()
    assert "left: the folder /srv/disk/surveys is gone" in robot.install()
    assert not (robot.folder / "srv/disk/surveys").exists()


def test_the_chrony_of_ubuntu_reads_the_file_too(tmp_path):
    server = machine_tree.server(tmp_path)
    server.write("etc/os-release", UBUNTU)
    main = server.write("etc/chrony/chrony.conf", "pool ntp.ubuntu.com\n")
    server.install()
    assert "\ninclude /etc/chrony/conf.d/gpr20.conf\n" in main.read_text()


WRONG = {
    "no addresses": ([], "--robot '' is not an IPv4 address"),
    "no address": (["--robot", "10.20.0.256", "--server", "10.20.0.2"], "'10.20.0.256' is not"),
    "the same": (["--robot", "10.20.0.1", "--server", "10.20.0.1"], "they must differ"),
    "nobody could get in": (ADDRESSES, "--admin ADDRESS"),
    "no admin": ([*ADDRESSES, "--admin", "me"], "--admin 'me'"),
    "everybody gets in": ([*ADDRESSES, "--admin", "0.0.0.0/0"], "--admin '0.0.0.0/0'"),
    "no user": ([*ADDRESSES, *ADMIN, "--user", "a b"], "not the name of a user"),
    "no path": ([*ADDRESSES, *ADMIN, "--data", "surveys"], "not an absolute path"),
    "quote in path": ([*ADDRESSES, *ADMIN, "--data", "/srv/o'neil"], "spaces, quotes"),
    "no value": (["--robot"], "--robot needs a value"),
    "unknown": (["--force"], "unknown argument '--force'"),
    "two and one": (["--one-machine", *ADDRESSES], "--one-machine needs no --robot"),
}


@pytest.mark.parametrize("arguments, reason", WRONG.values(), ids=WRONG)
def test_wrong_arguments_are_refused_and_nothing_changes(robot, arguments, reason):
    before = robot.contents()
    assert reason in robot.run(*arguments, status=1)
    assert robot.contents() == before


def test_another_system_is_refused(robot):
    robot.write("etc/os-release", 'ID=debian\nVERSION_ID="11"\n')
    assert "supported are Debian 12 and Ubuntu 20.04" in robot.run(*robot.options, status=1)


def test_a_system_without_systemd_is_refused(robot):
    (robot.folder / "lib/systemd/systemd").unlink()
    assert "systemd is missing" in robot.run(*robot.options, status=1)


def test_a_desktop_keeps_its_screen(robot):
    (robot.folder / "etc/systemd/system").mkdir(parents=True)
    (robot.folder / "etc/systemd/system/display-manager.service").symlink_to("lightdm.service")
    assert "--no-window" in robot.run(*robot.options, status=1)
    robot.install("--no-window")
    assert not (robot.folder / "etc/systemd/system/gpr20-window.service").exists()


def test_one_machine_has_one_role(tmp_path):
    server, robot = machine_tree.server(tmp_path), machine_tree.robot(tmp_path)
    server.install()
    assert "installed as 'server'" in robot.run(*robot.options, status=1)


def shell(*commands, **variables):
    """Run commands of bash with the functions of the scripts; return the process."""
    sources = [f"source {ROOT}/scripts/steps/{name}.sh" for name in NEEDED]
    text = "\n".join(["root=''", *sources, *commands])
    return subprocess.run(
        ["bash", "-c", text],
        env={"PATH": "/usr/bin:/bin", **variables},
        check=False,
        capture_output=True,
        text=True,
    )


NEEDED = ("installation_steps", "installation_services")
SPI = {
    "": False,
    "dtparam=spi=on": True,
    " dtparam = i2c_arm=on,spi=on  # both": True,
    "dtparam=spi": True,
    "#dtparam=spi=on": False,
    "dtparam=spi=on\r\ndtparam=spi=off": False,
    "dtparam=spi=off\n[all]\ndtparam=spi=on": True,
    "[cm4]\ndtparam=spi=on": False,
    "[pi4]\ndtparam=spi=on": True,
    "[cm4]\n[all]\ndtparam=spi=on": True,
}


@pytest.mark.parametrize("text, on", SPI.items(), ids=map(repr, SPI))
def test_spi_is_on_if_the_last_line_for_this_computer_says_so(tmp_path, text, on):
    (tmp_path / "config.txt").write_bytes(text.encode())
    assert (shell(f"spi_is_on {tmp_path}/config.txt").returncode == 0) is on


@pytest.mark.parametrize(
    ("client", "refused"),
    [("192.168.1.7", False), ("10.20.0.2", False), ("192.168.2.7", True), ("", False)],
)
def test_a_remote_shell_cannot_lock_itself_out(client, refused):
    done = shell(
        'fail() { echo "$*"; exit 1; }',
        "robot=10.20.0.1 server=10.20.0.2 admins=(192.168.1.0/24)",
        # sudo hides the variable from the script, not from its parents.
        "(unset SSH_CONNECTION; check_remote_shell)",
        SSH_CONNECTION=f"{client} 50000 10.20.0.1 22" if client else "",
    )
    assert (done.returncode == 1) is refused, done.stdout + done.stderr
    assert (f"--admin {client}" in done.stdout) is refused


ACTIVATE = """
systemd_runs() { true; }
is_real() { true; }
systemctl() { echo "systemctl $*" >&2; [ "$1" != is-active ] || [[ "$3" = $RUNNING ]]; }
udevadm() { echo "udevadm $*" >&2; }
SETTINGS=/etc/gpr20/environment dry=no
units=(gpr20-firewall gpr20-robot)
"""


def activated(written, running="none", *more):
    """Return the commands that are run and the lines that are printed after files were written."""
    done = shell(ACTIVATE, f"written=({written})", *more, "activate", RUNNING=running)
    assert done.returncode == 0
    commands = [one for one in done.stderr.splitlines() if " is-active " not in one]
    return commands, done.stdout


def test_new_services_are_started_at_once():
    commands, _printed = activated("/etc/udev/rules.d/60-gpr20.rules /etc/systemd/system/a.service")
    assert commands == [
        "udevadm control --reload",
        "udevadm trigger",
        "systemctl daemon-reload",
        "systemctl start --no-block gpr20-firewall",
        "systemctl start --no-block gpr20-robot",
    ]


def test_a_robot_that_needs_a_reboot_is_not_started():
    commands, printed = activated("", "none", "reboot=yes")
    assert commands == []
    assert "reboot now" in printed


def test_a_service_that_runs_is_not_restarted_because_a_survey_may_run():
    commands, printed = activated("/etc/gpr20/environment /etc/gpr20/firewall.nft", "gpr20-*")
    assert commands == ["systemctl reload gpr20-firewall"]
    assert "left: gpr20-robot runs with its former settings" in printed
    assert "gpr20-firewall runs\n" in printed


DIAGNOSE = """
systemd_runs() { true; }
systemd-run() { echo "systemd-run $*"; return 2; }
SETTINGS=/etc/gpr20/environment DEPLOY=/opt/gpr20/deploy user=gpr20 dry=no reboot=no
"""


@pytest.mark.parametrize(
    "setting, run, named", [("", 1, 1), ("dry=yes", 0, 0), ("reboot=yes", 0, 1)]
)
def test_at_its_end_the_doctor_looks_as_the_user_of_the_services(setting, run, named):
    done = shell(DIAGNOSE, setting, "diagnose")
    # What it finds does not make the installation fail.
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(re.findall("(?m)^systemd-run .*--uid=gpr20 .*run.sh doctor$", done.stdout)) == run
    assert done.stdout.count("rosrun gpr20_doctor doctor") == named


KEY = (
    f"source {ROOT}/scripts/steps/installation.sh"
    + """
is_real() { true; }
robot_config() { echo "robot_config $*"; }
chown() { echo "chown $*"; }
"""
)


@pytest.mark.parametrize(
    "text, made",
    [(None, 1), ("#signing_key: ''", 1), ("signing_key: ''", 0), ("signing_key: a", 0)],
)
def test_the_key_that_signs_surveys_is_made_once_for_the_user_of_the_storage(tmp_path, text, made):
    if text is not None:
        (tmp_path / "etc/gpr20/robot").mkdir(parents=True)
        (tmp_path / "etc/gpr20/robot/storage.yaml").write_text(f"data: /srv\n{text}\n")
    done = shell(KEY, f"root={tmp_path} user=measure", "ensure_key")
    assert done.returncode == 0, done.stderr
    folder = "/etc/gpr20/robot"
    assert done.stdout.count(f"robot_config key {folder}\n") == made
    owner = f"chown measure: {folder}/signing_key {folder}/signing_key.pub\n"
    assert done.stdout.count(owner) == made


@pytest.mark.parametrize("make", MACHINES, ids=lambda make: make.__name__)
def test_only_a_machine_that_stores_surveys_has_a_key(tmp_path, make):
    printed = make(tmp_path).install()
    assert ("signing_key" in printed) is (make is not machine_tree.robot)


def test_a_machine_without_running_services_is_told_of_the_doctor(bare):
    assert "rosrun gpr20_doctor doctor" in bare.install()


def test_a_checkout_may_have_an_ampersand_in_its_path():
    text = 'GPR20_ROOT="/opt/a&b" DEPLOY=%s/deploy'
    done = shell(text % ROOT, "template systemd/gpr20-robot.service")
    assert "ExecStart=/opt/a&b/deploy/run.sh" in done.stdout, done.stdout


def test_a_firewall_of_an_earlier_run_is_named(robot):
    robot.install()
    assert "left: the firewall of an earlier run" in robot.run(*ADDRESSES, "--no-firewall")


def test_a_remote_shell_over_ipv6_is_told_what_to_do():
    commands = ('fail() { echo "$*"; exit 1; }', "admins=(192.168.1.0/24)", "check_remote_shell")
    done = shell(*commands, SSH_CONNECTION="fe80::1%eth0 50000 fe80::2%eth0 22")
    assert done.returncode == 1
    assert "closes IPv6" in done.stdout and "--admin" not in done.stdout


OPTIONS = ["--robot", "--server", "--admin", "--no-firewall", "--one-machine", "--no-window"]
OPTIONS += ["--user", "--data", "--dry-run", "--uninstall", "--root"]


def test_every_option_is_described_in_the_help(robot):
    printed = robot.run("--help")
    assert [option for option in OPTIONS if option not in printed] == []
