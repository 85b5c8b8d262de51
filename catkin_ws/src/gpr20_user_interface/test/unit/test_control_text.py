import pytest
from window_helpers import application, snapshot, window

from gpr20_main_control.mid.coverage import Coverage
from gpr20_main_control.mid.survey_state import SurveyState
from gpr20_user_interface.mid.language import Language
from gpr20_user_interface.mid.survey_state import ControlState
from gpr20_user_interface.mid.views.control_text import control_text
from gpr20_user_interface.mid.views.translation import Languages

__all__ = ["application", "window"]


@pytest.fixture
def languages(application):
    languages = Languages(application, Language.SPANISH)
    yield languages
    languages.close()


@pytest.mark.parametrize(
    "text, spanish",
    [
        ("measuring", "midiendo"),
        ("pausing after this sample", "pausa tras esta medida"),
        (
            "complete: all 18 planned traces are stored",
            "completa: guardadas las 18 trazas previstas",
        ),
        (
            "INCOMPLETE: 710 of 882 planned traces are stored, 0 failed, 172 not visited",
            "INCOMPLETA: 710 de 882 trazas previstas guardadas, 0 fallidas, 172 sin visitar",
        ),
    ],
)
def test_standard_sentence_is_told_in_the_language_of_the_window(languages, text, spanish):
    assert control_text(text) == spanish
    languages.use(Language.ENGLISH)
    assert control_text(text) == text


@pytest.mark.parametrize("text", ["", "measuring; control differs by 3 dB", "paused: {lost}"])
def test_sentence_that_is_not_known_stays_as_it_is(languages, text):
    assert control_text(text) == text


def test_status_and_top_bar_change_their_sentence_with_the_language(window, languages):
    state = ControlState(SurveyState.SURVEYING, "measuring", "id", True)
    window.refresh(snapshot(SurveyState.SURVEYING, state=state))
    assert window.status.message.message == "midiendo"
    assert window.top_bar.message.whole == "midiendo"
    languages.use(Language.ENGLISH)
    window.status.message.retranslate()
    window.top_bar.retranslate()
    assert window.status.message.message == "measuring"
    assert window.top_bar.message.whole == "measuring"


@pytest.mark.parametrize("stored, word", [([0, 1], "completa"), ([1], "INCOMPLETA")])
def test_verdict_as_the_coverage_words_it_is_translated(languages, stored, word):
    assert control_text(Coverage(2, stored).verdict().text).startswith(f"{word}: ")
