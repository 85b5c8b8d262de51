"""The firewall is judged by what a foreign computer reaches, whatever our own files say.

In a network namespace that stands for the robot's computer, with the firewall of the packages.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

FIREWALL = Path(__file__).resolve().parents[5] / "deploy/common/usr/lib/gpr20/firewall"
ROBOT, SERVER = "10.20.0.1", "10.20.0.2"
LOOK = """
import os, sys
from dataclasses import replace
from pathlib import Path
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import ThisMachine
request = ThisMachine("pi", {"ROS_MASTER_URI": f"http://{sys.argv[2]}:11311"},
                      Path(sys.argv[1])).request({})
request = replace(request, files="")
(one,) = [one for one in findings(None, probe_machine(request)) if one.check == "firewall"]
print(one.level.name, one.text.fault_code or "-", one.text, one.remedy, sep="\\n")
"""
pytestmark = pytest.mark.needs("network namespaces", "firewall")


class Machine:
    def __init__(self, root):
        self.root, self.name = root, f"gpr20-doctor-{os.getpid()}"
        self.settings = root / "etc/gpr20/environment"

    def set(self, firewall):
        self.settings.write_text(
            f"GPR20_ROBOT={ROBOT}\nGPR20_SERVER={SERVER}\nGPR20_ADMIN=none\n"
            f"GPR20_FIREWALL={firewall}\n"
        )

    def run(self, *command, **more):
        environment = {**os.environ, "GPR20_ENVIRONMENT": str(self.settings)}
        return subprocess.run(
            ["ip", "netns", "exec", self.name, *command],
            check=True,
            text=True,
            stdout=subprocess.PIPE,
            env={**environment, **more},
        ).stdout

    def look(self, *prefix):
        """Return level, code, sentence and advice of the doctor."""
        python = [sys.executable, "-c", LOOK, str(self.root), ROBOT]
        return self.run(*prefix, *python).splitlines()

    def follow(self, advice):
        """Run the command of an advice, as root."""
        (command,) = re.findall(r"Run: sudo (.+)$", advice)
        self.run("sh", "-ec", command, GPR20_DEPLOY=str(FIREWALL.parents[4]))


@pytest.fixture
def machine(tmp_path):
    one = Machine(tmp_path)
    for path in (one.settings, tmp_path / "usr/lib/gpr20/firewall"):
        path.parent.mkdir(parents=True)
    (tmp_path / "usr/lib/gpr20/firewall").symlink_to(FIREWALL)
    (tmp_path / "proc").symlink_to("/proc")
    one.set("on")
    # With workers side by side there is one folder more.
    for folder in (tmp_path, *list(tmp_path.parents)[:3]):
        folder.chmod(0o755)
    subprocess.run(["ip", "netns", "add", one.name], check=True)
    try:
        one.run(
            "sh",
            "-ec",
            f"""
            ip link set lo up; ip link add cable type veth peer name end
            ip addr add {ROBOT}/24 dev cable; ip link set cable up; ip link set end up""",
        )
        yield one
    finally:
        subprocess.run(["ip", "netns", "del", one.name], check=True)


def test_a_table_that_was_flushed_is_found_and_the_advice_ends_it(machine):
    master = [sys.executable, "-m", "http.server", "11311", "--bind", "0.0.0.0"]
    with subprocess.Popen(
        ["ip", "netns", "exec", machine.name, *master], stderr=subprocess.DEVNULL
    ) as listener:
        try:
            level, code, text, advice = machine.look()
            assert (level, code) == ("FAULT", "network.firewall")
            machine.follow(advice)
            assert machine.look()[0] == "OK"
            # What `systemctl restart nftables` does. The table of the settings is as it was.
            machine.run("nft", "flush", "ruleset")
            level, code, text, advice = machine.look()
            assert (level, code) == ("FAULT", "network.firewall")
            assert "11311" in text
            machine.follow(advice)
            assert machine.look()[0] == "OK"
        finally:
            listener.kill()
    assert "gpr20-" not in machine.run("ip", "-brief", "link")


@pytest.mark.release
def test_a_firewall_that_is_switched_off_is_found_and_the_advice_ends_it(machine):
    machine.set("off")
    level, code, _text, advice = machine.look()
    assert (level, code) == ("FAULT", "network.firewall")
    assert f"GPR20_FIREWALL=on into {machine.settings}" in advice
    machine.set("on")
    machine.follow(advice)
    assert machine.look()[0] == "OK"


@pytest.mark.release
def test_who_may_not_try_it_gets_no_verdict_and_the_command(machine):
    level, code, text, advice = machine.look("setpriv", "--reuid=65534", "--clear-groups")
    assert (level, code) == ("UNKNOWN", "-")
    assert "only root may try it" in text and "sudo gpr20-run doctor" in advice
