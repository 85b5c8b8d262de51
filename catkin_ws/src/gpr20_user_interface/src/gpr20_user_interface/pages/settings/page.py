"""Connects the settings of the window with the languages, the theme and the dimming."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Sequence

from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.catalogue import Language
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_operator.palette import Theme
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.settings import WindowMemory
from gpr20_user_interface.look.translation import Languages, shown_text
from gpr20_user_interface.pages.settings.sheet import SettingsSheet
from gpr20_user_interface.touch.dimming import DimCover, Dimming
from gpr20_user_interface.widgets.page import Page

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
        self.sheet = SettingsSheet(window)
        self.cover = DimCover(window, stop, self._dimming)
        self.sheet.language_chosen.connect(self._use_language)
        self.sheet.theme_chosen.connect(self._use_theme)
        self.sheet.dimming_chosen.connect(self._dim_after)

    def refresh(self, snapshot: Snapshot) -> None:
        """Dim the window when it is time; not while there is something to see."""
        waits = snapshot.state is not None and snapshot.state.code in AWAKE
        seen = any(notice.isVisible() for notice in self._notices)
        level = condition_of(snapshot).level
        self._dimming.refresh(waits or seen or level in (JobLevel.ATTENTION, JobLevel.FAULT))
        self.cover.refresh()

    def open(self) -> None:
        """Open the sheet."""
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
