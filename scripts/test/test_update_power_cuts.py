"""Power cuts in an update: what starts afterwards is the old or the new version, whole.

The computer of `update_world` is on a file system whose power can be cut. The figures of
docs/evidence/bare_debian.md: pytest -s -m release scripts/test/test_update_power_cuts.py
"""

from __future__ import annotations

import json
import os
import random
import signal
import time
from collections import Counter
from dataclasses import dataclass

import pytest
from failing_disk import PowerCutDisk, PowerCutError, can_be_cut
from update_world import World
from user_shell import printed_by

CUTS = int(os.environ.get("GPR20_UPDATE_CUTS", "30"))
SEED = int(os.environ.get("GPR20_UPDATE_SEED", "31"))
# More than an update wants to be free.
SIZE_MIB = 600
BEFORE, UNFINISHED, ENDED = "copying", "unfinished", "at its end"


@dataclass(frozen=True)
class Computer(World):
    """The computer with version 1.0, on a disk."""

    disk: PowerCutDisk

    def step(self):
        """Return what the journal says that is being done."""
        journal = self.root / "var/lib/gpr20-update/journal.json"
        if not journal.exists():
            return BEFORE
        return ENDED if json.loads(journal.read_text("utf-8"))["outcome"] else UNFINISHED

    def run_and_cut(self, argument, after_s, written, begun=False):
        """Run gpr20-update and cut the power; return whether the cut came before its end.

        The kernel may write everything back before; the time may begin with the installation.
        """
        process = self.begin(argument)
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
        self.disk.unmount()
        self.disk.mount()
        return running


@pytest.fixture
def computer(first, tmp_path):
    try:
        can_be_cut()
    except PowerCutError as error:
        pytest.skip(str(error))
    disk = PowerCutDisk(tmp_path, SIZE_MIB)
    disk.mount()
    made = first.copy(disk.folder / "root")
    program = made.root / "programs/dpkg"
    # Here what dpkg syncs counts.
    program.write_text(program.read_text().replace("--force-unsafe-io", ""))
    disk.unmount()
    printed_by("cp", "--sparse=always", tmp_path / "disk.img", tmp_path / "first.img")
    return Computer(made.root, made.sticks, made.gpg, disk)


def renew(computer):
    """Let the disk, which is not mounted, be as it was at first; mount it."""
    image = computer.disk.folder.with_name("disk.img")
    printed_by("cp", "--sparse=always", image.with_name("first.img"), image)
    computer.disk.mount()


@pytest.mark.release
@pytest.mark.needs("packages", "mounts")
@pytest.mark.timeout(3600)
def test_after_a_power_cut_in_an_update_a_whole_version_starts(computer):
    random.seed(SEED)
    renew(computer)
    update, data, begin_s = computer.stick("2.0"), computer.data(), time.monotonic()
    computer.update(update)
    whole_s = time.monotonic() - begin_s
    assert computer.version() == "2.0"
    computer.disk.unmount()
    started, steps = Counter(), Counter()
    for number in range(1, CUTS + 1):
        renew(computer)
        after_s = random.uniform(0.0, whole_s)
        written = random.random() < 0.5
        cut = computer.run_and_cut(update, after_s, written, begun=number % 4 > 0)
        # Before what runs at boot too, the release in use is whole.
        computer.release()
        step = computer.step() if cut else "after its end"
        if step == UNFINISHED and number % 3 == 0:
            computer.run_and_cut("--continue", random.uniform(0.0, whole_s / 2), False)
            computer.release()
        if computer.step() != BEFORE:
            computer.update("--continue")
        assert (computer.data(), computer.dpkg("--audit")) == (data, ""), number
        steps[step] += 1
        started[computer.version()] += 1
        computer.disk.unmount()
    print(f"\ncut: {dict(steps)}; started: {dict(started)}")
    assert set(started) <= {"1.0", "2.0"}, started
