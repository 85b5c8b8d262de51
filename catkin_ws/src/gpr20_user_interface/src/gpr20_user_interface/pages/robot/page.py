"""ROBOT: what is wrong and the parts; behind a hold, axes and instruments."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtWidgets import QStackedWidget

from gpr20_operator.robot.notices import Notice, node_notice
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.pages.robot.overview import Overview
from gpr20_user_interface.pages.robot.service import ServiceScreen
from gpr20_user_interface.widgets.page import Page


class RobotPage(QStackedWidget, Page):
    """Shows the robot while it is in front; leaving it ends the service."""

    def __init__(self, model: ServiceModel, show_notice: Callable[[Notice], None]) -> None:
        super().__init__()
        self._model = model
        self._watched = False
        self.overview, self.service = Overview(), ServiceScreen()
        for screen in (self.overview, self.service):
            self.addWidget(screen)
        self.overview.parts.part_touched.connect(lambda node: show_notice(node_notice(node)))
        self.overview.entered.connect(lambda: self._after(model.enter))
        self.overview.check_requested.connect(lambda: self._after(model.check_everything))
        service, instruments = self.service, self.service.instruments
        service.left.connect(lambda: self._after(model.leave))
        service.touched.connect(model.touch)
        service.move_requested.connect(
            lambda axis, action, distance: self._after(lambda: model.move(axis, action, distance))
        )
        instruments.measure.clicked.connect(lambda: self._after(model.measure_height))
        instruments.analyzer.clicked.connect(lambda: self._after(model.test_analyzer))
        instruments.daily.clicked.connect(lambda: self._after(model.check_daily))

    @property
    def in_service(self) -> bool:
        """Whether the axes can be moved from here."""
        return self.currentWidget() is self.service

    def on_event(self, event: object) -> None:
        """Take an event about the robot."""
        self._model.on_event(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; end the service when another page is in front."""
        changed = self.isVisible() != self._watched
        if changed:
            self._watched = self.isVisible()
            self._model.set_watched(self._watched)
        self._model.refresh(snapshot)
        if self._watched or changed:
            self.overview.parts.show_health(snapshot.health)
            self._show()

    def draw(self) -> None:
        """Judge the robot again."""
        if self._watched:
            self.overview.show_findings(self._model.findings())

    def _after(self, act: Callable[[], None]) -> None:
        """Do something, and show its effect at once: a second touch must not repeat it."""
        act()
        self._show()

    def _show(self) -> None:
        if self._model.entered != self.in_service:
            self.service.begin()
            self.setCurrentIndex(int(self._model.entered))
        self.overview.show_model(self._model)
        self.service.show_model(self._model)
