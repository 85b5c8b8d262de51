from map_kit import DOUBTED, MARKER, SURE
from view_kit import make_grid

from gpr20_operator.ground.geometry import Area, fit
from gpr20_operator.ground.grid import Stop
from gpr20_user_interface.pages.ground.map_selection import next_candidate, select_place

MARKS = (SURE, DOUBTED, MARKER)


def test_marks_at_one_place_are_chosen_one_after_the_other_and_then_the_stop():
    grid = make_grid()
    found = []
    selected = None
    for _ in range(4):
        selected = select_place(grid, MARKS, (124.0, 91.0), 10.0, selected)
        found.append(selected.mark)
    assert found == [SURE, DOUBTED, None, SURE]
    assert selected.cell.stop == Stop(2, 1)
    assert (selected.x_mm, selected.y_mm, selected.depth_mm) == (125.0, 90.0, 85.0)


def test_a_touch_out_of_reach_of_marks_chooses_the_stop():
    selected = select_place(make_grid(), MARKS, (150.0, 70.0), 10.0)
    assert selected.mark is None
    assert (selected.x_mm, selected.y_mm) == (150.0, 70.0)


def test_a_touch_beside_the_area_chooses_the_closest_stop():
    assert select_place(make_grid(), (), (900.0, -50.0), 10.0).cell.stop == Stop(0, 4)


def test_candidates_follow_each_other():
    candidates = (SURE, DOUBTED)
    grid = make_grid()
    selected = select_place(grid, MARKS, (125.0, 90.0), 10.0)
    assert next_candidate(candidates, None) == SURE
    assert next_candidate(candidates, selected) == DOUBTED
    assert next_candidate((), selected) is None


def test_a_survey_around_is_shown_too_unless_the_stops_become_too_small():
    grid = make_grid()
    room = (0.0, 0.0, 400.0, 400.0)
    alone = fit(grid.xs_mm, grid.ys_mm, room)
    near = fit(grid.xs_mm, grid.ys_mm, room, [Area(50.0, 250.0, 40.0, 160.0)])
    assert near.area == alone.area
    for corner in ((50.0, 40.0), (250.0, 160.0)):
        x_px, y_px = near.to_screen(*corner)
        assert 0.0 <= x_px <= 400.0
        assert 0.0 <= y_px <= 400.0
    far = fit(grid.xs_mm, grid.ys_mm, room, [Area(0.0, 650.0, 0.0, 800.0)])
    assert far.px_per_mm > 0.5 * alone.px_per_mm
    assert far.to_ground(*far.to_screen(120.0, 60.0)) == (120.0, 60.0)


def test_a_small_survey_in_a_large_one_fills_most_of_the_map():
    grid = make_grid()
    room = (0.0, 0.0, 400.0, 400.0)
    alone = fit(grid.xs_mm, grid.ys_mm, room)
    around = Area(0.0, 300.0, 0.0, 300.0)
    assert fit(grid.xs_mm, grid.ys_mm, room, [around]).px_per_mm > 0.5 * alone.px_per_mm
