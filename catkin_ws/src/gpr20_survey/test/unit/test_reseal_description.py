"""survey.json of a closed survey is replaced; a power cut at any moment leaves it verifiable."""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from trace_examples import SURVEY

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest, sealing, survey_metadata

DESCRIPTION = {
    "format": survey_metadata.FORMAT,
    "survey_id": SURVEY,
    "started": "2026-09-21T14:13:20.123456+00:00",
    "parameters": {"x_points": 3, "polarizations_deg": [0.0, 90.0]},
    "outcome": "stopped",
    "reason": "",
}
CHANGED = {**DESCRIPTION, "reason": "the operator's note was added"}
CALLS = ("open", "fsync", "replace", "unlink", "link")
KILLED, DONE = 9, 0


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "survey"
    (folder / "traces").mkdir(parents=True)
    (folder / "traces" / "one.json").write_bytes(b"{}\n")
    (folder / "survey.json").write_bytes(survey_metadata.encode(DESCRIPTION))
    sealing.write_manifest(folder, SURVEY, "1.2.3", "2026-09-21T15:00:00.000000+00:00")
    return folder


def present(folder):
    return file_sums.sum_of_file(folder / "survey.json")


def is_sealed(folder) -> bool:
    sealed = manifest.read_manifest(folder)
    return all(sealed.matches(name, file_sums.sum_of_file(folder / name)) for name in sealed.files)


def content(folder):
    return json.loads((folder / "survey.json").read_text())


def test_the_new_content_is_sealed_and_the_former_is_not_any_more(folder):
    former = present(folder)
    sealing.reseal_description(folder, CHANGED)
    sealed = manifest.read_manifest(folder)
    assert content(folder) == CHANGED
    assert sealed.matches("survey.json", present(folder))
    assert not sealed.matches("survey.json", former)
    assert sealed.replacing == {}


def reseal_until(folder, number: int) -> int:
    """Replace survey.json in a process that dies in its n-th call of the disk."""
    child = os.fork()
    if child:
        return os.WEXITSTATUS(os.waitpid(child, 0)[1])
    calls = []

    def dying(real):
        def call(*arguments, **options):
            calls.append(real)
            if len(calls) == number:
                os._exit(KILLED)
            return real(*arguments, **options)

        return call

    for name in CALLS:
        setattr(os, name, dying(getattr(os, name)))
    try:
        sealing.reseal_description(folder, CHANGED)
        os._exit(DONE)
    finally:
        os._exit(1)


def test_a_kill_at_any_call_of_the_disk_leaves_a_sealed_survey(folder, tmp_path):
    number, ending, seen = 0, KILLED, []
    while ending == KILLED:
        number += 1
        copy = tmp_path / str(number)
        shutil.copytree(str(folder), str(copy))
        ending = reseal_until(copy, number)
        assert ending in (KILLED, DONE)
        assert is_sealed(copy)
        seen.append(content(copy))
        assert seen[-1] in (DESCRIPTION, CHANGED)
        sealing.reseal_description(copy, {**CHANGED, "reason": "again"})
        assert is_sealed(copy) and manifest.read_manifest(copy).replacing == {}
    assert number > 8
    assert DESCRIPTION in seen and CHANGED in seen


def test_a_description_that_was_damaged_is_not_sealed_again(folder):
    path = folder / "survey.json"
    path.write_bytes(path.read_bytes().replace(b'"x_points": 3', b'"x_points": 7'))
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        sealing.reseal_description(folder, CHANGED)


@each_case(
    "change",
    [
        {"survey_id": SURVEY[:-1] + "f"},
        {"parameters": {"x_points": 3.0, "polarizations_deg": [0.0, 90.0]}},
        {"parameters": {"x_points": 3, "polarizations_deg": [0.0]}},
        {"new": None},
    ],
)
def test_what_must_not_change_is_refused_by_name(folder, change):
    with raises_fault("storage.request_refused", next(iter(change)), error=SurveyRefusedError):
        sealing.reseal_description(folder, {**DESCRIPTION, **change})
    assert content(folder) == DESCRIPTION and is_sealed(folder)


def test_a_survey_that_is_open_is_refused(folder):
    sealing.mark_reopened(folder, manifest.read_manifest(folder), "now")
    with raises_fault("survey.not_closed", error=SurveyRefusedError):
        sealing.reseal_description(folder, CHANGED)
    (folder / "manifest.json").unlink()
    with raises_fault("survey.not_closed", error=SurveyRefusedError):
        sealing.reseal_description(folder, CHANGED)


def test_every_bit_of_a_manifest_is_covered(folder):
    path = folder / "manifest.json"
    whole = path.read_bytes()
    assert manifest.decode(whole).covers_itself
    chance = random.Random(7)
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 1 << chance.randrange(8)
        with pytest.raises(manifest.ManifestDamagedError):
            manifest.decode(bytes(changed))
    for end in range(0, len(whole), 7):
        with pytest.raises(manifest.ManifestDamagedError):
            manifest.decode(whole[:end])


@each_case("key", ["rewritten", "replacing", "files", "survey_id"])
@each_case("value", [None, 1, [1], "x"])
def test_a_manifest_with_entries_of_another_type_is_damaged(folder, key, value):
    values = json.loads((folder / "manifest.json").read_text())
    if type(value) is type(values[key]):
        value = 2.5
    del values["sha256"]
    values[key] = value
    own_sum = hashlib.sha256(survey_metadata.encode(values)).hexdigest()
    with pytest.raises(manifest.ManifestDamagedError):
        manifest.decode(survey_metadata.encode({**values, "sha256": own_sum}))


def test_a_manifest_of_the_former_format_is_read_and_replaced(folder):
    sealed = manifest.read_manifest(folder)
    former = {
        "format": "gpr20-manifest/1",
        "survey_id": sealed.survey_id,
        "software_revision": sealed.software_revision,
        "written": sealed.written,
        "files": {name: one._asdict() for name, one in sealed.files.items()},
    }
    (folder / "manifest.json").write_bytes(survey_metadata.encode(former))
    assert is_sealed(folder) and not manifest.read_manifest(folder).covers_itself
    sealing.reseal_description(folder, CHANGED)
    assert is_sealed(folder) and manifest.read_manifest(folder).covers_itself
