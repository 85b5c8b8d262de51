"""A report in a language of somebody else's."""

from pseudo_language import PSEUDO, write_pseudo_catalogue
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands import main as gpr20
from gpr20_common.low.catalogue_file import VARIABLE


def test_the_report_is_written_in_a_language_of_this_computer(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    write_pseudo_catalogue(tmp_path)
    survey = make_survey(tmp_path, len(POINTS) - 4, "stopped")
    output = tmp_path / "report.html"
    arguments = ["report", str(survey), "-o", str(output), "--language", PSEUDO.value]
    assert gpr20.main(arguments) == 1
    text = output.read_text(encoding="utf-8")
    assert f'<html lang="{PSEUDO.value}">' in text
    assert "<h2>Vérdîçt" in text
