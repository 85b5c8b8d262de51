"""The states of a survey in the operator's language."""

from __future__ import annotations

from PyQt5.QtCore import QCoreApplication

from gpr20_survey.plan.survey_state import SurveyState


def state_title(state: SurveyState) -> str:
    """Return a state as a title."""
    translate = QCoreApplication.translate
    return {
        SurveyState.IDLE: translate("SurveyState", "IDLE"),
        SurveyState.CONFIGURED: translate("SurveyState", "CONFIGURED"),
        SurveyState.CHECKING: translate("SurveyState", "CHECKING"),
        SurveyState.HOMING: translate("SurveyState", "HOMING"),
        SurveyState.SURVEYING: translate("SurveyState", "SURVEYING"),
        SurveyState.PAUSED: translate("SurveyState", "PAUSED"),
        SurveyState.PAUSING: translate("SurveyState", "PAUSING"),
        SurveyState.STOPPING: translate("SurveyState", "STOPPING"),
        SurveyState.FINISHED: translate("SurveyState", "FINISHED"),
        SurveyState.STOPPED: translate("SurveyState", "STOPPED"),
        SurveyState.FAILED: translate("SurveyState", "FAILED"),
    }[state]
