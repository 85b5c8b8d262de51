"""Power cuts in an update: what starts afterwards is the old or the new version, whole.

A bare Debian, which debootstrap makes once, is on a file system whose power can be cut; dpkg, apt,
gpr20-update and the maintainer scripts are the real ones. The figures of
docs/evidence/bare_debian.md: pytest -s -m release scripts/test/test_update_power_cuts.py
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import time
from collections import Counter
from pathlib import Path

import pytest
import update_kit
from failing_disk import PowerCutDisk, PowerCutError, can_be_cut

CUTS = int(os.environ.get("GPR20_UPDATE_CUTS", "30"))
SEED = int(os.environ.get("GPR20_UPDATE_SEED", "31"))
BASE = Path("/var/tmp/gpr20_power_cut_update/base")
SIZE_MIB, FILE_BYTES, LIMIT_S = 1500, 100_000, 300.0
CONTINUE = ("gpr20-update", "--continue")
UPDATE = ("gpr20-update", "/sticks/2.0")
# Nodes, doctor and configuration are played: the doctor finds nothing.
GPR20_RUN = b"""#!/bin/sh
case $1 in
    doctor) echo '{"findings": []}' ;;
    config) mkdir -p /etc/gpr20/robot; echo signing_key: >/etc/gpr20/robot/storage.yaml ;;
esac
"""
BEFORE, UNFINISHED, ENDED = "copying", "unfinished", "at its end"
QUERY = ("dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", "gpr20")
# An update must leave it as it is.
DATA = {
    "etc/gpr20/robot.conf": b"GPR20_LAUNCH_ARGUMENTS=ns:=robot1\n",
    "etc/gpr20/robot/axes.yaml": b"x: 1\n",
    **{f"var/lib/gpr20/surveys/s{n}/survey.json": bytes([n]) * 50_000 for n in range(20)},
}


class Computer:
    """The bare Debian with version 1.0 and the sticks, on a disk."""

    def __init__(self, place: Path) -> None:
        self._image, self._first = place / "disk.img", place / "first.img"
        self.disk = PowerCutDisk(place, SIZE_MIB)
        self.root = self.disk.folder
        self.disk.mount()
        update_kit.run("cp", "-a", f"{BASE}/.", self.root)
        key, more = update_kit.release_key(place), {"usr/bin/gpr20-run": GPR20_RUN}
        for version in ("1.0", "2.0"):
            update_kit.make_stick(self.root / "sticks", version, key, more, FILE_BYTES)
        self.must("useradd", "--system", "--home-dir", "/var/lib/gpr20", "gpr20")
        self.must("sh", "/sticks/1.0/install.sh")
        for name, data in DATA.items():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_bytes(data)
        self._data = update_kit.data_of(self.root)
        self.unmount()
        shutil.copyfile(self._image, self._first)

    def renew(self) -> None:
        """Let the disk, which is not mounted, be as it was at first; mount it."""
        update_kit.run("cp", "--sparse=always", self._first, self._image)
        self.disk.mount()

    def unmount(self) -> None:
        """Unmount the disk everywhere: the mounts of processes that were killed end after them."""
        self.disk.unmount()
        while update_kit.run("losetup", "--associated", self._image):
            time.sleep(0.02)

    def begin(self, *command: str) -> subprocess.Popen:
        """Start a program in the chroot with processes of its own, which all end with it."""
        inside = 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"'
        isolated = ("unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", inside)
        return subprocess.Popen(
            [*isolated, str(self.root), *command],
            env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def must(self, *command: str) -> str:
        """Run a program in the chroot that must succeed; return what it printed."""
        process = self.begin(*command)
        output, _nothing = process.communicate(timeout=LIMIT_S)
        assert process.returncode == 0, output
        return output

    def step(self) -> str:
        """Return what the journal says that is being done."""
        journal = self.root / "var/lib/gpr20-update/journal.json"
        if not journal.exists():
            return BEFORE
        return ENDED if json.loads(journal.read_text("utf-8"))["outcome"] else UNFINISHED

    def run_and_cut(self, command, after_s: float, written: bool, begun: bool = False) -> bool:
        """Run a program and cut the power; return whether the cut came before its end.

        Args:
            command: The program and its arguments.
            after_s: When to cut [s].
            written: Whether the kernel writes everything back at some time before.
            begun: Whether that time begins with the installation.
        """
        process = self.begin(*command)
        while begun and process.poll() is None and self.step() == BEFORE:
            time.sleep(0.002)
        share = random.random() if written else 1.0
        time.sleep(after_s * share)
        if written:
            self.disk.write_back()
            time.sleep(after_s * (1.0 - share))
        running = process.poll() is None
        self.disk.cut()
        if running:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        self.unmount()
        self.disk.mount()
        return running

    def judge(self) -> str:
        """Return the version that the system has whole, or what is wrong with it."""
        state = self.must(*QUERY)
        release = (self.root / "opt/gpr20/current/release").read_text("utf-8").strip()
        if state != f"installed {release}":
            return f"{release} with {state}"
        if update_kit.data_of(self.root) != self._data:
            return "configuration or surveys changed"
        audit = self.must("dpkg", "--audit")
        return update_kit.slot_problems(self.root, FILE_BYTES) or audit or release


@pytest.fixture
def computer(tmp_path):
    try:
        can_be_cut()
    except PowerCutError as error:
        pytest.skip(str(error))
    if not BASE.exists():
        new = BASE.with_name("base.new")
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir(parents=True)
        packages = "--include=python3"
        update_kit.run("debootstrap", "--variant=minbase", packages, "bookworm", new)
        new.rename(BASE)
    return Computer(tmp_path)


@pytest.mark.release
@pytest.mark.needs("packages", "mounts", "debootstrap")
@pytest.mark.timeout(3600)
def test_after_a_power_cut_in_an_update_a_whole_version_starts(computer):
    random.seed(SEED)
    computer.renew()
    begin_s = time.monotonic()
    computer.must(*UPDATE)
    whole_s = time.monotonic() - begin_s
    assert computer.judge() == "2.0"
    computer.unmount()
    started, steps = Counter(), Counter()
    for number in range(1, CUTS + 1):
        computer.renew()
        after_s = random.uniform(0.0, whole_s)
        written = random.random() < 0.5
        cut = computer.run_and_cut(UPDATE, after_s, written, begun=number % 4 > 0)
        at_boot = update_kit.slot_problems(computer.root, FILE_BYTES)
        step = computer.step() if cut else "after its end"
        if step == UNFINISHED and number % 3 == 0:
            computer.run_and_cut(CONTINUE, random.uniform(0.0, whole_s / 2), False)
            at_boot = at_boot or update_kit.slot_problems(computer.root, FILE_BYTES)
        if computer.step() != BEFORE:
            computer.must(*CONTINUE)
        steps[step] += 1
        started[at_boot or computer.judge()] += 1
        computer.unmount()
    print(f"\ncut: {dict(steps)}; started: {dict(started)}")
    assert set(started) <= {"1.0", "2.0"}, started
