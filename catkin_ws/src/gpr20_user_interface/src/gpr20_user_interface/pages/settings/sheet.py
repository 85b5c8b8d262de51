"""The sheet with the settings of the window: language, theme, dimming, robot."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, Tuple

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QButtonGroup, QGridLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import languages
from gpr20_operator.palette import Theme
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.settings import DIM_CHOICES_MIN, WindowSettings
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

MARGIN_PX = 24


class SettingsSheet(Overlay):
    """Shows the settings; each touch of a choice takes effect at once."""

    language_chosen = pyqtSignal(object)
    theme_chosen = pyqtSignal(object)
    dimming_chosen = pyqtSignal(int)

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.title = QLabel()
        self.title.setObjectName("title")
        self.close_button = new_button(self.hide)
        # Opens the list of robots; connected where there may be several.
        self.robot_button = QPushButton()
        self.robot_button.hide()
        self.language_label, self.theme_label, self.dim_label = QLabel(), QLabel(), QLabel()
        self.hint = QLabel()
        self.hint.setObjectName("quiet")
        self.hint.setWordWrap(True)
        self.languages: Dict[Language, QPushButton] = {}
        self.themes: Dict[Theme, QPushButton] = {}
        self.dim_choices: Dict[int, QPushButton] = {}
        for language in languages():
            self.languages[language] = _choice(partial(self.language_chosen.emit, language))
        for theme in Theme:
            self.themes[theme] = _choice(partial(self.theme_chosen.emit, theme))
        for minutes in DIM_CHOICES_MIN:
            self.dim_choices[minutes] = _choice(partial(self.dimming_chosen.emit, minutes))
        self._layout = QGridLayout(self)
        self._lay_out()
        self.retranslate()
        self.restyle()

    def show_settings(self, settings: WindowSettings) -> None:
        """Mark what is chosen."""
        self.languages[settings.language].setChecked(True)
        self.themes[settings.theme].setChecked(True)
        self.dim_choices[settings.dim_after_min].setChecked(True)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Settings"))
        self.close_button.setText(self.tr("CLOSE"))
        self.robot_button.setText(self.tr("OTHER ROBOT"))
        self.language_label.setText(self.tr("Language"))
        self.theme_label.setText(self.tr("Colours"))
        self.dim_label.setText(self.tr("Dim the screen after"))
        self.hint.setText(
            self.tr("The first touch of a dimmed screen only brightens it. STOP always acts.")
        )
        for language, button in self.languages.items():
            button.setText(language.own_name)
        names = {Theme.SUN: self.tr("Sunlight"), Theme.NIGHT: self.tr("Night")}
        for theme, button in self.themes.items():
            button.setText(names[theme])
        for minutes, button in self.dim_choices.items():
            text = self.tr("{minutes} min").format(minutes=minutes) if minutes else self.tr("Never")
            button.setText(text)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        margin, gap = look.px(MARGIN_PX), look.px(GAP_PX)
        self._layout.setContentsMargins(margin, gap, margin, gap)
        self._layout.setHorizontalSpacing(look.px(MARGIN_PX))
        self._layout.setVerticalSpacing(gap)

    def _lay_out(self) -> None:
        layout = self._layout
        layout.addWidget(self.title, 0, 0)
        rows: Tuple[Tuple[QLabel, Dict], ...] = (
            (self.language_label, self.languages),
            (self.theme_label, self.themes),
            (self.dim_label, self.dim_choices),
        )
        for row, (label, choices) in enumerate(rows, start=1):
            group = QButtonGroup(self)
            buttons = QHBoxLayout()
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
        bottom.addWidget(self.close_button, 1)
        layout.addLayout(bottom, 5, 0, 1, 2)
        layout.setColumnStretch(1, 1)
        layout.setRowStretch(4, 1)


def _choice(act: Callable[[], None]) -> QPushButton:
    button = new_button(act)
    button.setCheckable(True)
    button.setObjectName("choice")
    return button
