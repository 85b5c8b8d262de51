"""The result on every screen, in each language and theme: nothing is cut off, fingers hit it."""

from candidate_examples import candidate
from hiding_kit import a_map
from layout_kit import assert_fits, screen, spoken
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
MANY = [
    candidate(number, 1234.0, 1234.0, 1234.0, 31.0, list(Flag)[: (number - 1) // 8])
    for number in range(1, 51)
]
REFUSED = Message("the echoes agree with every permittivity").with_fault(
    Fault("a.b", Message("Enter the permittivity of the soil, then try again. Or use another one."))
)


def test_the_search_its_places_their_sheets_and_the_stick_fit_in_every_state(spoken):
    page, node = spoken.result, spoken.node

    def check(sheet=page):
        for _ in range(2):
            show(spoken, ENDED)
        assert_fits(spoken, sheet)

    def find(candidates=MANY, record=None, **changes):
        search(page.result, node, candidates, record, **changes)
        show(spoken, ENDED)

    interrupted = stored(7, outcome="interrupted")
    page.result.open("")
    page.end()
    show(spoken, ENDED)
    node.ticket("read").done(interrupted)
    show(spoken, ENDED)
    node.ticket("focus").fail(REFUSED)
    check()
    page.result.try_again()
    find((), interrupted)
    check()
    page.result.open("")
    find(record=interrupted, omitted=12345, omitted_primary=9)
    for _ in range(9):
        page.more.click()
    check()
    page.result.open("")
    find(MANY[24:27])
    check()
    assert not [row.why.shown_lines() for row in page.rows[:3] if row.why.is_cut]

    page.result.open("")
    find()
    page.rows[4].click()
    sheet = page.place_sheet
    sheet._who, sheet._depth, sheet._what = "W" * 60, "1234.5", What.DEVICE
    sheet.show_now()
    check(sheet)
    sheet.deep.click()
    assert_fits(spoken, sheet.pad)
    sheet.pad.hide()
    sheet.hide()
    page.soil.click()
    page.soil_sheet._choose(12.345)
    check(page.soil_sheet)
    page.soil_sheet.hide()
    page.hiding.click()
    list(page.hiding_sheet.targets.values())[1].click()
    node.ticket("hide").done(a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY))
    check(page.hiding_sheet)
    page.hiding_sheet.hide()

    page.stick.click()
    plug_in(node, BLUE, RED, LOCKED)
    check(page.stick_sheet)
    page.stick_sheet.sticks[1].click()
    node.ticket("export").progress(verbatim("copying to the USB stick"))
    check(page.stick_sheet)
    node.ticket("export").done(Exported(("GPR20/a.pdf", "GPR20/b.zip")))
    check(page.stick_sheet)
    page.stick_sheet.other.click()
    check(page.stick_sheet)
    page.stick_sheet.sticks[1].click()
    node.ticket("export").fail(verbatim("the USB stick is full; nothing was left. " * 7))
    check(page.stick_sheet)
