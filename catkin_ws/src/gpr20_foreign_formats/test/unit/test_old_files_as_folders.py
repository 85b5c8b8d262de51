"""Files of other programs become surveys' folders: exact, with every decision in the log."""

import json
import math
import random
import subprocess
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_surveys import random_survey
from run_seed import draws
from test_round_trips import FORMATS, SINGLE, same

from gpr20_analysis import image_survey
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.formats.imported_folder import DECISION_FORMAT, SOURCES_FILE
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import DECISIONS

REFUSED = 3
TURNS = (0.0, 90.0, -90.0)  # the original turned to -90 beyond x = 500 mm


@st.composite
def old_samples(draw):
    """Samples as the original storage wrote them, by file name."""
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    x_mm, y_mm = (np.cumsum(rng.uniform(1.0, 60.0, rng.integers(1, 4))) for _ in "xy")
    frequency_hz = np.linspace(600e6, 6e9, rng.integers(4, 12)).tolist()
    copied, constant = draw(st.booleans()), draw(st.booleans())
    places = [(x, y, z) for y in y_mm for x in x_mm for z in TURNS if rng.random() < 0.7]
    samples = {}
    for number, (x, y, z) in enumerate(places or [(x_mm[0], y_mm[0], 0.0)]):
        parts = rng.standard_normal((2, len(frequency_hz))) * 10.0 ** rng.uniform(-8, 0)
        real, imaginary = parts.tolist()
        samples[f"X{x:06.2f}_Y{y:06.2f}_Z{z:06.2f}.json"] = {
            "x_coord": float(x),
            "y_coord": float(y),
            "z_coord": z,
            "antennae_height": 10.0 if constant else rng.uniform(0.1, 0.5),
            "timestamp": f"20211015{number // 60 + 8:02d}{number % 60:02d}30",
            "survey_id": "6d0c",
            "sample_id": f"s{number}",
            "data": [
                {"freq_value": f, "real_value": r, "imaginary_value": r if copied else i}
                for f, r, i in zip(frequency_hz, real, imaginary)
            ],
        }
    return samples


def written(samples, folder):
    folder.mkdir()
    for name, sample in samples.items():
        (folder / name).write_text(json.dumps(sample, indent=4))
    return folder


def run(*arguments):
    """Return the exit status of `gpr20` and what it printed."""
    printed = StringIO()
    with redirect_stdout(printed), redirect_stderr(printed):
        status = main([*map(str, arguments)])
    return status, " ".join(printed.getvalue().split())


def imported(source, form, data, *options):
    status, printed = run("import", source, data, "--format", form, *options)
    assert status in (0, 1), printed
    (folder,) = (one for one in data.iterdir() if not one.name.startswith("."))
    return folder


def decisions_of(folder):
    lines = map(json.loads, (folder / "log.jsonl").read_text("ascii").splitlines())
    values = [one["values"] for one in lines if one["kind"] == "decision"]
    assert all(one["format"] == DECISION_FORMAT for one in values)
    return [one["text"] for one in values]


@settings(max_examples=draws(4))
@given(samples=old_samples())
def test_every_number_of_old_samples_arrives_bit_for_bit(samples, tmp_path_factory):
    place = tmp_path_factory.mktemp("old")
    folder = imported(written(samples, place / "scans"), "original-json", place / "data")
    found, decided = load_survey(folder), decisions_of(folder)
    assert found.attrs[DECISIONS] == decided
    some = next(iter(samples.values()))
    copied = some["data"][0]["real_value"] == some["data"][0]["imaginary_value"]
    assert any("copies of the real parts" in one for one in decided) == (
        copied and "display_only" not in found.attrs
    )
    for sample in samples.values():
        own = found.sel(polarization=sample["z_coord"]).sel(
            x=sample["x_coord"] / 1000.0, y=sample["y_coord"] / 1000.0, method="nearest"
        )
        rows = np.array([list(one.values()) for one in sample["data"]])
        np.testing.assert_array_equal(found.frequency.values, rows[:, 0])
        np.testing.assert_array_equal(own.s21.values.real, rows[:, 1])
        if not copied:
            np.testing.assert_array_equal(own.s21.values.imag, rows[:, 2])
        height = sample["antennae_height"]
        np.testing.assert_equal(float(own.height), math.nan if height == 10.0 else height)
        assert str(own.timestamp.values)[:19] == (
            f"2021-10-15T{sample['timestamp'][8:10]}:{sample['timestamp'][10:12]}:30"
        )
    verified = verify_survey(folder)
    assert verified.faults == [] and verified.stored == len(samples)
    assert str(verified.verdict).startswith("IMPORTED, files intact")


@pytest.mark.parametrize("form", FORMATS)
def test_the_log_says_what_was_decided_and_from_which_files(tmp_path, form):
    source = tmp_path / FORMATS[form]
    export_survey(random_survey(3), source, form)
    folder = imported(source, form, tmp_path / "data")
    decided = " ".join(decisions_of(folder))
    for word in ("mm" if form != "merged-hdf5" else "metres", "rotation", "phase"):
        assert word in decided
    status, printed = run("info", folder)
    assert status in (0, 1) and all(f"decided: {one}" in printed for one in decisions_of(folder))
    run("import", source, tmp_path / "survey.nc", "--format", form)
    assert load_survey(tmp_path / "survey.nc").attrs[DECISIONS] == decisions_of(folder)
    assert not (folder / "survey.bag").exists()
    description = json.loads((folder / "survey.json").read_text("ascii"))
    assert {"parameters", "axes", "nodes", "instrument"}.isdisjoint(description)
    # The survey is another one, whose source it names.
    entry, found = description["imported"], load_survey(folder)
    assert (entry["source"], entry["format"]) == (source.name, form)
    assert found.attrs["survey_id"] != entry["survey_id"] == "survey-3"
    own = found.assign_attrs(survey_id=entry["survey_id"])
    same(own, random_survey(3), SINGLE if form == "merged-hdf5" else 0.0)
    assert verify_survey(folder).faults == []
    checked = subprocess.run(
        ["sha256sum", "--strict", "-c", str(folder / SOURCES_FILE)],
        cwd=str(source if source.is_dir() else tmp_path),
        stdout=subprocess.PIPE,
    )
    assert checked.returncode == 0
    assert checked.stdout.count(b": OK") == description["imported"]["files"]


@settings(max_examples=draws(8))
@given(seed=st.integers(0, 1 << 32), form=st.sampled_from(sorted(FORMATS)))
def test_a_damaged_file_is_refused_with_a_sentence_and_leaves_nothing(seed, form, tmp_path_factory):
    place, rng = tmp_path_factory.mktemp("damaged"), random.Random(seed)
    source = place / FORMATS[form]
    export_survey(random_survey(seed % 4), source, form)
    (place / f"{source.name}.sha256").unlink(missing_ok=True)
    path = rng.choice(sorted(source.iterdir())) if source.is_dir() else source
    content = bytearray(path.read_bytes())
    if rng.random() < 0.5:
        del content[rng.randrange(len(content)) :]
    for _ in range(rng.randrange(3)):
        if content:
            content[rng.randrange(len(content))] = rng.randrange(256)
    path.write_bytes(content)
    data = place / "data"
    status, printed = run("import", source, data, "--format", form)
    folders = list(data.iterdir()) if data.exists() else []
    if status == REFUSED:
        assert folders == [] and "Traceback" not in printed and printed.startswith("gpr20 import: ")
        assert "program error" not in printed, printed
    else:
        assert verify_survey(*folders).faults == []


def test_the_constant_of_the_original_is_no_height_and_a_given_one_makes_an_image(tmp_path):
    survey = random_survey(1)
    heights = survey.height * 0.0 + 10.0
    export_survey(survey.assign(height=heights), tmp_path / "scans", "original-json")
    (tmp_path / "scans.sha256").unlink()
    folder = imported(tmp_path / "scans", "original-json", tmp_path / "data", "--height", "0.2")
    decided = " ".join(decisions_of(folder))
    assert "constant of the original control" in decided and "have 0.2 m, as the user" in decided
    found = load_survey(folder)
    assert set(found.height.values[np.isfinite(found.height.values)]) == {0.2}
    options = ImageOptions(permittivity=4.0, leave_out_missing=True)
    assert np.isfinite(image_survey(found, options).image.values).any()


def test_the_command_may_say_that_the_ground_is_real_but_not_of_simulated_data(tmp_path):
    simulated, real = tmp_path / "simulated", tmp_path / "real"
    survey = random_survey(1)
    export_survey(survey.assign_attrs(simulated=1), simulated, "group-csv")
    del survey.attrs["simulated"]
    export_survey(survey, real, "group-csv")
    assert "simulated" not in load_survey(imported(real, "group-csv", tmp_path / "1")).attrs
    found = load_survey(imported(real, "group-csv", tmp_path / "2", "--real-ground"))
    assert found.attrs["simulated"] == 0
    call = ("import", simulated, tmp_path / "3", "--format", "group-csv", "--real-ground")
    status, printed = run(*call)
    assert status == REFUSED and "holds simulated data" in printed
    assert not (tmp_path / "3").exists()
