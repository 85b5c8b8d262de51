"""A window with its frame never reaches over the edge of the screen."""

import random

from gpr20_user_interface.window.placement import Area, fitted


def test_a_window_that_fits_stays_where_it_is():
    window, frame = Area(101, 120, 800, 480), Area(100, 100, 802, 501)
    assert fitted(window, frame, Area(0, 0, 1920, 1080)) == Area(100, 100, 800, 480)


def test_the_frame_makes_a_window_smaller_on_a_screen_of_its_own_size():
    window, frame = Area(1, 20, 800, 480), Area(0, 0, 802, 501)
    assert fitted(window, frame, Area(0, 0, 800, 480)) == Area(0, 0, 798, 459)


def test_no_part_of_any_window_is_outside():
    draw = random.Random(20261122)
    for _ in range(2000):
        free = Area(*(draw.randint(0, 2000) for _ in range(2)), *(draw.randint(300, 2000),) * 2)
        width, height = draw.randint(100, 3000), draw.randint(100, 3000)
        left, top = draw.randint(-3000, 5000), draw.randint(-3000, 5000)
        sides, ends = draw.randint(0, 20), draw.randint(0, 60)
        window = Area(left + sides // 2, top + ends, width, height)
        frame = Area(left, top, width + sides, height + ends)
        place = fitted(window, frame, free)
        assert free.contains(Area(place.left, place.top, place.width + sides, place.height + ends))
        assert place.width <= width and place.height <= height
        if free.contains(frame):
            assert (place.left, place.top, place.width, place.height) == (left, top, width, height)
