"""The result on every screen, in each language and theme: nothing is cut off, fingers hit it."""

import itertools

import pytest
from candidate_examples import candidate
from finger import place_of
from hiding_kit import a_map
from layout_kit import assert_fits, screen, seen, spoken
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractButton
from result_kit import BLUE, LOCKED, RED, plug_in, search, stored
from view_kit import SURVEY, snapshot, state_of
from window_helpers import show

from gpr20_common.message import Fault, Message, verbatim
from gpr20_operator.jobs.pictures import Exported
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import Flag
from gpr20_survey.results.found import What

__all__ = ["screen", "spoken"]

ENDED = snapshot(SurveyState.FINISHED, state=state_of(SurveyState.FINISHED, survey_id=SURVEY))
SMALLEST_PX = 48
MANY = [
    candidate(number, 1234.0, 1234.0, 1234.0, 31.0, list(Flag)[: (number - 1) // 8])
    for number in range(1, 51)
]
REFUSED = Message("the echoes agree with every permittivity").with_fault(
    Fault("a.b", Message("Enter the permittivity of the soil, then try again. Or use another one."))
)


@pytest.fixture
def page(spoken):
    page = spoken.result
    page.result.open("")
    page.end()
    spoken.node.asked.clear()
    show(spoken, ENDED)
    return page


def check(window, page, *parts):
    """Check all that is seen of the page, or of a sheet."""
    show(window, ENDED)
    for _ in range(2):
        QTest.qWait(1)
    shown = parts or (page,)
    assert_fits(window, *shown)
    least_px = window.look.px(SMALLEST_PX) - 1
    for part in shown:
        places = [place_of(window, one) for one in seen(part, QAbstractButton)]
        small = [(one.width(), one.height()) for one in places if one.height() < least_px]
        assert not small, (small, window.size())
        assert not [pair for pair in itertools.combinations(places, 2) if pair[0] & pair[1]]


def found(page, window, candidates=MANY, record=None, **changes):
    search(page.result, window.node, candidates, record, **changes)
    show(window, ENDED)


def test_the_search_and_its_places_fit(spoken, page):
    interrupted = stored(7, outcome="interrupted")
    spoken.node.ticket("read").done(interrupted)
    show(spoken, ENDED)
    spoken.node.ticket("focus").fail(REFUSED)
    check(spoken, page)
    page.result.try_again()
    found(page, spoken, (), interrupted)
    check(spoken, page)
    page.result.open("")
    found(page, spoken, record=interrupted, omitted=12345, omitted_primary=9)
    for _ in range(9):
        page.more.click()
    check(spoken, page)
    page.result.open("")
    found(page, spoken, MANY[24:27])
    check(spoken, page)
    assert not [row.why.shown_lines() for row in page.rows[:3] if row.why.is_cut]


def test_the_sheets_of_a_place_of_the_soil_and_of_what_is_hidden_fit(spoken, page):
    found(page, spoken)
    page.rows[4].click()
    sheet = page.place_sheet
    sheet._who, sheet._depth, sheet._what = "W" * 60, "1234.5", What.DEVICE
    sheet.show_now()
    check(spoken, page, sheet)
    sheet.deep.click()
    assert_fits(spoken, sheet.pad)
    sheet.pad.hide()
    sheet.hide()
    page.soil.click()
    page.soil_sheet._choose(12.345)
    check(spoken, page, page.soil_sheet)
    page.soil_sheet.hide()
    page.hiding.click()
    list(page.hiding_sheet.targets.values())[1].click()
    spoken.node.ticket("hide").done(a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY))
    check(spoken, page, page.hiding_sheet)
    page.hiding_sheet.hide()


def test_the_stick_fits_in_every_state(spoken, page):
    found(page, spoken)
    page.stick.click()
    plug_in(spoken.node, BLUE, RED, LOCKED)
    check(spoken, page, page.stick_sheet)
    page.stick_sheet.sticks[1].click()
    spoken.node.ticket("export").progress(verbatim("copying to the USB stick"))
    check(spoken, page, page.stick_sheet)
    spoken.node.ticket("export").done(Exported(("GPR20/a.pdf", "GPR20/b.zip")))
    check(spoken, page, page.stick_sheet)
    page.stick_sheet.other.click()
    check(spoken, page, page.stick_sheet)
    page.stick_sheet.sticks[1].click()
    spoken.node.ticket("export").fail(verbatim("the USB stick is full; nothing was left. " * 7))
    check(spoken, page, page.stick_sheet)
