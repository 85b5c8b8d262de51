"""The frame of the window: the top bar, the tabs, and what lies over them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Callable, Dict, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QPushButton, QTabWidget, QVBoxLayout, QWidget

from gpr20_user_interface.mid.events import Request
from gpr20_user_interface.mid.profiles import MAX_NAME_LENGTH
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.control_view import ControlView, PadRequest
from gpr20_user_interface.views.key_pad import DIGITS, LETTERS, KeyPad
from gpr20_user_interface.views.notice import Notice, NoticeKind
from gpr20_user_interface.views.profiles_view import ProfilesView
from gpr20_user_interface.views.status_view import StatusView
from gpr20_user_interface.views.style import STYLE_SHEET
from gpr20_user_interface.views.top_bar import TopBar
from gpr20_user_interface.views.translation import Language, TranslatedWidget

WIDTH_PX = 800
HEIGHT_PX = 480


class TabName(enum.Enum):
    """The tabs, in their order."""

    CONTROL = "control"
    STATUS = "status"
    MAP = "map"
    RADAR = "radar"
    SURVEYS = "surveys"


@dataclass(frozen=True)
class Tabs:
    """What the tabs hold; a tab without a widget is left out."""

    control: ControlView
    status: StatusView
    map: Optional[QWidget] = None
    radar: Optional[QWidget] = None
    surveys: Optional[QWidget] = None


class MainWindow(TranslatedWidget):
    """Shows snapshots of a survey and tells what the operator wants."""

    # Carries the SurveyParameters.
    start_requested = pyqtSignal(object)
    stop_requested = pyqtSignal()
    pause_requested = pyqtSignal()
    resume_requested = pyqtSignal()
    language_requested = pyqtSignal()

    def __init__(self, tabs: Tabs, language: Language, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self.setStyleSheet(STYLE_SHEET)
        self.top_bar = TopBar()
        self.tabs = QTabWidget()
        self.control = tabs.control
        self.status = tabs.status
        self.language_button = QPushButton()
        self._language = language
        self._pages: Dict[TabName, QWidget] = {}
        for name in TabName:
            page = getattr(tabs, name.value)
            if page is not None:
                self._pages[name] = page
                self.tabs.addTab(page, "")
        self.number_pad = KeyPad(self, DIGITS)
        self.profiles = ProfilesView(self)
        self.name_pad = KeyPad(self, LETTERS)
        self.notice = Notice(self)
        self._lay_out()
        self._connect()
        self.retranslate()
        self.resize(WIDTH_PX, HEIGHT_PX)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self.top_bar.refresh(snapshot)
        self.control.refresh(snapshot)
        self.status.refresh(snapshot)
        if snapshot.fields_locked:
            # What was being entered would stand in the fields in place of the survey's parameters.
            for overlay in (self.number_pad, self.name_pad, self.profiles):
                overlay.hide()

    def show_refusal(self, request: Request, reason: str) -> None:
        """Open a dialog with the reason and the next step; STOP stays within reach."""
        self.notice.show_refusal(request, reason)

    def show_profile_trouble(self, reason: str) -> None:
        """Open a dialog about a profile that cannot be used."""
        self.notice.show_notice(NoticeKind.PROFILE, reason)

    def ask_profile_name(
        self, deliver: Callable[[str], None], is_allowed: Callable[[str], bool]
    ) -> None:
        """Open keys for the name of a profile.

        Args:
            deliver: Told the name.
            is_allowed: Tells whether a name can be used.
        """
        hint = self.tr(
            "a new name of at most {most} letters a to z, digits, blanks, - and _; "
            "first a letter or digit, no blank last"
        ).format(most=MAX_NAME_LENGTH)

        def judge(name: str) -> str:
            return "" if is_allowed(name) else hint

        self.name_pad.ask(deliver, self.tr("Save profile as"), hint, "", judge, strict=True)

    def show_tab(self, name: TabName) -> None:
        """Bring a tab to the front."""
        self.tabs.setCurrentWidget(self._pages[name])

    def show_language(self, language: Language) -> None:
        """Take note of the language that the window speaks."""
        self._language = language
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.setWindowTitle(self.tr("GPR-20"))
        titles = {
            TabName.CONTROL: self.tr("CONTROL"),
            TabName.STATUS: self.tr("STATUS"),
            TabName.MAP: self.tr("MAP"),
            TabName.RADAR: self.tr("RADAR"),
            TabName.SURVEYS: self.tr("SURVEYS"),
        }
        for name, page in self._pages.items():
            self.tabs.setTabText(self.tabs.indexOf(page), titles[name])
        # The language that a touch leads to, in its own words.
        self.language_button.setText(self._language.next.own_name)

    def _lay_out(self) -> None:
        self.tabs.setCornerWidget(self.language_button)
        self.tabs.tabBar().setExpanding(False)
        # Not by the style sheet, whose bold letters the tabs do not measure.
        font = self.tabs.tabBar().font()
        font.setBold(True)
        self.tabs.tabBar().setFont(font)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.top_bar)
        layout.addWidget(self.tabs, 1)

    def _connect(self) -> None:
        self.top_bar.stop_pressed.connect(self.stop_requested)
        self.control.start_pressed.connect(self.start_requested)
        self.control.pause_pressed.connect(self.pause_requested)
        self.control.resume_pressed.connect(self.resume_requested)
        self.control.pad_wanted.connect(self._on_pad_wanted)
        self.language_button.clicked.connect(self.language_requested)

    def _on_pad_wanted(self, request: PadRequest) -> None:
        # A wrong value may stand while another field is corrected; START stays locked.
        self.number_pad.ask(
            request.edit.setText,
            request.title,
            request.hint,
            request.edit.text(),
            request.judge,
            strict=False,
        )
