"""The settings of the window, remembered over a restart; who may start on the web page."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Callable, Dict, Iterable, Mapping, Optional, Tuple

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QButtonGroup, QLabel, QPushButton, QWidget

from gpr20_common.catalogue import Language, language_from_code, languages
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.errors import SettingsError
from gpr20_operator.palette import Theme
from gpr20_operator.plan.texts import HoldQuestion, remote_question
from gpr20_operator.robot.events import StartPlan
from gpr20_operator.robot.remote_control import Arming, remote_obstacle
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.low.settings_file import SettingsFile, settings_writer
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    Page,
    column,
    grid,
    new_button,
    new_label,
    row,
    say,
)

DIM_CHOICES_MIN = (0, 2, 5, 10)


@dataclass(frozen=True)
class WindowSettings:
    """What the operator has chosen.

    Attributes:
        language: Language of the window.
        theme: Colours of the window.
        dim_after_min: Time without a touch after which the screen is dimmed [min]; 0: never.
    """

    language: Language = Language.ENGLISH
    theme: Theme = Theme.SUN
    dim_after_min: int = 5

    @property
    def dim_after_s(self) -> Optional[float]:
        """Time without a touch after which the screen is dimmed [s]; None: never."""
        return self.dim_after_min * 60.0 if self.dim_after_min else None


def settings_from(values: Mapping[str, Any]) -> WindowSettings:
    """Return the settings of a file; what is missing has its default.

    Raises:
        SettingsError: A value is not one that this program writes.
    """
    given = {**values_of(WindowSettings()), **values}
    minutes = given["dim_after_min"]
    try:
        if isinstance(minutes, bool) or minutes not in DIM_CHOICES_MIN:
            raise ValueError("dim_after_min")
        return WindowSettings(language_from_code(given["language"]), Theme(given["theme"]), minutes)
    except ValueError as error:
        raise SettingsError(
            Message(
                "the settings of the window are damaged ({reason}); the defaults are used",
                reason=error,
            )
        ) from error


def values_of(settings: WindowSettings) -> Dict[str, Any]:
    """Return the content of the file."""
    return {
        "language": settings.language.value,
        "theme": settings.theme.value,
        "dim_after_min": settings.dim_after_min,
    }


class WindowMemory:
    """Reads the settings once and writes each change, not in the thread of the window.

    Args:
        file: The file; None: nothing is remembered.
        failed: Called if they cannot be read or written, also from another thread.

    Attributes:
        settings: The settings now.
    """

    def __init__(
        self,
        file: Optional[SettingsFile] = None,
        failed: Callable[[Message], None] = lambda _: None,
    ) -> None:
        self.settings = WindowSettings()
        self._writer = None if file is None else settings_writer(file, failed)
        if file is not None:
            try:
                self.settings = settings_from(file.read())
            except SettingsError as error:
                failed(error.message)

    def change(self, **changes: Any) -> None:
        """Change some settings, and remember them soon."""
        changed = replace(self.settings, **changes)
        if changed != self.settings and self._writer is not None:
            self._writer.put(values_of(changed))
        self.settings = changed

    def close(self, timeout_s: float) -> bool:
        """Return whether the settings are written within a time [s]."""
        return self._writer is None or self._writer.wait(timeout_s)


HINT = Message("The first touch of a dimmed screen only brightens it. STOP always acts.")


class SettingsPage(Overlay):
    """Shows the settings; each touch of a choice takes effect at once and is remembered.

    Args:
        window: The window.
        languages: Languages of the window.
        use_theme: Changes the theme of the window.
        memory: What was chosen before.

    Attributes:
        remote_button: Opens what concerns the web page.
    """

    def __init__(
        self,
        window: QWidget,
        languages_used: Languages,
        use_theme: Callable[[Theme], None],
        memory: WindowMemory,
    ) -> None:
        super().__init__(window)
        self._languages = languages_used
        self._apply_theme = use_theme
        self._memory = memory
        self.title = new_label("title", text=Message("Settings"))
        self.hint = new_label("quiet", wraps=True)
        self.close_button = new_button(self.hide, Message("CLOSE"))
        self.remote_button = new_button(self.hide, Message("REMOTE CONTROL"))
        self.languages: Dict[Language, QPushButton] = self._choices(languages(), self._use_language)
        self.themes: Dict[Theme, QPushButton] = self._choices(Theme, self._use_theme)
        self.dim_choices: Dict[int, QPushButton] = self._choices(DIM_CHOICES_MIN, self._dim_after)
        self._write_choices()
        self._lay_out()

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
        self.labels = [new_label(text=title) for title, _choices in rows]
        for number, (label, (_title, choices)) in enumerate(zip(self.labels, rows)):
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


class RemotePage(HoldSheet, Page):
    """Says where the web page is; a hold allows START and RESUME there until the next touch.

    Args:
        window: The window.
        arming: Whether they are allowed.
        plan: Returns what START would measure now.
        mark: Shows on every page that they are allowed, and how long.
        open_button: Opens the sheet.
    """

    # A survey has begun while it was allowed: the page has started it.
    survey_began = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        arming: Arming,
        plan: Callable[[], Optional[StartPlan]],
        mark: QLabel,
        open_button: QPushButton,
    ) -> None:
        super().__init__(window)
        self._arming, self._plan, self._mark = arming, plan, mark
        self._snapshot: Optional[Snapshot] = None
        open_button.clicked.connect(lambda: self.ask(self._current(), self._arm))

    def on_event(self, event: object) -> None:
        """Follow what the web page says."""
        self._arming.take(event)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show how long it is still allowed; end it if something forbids it."""
        before, self._snapshot = self._snapshot, snapshot
        self._arming.note(snapshot, self._plan())
        known = "" if before is None else before.running_survey
        if self._arming.armed and snapshot.running_survey not in ("", known):
            self.survey_began.emit()
        self._show_mark()
        if self.isVisible():
            self.show_question(self._current())

    def end(self) -> None:
        """Allow it no more: somebody has touched the window, or it closes."""
        if self._arming.armed:
            self._arming.touched()
            self._show_mark()

    def _arm(self) -> None:
        if self._snapshot is not None:
            self._arming.arm(self._snapshot)
            self._show_mark()

    def _current(self) -> HoldQuestion:
        snapshot = self._snapshot
        return remote_question(
            self._arming.web, None if snapshot is None else remote_obstacle(snapshot)
        )

    def _show_mark(self) -> None:
        left_s = math.ceil(self._arming.remaining_s)
        self._mark.setVisible(left_s > 0)
        title = self.tr("REMOTE")
        self._mark.setText(f"{title}\n{left_s // 60}:{left_s % 60:02d}")
