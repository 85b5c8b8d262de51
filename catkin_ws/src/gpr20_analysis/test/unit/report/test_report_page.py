"""The report is one HTML file that says first where to look, then what to doubt."""

import base64
import math
import re

import pytest
import xarray as xr
from case_kit import each_case
from log_examples import NOW
from survey_kit import POINTS, describe_again, make_survey
from translation_kit import shown_is_translated  # noqa: F401

from gpr20_analysis.commands.main import main
from gpr20_analysis.report.page import Report, Section, page
from gpr20_analysis.report.sections import title_of
from gpr20_analysis.sentences import ENGLISH
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import open_log, recover

ALL = len(POINTS)
OPTIONS = ["--permittivity", "4", "--depth", "0", "0.02", "0.005"]
LOW = ["--height", "0.03"]  # the sweep of these surveys shows short delays only


def report(tmp_path, stored, outcome, changes=None, more=LOW, annotation=()):
    folder = make_survey(tmp_path, stored, outcome, changes or {})
    assert main(["annotate", str(folder), *annotation]) == 0
    output = tmp_path / "report.html"
    status = main(["report", str(folder), "--output", str(output), *OPTIONS, *more])
    return status, output.read_text(encoding="utf-8")


ORDER = (
    *("Places to check", "What could have been missed", "How far the data can be believed"),
    *("Image of the ground", "Coverage and quality", "Data as measured", "Survey and settings"),
)


def test_the_page_loads_nothing_and_answers_in_the_order_of_an_officer(tmp_path):
    named = ["--name", "Carmen 3", "--site", "El Carmen"]
    status, text = report(tmp_path, ALL, "finished", annotation=named)
    assert status == 0
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    figures = re.findall(r"data:image/png;base64,([^\"]+)", text)
    assert len(figures) >= 6
    assert all(base64.b64decode(one).startswith(b"\x89PNG") for one in figures)
    headings = [re.sub(":.*", "", one) for one in re.findall("<h2>(.*?)</h2>", text)]
    assert tuple(headings) == ORDER
    first = text[text.index("<h2>") : text.index("<h2>What could")]
    assert first.index("<figure>") < first.index("<th>strength</th>")
    believed = text[text.index("<h2>How far") : text.index("<h2>Image")]
    assert "complete and intact" in believed and "permittivity is 4" in believed
    assert "3 stops from 10.0 to 20.0 mm" in text


@each_case(
    "known, title",
    [
        ({"survey_name": "Carmen 3", "site": "El Carmen", "started": "2026-09-21T14:13:20Z"},
         "GPR-20 survey Carmen 3, El Carmen, 2026-09-21"),
        ({"site": "El Carmen", "started": "2026-09-21T14:13:20Z"},
         "GPR-20 survey El Carmen, 2026-09-21"),
        ({"started": "2026-09-21T14:13:20Z"}, "GPR-20 survey 2026-09-21"),
        ({}, "GPR-20 survey line.nc"),
    ],
)  # fmt: skip
def test_the_title_is_name_site_and_date_and_never_the_id(known, title):
    survey = xr.Dataset(attrs={"survey_id": "e0bd3ae3", "source": "line.nc", **known})
    assert title_of(survey, ENGLISH) == title


@pytest.mark.usefixtures("blank_figures")
def test_a_spanish_report_has_decimal_commas_and_days_first(tmp_path):
    _status, text = report(tmp_path, ALL, "finished", more=[*LOW, "--language", "es"])
    text = text[: text.index("software del informe")]
    shown = re.sub("<[^>]*>", " ", re.sub("(?s)<style>.*?</style>", "", text))
    assert re.search(r"\d,\d", shown) and re.search(r"\d\d/\d\d/\d{4} \d\d:", shown)
    # Addresses and versions have more points.
    found = re.findall(r".{20}(?<![\w.])\d+\.\d+(?![\w.]).{9}|\d{4}-\d\d-\d\d.{9}", shown)
    assert found == []


@pytest.mark.usefixtures("blank_figures")
def test_missing_samples_are_the_first_thing_that_is_said(tmp_path):
    status, text = report(tmp_path, ALL - 4, "stopped")
    assert status == 1
    assert text.index("4 of 18 samples have no data") < text.index("How far the data")
    first = text[: text.index("What could have been missed")]
    assert "No image was made" in first and "no clearance" in first
    assert "missing: x " in text


@pytest.mark.usefixtures("blank_figures")
def test_warnings_of_the_robot_are_shown_in_the_language_of_the_reader(tmp_path, capsys):
    message = {"sentence": "Set back by {step_s:.1f} s.", "values": {"step_s": 120.0}}
    warning = {"time": "2026-09-21T14:13:20+00:00", "warning": "set back", "warning_message": None}
    recorded = {"warnings": [warning, {**warning, "warning_message": message}, 7]}
    folder = make_survey(tmp_path, ALL, "finished")
    describe_again(folder, report=recorded)
    output = tmp_path / "report.html"
    main(["report", str(folder), "--output", str(output)])
    text = output.read_text(encoding="utf-8")
    for words in ("warning of the robot at 2026-09-21 14:13:20 UTC: set back", "120.0 s"):
        assert words in text[: text.index("<h2>Survey and settings</h2>")]
    capsys.readouterr()
    assert main(["info", str(folder), "--language", "es"]) == 0
    assert "advertencia del robot del 21/09/2026 14:13:20 UTC" in capsys.readouterr().out


@pytest.mark.usefixtures("blank_figures")
def test_words_of_a_survey_are_never_markup(tmp_path):
    remark = "<script>alert(1)</script>"
    note = ["--operator", "Lucía Peña", "--notes", f"wet\n{remark}", "--position", "4.6,-74.1"]
    _, text = report(tmp_path, ALL, "finished", {2: {"quality": (remark,)}}, annotation=note)
    assert "<script>" not in text
    for words in ("Lucía Peña", "wet\n&lt;script&gt;", "4.6, -74.1", "complete and intact"):
        assert words in text
    assert "&lt;script&gt;" in text
    cells = ("<b>",)
    section = Section("<b>", "<b>", ["<b>"], ["<b>"], [], cells, [cells], ("<b>", [cells]))
    assert "<b>" not in page(Report("<b>", [section], banner="<b>"))


@pytest.mark.usefixtures("blank_figures")
def test_the_largest_drift_and_noise_of_all_visits_are_shown(tmp_path):
    # Without heights there is no image, which takes most of the time.
    blind = {index: {"antennae_height_m": math.nan} for index in range(ALL)}
    folder = make_survey(tmp_path, ALL, "finished", blind)
    describe_again(folder)
    log = open_log(folder, recover(folder), NOW)
    turns = [(0.1, 1.5, -60.0), (0.2, 0.5, None), (0.3, 1.0, -55.0), (0.2, 0.2, -70.0)]
    for pair in (turns[:2], turns[2:]):
        rotations = [{"amplitude_rms_db": one, "phase_rms_deg": other, "noise_db": noise}
                     for one, other, noise in pair]  # fmt: skip
        log.add(log.next(Kind.DRIFT, {"rotations": [*rotations, 7, {}]}, NOW))
    output = tmp_path / "report.html"
    main(["report", str(folder), "--output", str(output)])
    text = output.read_text(encoding="utf-8")
    said = "Visits of the first stop: 2. The amplitude drifted by at most 0.3 dB and the phase by "
    assert f"{said}at most 1.5 deg" in text and "is at most -55 dB" in text
    assert "not measured" in text and "No image was made" in text
