import numpy as np
import pytest
from candidate_examples import candidate_list
from map_kit import FINER
from view_kit import SURVEY

from gpr20_operator.ground.laid_over import MOST_VOXELS, laid_over
from gpr20_survey.results.focused_image import FocusedImage


def image(survey_id, x_mm, y_mm, level_db, depth_mm=(0.0, 20.0, 40.0)):
    shape = (len(depth_mm), len(y_mm), len(x_mm))
    return FocusedImage(
        9, np.asarray(x_mm, float), np.asarray(y_mm, float), np.asarray(depth_mm, float),
        np.full(shape, level_db, np.float32), candidate_list(survey_id=survey_id),
    )  # fmt: skip


def level_at(found, x_mm, y_mm, depth_mm):
    layer = int(np.argmin(np.abs(found.depth_mm - depth_mm)))
    row = int(np.argmin(np.abs(found.y_mm - y_mm)))
    return found.levels_db[layer, row, int(np.argmin(np.abs(found.x_mm - x_mm)))]


COARSE = image(SURVEY, np.arange(0, 101, 10), np.arange(0, 81, 10), 1.0)


@pytest.mark.parametrize("spacing_mm", [2.5, 5.0, 10.0])
def test_a_finer_image_replaces_the_coarse_one_where_it_lies(spacing_mm):
    fine = image(FINER, np.arange(30, 60.1, spacing_mm), np.arange(20, 50.1, spacing_mm), 7.0)
    found = laid_over(COARSE, [fine])
    assert found.survey_id == SURVEY
    assert np.allclose(np.diff(found.x_mm), spacing_mm)
    assert level_at(found, 45.0, 35.0, 20.0) == 7.0
    assert level_at(found, 30.0, 20.0, 0.0) == 7.0
    assert level_at(found, 15.0, 35.0, 20.0) == 1.0
    assert level_at(found, 45.0, 75.0, 40.0) == 1.0
    # The area is the same.
    for before, after in ((COARSE.x_mm, found.x_mm), (COARSE.y_mm, found.y_mm)):
        edges = [one[0] - (one[1] - one[0]) / 2.0 for one in (before, after)]
        assert edges[0] == pytest.approx(edges[1])


def test_what_the_finer_survey_did_not_measure_stays():
    fine = image(FINER, np.arange(30, 60.1, 5), np.arange(20, 50.1, 5), np.nan)
    assert np.array_equal(np.unique(laid_over(COARSE, [fine]).levels_db), [1.0])


def test_other_depths_are_those_that_are_nearest():
    fine = image(FINER, np.arange(30, 61, 5), np.arange(20, 51, 5), 0.0, (0.0, 10.0, 20.0, 30.0))
    fine.levels_db[:] = np.arange(4.0)[:, None, None]
    found = laid_over(COARSE, [fine])
    assert [level_at(found, 45.0, 35.0, one) for one in (0.0, 20.0, 40.0)] == [0.0, 2.0, 3.0]


def test_an_image_beside_the_area_changes_nothing():
    fine = image(FINER, np.arange(300, 330, 5), np.arange(20, 51, 5), 7.0)
    assert laid_over(COARSE, [fine]) is COARSE
    assert laid_over(COARSE, []) is COARSE


def test_memory_is_bounded():
    wide = image(SURVEY, np.arange(0, 1600, 5), np.arange(0, 1600, 5), 1.0, np.arange(60.0))
    fine = image(FINER, np.arange(100, 200, 1), np.arange(100, 200, 1), 7.0, np.arange(60.0))
    assert laid_over(wide, [fine]).levels_db.size <= MOST_VOXELS
