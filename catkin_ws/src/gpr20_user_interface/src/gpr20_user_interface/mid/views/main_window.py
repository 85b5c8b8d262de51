"""The window as a whole: who is told what, and who is heard."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QMessageBox, QPlainTextEdit, QVBoxLayout, QWidget

from gpr20_user_interface.mid.parameter_form import FormCheck, check_form
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.survey_state import DOCUMENTED_TRAVEL, Request
from gpr20_user_interface.mid.views.banners import Banners
from gpr20_user_interface.mid.views.command_bar import CommandBar
from gpr20_user_interface.mid.views.parameter_form_view import ParameterFormView
from gpr20_user_interface.mid.views.position_panel import PositionPanel
from gpr20_user_interface.mid.views.progress_panel import ProgressPanel
from gpr20_user_interface.mid.views.status_panel import StatusPanel
from gpr20_user_interface.mid.views.style import STYLE_SHEET

WIDTH_PX = 800
HEIGHT_PX = 480


class MainWindow(QWidget):
    """Shows snapshots of a survey and tells what the operator wants."""

    # Carries the SurveyParameters.
    start_requested = pyqtSignal(object)
    stop_requested = pyqtSignal()
    resume_requested = pyqtSignal()

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("GPR-20"))
        self.setStyleSheet(STYLE_SHEET)
        self.banners = Banners()
        self.form = ParameterFormView()
        self.problems = QPlainTextEdit()
        self.status = StatusPanel()
        self.progress = ProgressPanel()
        self.positions = PositionPanel()
        self.commands = CommandBar()
        self._travel = DOCUMENTED_TRAVEL
        self._snapshot: Optional[Snapshot] = None
        self._check: FormCheck = check_form(self.form.texts(), self._travel)
        self._lay_out()
        self._connect()
        self.resize(WIDTH_PX, HEIGHT_PX)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        if (snapshot.travel or DOCUMENTED_TRAVEL) != self._travel:
            self._travel = snapshot.travel or DOCUMENTED_TRAVEL
            self._check_form()
        self._snapshot = snapshot
        self.banners.show_simulated(snapshot.simulated)
        self.banners.show_control(snapshot.control_alive, snapshot.control_silent_s)
        self.form.setEnabled(not snapshot.fields_locked)
        self._show_remarks()
        self.status.show_state(snapshot.state)
        self.progress.show_progress(snapshot.progress)
        self.positions.show_current(snapshot.current)
        self.positions.show_target(snapshot.target)
        self.positions.show_height(snapshot.height_m)
        self._enable_commands()

    def show_refusal(self, request: Request, reason: str) -> None:
        """Open a dialog with the reason; the window stays usable, STOP above all."""
        titles = {
            Request.START: self.tr("The survey was not started"),
            Request.STOP: self.tr("STOP was not accepted"),
            Request.RESUME: self.tr("The survey was not resumed"),
        }
        dialog = QMessageBox(self)
        dialog.setIcon(QMessageBox.Icon.Warning)
        dialog.setWindowTitle(titles[request])
        dialog.setText(f"{titles[request]}.")
        dialog.setInformativeText(reason)
        dialog.setTextFormat(Qt.TextFormat.PlainText)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setWindowModality(Qt.WindowModality.NonModal)
        dialog.show()

    def _lay_out(self) -> None:
        self.problems.setObjectName("problems")
        self.problems.setReadOnly(True)
        self.problems.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        left, right = QVBoxLayout(), QVBoxLayout()
        left.addWidget(self.form)
        left.addWidget(self.problems, 1)
        right.addWidget(self.status, 1)
        right.addWidget(self.progress)
        right.addSpacing(8)
        right.addWidget(self.positions)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 8, 8, 8)
        grid.setHorizontalSpacing(16)
        grid.addWidget(self.banners, 0, 0, 1, 2)
        grid.addLayout(left, 1, 0)
        grid.addLayout(right, 1, 1)
        grid.addWidget(self.commands, 2, 0, 1, 2)
        for column in (0, 1):
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(1, 1)

    def _connect(self) -> None:
        self.form.changed.connect(self._on_form_changed)
        self.commands.start_pressed.connect(self._on_start)
        self.commands.stop_pressed.connect(self.stop_requested)
        self.commands.resume_pressed.connect(self.resume_requested)

    def _on_form_changed(self) -> None:
        self._check_form()
        self._show_remarks()
        self._enable_commands()

    def _on_start(self) -> None:
        if self._check.parameters is not None:
            self.start_requested.emit(self._check.parameters)

    def _check_form(self) -> None:
        self._check = check_form(self.form.texts(), self._travel)
        self.form.show_problems(self._check.field_problems)

    def _show_remarks(self) -> None:
        text = "\n".join(self._check.sentences)
        if self._snapshot is not None and self._snapshot.running:
            # What stands in the fields is what this window would start, not what runs.
            foreign = self.tr("The running survey was not started here: it has its own parameters.")
            text = "" if self._snapshot.started_here else foreign
        if text != self.problems.toPlainText():
            self.problems.setPlainText(text)

    def _enable_commands(self) -> None:
        known = self._snapshot
        self.commands.enable(
            start=known is not None and known.can_start and self._check.parameters is not None,
            stop=known is not None and known.can_stop,
            resume=known is not None and known.can_resume,
        )
