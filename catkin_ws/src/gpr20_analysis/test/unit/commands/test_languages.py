"""People read the commands and the report in their language; programs read the same as ever."""

from __future__ import annotations

import json

import pytest
import xarray as xr
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands import main as gpr20
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.report import build
from gpr20_analysis.report.summary import settings_of, summary_of
from gpr20_analysis.sentences import sentences_of
from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.message import Message, verbatim
from gpr20_survey.trace.calibration import CalibrationStatus

ALL = len(POINTS)
SPANISH = {
    "First: {remedy}": "Primero: {remedy}",
    "{path} does not exist": "{path} no existe",
    "missing: {position}": "falta: {position}",
    "{stored} of {planned} planned traces are stored and readable": "{stored} de {planned} trazas",
    "INCOMPLETE, but intact: {counted}": "INCOMPLETA, pero intacta: {counted}",
    "Verdict": "Veredicto",
    "No image was made: {reason}": "No hay imagen: {reason}",
    "Coverage: {usable} of {total} samples usable": "Cobertura: {usable} de {total}",
}


@pytest.fixture(autouse=True)
def catalogues(monkeypatch):
    """Spanish of this test's own, so that it does not follow each change of the catalogue."""

    def read(language):
        return Catalogue(SPANISH if language == Language.SPANISH else None)

    for module in (gpr20, build):
        monkeypatch.setattr(module, "read_catalogue", read)
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LANG", "en_US.UTF-8")


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("stopped"), ALL - 4, "stopped")


def test_the_language_is_an_option_anywhere_else_that_of_the_environment(
    tmp_path, capsys, monkeypatch
):
    for place in range(3):
        arguments = ["info", str(tmp_path / "nowhere")]
        arguments[place:place] = ["--language", "es"]
        assert gpr20.main(arguments) == 3
        said, first = capsys.readouterr().err.splitlines()
        assert said.startswith(f"gpr20 info: {tmp_path}/nowhere") and first.startswith("Primero: ")
    monkeypatch.setenv("LANG", "es_PE.UTF-8")
    assert gpr20.main(["info", str(tmp_path / "nowhere")]) == 3
    assert "Primero: " in capsys.readouterr().err


def test_the_verdict_and_the_warnings_are_translated(stopped, capsys):
    assert gpr20.main(["verify", str(stopped), "--language", "es"]) == 1
    verdict, first = capsys.readouterr().out.splitlines()[-2:]
    assert verdict.startswith("INCOMPLETA") and f" {ALL - 4} de {ALL} " in verdict
    assert first.startswith("Primero: ")
    assert gpr20.main(["info", str(stopped), "--language", "es"]) == 1
    assert "falta: x " in capsys.readouterr().err


def test_json_for_programs_is_the_same_in_every_language(stopped, capsys):
    answers = []
    for language in ("en", "es"):
        assert gpr20.main(["info", str(stopped), "--json", "--language", language]) == 1
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]
    assert answers[0]["missing"][0].startswith("missing: x ")


@pytest.mark.usefixtures("blank_figures")
def test_the_report_is_written_in_the_language(stopped, tmp_path):
    output = tmp_path / "report.html"
    assert gpr20.main(["report", str(stopped), "-o", str(output), "--language", "es"]) == 1
    text = output.read_text(encoding="utf-8")
    assert '<html lang="es">' in text
    for words in ("<h2>Veredicto</h2>", "INCOMPLETA", "falta: x ", "No hay imagen: "):
        assert words in text


def test_reason_and_calibration_are_translated_where_their_template_is_known(stopped):
    verdict = Message("complete: all {planned} planned traces are stored", planned=4)
    calibration = CalibrationStatus.HIGH.meaning
    described = {
        "reason_message": json.loads(verdict.to_json()),
        "instrument": {"calibration": str(calibration)},
    }
    survey = load_survey(stopped).assign_attrs(
        survey_json=json.dumps(described), reason=str(verdict)
    )
    assert verdict in [text for _, text in summary_of(survey)]
    assert calibration in [text for _, text in settings_of(survey)]


def test_sentences_without_a_template_that_fits_stay_in_english():
    for messages in (
        "{}", "{", "[]", "5", 5, "[" * 100_000, '{"by hand": "{"}',
        '{"by hand": 5}', '{"by hand": null}', '{"by hand": true}', '{"by hand": ["x"]}',
    ):  # fmt: skip
        survey = xr.Dataset(attrs={"notes": ["by hand"], "messages": messages})
        assert sentences_of(survey, "notes") == [verbatim("by hand")], messages
