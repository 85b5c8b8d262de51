"""What gpr20-update reads, a bundle or a backup, is whole and allowed, or it changes nothing."""

from __future__ import annotations

import gzip
import io
import os
import shutil
import tarfile

import pytest
import update_kit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_update.low.system import Paths, UpdateError
from gpr20_update.mid import backup
from gpr20_update.mid.bundle import find_bundle, open_bundle

pytestmark = pytest.mark.needs("packages")

# Every example damages what it has copied.
SAME_FOLDER = settings(
    max_examples=draws(10), suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture
def stick(first, tmp_path):
    """A copy of the bundle of version 2.0."""
    shutil.copytree(first.bundle("2.0"), tmp_path / "stick/gpr20-2.0")
    return tmp_path / "stick/gpr20-2.0"


def refused(world, place, *words):
    """Update from there; it is refused with these words, and nothing has changed."""
    before = world.data()
    said = world.update(place, status=2)
    assert all(one in said for one in words), said
    assert (world.version(), world.data()) == ("1.0", before)
    assert [one.name for one in (world.root / "var/lib/gpr20-update/packages").iterdir()] == ["1.0"]


@SAME_FOLDER
@given(data=st.data())
def test_a_bundle_with_any_damage_is_refused_and_one_without_is_copied(first, stick, data):
    whole = {one.name: one.read_bytes() for one in first.bundle("2.0").iterdir()}
    name = data.draw(st.sampled_from(sorted(whole)))
    at = data.draw(st.integers(0, len(whole[name]) - 1))
    damage = data.draw(st.sampled_from(["cut", "flip", "gone", "none"]))
    changed = bytearray(whole[name])
    changed[at] ^= data.draw(st.integers(1, 255)) if damage == "flip" else 0
    if damage == "gone":
        (stick / name).unlink()
    else:
        (stick / name).write_bytes(changed[:at] if damage == "cut" else changed)
    target = first.root / "copied"
    try:
        open_bundle(stick, Paths(first.root).signers).copy(target)
        accepted = True
    except UpdateError as error:
        accepted = False
        assert str(stick) in str(error)
    finally:
        (stick / name).write_bytes(whole[name])
    # Not every bit of the armour of a signature has a meaning.
    assert accepted == (damage == "none") or (accepted and name == "SHA256SUMS.sig")
    assert target.exists() == accepted
    if accepted:
        copied = {one.name: one.read_bytes() for one in target.iterdir()}
        assert {**copied, name: whole[name]} == whole
        shutil.rmtree(target)


def test_a_release_of_somebody_else_or_for_something_else_is_refused(world, stick, tmp_path):
    update_kit.sign(stick, update_kit.make_key(tmp_path))
    refused(world, stick, "not signed by anyone", str(world.root / "etc/gpr20/release_signers"))
    update_kit.sign(stick, world.sticks.parent / "key", namespace="gpr20")
    refused(world, stick, "as a release")


def test_an_older_version_is_refused(world):
    world.update(world.bundle("2.0"))
    said = world.update(world.bundle("1.0"), status=2)
    assert "1.0, which is older than 2.0" in said
    assert world.version() == "2.0"


def test_a_bundle_that_this_computer_cannot_take_is_refused(world, stick):
    control = (stick / "Packages").read_text("utf-8")
    index = control.replace("Installed-Size: 100", "Installed-Size: 9000000000")
    update_kit.sign(stick, world.sticks.parent / "key", index=index)
    refused(world, stick, "MB free")
    # An installed package is not in it.
    next(stick.glob("gpr20-robot_*")).unlink()
    update_kit.sign(stick, world.sticks.parent / "key")
    assert "gpr20-robot" in world.update(stick, status=2)
    assert world.version() == "1.0"


def test_the_bundle_is_found_by_the_folder_of_the_stick(first, stick, tmp_path):
    assert find_bundle(stick.parent) == stick
    for place in (tmp_path / "nothing", tmp_path):
        with pytest.raises(UpdateError, match="no bundle"):
            find_bundle(place)
    with pytest.raises(UpdateError, match=r"gpr20-1\.0, gpr20-2\.0"):
        find_bundle(first.sticks)


def test_a_restore_brings_everything_back_but_keys_and_signers(world, tmp_path):
    file = tmp_path / "robot.tar.gz"
    before = world.data()
    world.update("--backup", file)
    with tarfile.open(file) as tar:
        names = tar.getnames()
    assert "etc/gpr20/robot/axes.yaml" in names
    assert "var/lib/gpr20/.config/gpr20/plan.yaml" in names
    assert not any("signing_key" in one or "release_signers" in one for one in names)
    assert b"PRIVATE KEY" not in gzip.decompress(file.read_bytes())
    (world.root / "etc/gpr20/robot/axes.yaml").write_text("x: 2\n")
    (world.root / "etc/gpr20/robot/more.yaml").write_text("y: 1\n")
    (world.root / "var/lib/gpr20/.config/gpr20/plan.yaml").unlink()
    changed = world.data()
    world.update("--restore", file)
    assert world.data() == before
    assert world.services_run()
    world.update("--restore", file)
    first_of_two = min((world.root / "var/lib/gpr20-update/backups").iterdir())
    world.update("--restore", first_of_two)
    assert world.data() == changed


def test_links_and_pipes_refuse_a_backup_and_an_update_leaves_them_alone(world):
    robot = world.root / "etc/gpr20/robot"
    (robot / "more").symlink_to("/srv/robot")
    os.mkfifo(robot / "pipe")
    said = world.update("--backup", world.root / "b.tar.gz", status=2)
    assert str(robot / "more") in said
    assert str(robot / "pipe") in said
    assert not (world.root / "b.tar.gz").exists()
    world.doctor("2.0", "axes")
    said = world.update(world.bundle("2.0"), status=1)
    assert f"not kept, and not changed, as no files: {robot}/more, {robot}/pipe" in said
    assert os.readlink(robot / "more") == "/srv/robot"
    assert (robot / "pipe").is_fifo()


def test_a_killed_restore_is_finished_at_boot(first, world, tmp_path):
    file = tmp_path / "robot.tar.gz"
    wanted = first.data()
    world.update("--backup", file)
    for event in range(1, 40):
        world = first.copy(tmp_path / str(event))
        for name in ("robot/axes.yaml", "robot/more.yaml", "environment"):
            (world.root / "etc/gpr20" / name).write_text("z: 3\n")
        changed = world.data()
        killed = "Killed" in world.update("--restore", file, kill_at=event, status=None)
        world.update("--continue")
        assert world.data() in (wanted, changed)
        if not killed:
            break
    assert event > 5
    assert world.data() == wanted


@SAME_FOLDER
@given(data=st.data())
def test_a_damaged_backup_is_refused_whole(first, tmp_path, data):
    file = tmp_path / "backup.tar.gz"
    backup.write(backup.take(Paths(first.root))[0], file)
    whole = file.read_bytes()
    wanted = backup.read(file)
    at = data.draw(st.integers(0, len(whole) - 1))
    flipped = bytearray(whole)
    flipped[at] ^= data.draw(st.integers(1, 255))
    file.write_bytes(data.draw(st.sampled_from([whole[:at], bytes(flipped)])))
    try:
        # Not every byte has a meaning, such as the time in the head of gzip.
        assert backup.read(file) == wanted
    except UpdateError as error:
        assert str(file) in str(error)


@pytest.mark.parametrize(
    "name",
    [
        *("/etc/passwd", "etc/passwd", "etc/gpr20/../passwd"),
        *("etc/gpr20/release_signers", "etc/gpr20/./release_signers", "etc/gpr20"),
    ],
)
def test_a_backup_with_a_file_elsewhere_is_refused(first, tmp_path, name):
    file = tmp_path / "backup.tar.gz"
    with tarfile.open(file, "w:gz") as tar:
        member = tarfile.TarInfo(name)
        member.size = 1
        tar.addfile(member, io.BytesIO(b"x"))
    with pytest.raises(UpdateError, match="allowed are files below"):
        backup.read(file)


def test_a_configuration_elsewhere_is_named_instead_of_left_out(world):
    (world.root / "etc/gpr20/environment").write_text("GPR20_CONFIG=/srv/robot\n")
    said = world.update("--backup", world.root / "b.tar.gz", status=2)
    assert "/srv/robot" in said
