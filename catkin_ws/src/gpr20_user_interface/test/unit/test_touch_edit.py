"""A number is never cut off at its beginning: 600.1234 must not read as 500.1234 or 00.1234."""

import random

import pytest
from PyQt5.QtTest import QTest
from window_helpers import application, click, close, new_window, open_field, show, snapshot

from gpr20_common.low.catalogue_file import languages
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.plan_form import PLAN_FIELDS
from gpr20_user_interface.views.look import TEXT_PX
from gpr20_user_interface.views.plan_style import FITS
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

NUMBERS = 25


@pytest.fixture(params=[(one, size) for one in languages() for size in ((480, 320), (800, 480))])
def shown(request, application, tmp_path):
    language, size = request.param
    window = new_window(Languages(application, language), profiles=tmp_path)
    window.resize(*size)
    window.show()
    show(window, snapshot(SurveyState.IDLE))
    yield window
    close(window)


def beginning_is_seen(edit):
    """Return whether the first character is at the left end of the field."""
    edit.setCursorPosition(0)
    # Qt adds 5 pixels at the left of the cursor.
    return edit.cursorRect().left() + 5 >= 0


def test_random_numbers_are_whole_or_show_their_beginning(shown):
    draw = random.Random(5)
    for name in PLAN_FIELDS:
        edit = open_field(shown, name)
        QTest.qWait(1)
        for _ in range(NUMBERS):
            text = f"{draw.uniform(-1e4, 1e4):.{draw.randint(0, 30)}f}"
            edit.setText(text)
            edit.select_all()
            needed_px = edit.fontMetrics().horizontalAdvance(text)
            assert needed_px <= edit.room_px or edit.property("fit") == list(FITS)[-1]
            assert edit.cursorPosition() == 0 or needed_px <= edit.room_px
            assert beginning_is_seen(edit)
        click(shown.values.done)


def test_no_coordinate_needs_smaller_letters_than_18_px(shown):
    edit = open_field(shown, "x_stop_mm")
    QTest.qWait(1)
    for text in ("600.1234", "500.1234", "123.456789", "0.00001"):
        edit.setText(text)
        assert edit.fontMetrics().horizontalAdvance(text) <= edit.room_px
        assert edit.fontInfo().pixelSize() >= round(TEXT_PX * shown.look.scale) - 1
    edit.setText("192.168.100.100")
    assert edit.fontMetrics().horizontalAdvance("192.168.100.100") <= edit.room_px
