"""Connects the settings of the window with the languages, the theme and the dimming."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Sequence

from PyQt5.QtCore import QPointF
from PyQt5.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPolygonF
from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.catalogue import Language
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_operator.robot.motion import motion_of
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import TextColours, look_of
from gpr20_user_interface.look.settings import Theme, WindowMemory
from gpr20_user_interface.look.translation import Languages, shown_text
from gpr20_user_interface.pages.settings.sheet import SettingsSheet
from gpr20_user_interface.touch.dimming import DimCover, Dimming
from gpr20_user_interface.widgets.page import Page

TEETH = 8
# Radii, as parts of the height of the button, and half the width of a tooth [parts of a pitch].
TIP, ROOT, HOLE = 0.32, 0.24, 0.11
TOOTH_TIP, TOOTH_ROOT = 0.17, 0.27


class GearButton(QPushButton):
    """Opens settings."""

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: draw the widget."""
        super().paintEvent(event)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(self.width() / 2.0, self.height() / 2.0)
        pair = look_of(self).text(TextColours.PRESSED if self.isDown() else TextColours.BUTTON)
        painter.fillPath(_gear(min(self.width(), self.height())), QColor(pair.ink))


def _gear(size_px: int) -> QPainterPath:
    pitch = 2.0 * math.pi / TEETH
    corners = ((-TOOTH_ROOT, ROOT), (-TOOTH_TIP, TIP), (TOOTH_TIP, TIP), (TOOTH_ROOT, ROOT))
    outline = QPolygonF()
    for tooth in range(TEETH):
        for part, radius in corners:
            angle = (tooth + part) * pitch
            reach = radius * size_px
            outline.append(QPointF(reach * math.cos(angle), reach * math.sin(angle)))
    path = QPainterPath()
    path.addPolygon(outline)
    path.closeSubpath()
    path.addEllipse(QPointF(0.0, 0.0), HOLE * size_px, HOLE * size_px)
    return path


# These wait for the operator.
AWAKE = (SurveyState.PAUSED, SurveyState.FAILED)


class SettingsBinding(Page):
    """Changes the window as the operator chooses, and remembers it.

    Args:
        window: The window.
        stop: Its button STOP, which no dimming covers.
        notices: What must be seen while it is open.
        languages: Languages of the window.
        use_theme: Changes the theme of the window.
        memory: What was chosen before.
        clock: Measures the time without a touch.

    Attributes:
        button: Opens the sheet.
        sheet: The settings.
        cover: What dims the window.
    """

    def __init__(
        self,
        window: QWidget,
        stop: QPushButton,
        notices: Sequence[QWidget],
        languages: Languages,
        use_theme: Callable[[Theme], None],
        memory: WindowMemory,
        clock: Clock,
    ) -> None:
        self._notices = notices
        self._languages = languages
        self._apply_theme = use_theme
        self._memory = memory
        self._dimming = Dimming(clock, memory.settings.dim_after_s)
        self.button = GearButton()
        self.button.setObjectName("settings")
        self.sheet = SettingsSheet(window)
        self.cover = DimCover(window, stop, self._dimming)
        self.button.clicked.connect(lambda: self._open())
        self.sheet.language_chosen.connect(self._use_language)
        self.sheet.theme_chosen.connect(self._use_theme)
        self.sheet.dimming_chosen.connect(self._dim_after)

    def refresh(self, snapshot: Snapshot) -> None:
        """Dim the window when it is time; not while there is something to see."""
        waits = snapshot.state is not None and snapshot.state.code in AWAKE
        seen = any(notice.isVisible() for notice in self._notices)
        moves = motion_of(snapshot) is not None
        self._dimming.refresh(waits or seen or moves or snapshot.alarm is not None)
        self.cover.refresh()

    def _open(self) -> None:
        self._show_settings()
        self.sheet.open()

    def _show_settings(self) -> None:
        settings = self._memory.settings
        # A launch may have set another language than the one that is remembered.
        self.sheet.show_settings(replace(settings, language=self._languages.language))

    def _use_language(self, language: Language) -> None:
        try:
            self._languages.use(language)
        except InvalidValueError as error:
            # A catalogue of this computer that is damaged; the window keeps its language.
            self._show_settings()
            self.sheet.hint.setText(shown_text(error.message))
            return
        self._memory.change(language=language)

    def _use_theme(self, theme: Theme) -> None:
        self._apply_theme(theme)
        self._memory.change(theme=theme)

    def _dim_after(self, minutes: int) -> None:
        self._memory.change(dim_after_min=minutes)
        self._dimming.set_after(self._memory.settings.dim_after_s)
