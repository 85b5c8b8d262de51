"""Repair writes again what another file proves, names the rest for ever, and changes nothing else.

What random damage does to it is in `test_random_damage.py` of the storage.
"""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from log_examples import FILES, change_digit, marker, with_own_sum
from storage_kit import Kit
from survey_kit import (
    POINTS,
    SURVEY,
    contents,
    make_survey,
    planned_trace,
)

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.checks import DATA
from gpr20_analysis.read.repair import OTHERS, VOUCHED
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.faults import CAN_RESUME, MANIFEST_DAMAGED, UNCONFIRMED
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind, LogHead
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.folder.survey_metadata import encode
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.markers import markers_of
from gpr20_survey.trace.utc_time import moment_text

DONE, NOT_COMPLETE, DAMAGED = 0, 1, 2


def note_during(processing):
    """Add two markers, an annotation and a report to the open survey."""
    for number in (1, 2):
        processing.add_fact("", "marker", json.dumps(marker(number).request()))
    processing.add_fact("", "annotation", json.dumps(Annotation(operator="Ana").values()))
    processing.add_fact(SURVEY, "report", '{"complete": true}')


@pytest.fixture(scope="module")
def noted(tmp_path_factory):
    folder = make_survey(
        tmp_path_factory.mktemp("noted"), len(POINTS), "finished", at_end=note_during
    )
    kit = Kit(folder.parent)
    for number in (3, 4):
        kit.add_marker(SURVEY, marker(number))
    kit.remove_marker(SURVEY, marker(1).marker_id, "Luis")
    kit.annotate(SURVEY, Annotation(operator="Ana", site="El Carmen"))
    kit.add_marker(SURVEY, marker(5))
    kit.processing.shut_down()
    assert verify_survey(folder).status == DONE
    return folder


@pytest.fixture
def copy(noted, tmp_path):
    return Path(shutil.copytree(str(noted), str(tmp_path / noted.name)))


def change_both(folder, number):
    """Change a digit of a marker in both files of the log."""
    for name in FILES:
        change_digit(folder, name, number)


@pytest.mark.parametrize("number", [3, 5])
def test_a_record_that_is_damaged_in_both_files_is_unconfirmed_for_ever(copy, number):
    change_both(copy, number)
    assert verify_survey(copy).status == DAMAGED
    assert main(["verify", "--repair", str(copy)]) == NOT_COMPLETE
    ((name, entry),) = read_description(copy)["unconfirmed"].items()
    changed = f"9{str(marker(number).x_mm)[1:]}"
    assert all(changed in (copy / "damaged" / one).read_text() for one in FILES)
    for _ in range(2):
        found = verify_survey(copy)
        assert (found.status, found.faults) == (NOT_COMPLETE, [])
        assert found.verdict.fault_code == UNCONFIRMED.code
        assert name in str(found.verdict) and "UNCONFIRMED" in str(found.verdict)
        description = read_description(copy)
        assert description["unconfirmed"] == {name: entry}
        ids = {one.marker_id for one in markers_of(description)}
        assert ids == {marker(one).marker_id for one in range(1, 6) if one != number}
        assert main(["verify", "--repair", str(copy)]) == NOT_COMPLETE
    assert main(["annotate", str(copy), "--site", "here"]) == DONE
    assert verify_survey(copy).unconfirmed == (name,)


def test_the_last_entry_of_the_manifest_that_is_damaged_in_both_files_is_named(copied):
    for name in FILES:
        content = (copied / name).read_bytes()
        (copied / name).write_bytes(content.replace(b'"kind":"end"', b'"kind":"And"'))
    assert verify_survey(copied).status == DAMAGED
    assert main(["verify", "--repair", str(copied)]) == NOT_COMPLETE
    found = verify_survey(copied)
    assert (found.faults, len(found.unconfirmed)) == ([], 1)
    assert main(["verify", "--repair", str(copied)]) == NOT_COMPLETE
    assert main(["annotate", str(copied), "--site", "here"]) == NOT_COMPLETE + 2  # it never ended


def is_added_to(folder, before):
    """Return whether nothing but the log was changed, which has more lines."""
    now = files(folder)
    same = all(one.startswith(before[name]) for name, one in now.items() if name in FILES)
    return same and all(now[name] == one for name, one in before.items() if name not in FILES)


def files(folder):
    return {name: one for name, one in contents(folder).items() if name != "manifest.json"}


@pytest.fixture
def replaced(tmp_path):
    """The same survey with the values of another trace."""
    other = {4: {"s21_real": planned_trace(5).s21_real}}
    return make_survey(tmp_path / "other", len(POINTS), "finished", misplaced=other)


def test_a_manifest_is_left_alone_or_written_again_and_the_damaged_one_kept(copied, capsys):
    path, before = copied / "manifest.json", files(copied)
    whole = path.read_bytes()
    assert main(["verify", "--repair", str(copied)]) == 0 and path.read_bytes() == whole
    path.unlink()
    assert verify_survey(copied).status == 2
    assert main(["verify", "--repair", str(copied)]) == 0 and is_added_to(copied, before)
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 8
    path.write_bytes(content)
    found = verify_survey(copied)
    assert found.status == 2 and found.faults[0].fault_code == MANIFEST_DAMAGED.code
    capsys.readouterr()
    assert main(["verify", "--repair", str(copied)]) == 0
    assert str(VOUCHED) in capsys.readouterr().out
    assert is_added_to(copied, {**before, "damaged/manifest.json": bytes(content)})
    rewritten = recover(copied).found.records[-1]
    assert rewritten.kind == Kind.SEAL.value and rewritten.values["reason"]
    assert str(moment_text(rewritten.time)) in " ".join(map(str, verify_survey(copied).notes))


def test_the_manifest_of_another_survey_is_replaced_and_vouches_for_nothing(copied):
    path, before = copied / "manifest.json", files(copied)
    foreign = replace(manifest.read_manifest(copied), survey_id=SURVEY[::-1])
    foreign = replace(foreign, log=LogHead(40, "0" * 64))
    path.write_bytes(foreign.encode())
    (fault,) = verify_survey(copied).faults
    assert SURVEY[::-1] in str(fault)
    assert main(["verify", "--repair", str(copied)]) == DONE
    assert is_added_to(copied, {**before, "damaged/manifest.json": foreign.encode()})
    assert verify_survey(copied).status == DONE


@pytest.mark.parametrize(("is_own", "code"), [(True, DONE), (False, 3)])
def test_a_manifest_of_another_version_is_refused_but_not_one_whose_digit_flipped(
    copied, capsys, is_own, code
):
    path = copied / "manifest.json"
    values = json.loads(path.read_text())
    own_sum = values.pop("sha256")
    values["format"] = "gpr20-manifest/3"
    changed = encode({**values, "sha256": own_sum}) if is_own else with_own_sum(values)
    path.write_bytes(changed)
    assert verify_survey(copied).status == DAMAGED
    assert main(["verify", "--repair", str(copied)]) == code
    assert ("gpr20-manifest/3" in capsys.readouterr().err) != is_own
    assert (path.read_bytes() == changed) != is_own


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("cut", [5, None])
def test_a_file_of_the_log_that_lacks_the_last_entry_of_the_manifest_is_written_again(
    stopped_without_bag, name, cut
):
    path = stopped_without_bag / name
    whole = path.read_bytes()
    path.write_bytes(whole[: -cut if cut else whole.rindex(b"\n", 0, -1) + 1])
    assert verify_survey(stopped_without_bag).status == DAMAGED
    assert main(["verify", "--repair", str(stopped_without_bag)]) == NOT_COMPLETE
    assert path.read_bytes() == whole


@pytest.fixture
def stopped_without_bag(tmp_path):
    return make_survey(tmp_path, 4, "stopped")


@pytest.mark.parametrize(
    ("name", "keep"), [("survey.mcap", True), ("survey.mcap", False), ("trace", False)]
)
def test_nothing_is_sealed_that_disagrees(copied, capsys, name, keep):
    path = sorted((copied / "traces").iterdir())[4] if name == "trace" else copied / name
    content = path.read_bytes()
    place = content.index(b"s21_real") + 7 if name == "trace" else len(content) // 2
    path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    if not keep:
        (copied / "manifest.json").unlink()
    before = files(copied)
    assert main(["verify", "--repair", str(copied)]) in (2, 3)
    assert files(copied) == before
    assert (copied / "manifest.json").exists() == keep


def test_data_that_were_replaced_as_a_whole_are_named_for_ever(copied, replaced, capsys):
    for name in ("survey.mcap", "traces"):
        for path in [copied / name] if name != "traces" else (copied / name).iterdir():
            shutil.copy(str(replaced / path.relative_to(copied)), str(path))
    (copied / "manifest.json").unlink()
    assert main(["verify", "--repair", str(copied)]) == 1
    printed = capsys.readouterr().out
    assert str(OTHERS) in printed and str(VOUCHED) not in printed
    for _ in range(2):
        found = verify_survey(copied)
        assert (found.status, found.unconfirmed) == (1, (DATA,))
        assert main(["verify", "--repair", str(copied)]) == 1


def test_data_that_were_replaced_with_the_manifest_are_found(copied, replaced):
    for name in ("survey.json", *FILES):
        shutil.copy(str(copied / name), str(replaced / name))
    forged = manifest.read_manifest(replaced)
    own = manifest.read_manifest(copied)
    (replaced / "manifest.json").write_bytes(replace(own, files=forged.files).encode())
    assert verify_survey(copied).status == 0
    assert verify_survey(replaced).status == 2


def test_a_survey_that_is_not_closed_is_refused(tmp_path, refusals):
    folder = make_survey(tmp_path, 4, None)
    assert main(["verify", "--repair", str(folder)]) == 3
    assert refusals == [CAN_RESUME.code]
