"""A cluster of two workers gives the results of this process, and both of them work."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr
from distributed import Client, LocalCluster, get_task_stream
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.common import Imported, as_dataset
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.read.load import load_survey

pytestmark = pytest.mark.real_time

ALL = len(POINTS)
CHAIN = ["background:method=median", "time_zero", "fill", "window"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as running:
        yield running


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


@pytest.mark.parametrize("method", ["phase-shift", "back-projection"])
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


@pytest.mark.parametrize("method", ["phase-shift", "back-projection"])
def test_one_polarization_is_work_for_both_workers(ground, tmp_path, cluster, method):
    options = ["--permittivity", "4", "--depth", "0", "0.05", "0.01", "--method", method]
    options += ["--step", "polarization:rotation_deg=0", "-o", str(tmp_path / "i.nc")]
    address = cluster.scheduler_address
    with Client(address) as watcher, get_task_stream(client=watcher) as done:
        assert main(["image", str(ground), *options, "--scheduler", address]) == 0
    assert len({task["worker"] for task in done.data}) == 2


def test_lazy_numbers_are_computed_by_the_workers(folder, cluster):
    lazy = load_survey(folder, lazy_bytes=0)
    with Client(cluster.scheduler_address):
        mean = lazy.s21.mean(["x", "y"]).values
    np.testing.assert_allclose(mean, load_survey(folder).s21.mean(["x", "y"]).values)


def test_an_address_where_nobody_answers_is_told(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("gpr20_analysis.cluster.TIME_LIMIT_S", 0.5)
    arguments = ["image", str(folder), "--permittivity", "4", "--scheduler", "tcp://127.0.0.1:9"]
    assert main([*arguments, "-o", str(tmp_path / "i.nc")]) == 3
    assert "tcp://127.0.0.1:9" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("steps", "ending"), [(CHAIN, ".nc"), ([*CHAIN, "time", "gain:method=agc"], ".zarr")]
)
def test_two_workers_process_the_same(ground, tmp_path, cluster, steps, ending):
    here, there = tmp_path / f"here{ending}", tmp_path / f"there{ending}"
    arguments = ["process", str(ground), *(f"--step={step}" for step in steps), "-o"]
    address = cluster.scheduler_address
    assert main([*arguments, str(here)]) == 0
    with Client(address) as watcher, get_task_stream(client=watcher) as done:
        assert main([*arguments, str(there), "--scheduler", address]) == 0
    assert len({task["worker"] for task in done.data}) == 2
    found, expected = load_survey(there), load_survey(here)
    name = "a_scan" if "a_scan" in expected else "s21"
    assert np.isfinite(expected[name].values).all()
    np.testing.assert_allclose(found[name].values, expected[name].values, rtol=1e-12)
    assert found.drop_vars(name).identical(expected.drop_vars(name))


@pytest.mark.parametrize("kind", [["b-scan"], ["c-scan", "--delay", "2"], ["coverage"]])
def test_two_workers_draw_the_same(ground, tmp_path, cluster, kind):
    arguments = ["plot", *kind[:1], str(ground), *kind[1:], "--step", "background:method=mean"]
    address = ["--scheduler", cluster.scheduler_address]
    assert main([*arguments, "-o", str(tmp_path / "here.png")]) == 0
    assert main([*arguments, "-o", str(tmp_path / "there.png"), *address]) == 0
    assert (tmp_path / "there.png").read_bytes() == (tmp_path / "here.png").read_bytes()


@pytest.mark.usefixtures("blank_figures")
def test_two_workers_make_the_same_report(ground, tmp_path, cluster):
    options = ["--permittivity", "4", "--depth", "0", "0.05", "0.01"]
    address = ["--scheduler", cluster.scheduler_address]
    here, there = tmp_path / "here.html", tmp_path / "there.html"
    assert main(["report", str(ground), *options, "-o", str(here)]) == 0
    assert main(["report", str(ground), *options, "-o", str(there), *address]) == 0
    made_at = re.compile(r"\d{4}-\d\d-\d\dT[\d:]+")
    found, expected = (made_at.sub("", path.read_text()) for path in (there, here))
    assert "Maximum projections" in expected
    assert found == expected


@pytest.mark.parametrize(("form", "name"), [("netcdf", "s.nc"), ("csv", "s.csv")])
def test_two_workers_export_the_same(ground, tmp_path, cluster, form, name):
    options = ["--format", form]
    address = ["--scheduler", cluster.scheduler_address]
    here, there = tmp_path / "here" / name, tmp_path / "there" / name
    assert main(["export", str(ground), str(here), *options]) == 0
    assert main(["export", str(ground), str(there), *options, *address]) == 0
    if form == "netcdf":
        # The format keeps the second in which a file was made.
        with xr.open_dataset(here) as expected, xr.open_dataset(there) as found:
            assert found.identical(expected)
    else:
        assert there.read_bytes() == here.read_bytes()
