"""MAP, RADAR and the list of past surveys in their frame: nothing cut off, nothing untranslated."""

import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtWidgets import QApplication, QLabel, QPushButton
from view_kit import SURVEY, make_grid, trace_at
from window_helpers import application, close, new_window

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import languages
from gpr20_common.message import verbatim
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.mid.map_coverage import CoverageRuns
from gpr20_user_interface.mid.map_grid import Stop
from gpr20_user_interface.mid.trace_events import SurveysListed
from gpr20_user_interface.views.look import BORDER_PX, TOUCH_PX
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.past_surveys_view import VERDICT
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

SURVEY_TABS = (TabName.MAP, TabName.RADAR, TabName.SURVEYS)
PADDING_PX = 6


class Shown:
    def __init__(self, language, application):
        self.languages = Languages(application, language)
        self.window = new_window(self.languages)
        self.window.show()
        live = self.window.traces.live
        grid = make_grid()
        live.begin(grid)
        failures = {10: verbatim("the VNA did not answer within 90 s; check cable and address")}
        verdict = verbatim("INCOMPLETE: 11 of 40 planned traces are stored, 1 failed, 28 missing")
        coverage = CoverageRuns(SURVEY, 40, (0, 10, 11, 12), (1, 3, 1, 0), failures, verdict)
        live.map.set_coverage(coverage)
        live.take_trace(trace_at(grid, 0, height_m=float("nan")))
        past = SurveySummary(
            *("20261121T051000_7c9e6679", "7c9e6679", "2026-11-21T05:10:00", "stopped"),
            *(7, 40, verdict, False, True, None),
        )
        self.window.on_event(SurveysListed("", (past,), True))
        self.window.past.table.selectRow(0)
        self.window.map.select_stop(Stop(1, 4))
        self.window.radar.show_model(live.radar)

    def close(self):
        close(self.window)


@pytest.fixture(params=languages())
def shown(request, application):
    shown = Shown(request.param, application)
    yield shown
    shown.close()


def show(shown, tab):
    shown.window.show_tab(tab)
    # Layouts settle, texts are written in another language, when events are handled.
    QApplication.processEvents()


def visible(page, kind):
    return [one for one in page.findChildren(kind) if one.isVisible() and one.text()]


@pytest.mark.parametrize("tab", SURVEY_TABS)
def test_no_button_is_cut_off_or_too_small_for_a_glove(shown, tab):
    show(shown, tab)
    buttons = visible(shown.window, QPushButton)
    assert len(buttons) > 2
    for button in buttons:
        metrics = button.fontMetrics()
        lines = button.text().split("\n")
        widest = max(metrics.horizontalAdvance(line) for line in lines)
        assert widest <= button.width() - 2 * (BORDER_PX + PADDING_PX), button.text()
        assert metrics.lineSpacing() * len(lines) <= button.height() - 2 * BORDER_PX, button.text()
        assert min(button.width(), button.height()) >= TOUCH_PX, button.text()


@pytest.mark.parametrize("tab", SURVEY_TABS)
def test_no_label_is_cut_off(shown, tab):
    show(shown, tab)
    for label in visible(shown.window.tabs.currentWidget(), QLabel):
        if label.wordWrap():
            assert label.heightForWidth(label.width()) <= label.height(), label.text()
        else:
            assert label.sizeHint().width() <= label.width(), label.text()


@pytest.mark.parametrize("tab", SURVEY_TABS)
def test_the_window_keeps_its_size(shown, tab):
    show(shown, tab)
    assert (shown.window.width(), shown.window.height()) == (800, 480)
    hint = shown.window.minimumSizeHint()
    assert hint.width() <= 800
    assert hint.height() <= 480


def test_the_language_changes_at_once(application):
    shown = Shown(Language.ENGLISH, application)
    shown.languages.use(Language.SPANISH)
    show(shown, TabName.RADAR)
    views = shown.window
    assert "Sin eco no significa sin mina." in views.radar.note.text()
    assert views.map.next_problem.text() == "Siguiente\nincompleto"
    assert views.past.table.item(0, VERDICT).text() == "INCOMPLETA\nSIMULADO"
    sheet = views.radar_binding.sheet
    sheet.background.click()
    assert sheet.background.text() == "Fondo\nincluido"
    shown.close()


def test_a_text_without_translation_is_shown_in_english_and_never_empty(application):
    languages = Languages(application, Language.SPANISH)
    assert QApplication.translate("AnyView", "NO SUCH TEXT") == "NO SUCH TEXT"
    assert QApplication.translate("AnyView", "STOP") == "DETENER"
    languages.close()
