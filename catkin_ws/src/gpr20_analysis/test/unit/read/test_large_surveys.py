"""Surveys too large for the memory are lazy."""

from __future__ import annotations

import dask.array
import numpy as np
import pytest
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.lazy import available_bytes
from gpr20_analysis.processing.chain import apply_steps, step_from_text
from gpr20_analysis.read.load import load_survey

ALL = len(POINTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


def test_a_lazy_survey_holds_the_same_from_every_source(folder, tmp_path):
    for name in (".", "traces", "survey.bag", "survey.mcap"):
        lazy = load_survey(folder / name, lazy_bytes=0)
        assert isinstance(lazy.s21.data, dask.array.Array), name
        assert lazy.compute().identical(load_survey(folder / name)), name
    with_holes = make_survey(tmp_path, ALL - 5, "stopped")
    for place in (with_holes, with_holes / "traces"):
        assert load_survey(place, lazy_bytes=0).compute().identical(load_survey(place)), place


def test_only_the_chunk_that_is_looked_at_is_read(folder):
    lazy = load_survey(folder, lazy_bytes=0)
    assert lazy.s21.data.chunks[0] == (1, 1)
    one = lazy.s21.isel(polarization=1, y=0, x=2).values
    np.testing.assert_array_equal(one, load_survey(folder).s21.values[1, 0, 2])


def test_a_lazy_survey_is_written_as_it_is(folder, tmp_path):
    for name in ("s.nc", "s.zarr"):
        write_dataset(load_survey(folder, lazy_bytes=0), tmp_path / name)
        assert load_survey(tmp_path / name).identical(load_survey(folder)), name


def test_the_temporary_file_goes_with_the_survey(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    lazy = load_survey(folder, lazy_bytes=0)
    assert list(tmp_path.iterdir())
    del lazy
    assert not list(tmp_path.iterdir())


def test_an_image_deeper_than_the_frequencies_can_tell_is_refused(folder, refusals):
    assert main(["image", str(folder), "--permittivity", "4"]) == 3
    assert refusals[-1:] == [faults.TOO_DEEP.code]


@pytest.mark.parametrize("steps", [["window"], ["window", "time", "gain:method=agc"]])
@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_a_lazy_dataset_holds_the_same_and_goes_through_steps_to_a_file(
    folder, tmp_path, ending, steps
):
    first, second, third = (tmp_path / f"{name}.{ending}" for name in ("first", "second", "third"))
    # Through a file too: it describes its variables, some of whose attributes old xarray drops.
    write_dataset(
        apply_steps(load_survey(folder), [step_from_text(one) for one in steps], None), third
    )
    expected = load_survey(third)
    write_dataset(load_survey(folder), first)
    lazy = load_survey(first, lazy_bytes=0)
    assert isinstance(lazy.s21.data, dask.array.Array)
    assert lazy.compute().identical(load_survey(folder))
    write_dataset(apply_steps(lazy, [step_from_text(one) for one in steps], None), second)
    found = load_survey(second, lazy_bytes=0)
    assert found.chunks
    assert found.compute().identical(expected)


def test_an_image_of_more_than_the_memory_is_refused_before_it_is_loaded(folder, monkeypatch):
    monkeypatch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 1000)
    options = ImageOptions(permittivity=4.0, height_m=0.2)
    with raises_fault(faults.TOO_LARGE):
        image_survey(load_survey(folder, lazy_bytes=0), options)


def test_the_memory_that_is_free_is_at_most_the_limit_of_the_process(monkeypatch):
    free = available_bytes()
    assert free > 1 << 20
    monkeypatch.setattr("resource.getrlimit", lambda kind: (4096, 4096))
    assert available_bytes() == 4096
