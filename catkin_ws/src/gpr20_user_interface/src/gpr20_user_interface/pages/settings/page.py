"""The settings of the window: language, colours, dimming, and which robot it shows."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, Sequence, Tuple

from PyQt5.QtWidgets import QButtonGroup, QGridLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from gpr20_common.catalogue import Language, languages
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_operator.palette import Theme
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.settings import DIM_CHOICES_MIN, WindowMemory
from gpr20_user_interface.look.translation import Languages, shown_text
from gpr20_user_interface.touch.dimming import DimCover, Dimming
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import new_button

MARGIN_PX = 24
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
        robot_button: Opens the list of robots; connected where there may be several.
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
        self._dimming = Dimming(clock, memory.settings.dim_after_s)
        self.cover = DimCover(window, stop, self._dimming)
        self.title, self.hint = QLabel(), QLabel()
        self.title.setObjectName("title")
        self.hint.setObjectName("quiet")
        self.hint.setWordWrap(True)
        self.close_button = new_button(self.hide)
        self.robot_button = QPushButton()
        self.robot_button.hide()
        self.remote_button = QPushButton()
        self.labels = tuple(QLabel() for _ in range(3))
        self.languages: Dict[Language, QPushButton] = _choices(languages(), self._use_language)
        self.themes: Dict[Theme, QPushButton] = _choices(Theme, self._use_theme)
        self.dim_choices: Dict[int, QPushButton] = _choices(DIM_CHOICES_MIN, self._dim_after)
        self._lay_out()
        self.retranslate()
        self.restyle()

    def refresh(self, snapshot: Snapshot) -> None:
        """Dim the window when it is time; not while there is something to see."""
        waits = snapshot.state is not None and snapshot.state.code in AWAKE
        seen = any(notice.isVisible() for notice in self._notices)
        level = condition_of(snapshot).level
        self._dimming.refresh(waits or seen or level in (JobLevel.ATTENTION, JobLevel.FAULT))
        self.cover.refresh()

    def open(self) -> None:
        """Show what is chosen."""
        settings = self._memory.settings
        # A launch may have set another language than the one that is remembered.
        self.languages[self._languages.language].setChecked(True)
        self.themes[settings.theme].setChecked(True)
        self.dim_choices[settings.dim_after_min].setChecked(True)
        super().open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Settings"))
        self.close_button.setText(self.tr("CLOSE"))
        self.robot_button.setText(self.tr("OTHER ROBOT"))
        self.remote_button.setText(self.tr("REMOTE CONTROL"))
        titles = (self.tr("Language"), self.tr("Colours"), self.tr("Dim the screen after"))
        for label, title in zip(self.labels, titles):
            label.setText(title)
        self.hint.setText(
            self.tr("The first touch of a dimmed screen only brightens it. STOP always acts.")
        )
        for language, button in self.languages.items():
            button.setText(language.own_name)
        self.themes[Theme.SUN].setText(self.tr("Sunlight"))
        self.themes[Theme.NIGHT].setText(self.tr("Night"))
        minutes = self.tr("{minutes} min")
        for number, button in self.dim_choices.items():
            button.setText(minutes.format(minutes=number) if number else self.tr("Never"))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        margin, gap = look.px(MARGIN_PX), look.px(GAP_PX)
        self._layout.setContentsMargins(margin, gap, margin, gap)
        self._layout.setHorizontalSpacing(margin)
        self._layout.setVerticalSpacing(gap)

    def _use_language(self, language: Language) -> None:
        try:
            self._languages.use(language)
        except InvalidValueError as error:
            # A catalogue of this computer that is damaged; the window keeps its language.
            self.languages[self._languages.language].setChecked(True)
            self.hint.setText(shown_text(error.message))
            return
        self._memory.change(language=language)

    def _use_theme(self, theme: Theme) -> None:
        self._apply_theme(theme)
        self._memory.change(theme=theme)

    def _dim_after(self, minutes: int) -> None:
        self._memory.change(dim_after_min=minutes)
        self._dimming.set_after(self._memory.settings.dim_after_s)

    def _lay_out(self) -> None:
        layout = self._layout = QGridLayout(self)
        layout.addWidget(self.title, 0, 0)
        rows: Tuple[Dict[Any, QPushButton], ...] = (self.languages, self.themes, self.dim_choices)
        for row, (label, choices) in enumerate(zip(self.labels, rows), start=1):
            group, buttons = QButtonGroup(self), QHBoxLayout()
            buttons.setSpacing(GAP_PX)
            for button in choices.values():
                group.addButton(button)
                buttons.addWidget(button, 1)
            layout.addWidget(label, row, 0)
            layout.addLayout(buttons, row, 1)
        layout.addWidget(self.hint, 4, 0, 1, 2)
        bottom = QHBoxLayout()
        bottom.setSpacing(GAP_PX)
        bottom.addWidget(self.robot_button, 1)
        bottom.addWidget(self.remote_button, 1)
        bottom.addWidget(self.close_button, 1)
        layout.addLayout(bottom, 5, 0, 1, 2)
        layout.setColumnStretch(1, 1)
        layout.setRowStretch(4, 1)


def _choices(values: Iterable[Any], act: Callable[[Any], None]) -> Dict[Any, QPushButton]:
    """Return a button for each value, of which one is chosen."""
    buttons = {}
    for value in values:
        button = buttons[value] = QPushButton()
        button.setCheckable(True)
        button.setObjectName("choice")
        button.clicked.connect(lambda _checked, value=value: act(value))
    return buttons
