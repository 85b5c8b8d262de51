"""Going on with a survey whose files were damaged: repaired, never wrong."""

from __future__ import annotations

import json
import shutil

import pytest
from log_examples import make_former
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

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.folder import manifest
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


def test_an_mcap_that_is_gone_is_made_again_and_the_bag_beside_it_is_kept(kit, folder):
    (folder / "survey.mcap").unlink()
    bag = (folder / "survey.bag").read_bytes()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert {"count": 4, "file": "survey.mcap"} in [one.values for one in reopened.repairs]
    assert (folder / "damaged" / "survey.bag").read_bytes() == bag
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


def test_an_mcap_damaged_in_its_middle_is_rebuilt_and_both_recordings_are_kept(kit, folder):
    content = bytearray((folder / "survey.mcap").read_bytes())
    assert len(list(StoredMcap(folder / "survey.mcap").messages())) == 4 + 4 + 4
    content[len(content) // 2] ^= 0x20
    (folder / "survey.mcap").write_bytes(content)
    bag = (folder / "survey.bag").read_bytes()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert ("survey.mcap", "survey.repaired") in repaired(reopened)
    assert (folder / "damaged" / "survey.mcap").read_bytes() == content
    assert (folder / "damaged" / "survey.bag").read_bytes() == bag
    assert reopened.stored_indices == (0, 1, 2, 3)
    finish(kit, folder, reopened)


@pytest.mark.parametrize(
    "text",
    [
        b"type=gpr20_msgs/Trace",
        b"float64[] s21_real",
        b"md5sum=",
        b"topic=/trace",
        TRACES[2].s21_real.tobytes(),
    ],
)
def test_a_bag_that_is_wrong_changes_nothing_and_is_written_again(kit, folder, text):
    content = bytearray((folder / "survey.bag").read_bytes())
    content[content.rindex(text) + len(text) - (text[-1:] != b"=")] ^= 0x01
    (folder / "survey.bag").write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.repairs == ()
    finish(kit, folder, reopened)


def test_a_trace_that_only_the_bag_holds_is_measured_again(kit, folder):
    sorted((folder / "traces").iterdir())[2].unlink()
    (folder / "survey.mcap").unlink()
    bag = (folder / "survey.bag").read_bytes()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 3)
    assert (folder / "damaged" / "survey.bag").read_bytes() == bag
    finish(kit, folder, reopened)


@pytest.mark.parametrize("with_mcap", [True, False])
def test_a_digit_changed_in_a_json_file_is_found_by_its_own_checksum(kit, folder, with_mcap):
    path = sorted((folder / "traces").iterdir())[2]
    if not with_mcap:
        (folder / "survey.mcap").unlink()
    good = path.read_bytes()
    place = good.index(b"s21_real") + 20
    assert good[place : place + 1].isdigit()
    damaged = good[:place] + b"%d" % ((good[place] - 47) % 10) + good[place + 1 :]
    path.write_bytes(damaged)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert (path.name, "survey.repaired") in repaired(reopened)
    assert (folder / "damaged" / path.name).read_bytes() == damaged
    if with_mcap:
        assert path.read_bytes() == good
        assert reopened.stored_indices == (0, 1, 2, 3)
    else:
        assert reopened.stored_indices == (0, 1, 3)
    finish(kit, folder, reopened)


def with_other_number(path):
    """Change a number in a trace's file of an earlier version, which has no checksum."""
    values = read_json(path)
    values["s21_real"][0] += 1.0
    path.write_text(json.dumps(values) + "\n")


def test_of_an_earlier_version_the_mcap_decides_where_a_file_differs(kit, folder):
    make_former(folder)
    with_other_number(sorted((folder / "traces").iterdir())[2])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2, 3)
    finish(kit, folder, reopened)


def test_of_an_earlier_version_a_trace_that_only_a_file_holds_is_unconfirmed_for_ever(kit, folder):
    make_former(folder)
    (folder / "survey.mcap").unlink()
    names = {f"traces/{path.name}" for path in (folder / "traces").iterdir()}
    for ending in ("stopped", "finished"):
        reopened = kit.processing.reopen_survey(SURVEY)
        assert reopened.stored_indices == (0, 1, 2, 3)
        if ending == "finished":
            finish(kit, folder, reopened)
        else:
            assert "survey.unconfirmed" in {one.fault_code for one in reopened.repairs}
            kit.processing.close_survey(SURVEY, ending)
        assert names <= set(read_json(folder / "survey.json")["unconfirmed"])
        assert names <= set(manifest.read_manifest(folder).unconfirmed)
        assert names <= set(verify_survey(folder).unconfirmed)
