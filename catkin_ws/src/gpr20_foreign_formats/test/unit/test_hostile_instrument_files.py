"""Files of other instruments that are cut, damaged or hostile: refused, or still a survey."""

import os
import random
import tempfile
from functools import partial
from pathlib import Path

import h5py
import instruments_kit as kit
import numpy as np
from case_kit import each_case
from fault_kit import raises_fault
from group_kit import PLACES
from group_kit import write_merged as write_merged_of_group
from hypothesis import example, given, settings
from hypothesis import strategies as st
from memory_kit import peak_bytes
from run_seed import SEED, draws
from test_arrays_import import a_line, write_arrays

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.common import to_frequency
from gpr20_common.faults import NOT_ALLOWED

MOST_BYTES = 64 << 20
HEADERS = {"dzt": (0, 128), "segy": (3200, 3840), "dt1": (0, 128)}
ALL = {
    **kit.KINDS,
    "arrays": ("d.h5", partial(write_arrays, arrays=a_line()), {}, ["d.h5"]),
    "merged-hdf5": ("g.h5", partial(write_merged_of_group, samples=PLACES), {}, ["g.h5"]),
}
FORMS = st.sampled_from(sorted(ALL))
SHARE = st.floats(0.0, 1.0, exclude_max=True)


def survey_or_refusal(form, victim, change):
    """Change a file; return the survey that is read, or None if it was refused as it should be."""
    name, write, options, victims = ALL[form]
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / name)
        path = Path(folder) / victims[victim % len(victims)]
        path.write_bytes(change(path.read_bytes()))
        try:
            found = kit.read(Path(folder) / name, form, **options)
            if "a_scan" in found:
                to_frequency(found)
            return found
        except AnalysisError as error:
            assert str(error)
    return None


@settings(max_examples=draws(24))
@given(form=FORMS, victim=st.integers(0, 1), place=SHARE)
@example(form="dt1", victim=0, place=0.5)
def test_a_file_that_was_cut_anywhere_is_refused(form, victim, place):
    found = survey_or_refusal(form, victim, lambda whole: whole[: int(place * len(whole))])
    # What a cut leaves of lines of text may still say all; of samples, whole traces may be left.
    text = form == "touchstone" or (form in ("dt1", "rd3") and victim % 2)
    assert found is None or form in ("dzt", "segy") or text or "are stored" in str(found.attrs)


def read_damaged(count):
    chance = random.Random(SEED)
    for _ in range(count):
        form, in_header = chance.choice(sorted(ALL)), chance.random() < 0.5

        def change(whole, form=form, in_header=in_header):
            content = bytearray(whole)
            first, last = HEADERS.get(form, (0, 0)) if in_header else (0, 0)
            last = min(last, len(content)) or len(content)
            for _ in range(chance.randrange(5)):
                content[chance.randrange(first, last)] ^= chance.randrange(1, 256)
            return bytes(content)

        found = survey_or_refusal(form, chance.randrange(2), change)
        if found is not None:
            assert found.sizes["x"] * found.sizes["y"] <= 16 * kit.TRACES * kit.SAMPLES, form
            assert np.all(np.diff(found.x) > 0.0), form


def test_damaged_files_are_refused_or_still_a_survey_and_take_little_memory():
    assert peak_bytes(read_damaged, draws(24)) < MOST_BYTES


def touchstone(text):
    """Return a writer of a folder in which one file has another text."""

    def write(path):
        kit.write_touchstone(path, hz=np.array([1e9, 1.1e9]))
        (path / "X20_Y0.s2p").write_text(text)

    return write


def sweep(*hz):
    return lambda path: kit.write_touchstone(path, ["X0.s1p", "X1.s1p"], hz=np.array(hz))


def merged(damage):
    def write(path):
        kit.write_merged(path)
        with h5py.File(path, "r+") as file:
            damage(file)

    return write


def dzt_counts(**header):
    content = kit.channel_header(**{"data": 1, **header}) + kit.counts().tobytes()
    return lambda path: path.write_bytes(content)


LINE = "# MHz S RI R 50\n1000 0 0 1 0 0 0 0 0\n"
ROW = [kit.SAMPLES] * 6
WRONG = [
    ("l.dzt", partial(kit.write_dzt, tag=0x1234), ["rh_tag"]),
    ("l.dzt", partial(kit.write_dzt, epsr=0.5), ["rhf_epsr", "0.5", "between 1"]),
    ("l.dzt", partial(kit.write_dzt, spm=float("nan")), ["rhf_spm", "between -100000"]),
    ("l.dzt", partial(kit.write_dzt, position=-9.0), ["time zero", "--time-zero"]),
    ("l.dzt", dzt_counts(channels=60000), ["rh_nchan"]),
    ("l.dzt", dzt_counts(data=1000), ["cut off"]),
    ("l.dt1", partial(kit.write_dt1, x=[0, 1, 0.5, 2, 3, 4]), ["trace", "--spacing"]),
    (
        "l.dt1",
        partial(kit.write_dt1, **{"POSITION UNITS": "furlong"}),
        ["POSITION UNITS", "m or ft"],
    ),
    ("l.rd3", partial(kit.write_rd3, **{"TIMEWINDOW": 16.0}), ["TIMEWINDOW"]),
    ("l.sgy", partial(kit.write_segy, b3501=0x0100, b3505=0xFFFF), ["extended headers", "-1"]),
    ("l.sgy", partial(kit.write_segy, b115=[*ROW[:2], 7, *ROW[3:]]), ["number of samples", "7"]),
    ("l.sgy", partial(kit.write_segy, b89=2), ["angles", "--spacing"]),
    (
        "l.sgy",
        partial(kit.write_segy, b117=[200, 200, 0, 300, 200, 200]),
        ["300", "200", "--interval"],
    ),
    ("l.sgy", partial(kit.write_segy, b73=[0, 0, 20, 20, 40, 40], b81=[0, 0, 20, 20, 40, 40]), []),
    (
        "t",
        touchstone("# Hz S RI R 50\n1 0 0 1 0 0 0 0 0\n2 0 0 1 0 0 0 0 0\n"),
        ["frequency [Hz] is 1.0"],
    ),
    ("t", touchstone(LINE + "1200 0 0 1 0 0 0 0 0\n"), ["X20_Y0.s2p", "other frequencies"]),
    ("t", touchstone("no Touchstone file"), ["X20_Y0.s2p", "kind Touchstone"]),
    ("t", sweep(3e9, 2e9, 1e9), ["sort the lines"]),
    ("t", sweep(1e9, 2e9, 4e9), ["not evenly spaced"]),
    ("t", lambda path: path.mkdir(), ["contains no files *.s1p, *.s2p"]),
    (
        "t",
        partial(kit.write_touchstone, names=["X0.s1p", "X10.S2P"]),
        ["S11", "S21", "another folder"],
    ),
    ("m.h5", merged(lambda file: file.attrs.update(rxsteps=(np.nan, 0.0, 0.0))), ["m.h5"]),
    ("m.h5", merged(lambda f: f["rxs/rx1/Ey"].write_direct(np.full((400, 6), np.nan))), ["m.h5"]),
    ("m.h5", merged(lambda f: [f["rxs/rx1"].pop(f"E{one}") for one in "xyz"]), ["m.h5"]),
]


@each_case("name, write, shown", WRONG)
def test_a_file_that_is_wrong_is_refused_with_the_value(tmp_path_factory, name, write, shown):
    tmp_path = tmp_path_factory.mktemp("wrong")
    (form,) = (one for one, kind in kit.KINDS.items() if kind[0] == name)
    write(tmp_path / name)
    codes = (errors.INPUT, NOT_ALLOWED, errors.FILE_DAMAGED, errors.INPUT)
    with raises_fault(codes, *shown, error=AnalysisError):
        kit.read(tmp_path / name, form, **kit.KINDS[form][2])


def test_traces_that_were_taken_by_time_or_turn_need_a_spacing(tmp_path):
    kit.write_dzt(tmp_path / "l.dzt", spm=0.0)
    kit.write_rd3(tmp_path / "l.rd3", **{"TIME FLAG": 1, "DISTANCE FLAG": 0})
    kit.write_segy(tmp_path / "l.sgy", b73=0, b81=0)
    kit.write_dt1(tmp_path / "l.dt1", x=[0, 1, 1, 2, 3, 4])
    for form in ("dzt", "rd3", "segy", "dt1"):
        path = tmp_path / kit.KINDS[form][0]
        with raises_fault(NOT_ALLOWED, path.name, "--spacing"):
            kit.read(path, form)
        np.testing.assert_allclose(kit.read(path, form, spacing_m=0.5).x, np.arange(6) / 2)
        for spacing_m in (0.0, -0.1, np.nan, np.inf):
            with raises_fault(errors.INPUT, "--spacing"):
                kit.read(path, form, spacing_m=spacing_m)


@each_case("form", sorted(kit.KINDS))
def test_more_than_the_memory_holds_is_refused_before_it_is_read(tmp_path, monkeypatch, form):
    name, write, options, _ = kit.KINDS[form]
    write(tmp_path / name)
    monkeypatch.setattr("gpr20_analysis.work.available_bytes", lambda: 1000)
    with raises_fault(errors.TOO_LARGE):
        kit.read(tmp_path / name, form, **options)


def test_a_pipe_is_never_waited_for(tmp_path):
    for form, name in (("dzt", "l.dzt"), ("segy", "l.sgy")):
        os.mkfifo(tmp_path / name)
        output = str(tmp_path / "o.nc")
        assert main(["import", str(tmp_path / name), output, "--format", form]) == 3
