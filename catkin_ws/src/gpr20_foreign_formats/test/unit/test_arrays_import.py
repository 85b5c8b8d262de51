"""Plain arrays of other programs become surveys; damaged ones are refused with the way out."""

import tempfile
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from arrays_kit import ENDINGS, FREQUENCY_HZ, TIME_S, a_line, describe, read, write_arrays
from case_kit import each_case
from fault_kit import raises_fault
from group_kit import even, survey, write_merged
from hypothesis import given, settings
from hypothesis import strategies as st
from random_surveys import noise_survey
from run_seed import draws

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.formats.imports import IMPORTS
from gpr20_analysis.read.load import load_survey

PULSE = np.exp(-(((TIME_S - 2e-9) * 3e9) ** 2)) * np.cos(2 * np.pi * 1.5e9 * TIME_S)


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_file_with_documented_names_needs_nothing_beside_it(tmp_path, ending):
    path, line = tmp_path / f"line{ending}", a_line()
    write_arrays(path, {**line, "height_m": np.full(5, 0.1), "delay_s": 1e-9})
    found = read(path)
    np.testing.assert_array_equal(found.s21.values[0, 0], line["s21"])
    np.testing.assert_allclose(found.x, line["x_m"], atol=1e-12)
    assert found.height.values.tolist() == [[[0.1] * 5]]
    assert found.attrs["antenna_delay_s"] == 1e-9 and "simulated" not in found.attrs
    assert [key for key in ("rotation_deg", "y_m") if key in str(found.attrs["notes"])]
    assert read(path, height_m=0.3).height.values.tolist() == [[[0.3] * 5]]


def test_a_file_beside_it_names_arrays_and_gives_axes(tmp_path):
    path = tmp_path / "d.npy"
    values = np.stack([a_line(4)["s21"]] * 2)
    write_arrays(path, {"array": values})
    describe(
        path,
        s21="array",
        rotation_deg=[0, "9e1"],
        x_m={"start": 0.0, "step": "1e-2", "count": 4},
        frequency_hz={"start": 1e9, "step": 5e7, "count": 21},
        simulated=True,
    )
    found = read(path)
    np.testing.assert_array_equal(found.s21.values[:, 0], values)
    assert found.polarization.values.tolist() == [0.0, 90.0]
    assert found.attrs["simulated"] == 1 and (found.quality == 4).all()


@each_case("band", [[], ["--band", "1e9", "2e9", "21"]])
def test_a_scans_become_spectra_at_the_frequencies_that_are_given(tmp_path, band):
    path, output = tmp_path / "d.npz", tmp_path / "o.nc"
    scans = np.tile(PULSE + 0.25, (3, 1))
    write_arrays(path, {"a_scans": scans, "x_m": [0.0, 0.1, 0.2], "time_s": TIME_S})
    command = ["import", str(path), str(output), "--format", "arrays", "--overwrite"]
    assert main([*command, *band]) == 0
    found = load_survey(output)
    assert "antenna_delay_s" not in found.attrs
    assert "does not record its time zero" in str(found.attrs["notes"])
    turns = np.exp(-2j * np.pi * np.outer(TIME_S, found.frequency.values))
    ratio = found.s21.values[0, 0] / (scans @ turns)
    # Nothing is removed from them silently, such as their mean.
    np.testing.assert_allclose(ratio, abs(ratio[0, 0]), rtol=1e-6)
    assert not band or found.frequency.values.tolist() == FREQUENCY_HZ.tolist()
    assert main([*command, "--domain", "time"]) == 0
    np.testing.assert_array_equal(load_survey(output).a_scan.values[0, 0], scans)


def test_samples_of_nan_are_missing_or_damaged(tmp_path):
    path, line = tmp_path / "d.npz", a_line()
    line["s21"][1], line["s21"][2, 4] = np.nan, np.inf
    write_arrays(path, line)
    found = read(path)
    assert (found.quality.values.ravel() & 3).tolist() == [0, 1, 2, 0, 0]
    assert len(found.attrs["missing"]) == 2 and len(found.attrs["faults"]) == 1


def test_files_of_other_formats_are_not_taken(tmp_path):
    write_merged(tmp_path / "m.h5", even(survey()))
    write_dataset(noise_survey(1), tmp_path / "n.nc")
    (tmp_path / "n.nc").rename(tmp_path / "n.h5")
    (tmp_path / "text.npz").write_text("s21")
    describe(tmp_path / "m.h5", s21="other")
    write_arrays(tmp_path / "d.npz", {"other": np.ones((2, 3))})
    for name in ("m.h5", "n.h5", "text.npz", "absent.npy", "d.npz"):
        assert IMPORTS.find("arrays").whole(tmp_path / name) is None
    describe(tmp_path / "d.npz", s21="other")
    assert IMPORTS.find("arrays").whole(tmp_path / "d.npz") == tmp_path / "d.npz"


CONTENT = faults.INPUT
AXES = ("rotation_deg", "y_m", "x_m", "frequency_hz")
STEPS = {"rotation_deg": 30.0, "y_m": 0.1, "x_m": 0.02, "frequency_hz": 1e8}


@settings(max_examples=draws(15))
@given(
    sizes=st.tuples(*[st.integers(1, 4)] * 3, st.integers(2, 5)),
    order=st.permutations(range(4)),
    ending=st.sampled_from(ENDINGS),
)
def test_dimensions_are_what_their_lengths_say_or_refused_as_ambiguous(sizes, order, ending):
    random = np.random.default_rng(sizes)
    s21 = random.standard_normal(sizes) + 1j * random.standard_normal(sizes)
    axes = {key: (np.arange(size) + 1.0) * STEPS[key] for key, size in zip(AXES, sizes)}
    dims = [AXES[place] for place in order if sizes[place] > 1]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"d{ending}"
        write_arrays(path, {"s21": s21.transpose(order), **axes})
        longer = [size for size in sizes if size > 1]
        if len({*longer}) < len(longer):
            with raises_fault(CONTENT, "dims"):
                read(path)
            describe(path, dims=dims)
        found = read(path)
    np.testing.assert_array_equal(found.s21.values, s21)
    for name, key in zip(found.s21.dims, AXES):
        np.testing.assert_allclose(found[name], axes[key])


@settings(max_examples=draws(30))
@given(
    ending=st.sampled_from((*ENDINGS, ".npy")),
    place=st.floats(0.0, 1.0, exclude_max=True),
    change=st.integers(1, 255),
    is_cut=st.booleans(),
)
def test_damaged_files_are_refused_or_still_a_survey(ending, place, change, is_cut):
    with tempfile.TemporaryDirectory() as folder:
        path, line = Path(folder) / f"d{ending}", a_line()
        write_arrays(path, {"s21": line["s21"]} if ending == ".npy" else line)
        if ending == ".npy":
            describe(path, s21="array", **{key: line[key].tolist() for key in AXES[2:]})
        content = bytearray(path.read_bytes())
        spot = int(place * len(content))
        content[spot] ^= change
        path.write_bytes(content[:spot] if is_cut else content)
        try:
            found = read(path)
        except AnalysisError as error:
            assert path.name in str(error)
        else:
            assert found.s21.shape == (1, 1, 5, 21)


@settings(max_examples=draws(15))
@given(
    key=st.sampled_from(["s21", "x_m", "frequency_hz", "height_m", "delay_s", "dims", "simulated"]),
    value=st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.text("a", max_size=2), inner)
        ),
        max_leaves=4,
    ),
)
def test_whatever_the_file_beside_it_says_is_understood_or_refused(key, value):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "d.npz"
        write_arrays(path, a_line())
        describe(path, **{key: value})
        try:
            assert read(path).s21.shape == (1, 1, 5, 21)
        except AnalysisError as error:
            assert key in str(error) or "d.axes.yaml" in str(error)


SCANS = {"a_scans": np.ones((5, 200)), "time_s": TIME_S, "s21": None, "frequency_hz": None}


@pytest.mark.parametrize(
    ("arrays", "beside", "shown"),
    [
        ({"a_scans": np.ones((5, 21))}, {}, ["a_scans, s21"]),
        ({"s21": np.ones((5, 21))}, {}, ["float64", "complex"]),
        ({"s21": np.ones((5, 20)) * 1j}, {}, ["5 x 20", "frequency_hz 21"]),
        ({}, {"x": [0, 1]}, ["x is unknown", "x_m"]),
        ({}, {"x_m": {"start": 0, "step": 1, "count": 10**12}}, ["1000000"]),
        ({}, {"height_m": [0.1, 0.1]}, ["height_m", "one for each trace: 5"]),
        ({}, {"simulated": "no"}, ["true or false"]),
        ({"frequency_hz": np.arange(21.0) + 600}, {}, ["600", "1e+06"]),
        ({"x_m": np.array([0, 1, np.nan, 3, 4])}, {}, ["x_m", "nan"]),
        ({"x_m": np.zeros(5)}, {}, ["same position"]),
        ({**SCANS, "time_s": TIME_S**1.01}, {}, ["time_s", "equal steps"]),
        ({**SCANS, "time_s": TIME_S * 1e9}, {}, ["time_s", "0.0001"]),
        (SCANS, {"frequency_hz": [1e9, 2e9]}, ["frequency_hz", "--band"]),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, arrays, beside, shown):
    path, line = tmp_path / "d.npz", {**a_line(), **arrays}
    write_arrays(path, {key: one for key, one in line.items() if one is not None})
    if beside:
        describe(path, **beside)
    with raises_fault(CONTENT, "d.npz", *shown):
        read(path)


def test_a_damaged_type_of_numbers_in_a_matlab_file_does_not_end_the_program(tmp_path):
    path = tmp_path / "d.mat"
    write_arrays(path, a_line())
    content = bytearray(path.read_bytes())
    content[176] = 159  # of the first array's real parts
    path.write_bytes(content)
    with raises_fault(faults.FILE_DAMAGED, "d.mat"):
        read(path)


class Harmful:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def test_objects_are_refused_and_not_made(tmp_path):
    for ending in (".npz", ".npy"):
        path = tmp_path / f"d{ending}"
        write_arrays(path, {"s21": np.array([Harmful(tmp_path / "made")], object)})
        describe(path, s21="array" if ending == ".npy" else "s21")
        with raises_fault(faults.FILE_DAMAGED, path.name, "plain arrays"):
            read(path)
    assert not (tmp_path / "made").exists()


def test_headers_that_promise_more_than_there_is_take_no_memory(tmp_path):
    text = b"{'descr': '<c16', 'fortran_order': False, 'shape': (5, 1000000000000), }"
    header = b"\x93NUMPY\x01\x00\x76\x00" + text.ljust(0x75) + b"\n"
    (tmp_path / "d.npy").write_bytes(header)
    with zipfile.ZipFile(tmp_path / "d.npz", "w") as archive:
        archive.writestr("s21.npy", header)
    with h5py.File(tmp_path / "d.h5", "w") as file:
        file.create_dataset("s21", (5, 10**12), "c16", chunks=(1, 1000))
    for name in ("d.npy", "d.npz", "d.h5"):
        describe(tmp_path / name, s21="array" if name == "d.npy" else "s21")
        with raises_fault((faults.FILE_DAMAGED, faults.TOO_LARGE), name):
            read(tmp_path / name)


def test_a_list_of_traces_is_put_on_its_grid_in_any_order(tmp_path):
    path = tmp_path / "d.mat"
    random = np.random.default_rng(1)
    y_m, x_m = (one.ravel() for one in np.meshgrid([0.0, 0.1], [0.0, 0.02, 0.04]))
    shuffled = random.permutation(6)
    s21 = np.exp(1j * np.arange(6))[:, None] * np.ones(21)
    arrays = {"s21": s21, "x_m": x_m, "y_m": y_m, "height_m": 0.1 + x_m}
    arrays = {key: one[shuffled] for key, one in arrays.items()}
    write_arrays(path, {**arrays, "frequency_hz": FREQUENCY_HZ})
    found = read(path)
    np.testing.assert_allclose(
        found.s21.values[0, :, :, 3], np.exp(1j * np.arange(6)).reshape(3, 2).T
    )
    np.testing.assert_allclose(found.height.values[0], [[0.1, 0.12, 0.14]] * 2)


def test_an_array_in_other_units_has_a_factor(tmp_path):
    path, line = tmp_path / "d.h5", a_line()
    write_arrays(path, {**line, "g/mm": line["x_m"] * 1e3})
    describe(path, x_m={"array": "g/mm", "factor": "1e-3"})
    np.testing.assert_allclose(read(path).x, line["x_m"])
