"""Files of other instruments that are cut, damaged or hostile: refused, or still a survey."""

from __future__ import annotations

import os
import shutil
import tempfile
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from instruments_kit import (
    RICKER,
    SAMPLES,
    TRACES,
    counts,
    dzt_header,
    read,
    write_dt1,
    write_dzt,
    write_merged,
    write_rd3,
    write_segy,
    write_touchstone,
)

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.format import Band
from gpr20_analysis.processing.to_frequency import to_frequency

CONTENT = faults.FILE_CONTENT
EXAMPLES = int(os.environ.get("GPR20_HOSTILE_FILES", "100"))
MOST_BYTES = 64 << 20
SPECTRA = {"source": RICKER[1], "band": Band(1e9, 2e9, 11)}
# Format, name, writer, options, and the files that can be damaged.
KINDS = {
    "dzt": ("l.dzt", write_dzt, {}, ("l.dzt",)),
    "dt1": ("l.dt1", write_dt1, {}, ("l.dt1", "l.HD")),
    "rd3": ("l.rd3", write_rd3, {}, ("l.rd3", "l.rad")),
    "segy": ("l.sgy", write_segy, {}, ("l.sgy",)),
    "touchstone": ("t", write_touchstone, {}, ("t/X0_Y0.s2p", "t/X40_Y0.s2p")),
    "gprmax": ("m.h5", write_merged, SPECTRA, ("m.h5",)),
}
HEADERS = {"dzt": (0, 128), "segy": (3200, 3840), "dt1": (0, 128)}


def survey_or_refusal(folder, form, options):
    """Return the survey, in time and as spectra; None if it was refused as it should be."""
    tracemalloc.start()
    try:
        found = read(folder / KINDS[form][0], form, **options)
        if "a_scan" in found:
            to_frequency(found)
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
        return found
    except AnalysisError as error:
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
        assert str(error)
    finally:
        tracemalloc.stop()
    return None


@settings(max_examples=EXAMPLES, deadline=None)
@given(
    form=st.sampled_from(sorted(KINDS)),
    victim=st.integers(0, 1),
    place=st.floats(0.0, 1.0, exclude_max=True),
)
def test_a_file_that_was_cut_anywhere_is_refused(form, victim, place):
    name, write, options, victims = KINDS[form]
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / name)
        path = Path(folder) / victims[victim % len(victims)]
        content = path.read_bytes()
        path.write_bytes(content[: int(place * len(content))])
        found = survey_or_refusal(Path(folder), form, options)
    # What a cut leaves of lines of text may still say all; of samples, whole traces may be left.
    if found is not None:
        whole_traces = form in ("dzt", "segy")
        text = path.suffix.lower() in (".hd", ".rad", ".s2p")
        assert whole_traces or text


@settings(max_examples=EXAMPLES * 2, deadline=None)
@given(
    form=st.sampled_from(sorted(KINDS)),
    victim=st.integers(0, 1),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.integers(1, 255)), max_size=4
    ),
    in_header=st.booleans(),
)
def test_damaged_files_are_refused_or_still_a_survey(form, victim, changes, in_header):
    name, write, options, victims = KINDS[form]
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / name)
        path = Path(folder) / victims[victim % len(victims)]
        content = bytearray(path.read_bytes())
        first, last = HEADERS.get(form, (0, 0)) if in_header else (0, 0)
        last = min(last, len(content)) or len(content)
        for place, change in changes:
            content[first + int(place * (last - first))] ^= change
        path.write_bytes(content)
        found = survey_or_refusal(Path(folder), form, options)
    if found is not None:
        assert found.sizes["x"] * found.sizes["y"] <= 16 * TRACES * SAMPLES
        assert np.all(np.diff(found.x) > 0.0)


@settings(max_examples=EXAMPLES, deadline=None)
@given(
    form=st.sampled_from(sorted(HEADERS)), start=st.binary(max_size=200), more=st.integers(0, 5000)
)
def test_bytes_at_random_are_refused_or_a_survey(form, start, more):
    name, write, options, victims = KINDS[form]
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / name)
        path = Path(folder) / victims[0]
        kept = path.read_bytes()[: HEADERS[form][0]]
        path.write_bytes(kept + start + os.urandom(more))
        survey_or_refusal(Path(folder), form, options)


@pytest.mark.parametrize("form", sorted(KINDS))
@pytest.mark.parametrize("output", ["o.nc", "surveys"])
def test_nothing_is_imported_half(tmp_path, form, output):
    name, write, options, victims = KINDS[form]
    write(tmp_path / name)
    victim = tmp_path / victims[0]
    victim.write_bytes(victim.read_bytes()[:-1])
    if form == "touchstone":
        victim.write_bytes(victim.read_bytes()[: -victim.stat().st_size // 3])
    into = tmp_path / output
    into.mkdir() if output == "surveys" else into
    source = ["--source", options["source"]] if options else []
    command = ["import", str(tmp_path / name), str(into), "--format", form, *source]
    assert main(command) == 3
    left = sorted(tmp_path.rglob("*"))
    assert not (tmp_path / "o.nc").exists() and not any(one.suffix == ".tmp" for one in left)
    assert output == "o.nc" or not any(into.iterdir())


@pytest.mark.parametrize(
    ("header", "shown"),
    [
        ({"tag": 0x1234}, ["rh_tag"]),
        ({"range": 0.0}, ["rhf_range", "0.0"]),
        ({"range": np.nan}, ["rhf_range", "nan"]),
        ({"epsr": 0.5}, ["rhf_epsr", "0.5", "between 1"]),
        ({"epsr": np.nan}, ["rhf_epsr", "nan"]),
        ({"spm": -1e6}, ["rhf_spm"]),
        ({"spm": np.inf}, ["rhf_spm"]),
        ({"position": -1e30}, ["rhf_position"]),
        ({"position": -9.0}, ["time zero", "--time-zero"]),
    ],
)
def test_a_dzt_header_with_wrong_axes_is_refused(tmp_path, header, shown):
    write_dzt(tmp_path / "l.dzt", **header)
    with raises_fault(CONTENT, "l.dzt", *shown):
        read(tmp_path / "l.dzt", "dzt")


def test_a_dzt_header_with_wrong_counts_is_refused(tmp_path):
    path = tmp_path / "l.dzt"
    for samples, bits, channels, shown in (
        (0, 16, 1, "rh_nsamp"),
        (SAMPLES, 16, 0, "rh_nchan"),
        (SAMPLES, 16, 60000, "rh_nchan"),
    ):
        path.write_bytes(dzt_header(samples, bits, channels, data=1) + counts().tobytes())
        with raises_fault(CONTENT, shown):
            read(path, "dzt")
    content = bytearray(dzt_header())
    content[6] = 24
    path.write_bytes(content)
    with raises_fault(CONTENT, "rh_bits", "8, 16, 32"):
        read(path, "dzt")
    path.write_bytes(dzt_header(data=1000) + counts().tobytes())
    with raises_fault(faults.FILE_DAMAGED, "cut off"):
        read(path, "dzt")


def test_traces_that_were_taken_by_time_need_a_spacing(tmp_path):
    write_dzt(tmp_path / "l.dzt", spm=0.0)
    write_rd3(tmp_path / "l.rd3", **{"TIME FLAG": 1, "DISTANCE FLAG": 0})
    write_segy(tmp_path / "l.sgy", b73=0, b81=0)
    for name, form in (("l.dzt", "dzt"), ("l.rd3", "rd3"), ("l.sgy", "segy")):
        with raises_fault(faults.OPTION, name, "--spacing"):
            read(tmp_path / name, form)
        np.testing.assert_allclose(read(tmp_path / name, form, spacing_m=0.5).x, np.arange(6) / 2)
        for spacing_m in (0.0, -0.1, np.nan, np.inf):
            with raises_fault(CONTENT, "--spacing"):
                read(tmp_path / name, form, spacing_m=spacing_m)


@pytest.mark.parametrize(
    "x", [[0, 1, 1, 2, 3, 4], [0, 1, 0.5, 2, 3, 4], [5, 4, 4, 2, 1, 0], [0, 1, np.nan, 3, 4, 5]]
)
def test_places_that_turn_are_refused_with_the_way_out(tmp_path, x):
    write_dt1(tmp_path / "l.dt1", x=x)
    with raises_fault(faults.OPTION, "l.dt1", "trace", "--spacing"):
        read(tmp_path / "l.dt1", "dt1")
    assert read(tmp_path / "l.dt1", "dt1", spacing_m=0.1).sizes["x"] == TRACES


@pytest.mark.parametrize(
    ("write", "name", "entries", "shown"),
    [
        (write_dt1, "l.dt1", {"NUMBER OF TRACES": 5}, ["NUMBER OF TRACES", "6, as in l.dt1"]),
        (write_dt1, "l.dt1", {"NUMBER OF PTS/TRC": 41}, ["l.dt1", "cut off"]),
        (write_dt1, "l.dt1", {"TOTAL TIME WINDOW": "0"}, ["TOTAL TIME WINDOW"]),
        (write_dt1, "l.dt1", {"TOTAL TIME WINDOW": "abc"}, ["TOTAL TIME WINDOW", "abc"]),
        (write_dt1, "l.dt1", {"POSITION UNITS": "furlong"}, ["POSITION UNITS", "m or ft"]),
        (write_dt1, "l.dt1", {"ANTENNA SEPARATION": "30"}, ["--separation"]),
        (write_dt1, "l.dt1", {"NUMBER OF TRACES": "1e300"}, ["NUMBER OF TRACES"]),
        (write_rd3, "l.rd3", {"LAST TRACE": 7}, ["LAST TRACE", "6, as in l.rd3"]),
        (write_rd3, "l.rd3", {"SAMPLES": 0}, ["SAMPLES"]),
        (write_rd3, "l.rd3", {"NUMBER_OF_CH": 4}, ["NUMBER_OF_CH", "4"]),
        (write_rd3, "l.rd3", {"FREQUENCY": "nan"}, ["FREQUENCY"]),
        (write_rd3, "l.rd3", {"TIMEWINDOW": 16.0}, ["TIMEWINDOW"]),
        (write_rd3, "l.rd3", {"DISTANCE INTERVAL": -1}, ["DISTANCE INTERVAL"]),
    ],
)
def test_a_text_header_that_contradicts_its_file_is_refused(tmp_path, write, name, entries, shown):
    write(tmp_path / name, **entries)
    with pytest.raises(UnreadableFileError) as caught:
        read(tmp_path / name, Path(name).suffix[1:])
    for one in shown:
        assert one in str(caught.value)


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ({"b3221": 0}, ["number of samples"]),
        ({"b3225": 4}, ["format code"]),
        ({"b3501": 0x0100, "b3505": 0xFFFF}, ["extended headers", "-1"]),
        ({"b3221": SAMPLES - 1}, ["l.sgy"]),
        ({"b115": [SAMPLES, SAMPLES, 7, SAMPLES, SAMPLES, SAMPLES]}, ["number of samples", "7"]),
        ({"b3217": 0, "b117": 0}, ["sample interval"]),
        ({"b89": 2}, ["angles", "--spacing"]),
        ({"b117": [200, 200, 0, 300, 200, 200]}, ["300", "200 in all headers", "--interval"]),
        ({"b3217": 0, "b117": [200, 200, 0, 300, 200, 200]}, ["300", "200", "--interval"]),
        ({"b109": -5}, ["delay recording time", "-5", "--time-zero"]),
    ],
)
def test_a_segy_header_that_is_wrong_is_refused(tmp_path, more, shown):
    write_segy(tmp_path / "l.sgy", **more)
    with pytest.raises(AnalysisError) as caught:
        read(tmp_path / "l.sgy", "segy")
    for one in shown:
        assert one in str(caught.value)


def test_places_of_segy_that_form_no_grid_need_a_spacing(tmp_path):
    many = counts(8, traces=40)
    oblique = {key: 20 * np.arange(40) for key in ("b73", "b77", "b81", "b85")}
    write_segy(tmp_path / "l.sgy", values=many, **oblique)
    with raises_fault(faults.OPTION, "nor a grid", "--spacing"):
        read(tmp_path / "l.sgy", "segy")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (
            "# MHz S RI R 50\n1100 0 0 1 0 0 0 0 0\n1000 0 0 1 0 0 0 0 0\n",
            "frequency [Hz] is 1000000000",
        ),
        ("# MHz S RI R 50\n", "damaged"),
        ("# Hz S RI R 50\n1 0 0 1 0 0 0 0 0\n2 0 0 1 0 0 0 0 0\n", "first frequency"),
        ("# MHz S RI R 50\n1000 0 0 1 0 0 0 0 0\n1100 0 0 1\n", "damaged"),
        ("# MHz S RI R 50\n1000 0 0 1 0 0 0 0 0\n1200 0 0 1 0 0 0 0 0\n", "other frequencies"),
        ("no Touchstone file", "damaged"),
    ],
)
def test_a_touchstone_file_that_is_wrong_is_refused_by_its_name(tmp_path, text, shown):
    write_touchstone(tmp_path / "t", hz=np.array([1e9, 1.1e9]))
    (tmp_path / "t/X20_Y0.s2p").write_text(text)
    with pytest.raises(UnreadableFileError) as caught:
        read(tmp_path / "t", "touchstone")
    assert "X20_Y0.s2p" in str(caught.value) and shown in str(caught.value)


@pytest.mark.parametrize("ending", ["s1p", "s2p"])
@pytest.mark.parametrize(
    ("hz", "shown"),
    [
        (np.linspace(6e9, 6e8, 101), ["frequency [Hz] is 5946", "sort the lines"]),
        ([1e9, 2e9, 2e9], ["frequency [Hz] is 2000", "sort the lines"]),
        ([1e9, 2e9, 4e9], ["not evenly spaced"]),
    ],
)
def test_touchstone_frequencies_that_are_no_even_sweep_are_refused(tmp_path, ending, hz, shown):
    write_touchstone(tmp_path / "t", [f"X0.{ending}", f"X1.{ending}"], hz=np.array(hz))
    with raises_fault((CONTENT, faults.SWEEP), *shown):
        read(tmp_path / "t", "touchstone")


def test_a_folder_of_both_s11_and_s21_is_refused(tmp_path):
    write_touchstone(tmp_path / "t", ["X0.s1p", "X10.S2P", "X20.s1p"])
    with raises_fault(CONTENT, "S11", "S21", "another folder"):
        read(tmp_path / "t", "touchstone")


def test_two_traces_at_one_place_are_refused(tmp_path):
    write_touchstone(tmp_path / "t", ["a_X0_Y0.s2p", "b_X0_Y0.s2p", "c_X5_Y0.s2p"])
    with raises_fault((faults.OPTION, CONTENT)):
        read(tmp_path / "t", "touchstone")
    write_segy(tmp_path / "l.sgy", b73=[0, 0, 20, 20, 40, 40], b81=[0, 0, 20, 20, 40, 40])
    with raises_fault((faults.OPTION, CONTENT)):
        read(tmp_path / "l.sgy", "segy")


@pytest.mark.parametrize("form", ["dt1", "rd3"])
def test_a_file_without_its_partner_is_refused_with_the_name_of_it(tmp_path, form):
    name, write, _, victims = KINDS[form]
    write(tmp_path / name)
    (tmp_path / victims[1]).unlink()
    with raises_fault(faults.NO_INPUT, "beside it"):
        read(tmp_path / name, form)


def test_a_merged_file_that_contradicts_itself_is_refused(tmp_path):
    path = tmp_path / "m.h5"
    for damage in (
        lambda file: file.attrs.update(Iterations=7),
        lambda file: file.attrs.update(nrx=2),
        lambda file: [file["rxs/rx1"].pop(one) for one in ("Ex", "Ey")],
        lambda file: [
            file["rxs/rx1"][one].write_direct(np.zeros((400, 6))) for one in ("Ex", "Ey")
        ],
        lambda file: file["rxs/rx1/Ey"].write_direct(np.full((400, 6), np.nan)),
        lambda file: file.attrs.update(rxsteps=(np.nan, 0.0, 0.0)),
        lambda file: file.attrs.update(dt=np.nan),
    ):
        write_merged(path)
        with h5py.File(path, "r+") as file:
            damage(file)
        with raises_fault((CONTENT, faults.OPTION, faults.FILE_DAMAGED), "m.h5"):
            read(path, "gprmax", **SPECTRA)


def test_more_than_the_memory_holds_is_refused_before_it_is_read(tmp_path, monkeypatch):
    for form, (name, write, options, _) in KINDS.items():
        folder = tmp_path / form
        folder.mkdir()
        write(folder / name)
        with monkeypatch.context() as patch:
            patch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 1000)
            with raises_fault(faults.TOO_LARGE):
                read(folder / name, form, **options)
        shutil.rmtree(folder)


def test_traces_of_very_many_samples_take_no_more_memory_than_there_is(tmp_path, monkeypatch):
    write_dzt(tmp_path / "l.dzt", [counts(traces=1, samples=65000)], range=1000.0)
    found = read(tmp_path / "l.dzt", "dzt")
    monkeypatch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 1 << 30)
    with raises_fault(faults.TOO_LARGE):
        to_frequency(found)


def test_a_pipe_is_never_waited_for(tmp_path):
    for form, name in (("dzt", "l.dzt"), ("segy", "l.sgy")):
        os.mkfifo(tmp_path / name)
        output = str(tmp_path / "o.nc")
        assert main(["import", str(tmp_path / name), output, "--format", form]) == 3
