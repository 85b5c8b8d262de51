"""Connects SERVICE with the robot."""

from __future__ import annotations

from typing import Callable

from gpr20_operator.robot.service_model import ServiceModel
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.pages.service.view import ServiceView
from gpr20_user_interface.widgets.page import Page


class ServiceBinding(Page):
    """Passes the operator's requests on, and ends the service when its tab is left.

    Args:
        survey: Knows which events are about the robot that is shown.
        model: What is known of the service.
        view: The tab.
        is_in_front: Returns whether the tab is in front.
    """

    def __init__(
        self,
        survey: WindowPresenter,
        model: ServiceModel,
        view: ServiceView,
        is_in_front: Callable[[], bool],
    ) -> None:
        self._survey = survey
        self._model = model
        self._view = view
        self._is_in_front = is_in_front
        self._watched = False
        view.entered.connect(lambda: self._after(model.enter))
        view.left.connect(lambda: self._after(model.leave))
        view.touched.connect(model.touch)
        view.move_requested.connect(
            lambda axis, action, distance: self._after(lambda: model.move(axis, action, distance))
        )
        view.height_requested.connect(lambda: self._after(model.measure_height))
        view.check_requested.connect(lambda: self._after(model.check_everything))
        view.daily_check_requested.connect(lambda: self._after(model.check_daily))
        view.test_requested.connect(lambda: self._after(model.test_analyzer))

    def on_event(self, event: object) -> None:
        """Take an event about the robot."""
        self._model.on_event(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        in_front = self._is_in_front()
        changed = in_front != self._watched
        if changed:
            self._watched = in_front
            self._model.set_watched(in_front)
        self._model.refresh(snapshot)
        if in_front or changed:
            self._view.show_state(self._model.state)

    def draw(self) -> None:
        """Judge the robot again."""
        if self._watched:
            self._view.show_findings(self._model.findings())

    def _after(self, act: Callable[[], None]) -> None:
        """Do something, and show its effect at once: a second touch must not repeat it."""
        act()
        self._view.show_state(self._model.state)
