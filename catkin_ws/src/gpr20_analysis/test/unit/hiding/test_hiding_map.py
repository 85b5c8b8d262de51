"""The map of where a target could hide: from whole surveys, as files, and as a command."""

import json
from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import errors, read_hiding, write_hiding
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.hiding.injection import with_targets
from gpr20_analysis.hiding.scattering import Soil, echo_of
from gpr20_analysis.hiding.search import (
    Detector,
    HidingOptions,
    detection_interval,
    is_found,
    map_hidden,
)
from gpr20_analysis.imaging.image_options import DEFAULT_STEPS, ImageOptions
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample import sample_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.results.hiding_map import Target, Targets

SMALL = HidingOptions((0.03, 0.15), rounds=2, loss_tangent=0.0)
FEW_MM = np.linspace(60.0, 420.0, 11)
FEW_HZ = np.linspace(600e6, 6e9, 34)
DISC = Targets.TYPE_72.value


def detector(permittivity=4.0):
    options = ImageOptions(
        permittivity=permittivity, permittivity_uncertainty=0.05, ground=Ground.LEVEL
    )
    return Detector(options)


@pytest.fixture(scope="module")
def ground():
    """Level ground with one body, and noise that hides what is faint."""
    ground = scene([point(330.0, 330.0, 0.08, 0.02)], noise_db=-75.0)
    return survey_of(ground, FEW_MM, FEW_MM, FEW_HZ)


@pytest.fixture(scope="module")
def found(ground):
    return map_hidden(ground, detector(), DISC, SMALL)


def test_a_shallow_disc_is_found_and_none_that_noise_hides(ground, found):
    assert np.nanmedian(found.share[0]) > 0.7
    noisy = ground.assign(s21=ground["s21"] + noise(ground, 0.5))
    shallow = replace(SMALL, depth_m=SMALL.depth_m[:1])
    hidden = map_hidden(noisy, detector(), DISC, shallow)
    assert hidden.found.sum() < 0.5 * found.found[0].sum()
    assert hidden.missed.all()
    faint = map_hidden(ground, detector(), Target("faint", 0.03, 0.01, 3.99), shallow)
    assert np.nansum(faint.found) < 0.5 * np.nansum(found.found[0])


def test_the_same_seed_gives_the_same_map_and_another_seed_an_alike_one(ground, found):
    assert found.target == DISC
    assert found.permittivity_range == pytest.approx((3.8, 4.2))
    assert "permittivity of the soil: as given" in map(str, found.notes)
    assert np.all((found.lowest <= found.share) & (found.share <= found.highest))
    few = replace(SMALL, depth_m=(0.03,), rounds=1)
    first, again = (map_hidden(ground, detector(), DISC, few) for _ in range(2))
    assert np.array_equal(again.found, first.found) and np.array_equal(again.tried, first.tried)
    other = map_hidden(ground, detector(), DISC, replace(SMALL, seed=7))
    assert not np.array_equal(other.within_m, found.within_m)
    apart = (other.lowest > found.highest) | (found.lowest > other.highest)
    assert apart.mean() < 0.15


@each_case(
    "found, targets, published",
    [(50, 50, (0.929, 1.0)), (45, 48, (0.828, 0.987)), (0, 7, (0.0, 0.410)), (0, 0, (0.0, 1.0))],
)
def test_a_share_has_the_interval_of_clopper_and_pearson(found, targets, published):
    assert detection_interval(found, targets) == pytest.approx(published, abs=6e-4)


def noise(survey, level):
    """Return white noise, by its level relative to the largest value."""
    random = np.random.default_rng(5)
    parts = random.standard_normal((*survey["s21"].shape, 2)) @ np.array([1.0, 1j])
    return survey["s21"].copy(data=level * np.abs(survey["s21"]).max().item() * parts)


def test_what_changes_nothing_was_not_found(ground):
    searched = detector().search(ground)
    nothing = replace(searched, candidates=())
    body = searched.shown()[0]
    place_m = (body.x_m, body.y_m)
    assert is_found(searched, nothing, place_m, body.depth_m, DISC)
    assert not is_found(searched, searched, place_m, body.depth_m, DISC)
    assert not is_found(searched, nothing, (body.x_m + 0.2, body.y_m), body.depth_m, DISC)
    assert not is_found(searched, nothing, place_m, body.depth_m + 0.1, DISC)


def test_a_target_that_is_or_may_be_like_the_soil_is_found_nowhere(ground):
    few = HidingOptions((0.03,), rounds=1, loss_tangent=0.0)
    assert map_hidden(ground, detector(), Target("soil", 0.08, 0.01, 4.0), few).missed.all()
    unknown = Detector(ImageOptions(ground=Ground.LEVEL))
    found = map_hidden(ground, unknown, DISC, HidingOptions((0.03,), rounds=2, loss_tangent=0.0))
    assert found.tried.any() and not found.found.any()
    assert any("invisible" in str(one) for one in found.details)


def test_what_gives_no_map_is_refused(ground):
    near = survey_of(scene([point(240.0, 240.0, 0.08)], height_m=0.03), FEW_MM, FEW_MM, FEW_HZ)
    for fault, survey, own in (
        (errors.STEPS, process_survey(ground, *DEFAULT_STEPS), detector()),
        # A model of the antennas is needed.
        (NOT_ALLOWED, ground.assign(s21=noise(ground, 1.0)), detector()),
        (NOT_ALLOWED, near, detector()),
    ):
        with raises_fault(fault):
            map_hidden(survey, own, DISC, SMALL)


def test_traces_that_received_nothing_get_no_echo(ground):
    dead = ground.copy(deep=True)
    dead["s21"].values[:, :, 7:] = 1e-3 * noise(ground, 1e-3).values[:, :, 7:]
    echo = echo_of(DISC, 0.05, Soil(4.0), 0.2, ground["frequency"].values, 0.6)
    transmission = np.ones((2, ground.sizes["frequency"]))
    injected = with_targets(dead, echo, [(0.25, 0.25)], 4.0, transmission, 0.0)
    changed = np.any(injected["s21"].values != dead["s21"].values, axis=-1)
    assert changed[:, :, :7].all() and not changed[:, :, 7:].any()


def test_options_that_are_not_allowed_are_refused():
    depths_m = ((), (0.1, 0.1), (0.1, float("nan")), (0.1, 1.1))
    for wrong in (
        *({"depth_m": one} for one in depths_m),
        *({"rounds": 0}, {"needed": float("nan")}, {"loss_tangent": -0.1}, {"seed": -1}),
    ):
        with raises_fault(NOT_ALLOWED):
            HidingOptions(**wrong)


FAST = ["--permittivity", "5", "--rounds", "1", "--target-depths", "30", "150"]


@pytest.fixture(scope="module")
def sample_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("sample") / "corner.nc"
    few = {"x": slice(11), "y": slice(11), "frequency": slice(None, None, 2)}
    write_dataset(load_survey(sample_survey()).isel(few), path)
    return str(path)


@pytest.fixture(scope="module")
def written(sample_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hiding")
    outputs = [one for name in ("a.json", "a.png")
               for one in ("-o", str(folder / name))]  # fmt: skip
    assert main(["hiding", sample_file, *FAST, *outputs]) == DONE
    return folder


@pytest.mark.usefixtures("blank_figures")
def test_report_shows_the_map_of_its_survey_only(sample_file, written, tmp_path, refusals):
    report = tmp_path / "report.html"
    given = ["report", sample_file, "--permittivity", "5", "-o", str(report), "--hiding"]
    assert main([*given, str(written / "a.json")]) == DONE
    text = report.read_text(encoding="utf-8")
    assert "Where could a mine hide?" in text and "holds for this target only" in text
    assert "make the map again" not in text
    given[given.index("5")] = "8"
    assert main([*given, str(written / "a.json"), "--overwrite"]) == DONE
    doubt = "for the permittivity 5, the places are for 8: make the map again"
    assert doubt in report.read_text(encoding="utf-8")
    values = json.loads((written / "a.json").read_text(encoding="utf-8"))
    other = tmp_path / "other.json"
    other.write_text(json.dumps({**values, "survey_id": "another"}))
    assert main([*given, str(other), "--overwrite"]) == REFUSED
    assert main([*given, str(written / "a.png"), "--overwrite"]) == REFUSED
    assert refusals == [NOT_ALLOWED.code, errors.FILE_DAMAGED.code]


def test_a_map_is_read_as_it_was_written_and_wrong_files_are_refused(found, tmp_path):
    path = tmp_path / "b.json"
    write_hiding(found, path)
    for one in (path, str(path)):
        assert np.array_equal(read_hiding(one).found, found.found)
    with pytest.raises(AnalysisError):
        write_hiding(found, tmp_path / "a.geojson")
    for content in (b"", b"{}", b"\xff\xfe", b"[1]"):
        path.write_bytes(content)
        with pytest.raises(UnreadableFileError):
            read_hiding(path)


def test_wrong_arguments_are_refused_before_any_work(sample_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for wrong in (["--target", "tank"], ["--target-depths", "90", "30"], ["-o", "map.txt"]):
        assert main(["hiding", sample_file, *wrong]) == REFUSED
    assert not list(tmp_path.iterdir())
