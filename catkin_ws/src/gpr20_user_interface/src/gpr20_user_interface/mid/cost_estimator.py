"""Estimates what a survey costs beside the window's thread: a large one takes seconds."""

from __future__ import annotations

import threading
from typing import Optional, Tuple

from PyQt5.QtCore import QObject, pyqtSignal

from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.events import RobotFigures


class CostEstimator(QObject):
    """Answers the newest question; questions that were overtaken are left out."""

    # Carries the SurveyParameters and their SurveyCost.
    estimated = pyqtSignal(object, object)

    def __init__(self) -> None:
        super().__init__()
        self._lock = threading.Lock()
        self._wanted: Optional[Tuple[SurveyParameters, RobotFigures]] = None
        self._working = False
        self._closed = False

    def close(self) -> None:
        """Answer nothing more, whatever is still being estimated."""
        with self._lock:
            self._closed = True

    def ask(self, parameters: SurveyParameters, figures: RobotFigures) -> None:
        """Estimate; the answer is a signal."""
        with self._lock:
            self._wanted = parameters, figures
            if self._working:
                return
            self._working = True
        threading.Thread(target=self._work, name="cost_estimator", daemon=True).start()

    def _work(self) -> None:
        while True:
            with self._lock:
                if self._wanted is None or self._closed:
                    self._working = False
                    return
                (parameters, figures), self._wanted = self._wanted, None
            cost = survey_cost(parameters, figures.facts, figures.settings)
            with self._lock:
                # The receiver, and this object, may be gone once it has been closed.
                if not self._closed:
                    self.estimated.emit(parameters, cost)
