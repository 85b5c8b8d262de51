"""Power cuts in an update: what starts afterwards is the old or the new version, whole.

    scripts/bench.sh power_cut_update --cuts 30

A bare Debian with the programs of an update (real dpkg, apt, ssh-keygen and gpr20-update, real
maintainer scripts, small packages) is on a file system whose power can be cut (power_cut_disk).
gpr20-update installs version 2.0 over 1.0 from a bundle. At a random instant, three times of four
after the installation has begun, the power is cut; in half of the cases the kernel has written
everything back some time before. Then the disk is mounted
again and, as gpr20-update.service does at boot, the update is ended; every third time that is cut
too. Needs root, loop devices, debootstrap and, for the bare Debian, once, the network.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Dict, List

import update_kit
from power_cut_disk import PowerCutDisk, hide_mounts

SIZE_MIB = 1500
# Of each file of the release.
FILE_BYTES = 100_000
LIMIT_S = 300.0
CONTINUE = ("/usr/bin/python3", "-I", "/var/lib/gpr20-update/gpr20-update", "--continue")
UPDATE = ("gpr20-update", "/sticks/gpr20-2.0")
# The doctor and the nodes are played: the doctor finds nothing.
GPR20_RUN = b'#!/bin/sh\n[ "$1" != doctor ] || echo \'{"findings": []}\'\n'
BEFORE, UNFINISHED = "copying", ("installing", "judging", "returning")
QUERY = ("dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}\\n")
# It was changed by a person, so an update must leave it as it is.
DATA = {
    "etc/gpr20/environment": b"GPR20_LAUNCH_ARGUMENTS=ns:=robot1\n",
    "etc/gpr20/robot/axes.yaml": b"x: 1\n",
    "var/lib/gpr20/.config/gpr20/profiles/garden.yaml": b"x_points: 3\n",
}


def in_chroot(root: Path, *command: str) -> subprocess.Popen[str]:
    """Start a program in a chroot with processes of its own, which all end with it."""
    inside = 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"'
    isolated = ("unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", inside)
    return subprocess.Popen(
        [*isolated, str(root), *command],
        env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def must(root: Path, *command: str) -> str:
    """Run a program in a chroot that must succeed; return what it printed."""
    process = in_chroot(root, *command)
    output, _nothing = process.communicate(timeout=LIMIT_S)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed:\n{output}")
    return output


def make_base(folder: Path) -> Path:
    """Make the bare Debian with what an update needs, once; return its folder."""
    base = folder / "base"
    if not base.exists():
        new = folder / "base.new"
        shutil.rmtree(new, ignore_errors=True)
        packages = "--include=openssh-client,python3"
        update_kit.run("debootstrap", "--variant=minbase", packages, "bookworm", new)
        shutil.rmtree(new / "var/cache/apt/archives")
        new.rename(base)
    return base


def install(root: Path, work: Path) -> None:
    """Install version 1.0 in the chroot, with data; put the bundles there."""
    key, program = update_kit.make_key(work), work / "gpr20-update"
    update_kit.make_program(program)
    for version in ("1.0", "2.0"):
        more = {"usr/bin/gpr20-run": GPR20_RUN}
        bundle = update_kit.make_bundle(root / "sticks", version, key, program, more, FILE_BYTES)
        (bundle / "install.sh").write_bytes(
            (update_kit.ROOT / "deploy/bundle_install.sh").read_bytes()
        )
        update_kit.sign(bundle, key)
    must(root, "useradd", "--system", "--home-dir", "/var/lib/gpr20", "gpr20")
    print(must(root, "sh", "/sticks/gpr20-1.0/install.sh", "gpr20-robot"), flush=True)
    surveys = {f"var/lib/gpr20/surveys/s{n}/survey.json": os.urandom(50_000) for n in range(20)}
    for name, data in {**DATA, **surveys}.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(data)


def data_of(root: Path) -> Dict[str, str]:
    """Return the checksum of each file of the configuration and of the surveys."""
    return {
        str(one.relative_to(root)): hashlib.sha256(one.read_bytes()).hexdigest()
        for folder in ("etc/gpr20", "var/lib/gpr20")
        for one in sorted((root / folder).rglob("*"))
        if one.is_file() and one.suffix != ".dpkg-dist"
    }


def run_and_cut(
    disk: PowerCutDisk, command: List[str], after_s: float, written: bool, begun: bool = False
) -> bool:
    """Run a program and cut the power; return whether the cut came before its end.

    Args:
        disk: The disk of the chroot.
        command: The program and its arguments.
        after_s: When to cut [s].
        written: Whether the kernel writes everything back at some time before.
        begun: Whether that time begins with the installation.
    """
    process = in_chroot(disk.folder, *command)
    while begun and process.poll() is None and step_of(disk.folder) == BEFORE:
        time.sleep(0.002)
    share = random.random() if written else 1.0
    time.sleep(after_s * share)
    if written:
        disk.write_back()
        time.sleep(after_s * (1.0 - share))
    running = process.poll() is None
    disk.cut()
    if running:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    unmount(disk)
    disk.mount()
    return running


def unmount(disk: PowerCutDisk) -> None:
    """Unmount the disk everywhere: the mounts of processes that were killed end after them."""
    disk.unmount()
    image = disk.folder.with_name("disk.img")
    while update_kit.run("losetup", "--associated", image):
        time.sleep(0.02)


def renew(disk: PowerCutDisk, work: Path) -> None:
    """Let the disk, which is not mounted, be as it was at first; mount it."""
    update_kit.run("cp", "--sparse=always", work / "first.img", work / "disk.img")
    disk.mount()


def step_of(root: Path) -> str:
    """Return what the journal says that is being done."""
    journal = root / "var/lib/gpr20-update/journal.json"
    return json.loads(journal.read_text("utf-8"))["step"] if journal.exists() else BEFORE


def judge(root: Path, data: Dict[str, str]) -> str:
    """Return the version that the system has whole, or what is wrong with it."""
    lines = must(root, *QUERY, *update_kit.NAMES).split("\n")[:-1]
    audit = must(root, "dpkg", "--audit")
    release = (root / "opt/gpr20/current/release").read_text("utf-8").strip()
    problem = update_kit.slot_problems(root, FILE_BYTES) or audit
    if set(lines) != {f"installed {release}"}:
        problem = f"{release} with {lines}"
    if data_of(root) != data:
        problem = f"configuration or surveys: {set(data_of(root).items()) ^ set(data.items())}"
    return problem or release


def main() -> int:
    """Cut the power again and again; return 0 if each time a whole version started."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cuts", type=int, default=30)
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--folder", type=Path, default=Path("/var/tmp/gpr20_power_cut_update"))
    given = parser.parse_args()
    random.seed(given.seed)
    given.folder.mkdir(exist_ok=True)
    base, work = make_base(given.folder), given.folder / "work"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    hide_mounts()
    disk = PowerCutDisk(work, SIZE_MIB)
    disk.mount()
    update_kit.run("cp", "-a", f"{base}/.", disk.folder)
    install(disk.folder, work)
    data = data_of(disk.folder)
    unmount(disk)
    shutil.copyfile(work / "disk.img", work / "first.img")
    renew(disk, work)
    begin_s = time.monotonic()
    print(must(disk.folder, *UPDATE), flush=True)
    whole_s = time.monotonic() - begin_s
    print(f"an update without a cut takes {whole_s:.1f} s; {judge(disk.folder, data)} started")
    unmount(disk)
    started: Counter[str] = Counter()
    steps: Counter[str] = Counter()
    for number in range(1, given.cuts + 1):
        renew(disk, work)
        begun, after_s = number % 4 > 0, random.uniform(0.0, whole_s)
        cut = run_and_cut(disk, list(UPDATE), after_s, random.random() < 0.5, begun)
        at_boot = update_kit.slot_problems(disk.folder, FILE_BYTES)
        step = step_of(disk.folder) if cut else "after its end"
        steps[step] += 1
        again = step in UNFINISHED and number % 3 == 0
        if again:
            run_and_cut(disk, list(CONTINUE), random.uniform(0.0, whole_s / 2), False)
            at_boot = at_boot or update_kit.slot_problems(disk.folder, FILE_BYTES)
        if step_of(disk.folder) != BEFORE:
            must(disk.folder, *CONTINUE)
        ended = at_boot or judge(disk.folder, data)
        unmount(disk)
        started[ended] += 1
        twice = ", and again in the return" if again else ""
        print(f"{number:3}: cut after {after_s:4.1f} s, {step}{twice}: {ended}", flush=True)
    shutil.rmtree(work)
    for title, counted in (("cut", steps), ("started", started)):
        print(f"{title}:", ", ".join(f"{one} {count} times" for one, count in counted.items()))
    return 0 if set(started) <= {"1.0", "2.0"} else 1


if __name__ == "__main__":
    sys.exit(main())
