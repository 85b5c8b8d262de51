"""Surveys too large for the memory are lazy, and a cluster gives the same results."""

from __future__ import annotations

import dask.array
import numpy as np
import pytest
from distributed import LocalCluster
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.mid.dataset_files import write_dataset
from gpr20_analysis.mid.formats.imported import Imported, as_dataset
from gpr20_analysis.mid.loading import load_survey

ALL = len(POINTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as running:
        yield running


@pytest.mark.parametrize("name", [".", "traces", "survey.bag", "survey.mcap"])
def test_a_lazy_survey_holds_the_same(folder, name):
    lazy = load_survey(folder / name, lazy_bytes=0)
    assert isinstance(lazy.s21.data, dask.array.Array)
    assert lazy.compute().identical(load_survey(folder / name))


def test_a_lazy_survey_with_missing_samples_holds_the_same(tmp_path):
    folder = make_survey(tmp_path, ALL - 5, "stopped")
    for place in (folder, folder / "traces"):
        assert load_survey(place, lazy_bytes=0).compute().identical(load_survey(place))


def test_only_the_chunk_that_is_looked_at_is_read(folder):
    lazy = load_survey(folder, lazy_bytes=0)
    assert lazy.s21.data.chunks[0] == (1, 1)
    one = lazy.s21.isel(polarization=1, y=0, x=2).values
    np.testing.assert_array_equal(one, load_survey(folder).s21.values[1, 0, 2])


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_a_lazy_survey_is_written_as_it_is(folder, tmp_path, ending):
    path = tmp_path / f"s.{ending}"
    write_dataset(load_survey(folder, lazy_bytes=0), path)
    assert load_survey(path).identical(load_survey(folder))


def test_the_temporary_file_goes_with_the_survey(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    lazy = load_survey(folder, lazy_bytes=0)
    assert list(tmp_path.iterdir())
    del lazy
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def ground(tmp_path_factory):
    path = tmp_path_factory.mktemp("ground") / "ground.nc"
    frequency_hz = np.linspace(1e9, 5e9, 81)
    noise = np.random.default_rng(6).standard_normal((2, 2, 6, 7, 81))
    found = Imported(
        noise[0] + 1j * noise[1], [0.0, 90.0], np.arange(6) * 0.02, np.arange(7) * 0.02,
        np.full((2, 6, 7), 0.2), "noise", frequency_hz=frequency_hz,
    )  # fmt: skip
    write_dataset(as_dataset(found), path)
    return path


@pytest.mark.parametrize("method", ["phase-shift", "back-projection", "kirchhoff"])
def test_two_workers_make_the_same_image(ground, tmp_path, cluster, method):
    options = ["--permittivity", "4", "--depth", "0", "0.05", "0.01", "--method", method]
    here, there = tmp_path / "here.nc", tmp_path / "there.nc"
    assert main(["image", str(ground), *options, "-o", str(here)]) == 0
    address = ["--scheduler", cluster.scheduler_address]
    assert main(["image", str(ground), *options, *address, "-o", str(there)]) == 0
    expected, found = load_survey(here), load_survey(there)
    assert np.isfinite(expected.image.values).all()
    assert found.attrs == expected.attrs
    np.testing.assert_array_equal(found.image.values, expected.image.values)


@pytest.mark.parametrize("method", ["phase-shift", "back-projection", "kirchhoff"])
def test_one_polarization_is_work_for_both_workers(ground, tmp_path, cluster, method):
    from distributed import Client, get_task_stream

    options = ["--permittivity", "4", "--depth", "0", "0.05", "0.01", "--method", method]
    options += ["--step", "polarization:rotation_deg=0", "-o", str(tmp_path / "i.nc")]
    address = cluster.scheduler_address
    with Client(address) as watcher, get_task_stream(client=watcher) as done:
        assert main(["image", str(ground), *options, "--scheduler", address]) == 0
    assert len({task["worker"] for task in done.data}) == 2


def test_an_image_deeper_than_the_frequencies_can_tell_is_refused(folder, capsys):
    assert main(["image", str(folder), "--permittivity", "4"]) == 3
    assert "measure with more points" in capsys.readouterr().err


def test_lazy_numbers_are_computed_by_the_workers(folder, cluster):
    from distributed import Client

    lazy = load_survey(folder, lazy_bytes=0)
    with Client(cluster.scheduler_address):
        mean = lazy.s21.mean(["x", "y"]).values
    np.testing.assert_allclose(mean, load_survey(folder).s21.mean(["x", "y"]).values)


def test_an_address_where_nobody_answers_is_told(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("gpr20_analysis.commands.scheduler.TIME_LIMIT_S", 0.5)
    arguments = ["image", str(folder), "--permittivity", "4", "--scheduler", "tcp://127.0.0.1:9"]
    assert main([*arguments, "-o", str(tmp_path / "i.nc")]) == 3
    assert "tcp://127.0.0.1:9" in capsys.readouterr().err
