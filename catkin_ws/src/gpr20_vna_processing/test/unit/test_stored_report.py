"""The report of a survey that is open."""

from __future__ import annotations

from fault_kit import raises_fault
from reopening_kit import (
    data,
    finish,
    folder,
    kit,
)
from storage_kit import OTHER_SURVEY
from trace_examples import SURVEY, read_json

from gpr20_survey.errors import SurveyRefusedError

__all__ = ["data", "folder", "kit"]


def test_a_report_is_kept_and_survives_everything(kit, folder):
    reopened = kit.processing.reopen_survey(SURVEY)
    kit.processing.report(SURVEY, '{"verdict": "old"}')
    kit.processing.report(SURVEY, '{"verdict": "new", "coverage": "mm-"}')
    expected = {"verdict": "new", "coverage": "mm-"}
    assert read_json(folder / "survey.json")["report"] == expected
    finish(kit, folder, reopened)
    survey = read_json(folder / "survey.json")
    assert (survey["report"], survey["outcome"]) == (expected, "finished")


REFUSED = "storage.request_refused"


def test_a_wrong_report_is_refused_and_the_former_kept(kit, folder):
    kit.processing.reopen_survey(SURVEY)
    kit.processing.report(SURVEY, '{"verdict": "old"}')
    for survey_id, text, *expected in [
        (SURVEY, "[]", REFUSED, "report_json", "list"),
        (SURVEY, "{", REFUSED, "report_json"),
        (SURVEY, '{"a": NaN}', REFUSED, "NaN"),
        (SURVEY, '{"a": "' + "x" * (8 << 20) + '"}', REFUSED, 8388608),
        (OTHER_SURVEY, "{}", "survey.other_open", SURVEY),
        ("..", "{}", REFUSED, ".."),
    ]:
        with raises_fault(*expected, error=SurveyRefusedError):
            print(kit.processing.report(survey_id, text))
    assert read_json(folder / "survey.json")["report"] == {"verdict": "old"}


def test_a_report_without_a_survey_is_refused(kit):
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        kit.processing.report(SURVEY, "{}")
