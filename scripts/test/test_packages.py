"""The Debian packages: their files, and that the programs that read these accept them."""

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

from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY

VERSION = "1.2.3"
CHANGELOG = f"""gpr20 ({VERSION}) stable; urgency=medium

  * A change.

 -- Someone <someone@robot.example>  Fri, 27 Nov 2026 12:00:00 +0000
"""
# What debian/install makes, without building.
INSTALL = """#!/bin/sh
mkdir -p "$GPR20_PACKAGE/deploy"
cp deploy/gpr20-run "$GPR20_PACKAGE/deploy"
dpkg-parsechangelog -S Version >"$GPR20_PACKAGE/release"
"""
ADMIN = "192.168.1.0/24"
UNITS = {
    "gpr20-robot": ["gpr20-firewall", "gpr20-robot", "gpr20-window"],
    "gpr20-server": ["gpr20-firewall", "gpr20-server"],
}
# Programs of other packages that the units start.
PROGRAMS = ["usr/bin/xinit", "usr/sbin/nft", "usr/bin/Xorg"]
pytestmark = pytest.mark.release
needs_network = pytest.mark.needs("network namespaces", "firewall")


class Packages:
    """What was built, as .deb files in a folder."""

    def __init__(self, folder):
        self.folder = folder

    def file(self, name):
        (found,) = self.folder.glob(f"{name}_{VERSION}_*.deb")
        return found

    def extract(self, target, *names):
        """Write the files of packages below a folder, without running their scripts."""
        # As on an installed system.
        for name in ("bin", "lib", "sbin"):
            (target / "usr" / name).mkdir(parents=True, exist_ok=True)
            (target / name).symlink_to(f"usr/{name}")
        for name in names:
            # Not dpkg-deb --extract, which would replace the links by folders.
            files = subprocess.Popen(
                ["dpkg-deb", "--fsys-tarfile", str(self.file(name))], stdout=subprocess.PIPE
            )
            unpack = ["tar", "--extract", "--keep-directory-symlink", "--directory", str(target)]
            subprocess.run(unpack, stdin=files.stdout, check=True)
            assert files.wait() == 0

    def field(self, name, field):
        return printed_by("dpkg-deb", "--field", self.file(name), field).strip()

    def control(self, name, part):
        """Return a control file of a package, such as conffiles."""
        return printed_by("dpkg-deb", "--info", self.file(name), part)


def build(folder):
    """Build the packages of this checkout in a folder."""
    sources = folder / "gpr20"
    for name in ("debian", "deploy"):
        shutil.copytree(ROOT / name, sources / name)
    (sources / "docs").mkdir()
    shutil.copy(ROOT / "docs/install.md", sources / "docs")
    (sources / "debian/changelog").write_text(CHANGELOG)
    (sources / "debian/install").write_text(INSTALL)
    options = ["--build=binary", "--no-sign", "--no-check-builddeps"]
    printed_by("dpkg-buildpackage", *options, folder=sources)
    return Packages(folder)


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return build(tmp_path_factory.mktemp("packages"))


@pytest.fixture(scope="module", params=UNITS)
def machine(request, packages, tmp_path_factory):
    """A folder with the files of one machine: its package, and the folder."""
    folder = tmp_path_factory.mktemp(request.param)
    packages.extract(folder, "gpr20-software", "gpr20-common", request.param)
    return request.param, folder


def program(name):
    """Return the path of a program; skip the test without it."""
    found = shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def test_the_packages_need_what_a_developer_installs_to_run_the_robot(packages):
    setup = (ROOT / "scripts/setup.sh").read_text("utf-8")
    (listed,) = re.findall(r"^ROS_PACKAGES=\((.*?)^\)", setup, re.M | re.S)
    needed = {one.split(":")[0] for one in listed.split()}
    # They build and test it.
    needed -= {"catkin", "ros-base-dev", "python3-rostest"}
    depends = re.split(r"[, ]+", packages.field("gpr20-common", "Depends"))
    assert needed - set(depends) == set()


@pytest.mark.parametrize("name", UNITS)
def test_every_service_starts_at_boot_and_none_at_installation(packages, name):
    for owner in (name, "gpr20-common"):
        script = packages.control(owner, "postinst")
        assert "deb-systemd-invoke" not in script
    for unit in UNITS[name]:
        owner = "gpr20-common" if unit == "gpr20-firewall" else name
        assert f"deb-systemd-helper enable '{unit}.service'" in packages.control(owner, "postinst")


def test_systemd_accepts_every_unit_with_its_shared_part(machine):
    analyze = program("systemd-analyze")
    name, folder = machine
    for path in PROGRAMS:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(shutil.which("true"), folder / path)
    (folder / "opt/gpr20/current").symlink_to("unpacked")
    for target in Path("/usr/lib/systemd/system").glob("*.target"):
        shutil.copy(target, folder / "usr/lib/systemd/system")
    units = [folder / f"usr/lib/systemd/system/{unit}.service" for unit in UNITS[name]]
    printed = printed_by(analyze, "verify", "--man=no", f"--root={folder}", *units)
    own = [line for line in printed.splitlines() if "gpr20" in line]
    assert own == [], printed
    shared = folder / f"usr/lib/systemd/system/{name}.service.d/service.conf"
    text = shared.read_text("utf-8")
    shared.write_text(text.replace("KillMode=", "KillMood="))
    assert "KillMood" in printed_by(analyze, "verify", "--man=no", f"--root={folder}", *units)


def test_the_user_of_the_services_has_their_folders_and_devices(machine):
    sysusers, tmpfiles = program("systemd-sysusers"), program("systemd-tmpfiles")
    name, folder = machine
    (folder / "etc/group").write_text("root:x:0:\nvideo:x:44:\n")
    own = sorted((folder / "usr/lib/sysusers.d").glob("gpr20-*.conf"))
    printed_by(sysusers, f"--root={folder}", *own)
    assert "gpr20:" in (folder / "etc/passwd").read_text()
    groups = dict(re.findall(r"^(\w+):.*:(.*)$", (folder / "etc/group").read_text(), re.M))
    members = {group for group, users in groups.items() if users == "gpr20"}
    assert members == ({"gpio", "spi", "video"} if name == "gpr20-robot" else set())
    printed_by(tmpfiles, f"--root={folder}", "--create", "gpr20-common.conf")
    for path in ("var/log/gpr20", "var/lib/gpr20/surveys"):
        assert (folder / path).stat().st_uid != 0


def test_the_axes_get_the_real_time_priority_that_they_ask_for():
    assert unit_values("gpr20-robot", "LimitRTPRIO") == [str(PULSE_PRIORITY)]
    assert unit_values("gpr20-robot", "LimitMEMLOCK") == ["infinity"]
    limits = (ROOT / "deploy/common/etc/security/limits.d/gpr20.conf").read_text("utf-8")
    assert f"@gpr20 - rtprio {PULSE_PRIORITY}\n@gpr20 - memlock unlimited\n" in limits


@pytest.mark.parametrize("unit", UNITS)
def test_services_run_without_root_and_end_as_by_ctrl_c(unit):
    assert unit_values(unit, "User") == ["gpr20"]
    assert unit_values(unit, "CapabilityBoundingSet") == [""]
    assert unit_values(unit, "NoNewPrivileges") == ["yes"]
    assert unit_values(unit, "Restart") == ["always"]
    assert unit_values(unit, "KillMode") == ["mixed"]
    assert unit_values(unit, "KillSignal") == ["SIGINT"]
    assert unit_values(unit, "Requires") == ["gpr20-firewall.service"]
    # roslaunch kills a node after 17 s.
    assert int(*unit_values(unit, "TimeoutStopSec")) > 60


def test_logrotate_accepts_its_file(tmp_path):
    logrotate = program("logrotate")
    text = (ROOT / "debian/gpr20-common.logrotate").read_text("utf-8")
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


FIREWALL = ROOT / "deploy/common/usr/lib/gpr20/firewall"


@pytest.fixture
def environment(tmp_path):
    """Write the settings of a machine; return the variables that name them."""

    def write(**changed):
        values = dict(GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, GPR20_ADMIN=ADMIN)
        values.update(changed)
        text = (ROOT / "deploy/common/etc/gpr20/environment").read_text("utf-8")
        for name, value in values.items():
            text, count = re.subn(rf"^{name}=.*$", f"{name}={value}", text, flags=re.M)
            assert count == 1
        file = tmp_path / "environment"
        file.write_text(text)
        return {"GPR20_ENVIRONMENT": str(file), "GPR20_DEPLOY": str(ROOT / "deploy")}

    return write


def rules_after(*commands, **variables):
    """Return the ruleset of a new network namespace after commands of a shell."""
    script = "\n".join([*commands, "nft list ruleset"])
    return printed_by("unshare", "--net", "bash", "-ec", script, **variables)


@needs_network
def test_the_firewall_has_the_rules_of_the_page(environment):
    program("nft")
    settings = environment()
    own = rules_after(*firewall_commands(), remote_shell_rule(ADMIN))
    load = f"{FIREWALL} load"
    assert rules_after(load, **settings) == own
    # Loaded again, they replace themselves; unloaded, nothing is left.
    assert rules_after(load, load, **settings) == own
    assert rules_after(load, f"{FIREWALL} unload", **settings) == ""
    others = rules_after("nft add table inet other")
    assert others in rules_after("nft add table inet other", load, **settings)
    # What nftables does leaves them: its start, reload and stop empty the ruleset first.
    unit = (ROOT / "deploy/common/lib/systemd/system/nftables.service.d/gpr20.conf").read_text()
    for key in ("ExecStartPost", "ExecReload", "ExecStopPost"):
        assert f"{key}=/usr/lib/gpr20/firewall load\n" in unit
    assert rules_after(load, "nft flush ruleset", load, **settings) == own
    # There are none without a link, or switched off.
    for changed in ({"GPR20_FIREWALL": "off"}, {"GPR20_ROBOT": "", "GPR20_SERVER": ""}):
        assert rules_after(load, **environment(**changed)) == ""


NETWORKS = f"{ADMIN} 10.9.8.7"
ONE_MACHINE = {"GPR20_ROBOT": "", "GPR20_SERVER": "", "GPR20_ADMIN": ""}


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
    ({"GPR20_SERVER": ""}, "GPR20_SERVER is ''"),
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
