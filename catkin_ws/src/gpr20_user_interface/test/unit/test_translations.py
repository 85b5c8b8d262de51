import pytest
from PyQt5.QtWidgets import QApplication
from view_kit import make_grid, past_survey, snapshot
from window_helpers import show

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.robot.events import ControlState
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.translation import Languages, shown_text
from gpr20_user_interface.window.rail import TabName


@pytest.fixture
def spanish(application):
    languages = Languages(application, Language.SPANISH)
    yield languages
    languages.close()


def test_message_is_shown_in_the_language_of_the_application_with_those_inside_it(spanish):
    message = Message("Not done: {reason}", reason=Message("no answer in time", details="errno"))
    assert shown_text(message) == "No se hizo: no hubo respuesta a tiempo"
    spanish.use(Language.ENGLISH)
    assert shown_text(message) == "Not done: no answer in time"


def test_text_without_template_or_translation_stays_as_it_is_and_is_never_empty(spanish):
    for text in ("", "the moon is full", "{0} and {name}", "x" * 100_000):
        assert shown_text(verbatim(text)) == text
    assert shown_text(Message("the moon is {phase}", phase="full")) == "the moon is full"
    assert QApplication.translate("AnyView", "NO SUCH TEXT") == "NO SUCH TEXT"
    assert QApplication.translate("AnyView", "STOP") == "DETENER"


def test_status_of_the_robot_changes_its_language_at_once(window, application, spanish):
    spanish.use(Language.ENGLISH)
    reason = Message("the disk is full")
    status = Message("Stop not accepted: {reason}", reason=reason)
    state = ControlState(SurveyState.STOPPED, status, "id", True)
    show(window, snapshot(SurveyState.STOPPED, state=state))
    assert window.top_bar.band.title.whole == "STOPPED"
    spanish.use(Language.SPANISH)
    application.processEvents()
    assert window.top_bar.band.title.whole == "DETENIDO"
    expected = "No se aceptó la orden de detener: el disco está lleno"
    assert window.top_bar.band.message.whole == expected


def test_every_tab_changes_its_language_at_once(window, application, spanish):
    spanish.use(Language.ENGLISH)
    window.on_event(SurveysListed("", (past_survey(),), True))
    window.traces.live.begin(make_grid())
    window.show_tab(TabName.ROBOT)
    show(window, snapshot(SurveyState.IDLE))
    hint = window.robot.overview.hint.text()
    spanish.use(Language.SPANISH)
    window.show_tab(TabName.GROUND)
    application.processEvents()
    assert "Sin eco no significa sin mina." in window.ground.view.note.text()
    assert window.ground.view.set_marker.text() == "Poner\nmarca"
    assert window.robot.overview.hint.text() not in ("", hint)
    sheet = window.ground.layers
    sheet.background.click()
    assert sheet.background.text() == "Fondo\nincluido"
