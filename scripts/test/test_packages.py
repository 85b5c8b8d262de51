"""The Debian package: its files, and that the programs that read these accept them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from case_kit import each_case
from network_namespaces import ROBOT, SERVER, firewall_commands, remote_shell_rule
from user_shell import ROOT, printed_by, unit_values

from gpr20_survey.axes import PULSE_PRIORITY

VERSION = "1.2.3"
CHANGELOG = f"""gpr20 ({VERSION}) stable; urgency=medium

  * A change.

 -- Someone <someone@robot.example>  Fri, 27 Nov 2026 12:00:00 +0000
"""
# What debian/install makes, without building.
INSTALL = """#!/bin/sh
mkdir -p "$GPR20_PACKAGE/deploy"
cp deploy/gpr20-run deploy/firewall "$GPR20_PACKAGE/deploy"
dpkg-parsechangelog -S Version >"$GPR20_PACKAGE/release"
"""
ADMIN = "192.168.1.0/24"
UNITS = ["gpr20", "gpr20-firewall", "gpr20-update", "gpr20-window"]
# Programs of other packages that the units start.
PROGRAMS = ["usr/bin/xinit", "usr/sbin/nft", "usr/bin/Xorg", "usr/bin/grep"]
pytestmark = pytest.mark.release
needs_network = pytest.mark.needs("network namespaces", "firewall")


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The .deb of this checkout."""
    folder = tmp_path_factory.mktemp("package")
    sources = folder / "gpr20"
    for name in ("debian", "deploy"):
        shutil.copytree(ROOT / name, sources / name)
    (sources / "docs").mkdir()
    shutil.copy(ROOT / "docs/install.md", sources / "docs")
    (sources / "debian/changelog").write_text(CHANGELOG)
    (sources / "debian/install").write_text(INSTALL)
    options = ["--build=binary", "--no-sign", "--no-check-builddeps"]
    printed_by("dpkg-buildpackage", *options, folder=sources)
    (found,) = folder.glob(f"gpr20_{VERSION}_*.deb")
    return found


@pytest.fixture(scope="module")
def machine(package, tmp_path_factory):
    """A folder with the files of the package, whose scripts have not run."""
    folder = tmp_path_factory.mktemp("machine")
    # As on an installed system.
    for name in ("bin", "lib", "sbin"):
        (folder / "usr" / name).mkdir(parents=True, exist_ok=True)
        (folder / name).symlink_to(f"usr/{name}")
    # Not dpkg-deb --extract, which would replace the links by folders.
    files = subprocess.Popen(["dpkg-deb", "--fsys-tarfile", str(package)], stdout=subprocess.PIPE)
    unpack = ["tar", "--extract", "--keep-directory-symlink", "--directory", str(folder)]
    subprocess.run(unpack, stdin=files.stdout, check=True)
    assert files.wait() == 0
    return folder


def program(name):
    """Return the path of a program; skip the test without it."""
    found = shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def test_the_package_needs_what_a_developer_installs_to_run_the_robot(package):
    setup = (ROOT / "scripts/setup.sh").read_text("utf-8")
    (listed,) = re.findall(r"^ROS_PACKAGES=\((.*?)^\)", setup, re.M | re.S)
    needed = {one.split(":")[0] for one in listed.split()}
    # They build and test it.
    needed -= {"catkin", "ros-base-dev", "python3-rostest"}
    field = printed_by("dpkg-deb", "--field", package, "Depends")
    assert needed - set(re.split(r"[, ]+", field)) == set()
    assert {"xinit", "openbox"} & set(re.split(r"[, ]+", field)) == set()


def test_every_service_starts_at_boot_and_none_at_installation(package):
    script = printed_by("dpkg-deb", "--info", package, "postinst")
    assert "deb-systemd-invoke" not in script
    for unit in UNITS:
        assert f"deb-systemd-helper enable '{unit}.service'" in script


def test_systemd_accepts_every_unit(machine):
    analyze = program("systemd-analyze")
    for path in PROGRAMS:
        (machine / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(shutil.which("true"), machine / path)
    (machine / "opt/gpr20/current").symlink_to("unpacked")
    for target in Path("/usr/lib/systemd/system").glob("*.target"):
        shutil.copy(target, machine / "usr/lib/systemd/system")
    units = [machine / f"usr/lib/systemd/system/{unit}.service" for unit in UNITS]
    verify = (analyze, "verify", "--man=no", f"--root={machine}", *units)
    printed = printed_by(*verify)
    assert [line for line in printed.splitlines() if "gpr20" in line] == [], printed
    text = units[0].read_text("utf-8")
    units[0].write_text(text.replace("KillMode=", "KillMood="))
    assert "KillMood" in printed_by(*verify)


def test_the_user_of_the_services_has_their_folders_and_devices(machine):
    sysusers, tmpfiles = program("systemd-sysusers"), program("systemd-tmpfiles")
    (machine / "etc/group").write_text("root:x:0:\nvideo:x:44:\n")
    printed_by(sysusers, f"--root={machine}", machine / "usr/lib/sysusers.d/gpr20.conf")
    assert "gpr20:" in (machine / "etc/passwd").read_text()
    groups = dict(re.findall(r"^(\w+):.*:(.*)$", (machine / "etc/group").read_text(), re.M))
    members = {group for group, users in groups.items() if users == "gpr20"}
    assert members == {"gpio", "spi", "video"}
    printed_by(tmpfiles, f"--root={machine}", "--create", "gpr20.conf")
    for path in ("var/log/gpr20", "var/lib/gpr20/surveys"):
        assert (machine / path).stat().st_uid != 0


def test_the_service_has_real_time_and_no_root_and_ends_as_by_ctrl_c():
    wanted = {
        "LimitRTPRIO": str(PULSE_PRIORITY),
        "LimitMEMLOCK": "infinity",
        "User": "gpr20",
        "CapabilityBoundingSet": "",
        "NoNewPrivileges": "yes",
        "Restart": "always",
        "KillMode": "mixed",
        "KillSignal": "SIGINT",
        "Requires": "gpr20-firewall.service",
    }
    assert {key: unit_values("gpr20", key) for key in wanted} == {
        key: [value] for key, value in wanted.items()
    }
    # roslaunch kills a node after 17 s.
    assert int(*unit_values("gpr20", "TimeoutStopSec")) > 60
    limits = (ROOT / "deploy/root/etc/security/limits.d/gpr20.conf").read_text("utf-8")
    assert f"@gpr20 - rtprio {PULSE_PRIORITY}\n@gpr20 - memlock unlimited\n" in limits


def test_logrotate_accepts_its_file(tmp_path):
    logrotate = program("logrotate")
    text = (ROOT / "debian/gpr20.logrotate").read_text("utf-8")
    logs = tmp_path / "log/run"
    logs.mkdir(parents=True)
    log = logs / "node.log"
    log.write_text("x\n" * 2**21)
    # Of a user that exists, and in a folder of this test.
    text = re.sub(r"^ *su .*\n", "", text, flags=re.M).replace("/var/log/gpr20", f"{tmp_path}/log")
    (tmp_path / "conf").write_text(text)
    (tmp_path / "conf").chmod(0o644)
    state = tmp_path / "state"
    printed = printed_by(logrotate, "--verbose", "--force", "--state", state, tmp_path / "conf")
    assert "error" not in printed
    assert log.stat().st_size == 0
    assert (logs / "node.log.1.gz").stat().st_size < 2**16


FIREWALL = ROOT / "deploy/firewall"


@pytest.fixture
def environment(tmp_path):
    """Write the settings of a machine; return the variables that name them."""

    def write(**changed):
        values = dict(GPR20_ROLE="robot", GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, GPR20_ADMIN=ADMIN)
        values.update(changed)
        text = (ROOT / "deploy/root/etc/gpr20/robot.conf").read_text("utf-8")
        for name, value in values.items():
            text, count = re.subn(rf"^{name}=.*$", f"{name}={value}", text, flags=re.M)
            assert count == 1
        file = tmp_path / "robot.conf"
        file.write_text(text)
        return {"GPR20_ENVIRONMENT": str(file)}

    return write


def rules_after(*commands, **variables):
    """Return the ruleset of a new network namespace after commands of a shell."""
    script = "\n".join([*commands, "nft list ruleset"])
    return printed_by("unshare", "--net", "bash", "-ec", script, **variables)


@needs_network
def test_the_firewall_has_the_rules_of_the_page(environment, tmp_path):
    program("nft")
    settings = environment()
    own = rules_after(*firewall_commands(), remote_shell_rule(ADMIN))
    load = f"{FIREWALL} load"
    assert rules_after(load, **settings) == own
    # As lines of a file too.
    lines = [line.replace("nft ", "", 1).replace("'", "") for line in firewall_commands()]
    lines.append(remote_shell_rule(ADMIN).replace("nft ", "", 1))
    (tmp_path / "nftables.conf").write_text("\n".join(["flush ruleset", *lines]) + "\n")
    assert rules_after("nft add table inet other", f"nft -f {tmp_path}/nftables.conf") == own
    # Loaded again, they replace themselves; unloaded, nothing is left.
    assert rules_after(load, load, **settings) == own
    assert rules_after(load, f"{FIREWALL} unload", **settings) == ""
    others = rules_after("nft add table inet other")
    assert others in rules_after("nft add table inet other", load, **settings)
    # What nftables does leaves them: its start, reload and stop empty the ruleset first.
    unit = (ROOT / "deploy/root/lib/systemd/system/nftables.service.d/gpr20.conf").read_text()
    for key in ("ExecStartPost", "ExecReload", "ExecStopPost"):
        assert f"{key}=/opt/gpr20/current/deploy/firewall load\n" in unit
    assert rules_after(load, "nft flush ruleset", load, **settings) == own
    # There are none without a link or a role, or switched off.
    for changed in ({"GPR20_FIREWALL": "off"}, ONE_MACHINE, {"GPR20_ROLE": ""}):
        assert rules_after(load, **environment(**changed)) == ""


NETWORKS = f"{ADMIN} 10.9.8.7"
ONE_MACHINE = {"GPR20_ROLE": "both", "GPR20_ROBOT": "", "GPR20_SERVER": "", "GPR20_ADMIN": ""}


def port_rules(rules, port):
    return [line.strip() for line in rules.splitlines() if f"tcp dport {port} " in line]


@needs_network
@pytest.mark.parametrize("text, port", [("", 8443), ("#port: 1\nport: 9443  # own\n", 9443)])
def test_the_web_page_is_reached_from_its_networks_alone(environment, tmp_path, text, port):
    program("nft")
    (tmp_path / "web.yaml").write_text(text)
    settings = environment(GPR20_WEB=NETWORKS, GPR20_CONFIG=tmp_path)
    accepted = [f"ip saddr {one} tcp dport {port} accept" for one in NETWORKS.split()]
    rules = rules_after(f"{FIREWALL} load", **settings)
    assert port_rules(rules, port) == accepted and "policy drop" in rules
    # Where nothing else is protected, it is.
    settings = environment(GPR20_WEB=NETWORKS, GPR20_CONFIG=tmp_path, **ONE_MACHINE)
    rules = rules_after(f"{FIREWALL} load", **settings)
    assert port_rules(rules, port) == [*accepted, f"tcp dport {port} drop"]
    assert "policy accept" in rules and "dport 22" not in rules
    settings = environment(GPR20_WEB="none", GPR20_CONFIG=tmp_path, **ONE_MACHINE)
    rules = rules_after(f"{FIREWALL} load", **settings)
    assert port_rules(rules, port) == [f"tcp dport {port} drop"]


WRONG = [
    ({"GPR20_ADMIN": ""}, "GPR20_ADMIN is empty"),
    ({"GPR20_ROBOT": "10.20.0.256"}, "GPR20_ROBOT is '10.20.0.256'"),
    ({"GPR20_SERVER": ""}, "robot and server with both addresses"),
    ({"GPR20_ROLE": "both"}, "GPR20_ROLE is 'both'"),
    ({"GPR20_SERVER": ROBOT}, "must differ"),
    ({"GPR20_ADMIN": "0.0.0.0/0"}, "GPR20_ADMIN is '0.0.0.0/0'"),
    ({"GPR20_ADMIN": "1.2.3.4 accept; drop"}, "GPR20_ADMIN is 'accept;'"),
    ({"GPR20_WEB": "0.0.0.0/0"}, "GPR20_WEB is '0.0.0.0/0'"),
    ({"GPR20_FIREWALL": "OFF"}, "GPR20_FIREWALL is 'OFF'"),
    ({"GPR20_SERVER": "10.20.0.2 # pc"}, "GPR20_SERVER has a comment behind it"),
]


@each_case("changed, reason", WRONG)
def test_wrong_addresses_are_refused_by_name_and_value(environment, changed, reason):
    settings = environment(**changed)
    assert reason in printed_by(FIREWALL, "load", status=1, **settings)
