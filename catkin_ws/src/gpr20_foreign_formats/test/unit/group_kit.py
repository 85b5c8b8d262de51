"""The files of the GPR-20 group and of the original project, as their guides describe them."""

import json
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import h5py
import numpy as np

from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.imported_folder import DECISION_FORMAT

HZ = np.linspace(600e6, 6e9, 7)
HEADERS = {"VNA": "S21_real,S21_imag", "TIME": "A-Scan_real,A-Scan_imag"}
LETTERS = {0.0: "X", 90.0: "Y"}
PLACES = {
    (x, y, 0.0): (0.25, (np.arange(7) * (0.01 + 0.001j * x) + y + 1j) / 30.0)
    for x in (0, 20)
    for y in (0, 15)
}
KEYS = ("freq_value", "real_value", "imaginary_value")


def survey(seed=0, turns=(0.0, 90.0), hz=HZ):
    """Return the height [m] and spectrum of each place: x [mm], y [mm], rotation [deg]."""
    rng = np.random.default_rng(seed)
    x_mm, y_mm = (np.cumsum(rng.integers(2, 60, rng.integers(2, 5))) for _ in "xy")
    parts = rng.standard_normal((2, len(x_mm), len(y_mm), len(turns), len(hz))) * 0.1
    heights_m = rng.integers(100, 400, parts.shape[1:4]) / 1e3
    return {
        (int(x), int(y), turn): (heights_m[place], parts[0][place] + 1j * parts[1][place])
        for column, x in enumerate(x_mm)
        for row, y in enumerate(y_mm)
        for number, turn in enumerate(turns)
        for place in [(column, row, number)]
    }


def write_csv(folder, samples, kind="VNA", ends="Fs600M_Fe6000M", change=str):
    folder.mkdir(exist_ok=True)
    for (x, y, turn), (height_m, values) in samples.items():
        axis = f"{ends}_Q{'f' if kind == 'VNA' else 't'}{len(values)}"
        name = f"{kind}_X{x}_Y{y}_Or{LETTERS[turn]}_{axis}_H{height_m * 1e3:g}.csv"
        lines = [f"{one.real!r},{one.imag!r}" for one in values.tolist()]
        (folder / name).write_text(change("\n".join([HEADERS[kind], *lines, ""])))
    return folder


def originals(samples, hz=HZ, **other):
    """Return the samples of the original project by the names of their files."""
    return {
        f"X{x:06.2f}_Y{y:06.2f}_Z{turn:06.2f}.json": {
            **{"x_coord": x, "y_coord": y, "z_coord": turn, "antennae_height": height_m},
            **{
                "timestamp": f"2021101508{number:04d}",
                "survey_id": "6d0c",
                "sample_id": f"{x} {y}",
            },
            "data": [
                dict(zip(KEYS, row))
                for row in np.column_stack([hz, values.real, values.imag]).tolist()
            ],
            **other,
        }
        for number, ((x, y, turn), (height_m, values)) in enumerate(samples.items())
    }


def write_originals(folder, found):
    folder.mkdir(exist_ok=True)
    for name, sample in found.items():
        (folder / name).write_text(json.dumps(sample, indent=4))
    return folder


def write_merged(path, samples, group="Frequency", axis=HZ / 1e6, heights=True, as_matlab=False):
    """Write a whole grid with even steps; scans are ordered by x, then y."""
    xs, ys, turns = (sorted({place[one] for place in samples}) for one in range(3))
    names = {"Frequency": ("f0", "ff", "df", "S21"), "Time": ("t0", "tf", "dt", "A-Scan")}[group]
    with h5py.File(path, "w") as file:
        file.attrs.update({"Title": "t", "Total Amount of A-Scans": len(samples)})
        ends = {names[0]: axis[0], names[1]: axis[-1], names[2]: axis[1] - axis[0], "q": len(axis)}
        file.create_group(group).attrs.update(ends)
        place = file.create_group("Position")
        for letter, own in (("x", xs), ("y", ys)):
            step = (own[1] - own[0]) / 1e3 if len(own) > 1 else 0.0
            place.attrs.update({f"{letter}0": own[0] / 1e3, f"{letter}f": own[-1] / 1e3})
            place.attrs[f"d{letter}"] = step
        for turn in turns:
            pol = f"{LETTERS[turn].lower()}-pol"
            own = [samples[x, y, turn] for x in xs for y in ys]
            if heights:
                place[f"h {pol}"] = np.array([[height_m for height_m, _ in own]])
            values = np.array([one for _, one in own])
            for word, part in (("Re", values.real), ("Im", values.imag)):
                stored = part.astype(np.float32)
                file[f"A-Scan/{word}{{{names[3]} {pol}}}"] = stored.T if as_matlab else stored
    return path


def even(samples):
    """Return samples at even places, in the same order."""
    xs, ys = (sorted({place[one] for place in samples}) for one in (0, 1))
    return {
        (20 * xs.index(x), 15 * ys.index(y), turn): one for (x, y, turn), one in samples.items()
    }


def run(*arguments):
    """Return the exit status of `gpr20` and what it printed."""
    printed = StringIO()
    with redirect_stdout(printed), redirect_stderr(printed):
        status = main([*map(str, arguments)])
    return status, " ".join(printed.getvalue().split())


def imported(source, form, data, *options):
    """Import into a survey's folder, and return that."""
    status, printed = run("import", source, data, "--format", form, *options)
    assert status in (0, 1), printed
    (folder,) = (one for one in data.iterdir() if not one.name.startswith("."))
    return folder


def decisions_of(folder):
    lines = map(json.loads, (folder / "log.jsonl").read_text("ascii").splitlines())
    values = [one["values"] for one in lines if one["kind"] == "decision"]
    assert all(one["format"] == DECISION_FORMAT for one in values)
    return [one["text"] for one in values]
