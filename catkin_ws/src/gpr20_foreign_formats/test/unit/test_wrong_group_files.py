"""Files of the group that contradict themselves, or hold what no VNA measures, are named."""

import warnings

import h5py
import numpy as np
from case_kit import each_case
from group_kit import (
    PLACES,
    decisions_of,
    imported,
    originals,
    run,
    write_merged,
    write_originals,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_analysis.formats.imports import ImportOptions
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.work import no_progress
from gpr20_foreign_formats.group_files import IMPORT

FIRST, LAST = "X000.00_Y000.00_Z000.00.json", "X020.00_Y015.00_Z000.00.json"
ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=3),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.text(max_size=1), st.none(), max_size=1),
)


def refused(source, form, data, words):
    status, printed = run("import", source, data, "--format", form)
    assert status == 3
    assert [word for word in words if word not in printed] == [], printed
    assert "Error" not in printed and not data.exists()


def swap(found):
    found[FIRST], found[LAST] = found[LAST], found[FIRST]


def rename(name):
    return lambda found: found.update({name: found.pop(FIRST)})


def put(key, value):
    return lambda found: found[FIRST].update({key: value})


def in_rows(key, change):
    """Return a change of every row of the first sample."""

    def changed(found):
        for row in found[FIRST]["data"]:
            row[key] = change(row[key])

    return changed


ORIGINALS = {
    "another place": (rename("X010.00_Y000.00_Z000.00.json"), "X010.00_Y", "it must be 010.00"),
    "names that were exchanged": (swap, FIRST, "x_coord is 20; it must be 000.00"),
    "a copy of a file manager": (rename(f"{FIRST[:-5]} (1).json"), f"{FIRST[:-5]} (1).json"),
    "GHz": (in_rows("freq_value", lambda hz: hz / 1e9), FIRST, "is 6.0", "1e+07"),
    "no instrument's number": (in_rows("real_value", lambda _: 1e300), FIRST, "1e+300"),
    "a text": (in_rows("imaginary_value", str), FIRST, "imaginary_value 1", "no text"),
    "a height in mm": (put("antennae_height", 250), FIRST, "250", "between 0 and 10"),
    "two surveys": (put("survey_id", "7e1d"), FIRST, "of another survey"),
    "a day": (put("timestamp", "2021-10-15"), FIRST, "2021-10-15", "20211015083000"),
}


@each_case("case", ORIGINALS)
def test_what_cannot_be_right_is_refused_by_file_value_and_what_is_allowed(case, tmp_path):
    change, *words = ORIGINALS[case]
    found = originals(PLACES)
    change(found)
    source = write_originals(tmp_path / case, found)
    refused(source, "original-json", tmp_path / "data", words)


GROUP = "VNA_X0_Y0_OrX_Fs600M_Fe6000M_Qf3_H250.csv"
SCAN = "S21_real,S21_imag\n0.1,0.2\n0.3,-0.1\n0.2,0.1\n"


@each_case(
    "name, text, words",
    [
        (f"more/{GROUP.replace('X0', 'X20')}", SCAN, ["more/VNA_X20"]),
        (GROUP.lower(), SCAN, [GROUP.lower(), "must have the form VNA_X155"]),
        (GROUP.replace("X0", "X20000"), SCAN, ["X [mm] is 20000", "10000"]),
        ("VNA_X20_Y0_OrX_Fs0.6M_Fe6M_Qf3_H250.csv", SCAN, ["Fe6M", "6000000.0", "1e+07"]),
        (GROUP.replace("VNA", "TIME").replace("M_", "u_").replace("Qf", "Qt"), SCAN, ["VNA_"]),
        (GROUP.replace("Y0", "Y20").replace("Fe6000", "Fe5000"), SCAN, ["mixes", "5000000000"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("0.3", "0,3"), ["VNA_X20", "two numbers"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("0.3", "nan"), ["VNA_X20", "NaN"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("0.3", "1_0"), ["VNA_X20"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("0.3", "1e999"), ["VNA_X20", "two numbers"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("\n0.3", ",0.3"), ["VNA_X20", "3 lines"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("2\n0.3,", "2,0.3\n"), ["VNA_X20", "3 lines"]),
        (GROUP.replace("X0", "X20"), SCAN[:-1], ["VNA_X20", "cut off"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("real", "mag"), ["VNA_X20", "S21_real,S21_imag"]),
    ],
)
def test_csv_files_that_cannot_be_right_are_refused_by_name(name, text, words, tmp_path_factory):
    tmp_path = tmp_path_factory.mktemp("csv")
    (tmp_path / "scans/more").mkdir(parents=True)
    (tmp_path / "scans" / GROUP).write_text(SCAN)
    (tmp_path / "scans" / name).write_text(text)
    refused(tmp_path / "scans", "group-csv", tmp_path / "data", words)


def test_numbers_as_other_programs_write_them_are_read(tmp_path):
    written = {"json": "0.1,0.2\n0.3,-0.1\n0.2,0.1", "other": ".1,+0.2\n3.E-1,-.1\n02e-1,1E-1"}
    for name, rows in written.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / GROUP).write_text(f"S21_real,S21_imag\n{rows}\n")
    read = [IMPORT.read(tmp_path / one, ImportOptions(), no_progress)["s21"] for one in written]
    assert np.array_equal(*read)


@each_case(
    "damage, shown",
    [
        (lambda file: file["Frequency"].attrs.update(df=1e6), "df"),
        (lambda file: file["Position"].attrs.update(dx=0.003), "dx"),
        (lambda file: file["A-Scan"].pop("Im{S21 x-pol}"), "Im{S21 x-pol}"),
        (lambda file: file.pop("Frequency"), "t0"),
        (lambda file: file.attrs.update({"Total Amount of A-Scans": 3}), "Total Amount"),
        (lambda file: file["Position/h x-pol"].write_direct(np.full((1, 4), -0.2)), "-0.2"),
        (lambda file: file["A-Scan/Re{S21 x-pol}"].write_direct(np.full((4, 7), 2e6)), "|S21|"),
    ],
)
def test_a_merged_file_that_contradicts_itself_is_refused(damage, shown, tmp_path_factory):
    path = write_merged(tmp_path_factory.mktemp("merged") / "m.h5", PLACES)
    with h5py.File(path, "r+") as file:
        damage(file)
    refused(path, "merged-hdf5", path.parent / "data", ["m.h5", shown])


def test_capitals_a_mark_of_the_encoding_and_hidden_files_are_no_obstacle(tmp_path):
    source = write_originals(tmp_path / "scans", originals(PLACES))
    content = (source / FIRST).read_bytes()
    (source / FIRST).rename(source / FIRST.replace("json", "JSON"))
    (source / FIRST.replace("json", "JSON")).write_bytes(b"\xef\xbb\xbf" + content)
    (source / f"._{FIRST}").write_bytes(b"\0")  # as a Mac leaves it on a stick
    (source / "notes.txt").write_text("wet ground")
    folder = imported(source, "original-json", tmp_path / "data")
    assert load_survey(folder).attrs["missing"] == []
    assert "not read: 1, notes.txt" in " ".join(decisions_of(folder))
    (tmp_path / "csv").mkdir()
    (tmp_path / "csv" / GROUP.replace("csv", "CSV")).write_text(f"\ufeff{SCAN}", "utf-8")
    found = load_survey(imported(tmp_path / "csv", "group-csv", tmp_path / "other"))
    assert found.s21.values.reshape(-1).tolist() == [0.1 + 0.2j, 0.3 - 0.1j, 0.2 + 0.1j]


def test_what_may_be_right_is_kept_and_said_in_the_log(tmp_path):
    found = originals(PLACES)
    zero, _, _, large = sorted(found)
    for row in found[zero]["data"]:
        row.update(real_value=0.0, imaginary_value=0)
    found[large]["data"][3]["real_value"] = -1000.0
    folder = imported(write_originals(tmp_path / "s", found), "original-json", tmp_path / "data")
    said, survey_there = " ".join(decisions_of(folder)), load_survey(folder)
    assert f"measured: 1, {zero}" in said and f"1, {large} (1000)" in said
    assert survey_there.attrs["missing"] == ["missing: x 0 mm, y 0 mm, 0 deg"]
    assert float(survey_there.s21.real.min()) == -1000.0
    for one in found.values():
        one["data"] = found[zero]["data"]
    source = write_originals(tmp_path / "zero", found)
    refused(source, "original-json", tmp_path / "no", ["samples of only 0"])


@settings(max_examples=draws(15))
@given(data=st.data())
def test_anything_in_a_sample_is_refused_or_arrives_as_it_is(data, tmp_path_factory):
    place, found = tmp_path_factory.mktemp("any"), originals(PLACES)
    victim = found[data.draw(st.sampled_from(sorted(found)))]
    victim = data.draw(st.sampled_from([victim, *victim["data"]]))
    victim[data.draw(st.sampled_from(sorted(victim)))] = data.draw(ANYTHING)
    source, into = write_originals(place / "scans", found), place / "data"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        status, printed = run("import", source, into, "--format", "original-json")
    for word in ("Traceback", "program error", "Warning:", "NoneType", "not supported"):
        assert word not in printed, printed
    if status == 3:
        assert "gpr20 import: " in printed
        return
    survey_there = load_survey(next(one for one in into.iterdir() if one.name[0] != "."))
    for one in found.values():
        own = survey_there.isel(polarization=0)
        own = own.sel(x=one["x_coord"] / 1e3, y=one["y_coord"] / 1e3, method="nearest")
        rows = np.array([list(row.values()) for row in one["data"]], np.float64)
        np.testing.assert_array_equal(survey_there.frequency.values, rows[:, 0])
        np.testing.assert_array_equal(own.s21.values, rows[:, 1] + 1j * rows[:, 2])
        known = one["antennae_height"] is not None
        assert not known or float(own.height) == one["antennae_height"]
