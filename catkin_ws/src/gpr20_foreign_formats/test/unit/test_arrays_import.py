"""Plain arrays with documented names become surveys; damaged ones are refused with the way out."""

import tempfile
import zipfile
from pathlib import Path

import h5py
import numpy as np
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from instruments_kit import read
from run_seed import draws
from scipy.io import savemat

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey

FREQUENCY_HZ = np.linspace(1e9, 2e9, 21)
TIME_S = np.arange(200) * 25e-12
PULSE = np.exp(-(((TIME_S - 2e-9) * 3e9) ** 2)) * np.cos(2 * np.pi * 1.5e9 * TIME_S)
ENDINGS = (".npz", ".v73.mat", ".h5")
AXES = {"rotation_deg": 30.0, "y_m": 0.1, "x_m": 0.02, "frequency_hz": 1e8}


def write_arrays(path, arrays):
    if path.suffix == ".npz":
        np.savez(path, **arrays)
        return
    is_matlab = path.suffix == ".mat"
    with h5py.File(path, "w", userblock_size=512 if is_matlab else 0) as file:
        for name, values in arrays.items():
            stored = np.atleast_2d(values).T if is_matlab else np.asarray(values)
            if is_matlab and np.iscomplexobj(stored):
                pairs = np.empty(stored.shape, [("real", "f8"), ("imag", "f8")])
                pairs["real"], pairs["imag"] = stored.real, stored.imag
                stored = pairs
            file[name] = stored
            if is_matlab:
                file[name].attrs["MATLAB_class"] = np.bytes_("double")


def a_line(count=5):
    random = np.random.default_rng(3)
    s21 = random.standard_normal((count, 21)) + 1j * random.standard_normal((count, 21))
    return {"s21": s21, "x_m": np.arange(count) * 0.02, "frequency_hz": FREQUENCY_HZ}


@settings(max_examples=draws(12))
@given(
    sizes=st.tuples(*[st.integers(1, 4)] * 3, st.integers(2, 5)),
    ending=st.sampled_from(ENDINGS),
    as_list=st.booleans(),
)
def test_a_grid_or_a_list_of_traces_is_put_on_its_grid(sizes, ending, as_list):
    random = np.random.default_rng(sizes)
    s21 = random.standard_normal(sizes) + 1j * random.standard_normal(sizes)
    axes = [(np.arange(size) + 1.0) * step for size, step in zip(sizes, AXES.values())]
    arrays, heights_m = dict(zip(AXES, axes)), random.uniform(0.1, 0.4, sizes[:3])
    stored, order = s21, np.arange(heights_m.size)
    if as_list:
        order = random.permutation(order)
        places = [one.ravel()[order] for one in np.meshgrid(*axes[:3], indexing="ij")]
        arrays.update(zip(AXES, places))
        stored = s21.reshape(-1, sizes[3])[order]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"d{ending}"
        height_m = heights_m.ravel()[order] if as_list else heights_m
        write_arrays(path, {"s21": stored, "height_m": height_m, **arrays, "delay_s": 1e-9})
        found = read(path, "arrays")
        given_m = read(path, "arrays", height_m=0.3).height
    np.testing.assert_array_equal(found.s21.values, s21)
    np.testing.assert_array_equal(found.height.values, heights_m)
    for name, axis in zip(found.s21.dims, axes):
        np.testing.assert_allclose(found[name], axis)
    assert found.attrs["antenna_delay_s"] == 1e-9 and (given_m == 0.3).all()
    assert "simulated" not in found.attrs and found.attrs["notes"] == []


@each_case("band", [[], ["--band", "1e9", "2e9", "21"]])
def test_a_scans_become_spectra_at_the_frequencies_that_are_given(tmp_path, band):
    path, output = tmp_path / "d.npz", tmp_path / "o.nc"
    scans = np.tile(PULSE + 0.25, (3, 1))
    write_arrays(path, {"a_scans": scans, "x_m": [0.0, 0.1, 0.2], "time_s": TIME_S})
    command = ["import", str(path), str(output), "--format", "arrays", "--overwrite"]
    assert main([*command, *band]) == 0
    found = load_survey(output)
    assert "antenna_delay_s" not in found.attrs
    for note in ("has no delay_s: its time zero", "no rotation_deg: 0 is assumed", "no y_m"):
        assert note in str(found.attrs["notes"])
    turns = np.exp(-2j * np.pi * np.outer(TIME_S, found.frequency.values))
    ratio = found.s21.values[0, 0] / (scans @ turns)
    # Nothing is removed from them silently, such as their mean.
    np.testing.assert_allclose(ratio, abs(ratio[0, 0]), rtol=1e-6)
    assert not band or found.frequency.values.tolist() == FREQUENCY_HZ.tolist()


def test_samples_of_nan_are_missing_or_damaged(tmp_path):
    path, line = tmp_path / "d.npz", a_line()
    line["s21"][1], line["s21"][2, 4] = np.nan, np.inf
    write_arrays(path, line)
    found = read(path, "arrays")
    assert (found.quality.values.ravel() & 3).tolist() == [0, 1, 2, 0, 0]
    assert len(found.attrs["missing"]) == 2 and len(found.attrs["faults"]) == 1


SCANS = {"a_scans": np.ones((5, 200)), "time_s": TIME_S, "s21": None, "frequency_hz": None}


@each_case(
    "arrays, shown",
    [
        ({"a_scans": np.ones((5, 21))}, ["its data is s21, a_scans", "one complex array s21"]),
        ({"s21": np.ones((5, 21))}, ["float64", "complex"]),
        ({"s21": np.ones((21, 5)) * 1j}, ["21 x 5", "5 x 21 (x_m, frequency_hz)", "transpose"]),
        ({"x_m": None}, ["x_m is missing"]),
        ({"height_m": [0.1, 0.1]}, ["height_m", "one for each trace: 5"]),
        ({"frequency_hz": np.arange(21.0) + 600}, ["600", "1e+06"]),
        ({"frequency_hz": FREQUENCY_HZ[::-1]}, ["two or more that ascend"]),
        ({"x_m": np.array([0, 1, np.nan, 3, 4])}, ["x_m", "nan"]),
        ({"x_m": np.zeros(5)}, ["same position"]),
        ({**SCANS, "time_s": TIME_S**1.01}, ["time_s", "equal steps"]),
        ({**SCANS, "time_s": TIME_S * 1e9}, ["time_s", "0.0001"]),
        ({"delay_s": "late"}, ["delay_s"]),
        ({"s21": np.zeros((5, 21), complex)}, ["no sample other than 0"]),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, arrays, shown):
    path, line = tmp_path / "d.npz", {**a_line(), **arrays}
    write_arrays(path, {key: one for key, one in line.items() if one is not None})
    with raises_fault(errors.INPUT, "d.npz", *shown):
        read(path, "arrays")


class Harmful:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def test_what_is_not_read_safely_is_refused(tmp_path):
    write_arrays(tmp_path / "o.npz", {"s21": np.array([Harmful(tmp_path / "made")], object)})
    with raises_fault(errors.FILE_DAMAGED, "o.npz", "plain arrays"):
        read(tmp_path / "o.npz", "arrays")
    assert not (tmp_path / "made").exists()
    savemat(tmp_path / "old.mat", a_line())
    with raises_fault(errors.INPUT, "old.mat", "-v7.3"):
        read(tmp_path / "old.mat", "arrays")
    text = b"{'descr': '<c16', 'fortran_order': False, 'shape': (5, 1000000000000), }"
    with zipfile.ZipFile(tmp_path / "large.npz", "w") as archive:
        archive.writestr("s21.npy", b"\x93NUMPY\x01\x00\x76\x00" + text.ljust(0x75) + b"\n")
    with h5py.File(tmp_path / "large.h5", "w") as file:
        file.create_dataset("s21", (5, 10**12), "c16", chunks=(1, 1000))
    for name in ("large.npz", "large.h5"):
        with raises_fault((errors.FILE_DAMAGED, errors.TOO_LARGE), name):
            read(tmp_path / name, "arrays")
