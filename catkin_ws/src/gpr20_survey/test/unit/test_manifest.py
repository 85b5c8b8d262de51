"""The manifest covers itself to the last bit, and manifests of earlier versions are read."""

from __future__ import annotations

import json
import random
from dataclasses import replace

import pytest
from case_kit import each_case
from log_examples import (
    EARLIER,
    NOW,
    add_marker,
    make_former,
    make_survey,
    recovered,
    with_own_sum,
)

from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest
from gpr20_survey.folder.annotating import add_to_survey


@pytest.fixture
def folder(tmp_path):
    make_survey(tmp_path / "survey")
    return tmp_path / "survey"


def is_sealed(folder):
    sealed = manifest.read_manifest(folder)
    return sealed.covers(recovered(folder).found.records) and all(
        sealed.matches(name, file_sums.sum_of_file(folder / name)) for name in sealed.files
    )


def test_the_log_is_named_by_its_last_record_and_its_files_are_not_listed(folder):
    sealed = manifest.read_manifest(folder)
    last = recovered(folder).found.records[-1]
    assert (sealed.log, sealed.next_log) == ((last.number, last.sha256), None)
    assert set(sealed.files) == {"traces/one.json"}


def test_a_manifest_is_read_as_it_was_written(folder):
    sealed = replace(
        manifest.read_manifest(folder),
        next_log=manifest.LogHead(4, "a" * 64),
        unconfirmed=("record 3", "markers/1"),
        reopened=NOW,
        rewritten=({"time": NOW, "reason": "it was missing"},),
    )
    assert manifest.decode(sealed.encode()) == sealed


def test_every_bit_of_a_manifest_is_covered(folder):
    whole = (folder / "manifest.json").read_bytes()
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


@each_case("key", ["rewritten", "files", "survey_id", "log", "next_log", "unconfirmed"])
@each_case("value", [1, [1], "x", {"number": -1, "sha256": "a"}, {"number": 1, "sha256": 1}])
def test_a_manifest_with_entries_of_another_type_is_damaged(folder, key, value):
    values = json.loads((folder / "manifest.json").read_text())
    if type(value) is type(values[key]) and key not in ("log", "next_log", "rewritten"):
        value = 2.5
    del values["sha256"]
    with pytest.raises(manifest.ManifestDamagedError):
        manifest.decode(with_own_sum({**values, key: value}))


@pytest.mark.parametrize("form", EARLIER)
def test_a_manifest_of_an_earlier_version_is_read_and_replaced_by_the_next_addition(folder, form):
    former = make_former(folder, form)
    sealed = manifest.read_manifest(folder)
    assert sealed.log is None and sealed.covers_itself is (form != EARLIER[0])
    assert sealed.matches("survey.json", file_sums.sum_of_file(folder / "survey.json"))
    add_to_survey(folder, add_marker(7), NOW)
    assert is_sealed(folder) and manifest.read_manifest(folder).covers_itself
    assert recovered(folder).found.records[0].values == former
    assert recovered(folder).all_unconfirmed == {}
