"""Files of plain arrays, as other programs write them."""

import h5py
import numpy as np
import yaml
from scipy.io import savemat

from gpr20_analysis.formats.imports import ImportOptions
from gpr20_analysis.work import no_progress
from gpr20_foreign_formats.arrays import read_arrays

FREQUENCY_HZ = np.linspace(1e9, 2e9, 21)
TIME_S = np.arange(200) * 25e-12
ENDINGS = (".npz", ".mat", ".v7.mat", ".v73.mat", ".h5")


def write_arrays(path, arrays):
    if path.name.endswith(".v73.mat"):
        _write_matlab_73(path, arrays)
    elif path.suffix == ".npz":
        np.savez(path, **arrays)
    elif path.suffix == ".npy":
        np.save(path, *arrays.values())
    elif path.suffix == ".mat":
        savemat(path, {**arrays, "text": "no numbers"}, do_compression=path.stem.endswith("7"))
    else:
        with h5py.File(path, "w") as file:
            for name, values in arrays.items():
                file[name] = values


def _write_matlab_73(path, arrays):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in arrays.items():
            stored = np.atleast_2d(values).T
            if np.iscomplexobj(stored):
                pairs = np.empty(stored.shape, [("real", "f8"), ("imag", "f8")])
                pairs["real"], pairs["imag"] = stored.real, stored.imag
                stored = pairs
            file[name] = stored
            file[name].attrs["MATLAB_class"] = np.bytes_("double")


def describe(path, **keys):
    path.with_suffix(".axes.yaml").write_text(yaml.safe_dump(keys))


def read(path, **options):
    return read_arrays(path, ImportOptions(**options), no_progress)


def a_line(count=5):
    random = np.random.default_rng(3)
    s21 = random.standard_normal((count, 21)) + 1j * random.standard_normal((count, 21))
    return {"s21": s21, "x_m": np.arange(count) * 0.02, "frequency_hz": FREQUENCY_HZ}
