"""Maintainer scripts of gpr20-software: `current` is a whole release at every instant."""

from __future__ import annotations

import subprocess

import pytest

pytestmark = [pytest.mark.release, pytest.mark.needs("packages")]

# Whatever the scripts of the package call.
CALLED = ("cp", "mv", "ln", "sync", "rm", "mkdir", "readlink")


def deb(world, version):
    return world.bundle(version) / f"gpr20-software_{version}_all.deb"


def install(world, version, **how):
    """Install the software alone, whatever others need."""
    return world.dpkg("--force-depends", "--install", deb(world, version), **how)


def slots(world):
    return {
        one.name: (one / "release").read_text("utf-8").strip()
        for one in (world.root / "opt/gpr20/slots").iterdir()
    }


def test_upgrade_and_downgrade_keep_the_version_before_in_the_other_slot(world):
    assert slots(world) == {"a": "1.0"}
    install(world, "2.0")
    assert (world.release(), slots(world)) == ("2.0", {"a": "1.0", "b": "2.0"})
    install(world, "1.0")
    assert (world.release(), slots(world)) == ("1.0", {"a": "1.0", "b": "2.0"})


def test_the_same_version_again_repairs_the_release_in_use(world):
    (world.root / "opt/gpr20/current/lib/folder0/file0").unlink()
    install(world, "1.0")
    assert world.release() == "1.0"


def test_a_failed_unpacking_leaves_the_release_in_use(world, tmp_path):
    whole, torn = deb(world, "2.0").read_bytes(), tmp_path / "torn.deb"
    torn.write_bytes(whole[: len(whole) // 2])
    world.dpkg("--force-depends", "--install", torn, status=1)
    assert world.release() == "1.0"
    assert world.versions()["gpr20-software"] == "installed 1.0"
    install(world, "2.0")
    assert world.release() == "2.0"


def test_a_slot_from_which_something_runs_is_not_replaced(world):
    install(world, "2.0")
    used = {"PYTHONPATH": f"{world.root}/opt/gpr20/slots/a/lib"}
    with subprocess.Popen(["/bin/cat"], stdin=subprocess.PIPE, env=used) as service:
        assert f"process {service.pid}" in install(world, "1.0", status=1)
        assert (world.release(), slots(world)) == ("2.0", {"a": "1.0", "b": "2.0"})
        service.stdin.close()
    install(world, "1.0")
    assert world.release() == "1.0"


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
            ["dpkg", "--force-depends", "--install", deb(world, "2.0")],
            env=world.environment,
            capture_output=True,
            check=False,
        )
        assert world.release() in ("1.0", "2.0")
        if int(count.read_text()) < number:
            break
        for name in CALLED:
            (world.root / "programs" / name).unlink()
        world.dpkg("--force-depends", "--configure", "--pending")
        if killed.returncode != 0:
            install(world, "2.0")
        assert world.release() == "2.0"
    assert number > 8
