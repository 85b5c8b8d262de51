"""Files of the group that contradict themselves, or hold what no VNA measures, are named."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from test_old_files_as_folders import REFUSED, decisions_of, imported, run, written

from gpr20_analysis.read.load import load_survey

HZ = np.linspace(600e6, 6e9, 7)
FIRST = "X000.00_Y000.00_Z000.00.json"
ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=3),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.text(max_size=1), st.none(), max_size=1),
)


def sample(x_mm, y_mm, **other):
    rng = np.random.default_rng([x_mm, y_mm])
    rows = np.column_stack([HZ, rng.uniform(-0.1, 0.1, (len(HZ), 2))]).tolist()
    return {
        **{"x_coord": x_mm, "y_coord": y_mm, "z_coord": 0.0, "antennae_height": 0.25},
        **{"timestamp": "20211015083000", "survey_id": "6d0c", "sample_id": f"{x_mm} {y_mm}"},
        "data": [dict(zip(("freq_value", "real_value", "imaginary_value"), row)) for row in rows],
        **other,
    }


def samples():
    places = [(x_mm, y_mm) for x_mm in (0, 20, 40) for y_mm in (0, 20)]
    return {f"X{x:06.2f}_Y{y:06.2f}_Z000.00.json": sample(x, y) for x, y in places}


def with_rows(**other):
    """Return a change of every row of the first sample."""
    return lambda found: [row.update(other) for row in found[FIRST]["data"]]


def in_ghz(found):
    for row in [row for one in found.values() for row in one["data"]]:
        row["freq_value"] /= 1e9


def swap(found):
    last = max(found)
    found[FIRST], found[last] = found[last], found[FIRST]


def rename(name):
    return lambda found: found.update({name: found.pop(FIRST)})


def put(key, value):
    return lambda found: found[FIRST].update({key: value})


CASES = {
    "a name that says another place": (
        rename("X010.00_Y000.00_Z000.00.json"),
        "X010.00_Y",
        "x_coord is 0; it must be 010.00",
    ),
    "two names that were exchanged": (swap, FIRST, "x_coord is 40; it must be 000.00"),
    "a copy of a file manager": (rename(f"{FIRST[:-5]} (1).json"), f"{FIRST[:-5]} (1).json"),
    "GHz": (in_ghz, FIRST, "is 6.0", "1e+07"),
    "a number that no instrument measures": (with_rows(real_value=1e300), FIRST, "1e+300"),
    "a text": (with_rows(imaginary_value="0.5"), FIRST, "imaginary_value 1 is 0.5", "no text"),
    "a height in mm": (put("antennae_height", 250), FIRST, "250", "between 0 and 10"),
    "two surveys": (put("survey_id", "7e1d"), "samples of 2 surveys", "6d0c", "7e1d"),
    "a day": (put("timestamp", "2021-10-15"), FIRST, "2021-10-15", "20211015083000"),
}


def refused(source, form, data, words):
    status, printed = run("import", source, data, "--format", form)
    assert status == REFUSED
    assert [word for word in words if word not in printed] == [], printed
    assert "Error" not in printed and "VNA's display" not in printed


@pytest.mark.parametrize("case", CASES)
def test_what_cannot_be_right_is_refused_by_file_value_and_what_is_allowed(case, tmp_path):
    change, *words = CASES[case]
    found = samples()
    change(found)
    source = written(found, tmp_path / "scans")
    refused(source, "original-json", tmp_path / "data", words)


GROUP = "VNA_X0_Y0_OrX_Fs600M_Fe6000M_Qf3_H250.csv"
SCAN = "S21_real,S21_imag\n0.1,0.2\n0.3,-0.1\n0.2,0.1\n"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        (f"more/{GROUP.replace('X0', 'X20')}", SCAN, ["more/VNA_X20"]),
        (GROUP.lower(), SCAN, [GROUP.lower(), "must have the form VNA_X155"]),
        (GROUP.replace("X0", "X20000"), SCAN, ["X [mm] is 20000", "10000"]),
        ("VNA_X20_Y0_OrX_Fs0.6M_Fe6M_Qf3_H250.csv", SCAN, ["Fe6M", "6000000.0", "1e+07"]),
        (GROUP.replace("X0", "X20"), SCAN.replace("0.3", "0,3"), ["VNA_X20", "two numbers"]),
    ],
)
def test_csv_files_that_cannot_be_right_are_refused_by_name(name, text, words, tmp_path):
    (tmp_path / "scans/more").mkdir(parents=True)
    (tmp_path / "scans" / GROUP).write_text(SCAN)
    (tmp_path / "scans" / name).write_text(text)
    refused(tmp_path / "scans", "group-csv", tmp_path / "data", words)


def test_capitals_a_mark_of_the_encoding_and_hidden_files_are_no_obstacle(tmp_path):
    source = written(samples(), tmp_path / "scans")
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
    found = samples()
    zero, same, first, large, early, high = sorted(found)
    found[same]["data"] = found[first]["data"]
    for row in found[zero]["data"]:
        row.update(real_value=0.0, imaginary_value=0)
    found[large]["data"][3]["real_value"] = -1000.0
    found[early]["timestamp"] = "19700101000000"
    found[high]["antennae_height"] = 3.0
    folder = imported(written(found, tmp_path / "scans"), "original-json", tmp_path / "data")
    said, survey = " ".join(decisions_of(folder)), load_survey(folder)
    for words in (
        f"measured: 1, {zero}",
        f"1, {first} = {same}",
        f"{large} (1000)",
        early,
        f"{high} (3000 mm)",
    ):
        assert words in said
    assert survey.attrs["missing"] == ["missing: x 0 mm, y 0 mm, 0 deg"]
    assert float(survey.s21.real.min()) == -1000.0
    found = {name: {**one, "data": found[zero]["data"]} for name, one in found.items()}
    source = written(found, tmp_path / "zero")
    status, printed = run("import", source, tmp_path / "data", "--format", "original-json")
    assert status == REFUSED and "samples of only 0" in printed


@settings(max_examples=draws(15))
@given(data=st.data())
def test_anything_in_a_sample_is_refused_or_arrives_as_it_is(data, tmp_path_factory):
    place, found = tmp_path_factory.mktemp("any"), samples()
    victim = found[data.draw(st.sampled_from(sorted(found)))]
    victim = data.draw(st.sampled_from([victim, *victim["data"]]))
    victim[data.draw(st.sampled_from(sorted(victim)))] = data.draw(ANYTHING)
    source, into = written(found, place / "scans"), place / "data"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        status, printed = run("import", source, into, "--format", "original-json")
    for word in ("Traceback", "program error", "Warning:", "NoneType", "not supported"):
        assert word not in printed, printed
    if status == REFUSED:
        assert "gpr20 import: " in printed
        return
    survey = load_survey(next(one for one in into.iterdir() if one.name[0] != "."))
    for one in found.values():
        own = survey.isel(polarization=0)
        own = own.sel(x=one["x_coord"] / 1e3, y=one["y_coord"] / 1e3, method="nearest")
        rows = np.array([list(row.values()) for row in one["data"]], np.float64)
        np.testing.assert_array_equal(survey.frequency.values, rows[:, 0])
        np.testing.assert_array_equal(own.s21.values, rows[:, 1] + 1j * rows[:, 2])
        assert abs(float(own.x) * 1e3 - one["x_coord"]) < 1e-9
        known = one["antennae_height"] is not None
        assert not known or float(own.height) == one["antennae_height"]
