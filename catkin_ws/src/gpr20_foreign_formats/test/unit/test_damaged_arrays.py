"""Arrays that are damaged or contradict their axes are refused with the value and the way out."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from arrays_kit import ENDINGS, TIME_S, a_line, describe, read, write_arrays
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError

CONTENT = faults.FILE_CONTENT
AXES = ("rotation_deg", "y_m", "x_m", "frequency_hz")
STEPS = {"rotation_deg": 30.0, "y_m": 0.1, "x_m": 0.02, "frequency_hz": 1e8}


@settings(max_examples=60, deadline=None)
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


@settings(max_examples=120, deadline=None)
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


@settings(max_examples=60, deadline=None)
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


@pytest.mark.parametrize(
    ("arrays", "beside", "shown"),
    [
        ({"x_m": None}, {}, ["x_m", "missing"]),
        ({"s21": None}, {}, ["s21", "a_scans"]),
        ({"a_scans": np.ones((5, 21))}, {}, ["a_scans, s21"]),
        ({"s21": np.ones((5, 21))}, {}, ["float64", "complex"]),
        ({"s21": np.ones((5, 20)) * 1j}, {}, ["5 x 20", "frequency_hz 21"]),
        ({}, {"s21": "other"}, ["other"]),
        ({}, {"x": [0, 1]}, ["x is unknown", "x_m"]),
        ({}, {"x_m": [0, 1, 2]}, ["x_m 3"]),
        ({}, {"x_m": {"start": 0, "step": 1, "count": 10**12}}, ["1000000"]),
        ({}, {"x_m": {"start": 0, "stop": 1}}, ["stop"]),
        ({}, {"x_m": "position"}, ["position", "real array"]),
        ({}, {"dims": ["x_m"]}, ["dims", "0 orders"]),
        ({}, {"height_m": [0.1, 0.1]}, ["height_m", "one for each trace: 5"]),
        ({}, {"height_m": 11}, ["11", "between 0 and 10"]),
        ({}, {"delay_s": 1.0}, ["1e-07"]),
        ({}, {"delay_s": [0.0, 0.0]}, ["delay_s", "a number"]),
        ({}, {"x_m": [False, True, True, True, True]}, ["x_m", "a number"]),
        ({}, {"simulated": "no"}, ["true or false"]),
        ({"frequency_hz": np.arange(21.0) + 600}, {}, ["600", "1e+06"]),
        ({"frequency_hz": np.full(21, 1e9)}, {}, ["frequency_hz", "ascend"]),
        ({"x_m": np.array([0, 1, np.nan, 3, 4])}, {}, ["x_m", "nan"]),
        ({"x_m": np.arange(5) * 1j}, {}, ["complex128"]),
        ({"x_m": np.zeros(5)}, {}, ["same position"]),
        ({"x_m": np.array(list("abcde"))}, {}, ["<U1"]),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, arrays, beside, shown):
    path, line = tmp_path / "d.npz", {**a_line(), **arrays}
    write_arrays(path, {key: one for key, one in line.items() if one is not None})
    if beside:
        describe(path, **beside)
    with raises_fault(CONTENT, "d.npz", *shown):
        read(path)


@pytest.mark.parametrize(
    ("time_s", "more", "shown"),
    [
        (TIME_S**1.01, {}, ["time_s", "equal steps"]),
        (TIME_S * 1e9, {}, ["time_s", "0.0001"]),
        (TIME_S, {"frequency_hz": [1e9, 21e9]}, ["2.1e+10", "below 2e+10"]),
        (TIME_S, {"a_scans": np.ones((5, 200)) * 1j}, ["complex128", "a_scans"]),
    ],
)
def test_a_scans_need_even_times_and_frequencies_that_they_hold(tmp_path, time_s, more, shown):
    path = tmp_path / "d.npz"
    arrays = {"a_scans": np.ones((5, 200)), "x_m": np.arange(5.0), "time_s": time_s, **more}
    write_arrays(path, arrays)
    with raises_fault(CONTENT, *shown):
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


def test_an_archive_that_unpacks_to_more_than_the_memory_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "d.npz"
    np.savez_compressed(path, s21=np.zeros((5, 100_000), complex))
    monkeypatch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 1 << 20)
    assert path.stat().st_size < 1 << 20
    with raises_fault(faults.TOO_LARGE, "d.npz"):
        read(path)
