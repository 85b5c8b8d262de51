import pytest
from view_kit import make_grid, past_survey, snapshot
from window_helpers import show

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.trace_events import SurveysListed
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
    spanish.use(Language.SPANISH)
    for text in ("", "the moon is full", "{0} and {name}"):
        assert shown_text(verbatim(text)) == text
    assert shown_text(Message("the moon is {phase}", phase="full")) == "the moon is full"


def test_every_tab_changes_its_language_at_once(window, application, spanish):
    spanish.use(Language.ENGLISH)
    window.on_event(SurveysListed("", (past_survey(),), True))
    window.traces.live.begin(make_grid())
    window.show_tab(TabName.ROBOT)
    show(window, snapshot(SurveyState.IDLE))
    hint, title = window.robot.overview.hint.text(), window.top_bar.band.title.whole
    spanish.use(Language.SPANISH)
    window.show_tab(TabName.GROUND)
    application.processEvents()
    assert "Sin eco no significa sin mina." in window.ground.view.note.text()
    assert window.ground.view.set_marker.text() == "Poner\nmarca"
    assert window.robot.overview.hint.text() not in ("", hint)
    assert window.top_bar.band.title.whole not in ("", title)
    sheet = window.ground.layers
    sheet.background.click()
    assert sheet.background.text() == "Fondo\nincluido"
