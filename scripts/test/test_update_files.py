"""A stick that gpr20-update reads is whole and allowed, or nothing changes."""

from __future__ import annotations

import shutil

import pytest
import update_kit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws

pytestmark = pytest.mark.needs("packages")

# Every example damages what it has copied.
SAME_FOLDER = settings(
    max_examples=draws(10), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
# What apt reads of a stick; the rest is for people.
READ = ("InRelease", "Packages", "gpr20_2.0_all.deb", "other-library_2.0_all.deb")


@pytest.fixture
def stick(first, tmp_path):
    """A copy of the stick of version 2.0."""
    shutil.copytree(first.stick("2.0"), tmp_path / "stick")
    return tmp_path / "stick"


def refused(world, place, *words):
    """Update from there; it is refused with these words, and nothing has changed."""
    before = world.data()
    said = world.update(place, status=2)
    assert all(one in said for one in words), said
    assert (world.version(), world.data()) == ("1.0", before)
    assert "versions that are kept: 1.0\n" in world.update("--status")


@SAME_FOLDER
@given(data=st.data())
def test_a_stick_with_any_damage_is_refused(world, stick, data):
    name = data.draw(st.sampled_from(READ))
    whole = (stick / name).read_bytes()
    at = data.draw(st.integers(0, len(whole) - 1))
    damage = data.draw(st.sampled_from(["cut", "flip", "gone"]))
    changed = bytearray(whole)
    changed[at] ^= data.draw(st.integers(1, 255)) if damage == "flip" else 0
    if damage == "gone":
        (stick / name).unlink()
    else:
        (stick / name).write_bytes(changed[:at] if damage == "cut" else changed)
    try:
        # Not every bit of the armour of a signature has a meaning; a good one stays good.
        said = world.update(stick, status=None if name == "InRelease" else 2)
        assert world.version() == "1.0" or (name == "InRelease" and "good signature" in said)
        if world.version() == "2.0":
            world.update("--back")
    finally:
        (stick / name).write_bytes(whole)


def test_a_release_of_somebody_else_is_refused(world, stick, tmp_path):
    update_kit.sign(stick, update_kit.release_key(tmp_path))
    key = world.root / "etc/gpr20/release_key.asc"
    refused(world, stick, f"not signed with {key}")
    (stick / "InRelease").write_text((stick.parent / "Release").read_text("utf-8"))
    refused(world, stick, f"not signed with {key}")
    key.unlink()
    refused(world, world.stick("2.0"), f"{key} is missing")


def test_an_older_version_is_refused(world):
    world.update(world.stick("2.0"))
    said = world.update(world.stick("1.0"), status=2)
    assert "1.0, which is older than 2.0" in said
    assert world.version() == "2.0"


def test_a_stick_that_this_computer_cannot_take_is_refused(world, stick):
    refused_sizes = {"Installed-Size": "9000000000"}
    needs = {"Depends": "other-library, nobody-has-it"}
    for fields, reason in ((needs, "nobody-has-it"), (refused_sizes, "MB free")):
        update_kit.make_deb(stick, "gpr20", "2.0", {}, **fields)
        update_kit.sign(stick, world.gpg)
        refused(world, stick, reason)


def test_a_version_to_which_no_way_leads_back_is_not_left(world):
    kept = world.root / "var/lib/gpr20-update/kept/1.0.deb"
    data = kept.read_bytes()
    for changed in (data[:-1], data[:-1] + b"x"):
        kept.write_bytes(changed)
        refused(world, world.stick("2.0"), "no way back")
    world.update(world.stick("1.0"))
    assert kept.read_bytes() == data
    world.update(world.stick("2.0"))


def test_a_configuration_that_could_not_return_is_refused(world):
    (world.root / "etc/gpr20/robot.conf").write_text("GPR20_CONFIG=/srv/robot\n")
    assert "/srv/robot" in world.update(world.stick("2.0"), status=2)
    assert world.version() == "1.0"
