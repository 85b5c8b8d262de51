"""The picture of the states in docs/architecture.md is the table."""

import re
from pathlib import Path

from gpr20_survey.plan.survey_state import TRANSITIONS, SurveyState

ARCHITECTURE = Path(__file__).resolve().parents[5] / "docs" / "architecture.md"
ARROW = re.compile(r"^ +(\w+) --> (\w+)(?: : .+)?$", re.MULTILINE)


def test_the_picture_shows_the_states_and_the_ways_of_the_table():
    (picture,) = re.findall(
        r"```mermaid\nstateDiagram-v2\n(.*?)```", ARCHITECTURE.read_text(), re.S
    )
    arrows = ARROW.findall(picture)
    assert len(arrows) == len(picture.splitlines()), "a line is no arrow"
    assert len(set(arrows)) == len(arrows)
    drawn = {
        (SurveyState[before], SurveyState[after]) for before, after in arrows if before != "[*]"
    }
    assert drawn == {(one, after) for one, others in TRANSITIONS.items() for after in others}
