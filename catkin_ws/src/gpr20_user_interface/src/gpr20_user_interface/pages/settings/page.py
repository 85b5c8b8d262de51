"""The settings of the window: language, colours, dimming, and which robot it shows."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, Iterable, Sequence, Tuple

from PyQt5.QtWidgets import QButtonGroup, QPushButton, QWidget

from gpr20_common.catalogue import Language, languages
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.palette import Theme
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.settings import DIM_CHOICES_MIN, WindowMemory
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.touch.dimming import DimCover
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import column, grid, new_button, new_label, row, say

HINT = Message("The first touch of a dimmed screen only brightens it. STOP always acts.")
# These wait for the operator.
AWAKE = (SurveyState.PAUSED, SurveyState.FAILED)


class SettingsPage(Overlay, Page):
    """Shows the settings; each touch of a choice takes effect at once and is remembered.

    Args:
        window: The window.
        stop: Its button STOP, which no dimming covers.
        notices: What must be seen while it is open.
        languages: Languages of the window.
        use_theme: Changes the theme of the window.
        memory: What was chosen before.
        clock: Measures the time without a touch.

    Attributes:
        cover: What dims the window.
        remote_button: Opens what concerns the web page.
    """

    def __init__(
        self,
        window: QWidget,
        stop: QPushButton,
        notices: Sequence[QWidget],
        languages_used: Languages,
        use_theme: Callable[[Theme], None],
        memory: WindowMemory,
        clock: Clock,
    ) -> None:
        super().__init__(window)
        self._notices = notices
        self._languages = languages_used
        self._apply_theme = use_theme
        self._memory = memory
        self.cover = DimCover(window, stop, clock, memory.settings.dim_after_s)
        self.title = new_label("title", text=Message("Settings"))
        self.hint = new_label("quiet", wraps=True)
        self.close_button = new_button(self.hide, Message("CLOSE"))
        self.remote_button = new_button(self.hide, Message("REMOTE CONTROL"))
        self.languages: Dict[Language, QPushButton] = self._choices(languages(), self._use_language)
        self.themes: Dict[Theme, QPushButton] = self._choices(Theme, self._use_theme)
        self.dim_choices: Dict[int, QPushButton] = self._choices(DIM_CHOICES_MIN, self._dim_after)
        self._write_choices()
        self._lay_out()

    def refresh(self, snapshot: Snapshot) -> None:
        """Dim the window when it is time; not while there is something to see."""
        waits = snapshot.state is not None and snapshot.state.code in AWAKE
        seen = any(notice.isVisible() for notice in self._notices)
        level = condition_of(snapshot).level
        self.cover.refresh(waits or seen or level in (JobLevel.ATTENTION, JobLevel.FAULT))

    def open(self) -> None:
        """Show what is chosen."""
        settings = self._memory.settings
        # A launch may have set another language than the one that is remembered.
        say(self.hint, HINT)
        self.languages[self._languages.language].setChecked(True)
        self.themes[settings.theme].setChecked(True)
        self.dim_choices[settings.dim_after_min].setChecked(True)
        super().open()

    def _use_language(self, language: Language) -> None:
        try:
            self._languages.use(language)
        except InvalidValueError as error:
            # A catalogue of this computer that is damaged; the window keeps its language.
            self.languages[self._languages.language].setChecked(True)
            say(self.hint, error.message)
            return
        self._memory.change(language=language)

    def _use_theme(self, theme: Theme) -> None:
        self._apply_theme(theme)
        self._memory.change(theme=theme)

    def _dim_after(self, minutes: int) -> None:
        self._memory.change(dim_after_min=minutes)
        self.cover.set_after(self._memory.settings.dim_after_s)

    def _write_choices(self) -> None:
        for language, button in self.languages.items():
            button.setText(language.own_name)
        say(self.themes[Theme.SUN], Message("Sunlight"))
        say(self.themes[Theme.NIGHT], Message("Night"))
        for minutes, button in self.dim_choices.items():
            never = Message("Never")
            say(button, Message("{minutes} min", minutes=minutes) if minutes else never)

    def _lay_out(self) -> None:
        layout = grid(gap=2 * GAP_PX)
        rows: Tuple[Tuple[Message, Dict[Any, QPushButton]], ...] = (
            (Message("Language"), self.languages),
            (Message("Colours"), self.themes),
            (Message("Dim the screen after"), self.dim_choices),
        )
        self.labels = [new_label() for _row in rows]
        for number, (label, (title, choices)) in enumerate(zip(self.labels, rows)):
            say(label, title)
            layout.addWidget(label, number, 0)
            layout.addLayout(row(*((one, 1) for one in choices.values())), number, 1)
        layout.setColumnStretch(1, 1)
        bottom = row((self.remote_button, 1), (self.close_button, 1))
        self.setLayout(column(self.title, layout, (self.hint, 1), bottom, margin=2 * GAP_PX))

    def _choices(self, values: Iterable[Any], act: Callable[[Any], None]) -> Dict[Any, QPushButton]:
        """Return a button for each value, of which one is chosen."""
        buttons, group = {}, QButtonGroup(self)
        for value in values:
            button = buttons[value] = new_button(partial(act, value))
            button.setCheckable(True)
            button.setObjectName("choice")
            group.addButton(button)
        return buttons
