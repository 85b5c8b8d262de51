"""What main_control and the nodes say, and the states of a survey, in the operator's language."""

from __future__ import annotations

import re
import string
from functools import lru_cache
from typing import Dict, Optional, Tuple

from PyQt5.QtCore import QCoreApplication

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.views.robot_sentences import SENTENCES

BETWEEN_SENTENCES = "; "
# Places that hold another sentence; all others hold a value, which stays as it is.
SENTENCE_PLACES = frozenset(("reason", "error", "verdict", "lost", "meaning", "kind"))
VALUE_PATTERNS = {"service": r"[\w/]+", "missing": r"\d+"}
# The robot says few different things at a time, and each is shown again several times a second.
REMEMBERED_TEXTS = 256
# No sentence of the robot is as long; searching in text of any length takes time.
MOST_CHARACTERS = 1000


def robot_text(text: str) -> str:
    """Return what the robot says in the language of the application.

    A sentence is translated whole or, if it is not known, left whole in the robot's words: a
    reason must never be lost on the way to the operator.
    """
    return BETWEEN_SENTENCES.join(_told(one) for one in text.split(BETWEEN_SENTENCES))


def _told(sentence: str) -> str:
    known = _recognized(sentence)
    if known is None:
        return sentence
    template, values = known
    translated = QCoreApplication.translate("RobotText", template)
    return translated.format(
        **{
            place: _told(value) if place in SENTENCE_PLACES else value
            for place, value in values.items()
        }
    )


@lru_cache(maxsize=REMEMBERED_TEXTS)
def _recognized(sentence: str) -> Optional[Tuple[str, Dict[str, str]]]:
    if len(sentence) > MOST_CHARACTERS:
        return None
    for template, pattern in _PATTERNS:
        found = pattern.fullmatch(sentence)
        if found:
            return template, found.groupdict()
    return None


def _pattern(template: str) -> re.Pattern[str]:
    pieces = []
    for words, place, _, _ in string.Formatter().parse(template):
        pieces.append(re.escape(words))
        if place:
            pieces.append(f"(?P<{place}>{VALUE_PATTERNS.get(place, '.+?')})")
    return re.compile("".join(pieces), re.DOTALL)


def _rank(template: str) -> Tuple[bool, bool]:
    # A value at the beginning would take in the beginning of a sentence around its own.
    return template.startswith("{"), not template.startswith("{service}")


_PATTERNS = tuple((template, _pattern(template)) for template in sorted(SENTENCES, key=_rank))


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
