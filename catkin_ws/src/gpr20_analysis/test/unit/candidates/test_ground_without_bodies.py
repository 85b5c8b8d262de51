"""Ground in which nothing is buried has no more candidates than were asked for."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from random_scenes_kit import Clutter, random_noise
from recorded_worlds import LINES, line, truths
from run_seed import LONG, draws

from gpr20_analysis import faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import X, Y
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey

ASKED_PER_M2 = 10.0
RELEASE = pytest.mark.release
MORE = [(5, 5), (30, 3), (3, 40), (1, 5), (5, 1), (2, 2), (2, 1)]
SHAPES = [(1, 40), (30, 1), (1, 2), *(pytest.param(*one, marks=RELEASE) for one in MORE)]


def found_in(survey, permittivity=5.0):
    options = ImageOptions(permittivity=permittivity, ground=Ground.LEVEL)
    return find_candidates(image_survey(process_survey(survey, *DEFAULT_STEPS), options))


def density(lists):
    """Return candidates per m2 that are not doubtful, of the lists that say how many to expect."""
    rated = [one for one in lists if not np.isnan(one.false_alarms_per_m2)]
    assert len(rated) > 5
    return sum(one.primary for one in rated) / sum(one.area_m2 for one in rated)


@pytest.mark.parametrize("kind", [Clutter.WHITE, Clutter.SURFACE])
@pytest.mark.parametrize(
    ("rows", "columns"),
    [(3, 100), *(pytest.param(*one, marks=RELEASE) for one in ((100, 100), (100, 3), (1, 100)))],
)
def test_of_noise_and_of_a_rough_surface(kind, rows, columns):
    lists = []
    for seed in range(draws(15)):
        survey = random_noise(seed, kind).isel(y=slice(rows), x=slice(columns))
        if (survey.sizes[Y] == 1) == (rows == 1) and max(survey.sizes[X], survey.sizes[Y]) > 20:
            lists.append(found_in(survey))
    # Noise alone falls off otherwise than the clutter of ground.
    assert density(lists) < 2.5 * ASKED_PER_M2


def test_of_computed_lines():
    lists = []
    empty = [number for number, truth in enumerate(truths(LINES)) if not truth["bodies"]]
    assert len(empty) == 53
    for number in empty[:: 1 if LONG else 4]:
        survey, truth = line(number)
        lists.append(found_in(survey, truth["permittivity"]))
    least, most = (0.5, 1.3) if LONG else (0.3, 1.6)
    assert least * ASKED_PER_M2 < density(lists) < most * ASKED_PER_M2


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
def test_the_default_command_images_every_shape(tmp_path, capsys, rows, columns):
    survey = next(
        one
        for one in (random_noise(seed, Clutter.WHITE) for seed in range(100))
        if one.sizes[Y] >= rows and one.sizes[X] >= columns
    )
    path = tmp_path / "survey.nc"
    write_dataset(survey.isel(y=slice(rows), x=slice(columns)), path)
    assert main(["image", str(path), "--permittivity", "5"]) == 0
    text = capsys.readouterr().out
    assert "C01" in text or "No candidate was found." in text
    assert ("length:" in text) == (1 in (rows, columns)) != ("area:" in text)


@pytest.mark.parametrize(
    "ground", ["cluttered", pytest.param("rough, cluttered and lossy", marks=RELEASE)]
)
def test_clean_ground_of_the_site_gives_no_smaller_density_than_there_is(ground):
    images = [
        image_survey(
            process_survey(line(number)[0], *DEFAULT_STEPS),
            ImageOptions(permittivity=5.0, ground=Ground.LEVEL),
        )
        for number, truth in enumerate(truths(LINES))
        if truth["ground"] == ground and not truth["bodies"]
    ]
    # Each by another line of such ground.
    lists = [
        find_candidates(image, clean_ground=images[place - 1]) for place, image in enumerate(images)
    ]
    assert len(lists) >= 10
    assert all("clean ground" in str(one.notes[-1]) for one in lists)
    assert 2.0 < density(lists) < 1.2 * ASKED_PER_M2


def test_clean_ground_that_was_imaged_in_another_way_is_refused(tmp_path, capsys):
    survey = process_survey(line(0)[0], *DEFAULT_STEPS)
    image = image_survey(survey, ImageOptions(permittivity=5.0))
    other = image_survey(survey, ImageOptions(permittivity=16.0))
    for clean in (other, image.assign_attrs(method="back-projection")):
        with raises_fault(faults.OPTION):
            find_candidates(image, clean_ground=clean)
    write_dataset(survey, tmp_path / "survey.nc")
    write_dataset(image, tmp_path / "clean.nc")
    paths = [str(tmp_path / "survey.nc"), "--permittivity", "5", "--clean-ground"]
    assert main(["candidates", *paths, str(tmp_path / "clean.nc")]) == DONE
    assert "clean ground" in capsys.readouterr().out
    assert main(["candidates", *paths, str(tmp_path / "survey.nc")]) == REFUSED
    assert "program error" not in capsys.readouterr().err
