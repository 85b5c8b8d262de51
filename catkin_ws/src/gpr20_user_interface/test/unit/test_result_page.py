"""The result in the window: it is there when a survey has ended; what each touch does."""

import pytest
from candidate_examples import candidate
from result_examples import a_map
from result_kit import BLUE, RED, plug_in, search, stored
from view_kit import FOLDER, PAST, SURVEY, make_grid, past_survey, snapshot, state_of
from window_helpers import click, hold, press_keys, show, take_list

from gpr20_common.message import Fault, Message, verbatim
from gpr20_operator.jobs.pictures import Exported
from gpr20_operator.jobs.result_texts import NOT_SAFE, NOTHING_FOUND
from gpr20_operator.words import local_time
from gpr20_survey.plan.markers import What
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import NO_CLEARANCE, Flag
from gpr20_survey.results.hiding_map import Targets
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.bars import TabName

ENDED = snapshot(SurveyState.FINISHED, state=state_of(SurveyState.FINISHED, survey_id=SURVEY))
RUNS = snapshot(SurveyState.SURVEYING, state=state_of(SurveyState.SURVEYING, survey_id=SURVEY))
REMEDY = Message("Enter the permittivity of the soil.")
REFUSED = Message("the echoes agree with every permittivity").with_fault(Fault("a.b", REMEDY))


@pytest.fixture
def ended(window):
    """The page at the end of a survey."""
    show(window, RUNS)
    show(window, ENDED)
    return window.result


@pytest.fixture
def done(ended, node):
    """The page with the places of the survey."""
    search(ended.result, node)
    return refreshed(ended)


def refreshed(page):
    page.show_now()
    return page


def test_the_search_begins_when_the_page_is_seen_and_ends_with_the_window(window, ended, node):
    assert node.of("read") == [(SURVEY,)]
    node.ticket("read").done(stored())
    window.show_tab(TabName.SURVEYS)
    show(window, ENDED)
    assert node.of("focus") == []
    window.show_tab(TabName.SURVEY)
    show(window, ENDED)
    assert len(node.of("focus")) == 1
    assert ended.progress.isVisible() and ended.card.button.isVisible()
    window.end()
    assert node.cancelled == [node.ticket("focus").request_id]


def test_a_stored_survey_is_named_on_its_result_and_over_its_sheets(window, done):
    page = window.result
    assert not page.band.isVisible()
    window.past.result_requested.emit(SURVEY)
    show(window, snapshot(state=state_of(SurveyState.FINISHED, survey_id=PAST)))
    named = f"SIMULATED; PAST SURVEY: {local_time(past_survey().started)}"
    assert page.band.isVisible() and page.band.text().startswith(named)
    page.place_sheet.ask(page.result.shown[0])
    page.stick_sheet.open_now()
    for sheet in (page.place_sheet, page.stick_sheet):
        assert sheet.band.isVisible() and sheet.band.text() == page.band.text()
        sheet.hide()


def shown_rows(page):
    return [row for row in page.rows if row.isVisible()]


def numbers(page):
    return [row.title.text().split(":")[0] for row in shown_rows(page)]


def test_the_places_are_listed_and_the_weaker_echoes_are_counted_and_reached(done):
    assert done.title.text() == "1 place to check; 10 weaker echoes"
    assert [one.text for one in done.picture.marks] == ["1"]
    for listed, more in ((1,), "10\nmore"), ((2, 3, 4, 5, 6), None), ((7, 8, 9, 10, 11), None):
        assert numbers(done) == [str(one) for one in listed]
        assert more in (None, done.more.text())
        click(done.rows[len(listed) - 1])
        assert done.place_sheet.title.text().startswith(f"{listed[-1]} ")
        click(done.place_sheet.close_button)
        click(done.more)
    assert numbers(done) == ["1"]


def test_a_sure_place_a_doubted_one_and_a_weaker_echo_differ_in_card_and_words(ended, node):
    flags = (), (Flag.ONE_POLARIZATION,), (Flag.SURFACE_RESIDUE, Flag.EDGE), (Flag.CLUTTER,)
    places = [candidate(number, 125.0, 90.0, flags=one) for number, one in enumerate(flags, 1)]
    search(ended.result, node, places)
    found = []
    for _ in range(2):
        rows = shown_rows(refreshed(ended))
        found += [(row.lines[0].text().split("; ")[1], row.property("level")) for row in rows]
        click(ended.more)
    assert found == [
        *(("sure echo", "sure"), ("measure finer", ""), ("see the surface", "")),
        ("weaker echo", "locked"),
    ]


def test_what_is_doubted_is_counted_beside_the_picture_and_said_with_what_to_do(ended, node):
    search(ended.result, node)
    assert not refreshed(ended).doubts.isVisible()
    ended.result.open("")
    search(ended.result, node, notes=(REFUSED, Message("the heights differ")))
    assert refreshed(ended).doubts.text() == "Doubts: 1"
    click(ended.doubts)
    said = ended.doubts_sheet.text.text()
    assert "agree with every" in said and shown_text(REMEDY) in said and "heights" not in said


def test_nothing_found_says_what_that_does_not_mean(window, ended, node):
    search(ended.result, node, [])
    view = refreshed(ended)
    assert view.title.text() == shown_text(NOTHING_FOUND)
    assert view.nothing.text() == shown_text(NOT_SAFE) and view.nothing.isVisible()
    assert not view.more.isVisible() and not shown_rows(view)
    # What ended early is resumed there, by a hold; another one is not.
    for survey_id in (PAST, SURVEY):
        assert not view.resume.isVisible()
        take_list(window, (past_survey(survey_id=survey_id, stored_traces=12, planned_traces=98),))
        show(window, ENDED)
    assert view.resume.text() == "RESUME: 12 of 98 stored"
    click(view.resume)
    hold(window.start_sheet.hold)
    assert window.survey.asked == [f"resume {FOLDER}"]
    # The page is there until the next survey is planned.
    click(view.plan)
    show(window, ENDED)
    assert window.survey_tab.currentWidget() is window.control


def test_the_sentence_is_visible_in_every_state_and_over_every_sheet(window, ended, node):
    def is_said(label):
        return label.isVisible() and label.text() == shown_text(NO_CLEARANCE)

    assert is_said(ended.no_clearance)
    node.ticket("read").done(stored())
    show(window, ENDED)
    assert is_said(ended.no_clearance)
    node.ticket("focus").fail(REFUSED)
    said = refreshed(ended).card.sentence.text()
    assert is_said(ended.no_clearance)
    assert "agree with every permittivity" in said and shown_text(REMEDY) in said
    click(ended.card.button)
    search(ended.result, node)
    refreshed(ended)
    assert is_said(ended.no_clearance)
    for key, sheet in (
        (ended.rows[0], ended.place_sheet),
        (ended.soil, ended.soil_sheet),
        (ended.hiding, ended.hiding_sheet),
        (ended.stick, ended.stick_sheet),
    ):
        click(key)
        assert sheet.isVisible() and is_said(sheet.no_clearance)
        click(sheet.close_button)


def test_what_was_found_is_stored_only_by_a_hold(done, node):
    click(done.rows[0])
    assert not done.place_sheet.store.isEnabled()
    click(done.place_sheet.whats[What.SCRAP])
    click(done.place_sheet.who)
    press_keys(done.place_sheet.pad, "Ana")
    click(done.place_sheet.pad.accept_button)
    click(done.place_sheet.deep)
    press_keys(done.place_sheet.pad, "35")
    click(done.place_sheet.pad.accept_button)
    click(done.place_sheet.store)
    assert node.of("fact") == []
    hold(done.place_sheet.store)
    node.ticket("fact").fail(verbatim("the disk is full"))
    assert "The disk is full" in refreshed(done).place_sheet.text.text()
    hold(done.place_sheet.store)
    _survey, _kind, values = node.of("fact")[-1]
    assert (values["what"], values["depth_mm"], values["who"]) == ("scrap", 35.0, "Ana")
    assert done.place_sheet.close_button.text() == "Leave\nunsaved"
    node.ticket("fact").done(verbatim("stored"))
    assert refreshed(done).place_sheet.close_button.text() == "CLOSE"


def test_the_soil_is_entered_and_used_by_a_hold(window, done, node):
    sheet = done.soil_sheet
    click(done.soil)
    for text, allowed in (("0.5", False), ("101", False), ("x", False), ("6,5", True)):
        click(sheet.other)
        sheet.pad.edit.setPlainText(text)
        assert sheet.pad.accept_button.isEnabled() == allowed
    click(sheet.pad.accept_button)
    click(sheet.use)
    assert sheet.isVisible() and node.of("fact") == []
    hold(sheet.use)
    show(window, ENDED)
    # It is searched for once the log has it.
    assert len(node.of("focus")) == 1 and not sheet.isVisible()
    assert node.of("fact")[-1][2]["permittivity"] == 6.5


def test_where_a_mine_could_hide_is_hatched(done, node):
    click(done.hiding)
    click(done.hiding_sheet.targets[Targets.PMN])
    assert refreshed(done).hiding_sheet.progress.isVisible()
    found = a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY)
    node.ticket("hide").done(found)
    assert refreshed(done).hiding_sheet.text.text().count("\n") >= 3
    assert done.picture._hiding is found


def test_the_report_says_when_the_stick_can_go_and_why_it_fails(done, node):
    sheet = done.stick_sheet
    click(done.stick)
    plug_in(node, BLUE, RED)
    assert refreshed(done).stick_sheet.title.text() == "Touch the stick that it is written to."
    assert node.of("export") == []
    click(sheet.sticks[0])
    refreshed(done)
    (asked,) = node.of("export")
    assert (asked.survey, asked.volume, asked.kinds) == (SURVEY, BLUE.path, ["report-html"])
    node.ticket("export").progress(verbatim("copying"))
    assert "Copying" in refreshed(done).stick_sheet.text.text()
    assert sheet.title.text() == "Do not remove the stick."
    node.ticket("export").done(Exported(("GPR20/a.pdf",)))
    assert refreshed(done).stick_sheet.title.text() == "Done. Remove the stick."
    click(sheet.all_data)
    click(sheet.sticks[1])
    assert node.of("export")[-1].volume == RED.path
    assert "survey-zip" in node.of("export")[-1].kinds
    node.ticket("export").fail(verbatim("the USB stick RED is full"))
    assert refreshed(done).stick_sheet.title.text() == "Nothing was written."
    assert "RED is full" in sheet.text.text()


def test_a_place_says_why_and_opens_its_finer_plan_and_ground(window, done):
    click(done.rows[0])
    assert "31 dB" in done.place_sheet.text.text() and "125" in done.place_sheet.title.text()
    click(done.place_sheet.finer)
    assert window.control.isVisible() and window.survey.finer.refines == SURVEY
    window.show_tab(TabName.SURVEY)
    window.survey_tab.show_result("", window.survey.snapshot)
    # The survey that has ended is the one that GROUND shows.
    window.traces.live.begin(make_grid())
    click(done.rows[0])
    click(done.place_sheet.view)
    show(window, ENDED)
    assert window.tabs.currentWidget() is window.ground.view
