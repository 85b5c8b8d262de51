"""Going on with a survey whose files were damaged: repaired, never wrong."""

from __future__ import annotations

import json
import shutil

import pytest
from reopening_kit import (
    METADATA,
    TRACES,
    data,
    finish,
    folder,
    kit,
)
from storage_kit import Kit
from trace_examples import SURVEY, read_json

from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recordings import open_recordings

__all__ = ["data", "folder", "kit"]


def repaired(reopened):
    """The files that were repaired, each with the code of the repair."""
    return {(one.values.get("file"), one.fault_code) for one in reopened.repairs}


def test_torn_temporary_files_are_removed_and_never_data(kit, folder):
    torn = [folder / "traces" / ".000004_X0050.00.json.0a.tmp", folder / ".survey.json.0a.tmp"]
    for path in torn:
        path.write_text("{")
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.repairs[0].values["count"] == 2
    assert not any(path.exists() for path in torn)
    assert reopened.stored_indices == (0, 1, 2, 3)


def test_a_trace_that_is_in_json_alone_is_put_into_the_recordings(data, folder, tmp_path):
    source = Kit(tmp_path / "other", open_recordings)
    source.open(metadata_json=METADATA)
    path = source.processing.store(TRACES[5])
    shutil.copy(str(path), str(folder / "traces"))
    source.processing.shut_down()
    kit = Kit(data, open_recordings)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2, 3, 5)
    assert reopened.recent[-1].index == 5
    finish(kit, folder, reopened)
    kit.processing.shut_down()


def test_a_trace_that_is_in_the_recordings_alone_gets_its_json(kit, folder):
    path = sorted((folder / "traces").iterdir())[1]
    content = path.read_bytes()
    path.unlink()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2, 3)
    assert path.read_bytes() == content
    finish(kit, folder, reopened)


def test_a_recording_that_is_gone_is_made_again(kit, folder):
    (folder / "survey.bag").unlink()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert {"count": 4, "file": "survey.bag"} in [one.values for one in reopened.repairs]
    finish(kit, folder, reopened)


def test_an_unreadable_trace_of_which_there_is_no_copy_counts_as_not_stored(kit, folder):
    for name in ("survey.bag", "survey.mcap"):
        (folder / name).unlink()
    path = sorted((folder / "traces").iterdir())[1]
    path.write_bytes(path.read_bytes()[:-5])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 2, 3)
    assert (folder / "damaged" / path.name).exists()
    assert "survey.repaired" in {repair.fault_code for repair in reopened.repairs}
    finish(kit, folder, reopened)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
def test_a_recording_damaged_in_its_middle_is_rebuilt_and_the_old_one_kept(kit, folder, name):
    content = bytearray((folder / name).read_bytes())
    stored = (StoredBag if name == "survey.bag" else StoredMcap)(folder / name)
    assert len(list(stored.messages())) == 4 + 4 + 3
    place = len(content) // 2
    if name == "survey.bag":
        place = content.index(TRACES[2].s21_real.tobytes()) + 3
    content[place] ^= 0x20
    (folder / name).write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert (name, "survey.repaired") in repaired(reopened)
    assert (folder / "damaged" / name).read_bytes() == content
    assert reopened.stored_indices == (0, 1, 2, 3)
    finish(kit, folder, reopened)


@pytest.mark.parametrize(
    "text", [b"type=gpr20_msgs/Trace", b"float64[] s21_real", b"md5sum=", b"topic=/trace"]
)
def test_a_bag_whose_types_are_damaged_is_rebuilt_with_the_right_ones(kit, folder, text):
    content = bytearray((folder / "survey.bag").read_bytes())
    content[content.rindex(text) + len(text) - (text[-1:] != b"=")] ^= 0x01
    (folder / "survey.bag").write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert ("survey.bag", "survey.repaired") in repaired(reopened)
    finish(kit, folder, reopened)


def test_a_digit_changed_in_a_json_file_is_found_by_the_recordings(kit, folder):
    path = sorted((folder / "traces").iterdir())[2]
    good = path.read_bytes()
    place = good.index(b"s21_real") + 20
    assert good[place : place + 1].isdigit()
    path.write_bytes(good[:place] + b"%d" % ((good[place] - 47) % 10) + good[place + 1 :])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert path.read_bytes() == good
    assert reopened.stored_indices == (0, 1, 2, 3)
    finish(kit, folder, reopened)


def test_a_trace_on_which_no_two_sources_agree_is_not_called_stored(kit, folder):
    (folder / "survey.mcap").unlink()
    path = sorted((folder / "traces").iterdir())[2]
    values = read_json(path)
    values["s21_real"][0] += 1.0
    path.write_text(json.dumps(values) + "\n")
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 3)
    finish(kit, folder, reopened)
