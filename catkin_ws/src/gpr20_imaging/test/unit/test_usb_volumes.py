import json

import pytest
from fault_kit import raises_fault

from gpr20_imaging import faults
from gpr20_imaging.low import usb_volumes
from gpr20_imaging.low.usb_volumes import UsbVolumes


def test_lists_mounted_sticks_with_free_space(sticks):
    path = sticks.plug_in("BLUE")
    (found,) = sticks.volumes.mounted()
    assert (found.path, found.name, found.writable) == (str(path), "BLUE", True)
    assert found.free_bytes > 0


@pytest.mark.parametrize("mark", [{"rm": "1"}, {"rm": True}, {"hotplug": "1"}, {"tran": "usb"}])
def test_knows_removable_devices_of_every_version_of_lsblk(tmp_path, mark):
    device = {"name": "sda1", "label": None, "mountpoint": str(tmp_path), **mark}
    volumes = UsbVolumes(lambda: json.dumps({"blockdevices": [device]}), (tmp_path.parent,))
    assert [one.name for one in volumes.mounted()] == ["sda1"]


@pytest.mark.parametrize(
    "device",
    [
        {"rm": "0", "tran": "sata"},
        {"rm": True, "mountpoint": None},
        {"rm": True, "mountpoint": "/"},
        {"rm": True, "mountpoint": "/boot/firmware"},
    ],
)
def test_leaves_disks_of_the_system_alone(tmp_path, device):
    device = {"name": "sda", "label": None, "mountpoint": str(tmp_path / "x"), **device}
    (tmp_path / "x").mkdir()
    volumes = UsbVolumes(lambda: json.dumps({"blockdevices": [device]}), (tmp_path,))
    assert volumes.mounted() == []


def test_a_stick_that_is_pulled_out_while_it_is_listed_is_left_out(sticks):
    sticks.plug_in("BLUE").rmdir()
    assert sticks.volumes.mounted() == []


def test_a_stick_that_was_removed_or_replaced_is_noticed(sticks):
    path = sticks.plug_in("BLUE")
    volume = sticks.volumes.find(str(path))
    sticks.volumes.check_present(volume)
    other = type(volume)(volume.path, "BLUE", 1, True, volume.device + 1)
    with raises_fault(faults.STICK_GONE):
        sticks.volumes.check_present(other)
    sticks.pull_out()
    with raises_fault(faults.STICK_GONE):
        sticks.volumes.check_present(volume)


@pytest.mark.parametrize("text", ["", "[]", '{"blockdevices": [1]}', '{"blockdevices": 3}'])
def test_a_broken_list_is_an_error(text):
    with raises_fault(faults.NO_STICK_LIST):
        UsbVolumes(lambda: text).mounted()


def test_lsblk_of_this_computer_can_be_read():
    assert isinstance(UsbVolumes(usb_volumes.list_block_devices).mounted(), list)


def test_a_missing_lsblk_is_an_error(monkeypatch):
    monkeypatch.setattr(usb_volumes, "COMMAND", ("no-such-lsblk",))
    with raises_fault(faults.NO_STICK_LIST):
        usb_volumes.list_block_devices()
