"""gpr20 repair: a manifest that is lost or damaged is written again; nothing else is changed."""

from __future__ import annotations

import random
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from survey_kit import POINTS, describe_again, make_survey, planned_trace

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.manifest_repair import NOT_VOUCHED, OTHERS, VOUCHED
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.folder import manifest, sealing


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("finished"), len(POINTS), "finished")


@pytest.fixture
def copy(finished, tmp_path):
    return Path(shutil.copytree(str(finished), str(tmp_path / finished.name)))


def files(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path != folder / "manifest.json"
    }


def flip(path, chance):
    content = bytearray(path.read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)
    return bytes(content)


def test_a_whole_manifest_is_left_alone(copy, capsys):
    before = (copy / "manifest.json").read_bytes()
    assert main(["repair", str(copy)]) == 0
    assert "nothing was changed: every file is as in the manifest" in capsys.readouterr().out
    assert (copy / "manifest.json").read_bytes() == before


@pytest.mark.parametrize("seed", range(3))
def test_a_damaged_manifest_is_written_again_and_kept(copy, capsys, seed):
    before = files(copy)
    wrong = flip(copy / "manifest.json", random.Random(seed))
    found = verify_survey(copy)
    assert found.status == 2 and "gpr20 repair" in str(found.faults[0])
    assert main(["repair", str(copy)]) == 0
    printed = capsys.readouterr().out
    assert "manifest.json was written again" in printed
    assert str(VOUCHED) in printed
    assert files(copy) == {**before, "damaged/manifest.json": wrong}
    (rewritten,) = manifest.read_manifest(copy).rewritten
    assert rewritten["reason"] and rewritten["time"]
    notes = " ".join(map(str, verify_survey(copy).notes))
    assert f"the manifest was written again at {rewritten['time']}" in notes


def test_a_manifest_that_is_missing_is_written_again(copy):
    before = files(copy)
    (copy / "manifest.json").unlink()
    found = verify_survey(copy)
    assert found.status == 2
    assert "removed, or the survey was cut off while it was closed" in str(found.faults[0])
    assert "gpr20 repair" in str(found.faults[0])
    assert main(["repair", str(copy)]) == 0
    assert files(copy) == before


@pytest.mark.parametrize("keep", [True, False])
def test_a_changed_plan_in_survey_json_is_written_again_from_the_log(copy, keep):
    before, path = files(copy), copy / "survey.json"
    changed = path.read_bytes().replace(b'"y_stop_mm": 20.0', b'"y_stop_mm": 21.0', 1)
    path.write_bytes(changed)
    if not keep:
        (copy / "manifest.json").unlink()
    assert main(["repair", str(copy)]) == 0
    after = files(copy)
    assert after["damaged/survey.json"] == changed
    assert {name: after[name] for name in before} == before
    assert verify_survey(copy).status == 0


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap", "trace"])
@pytest.mark.parametrize("keep", [True, False])
def test_nothing_is_sealed_that_disagrees(copy, capsys, name, keep):
    path = sorted((copy / "traces").iterdir())[4] if name == "trace" else copy / name
    content = path.read_bytes()
    place = content.index(b"s21_real") + 7 if name == "trace" else len(content) // 2
    path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    if not keep:
        (copy / "manifest.json").unlink()
    before = files(copy)
    assert main(["repair", str(copy)]) in (2, 3)
    assert files(copy) == before
    assert (copy / "manifest.json").exists() == keep


def test_a_manifest_is_not_said_to_be_proven_if_nothing_says_what_the_survey_held(
    tmp_path, capsys, monkeypatch
):
    with monkeypatch.context() as patch:
        patch.setattr(sealing, "content_sum", lambda _sums: None)
        copy = make_survey(tmp_path, len(POINTS), "finished")
    (copy / "manifest.json").unlink()
    assert main(["repair", str(copy)]) == 0
    assert str(NOT_VOUCHED) in capsys.readouterr().out


def test_data_that_were_replaced_as_a_whole_are_named_for_ever(copy, tmp_path, capsys):
    other = {4: {"s21_real": planned_trace(5).s21_real}}
    replaced = make_survey(tmp_path / "other", len(POINTS), "finished", misplaced=other)
    for name in ("survey.bag", "survey.mcap", "traces"):
        for path in [copy / name] if name != "traces" else (copy / name).iterdir():
            shutil.copy(str(replaced / path.relative_to(copy)), str(path))
    (copy / "manifest.json").unlink()
    assert main(["repair", str(copy)]) == 1
    printed = capsys.readouterr().out
    assert str(OTHERS) in printed and str(VOUCHED) not in printed
    for _ in range(2):
        found = verify_survey(copy)
        assert (found.status, found.unconfirmed) == (1, (sealing.DATA,))
        assert main(["repair", str(copy)]) == 1
    assert manifest.read_manifest(copy).unconfirmed == (sealing.DATA,)


def test_data_that_were_replaced_with_the_manifest_are_found(copy, tmp_path):
    other = {4: {"s21_real": planned_trace(5).s21_real}}
    replaced = make_survey(tmp_path / "other", len(POINTS), "finished", misplaced=other)
    for name in ("survey.json", "log.jsonl"):
        shutil.copy(str(copy / name), str(replaced / name))
    sealed = manifest.read_manifest(replaced)
    own = manifest.read_manifest(copy)
    (replaced / "manifest.json").write_bytes(replace(own, files=sealed.files).encode())
    assert verify_survey(copy).status == 0
    assert verify_survey(replaced).status == 2


@pytest.mark.parametrize("outcome", [None, "reopened"])
def test_a_survey_that_is_not_closed_is_refused(tmp_path, refusals, outcome):
    folder = make_survey(tmp_path, 4, None)
    if outcome is not None:
        describe_again(folder, resumed=["now"])
    assert main(["repair", str(folder)]) == 3
    assert refusals[-1:] == [faults.NOT_CLOSED.code]


def test_a_folder_that_is_no_survey_is_refused(tmp_path, refusals):
    assert main(["repair", str(tmp_path)]) == 3
    assert refusals[-1:] == [faults.NO_INPUT.code]
