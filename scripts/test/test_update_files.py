"""A bundle that gpr20-update reads is whole and allowed, or nothing changes."""

from __future__ import annotations

import shutil

import pytest
import update_kit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_update.low.system import Paths, UpdateError
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


def test_a_configuration_that_could_not_return_is_refused(world):
    (world.root / "etc/gpr20/environment").write_text("GPR20_CONFIG=/srv/robot\n")
    assert "/srv/robot" in world.update(world.bundle("2.0"), status=2)
    assert world.version() == "1.0"
