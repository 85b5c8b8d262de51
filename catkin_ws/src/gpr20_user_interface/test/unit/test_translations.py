import pytest
from view_kit import make_grid, past_survey, snapshot
from window_helpers import show

from gpr20_common.catalogue import Language
from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.window.rail import TabName


@pytest.fixture
def spanish(application):
    languages = Languages(application, Language.SPANISH)
    yield languages
    languages.close()


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
