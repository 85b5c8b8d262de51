import pytest

pytest.importorskip("PyQt5")

from window_helpers import application, show, snapshot, window

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.views.translation import Languages, shown_text

__all__ = ["application", "window"]


@pytest.fixture
def spanish(application):
    languages = Languages(application, Language.SPANISH)
    yield languages
    languages.close()


def test_message_is_shown_in_the_language_of_the_application_with_those_inside_it(spanish):
    message = Message("VNA fault: {reason}", reason=Message("no answer in time", details="errno"))
    assert shown_text(message) == "Fallo del VNA: no hubo respuesta a tiempo"
    spanish.use(Language.ENGLISH)
    assert shown_text(message) == "VNA fault: no answer in time"


@pytest.mark.parametrize("text", ["", "the moon is full", "{0} and {name}", "x" * 100_000])
def test_text_that_came_without_a_template_stays_as_it_is(spanish, text):
    assert shown_text(verbatim(text)) == text


def test_template_without_translation_is_shown_in_english(spanish):
    template = "the moon is {phase}"
    assert shown_text(Message(template, phase="full")) == "the moon is full"


def test_status_of_the_robot_changes_its_language_at_once(window, application, spanish):
    spanish.use(Language.ENGLISH)
    reason = Message("the disk is full")
    status = Message("Stop not accepted: {reason}", reason=reason)
    state = ControlState(SurveyState.STOPPED, status, "id", True)
    show(window, snapshot(SurveyState.STOPPED, state=state))
    assert window.status.message.title == "STOPPED"
    spanish.use(Language.SPANISH)
    application.processEvents()
    assert window.status.message.title == "DETENIDO"
    expected = "No se aceptó la orden de detener: el disco está lleno"
    assert window.status.message.message == expected
    assert window.top_bar.message.whole == expected
