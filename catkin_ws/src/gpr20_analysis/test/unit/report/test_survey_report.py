"""The report holds everything in one file, and says what is wrong first."""

from __future__ import annotations

import base64
import json
import math
import re

import pytest
from survey_kit import POINTS, SURVEY, describe_again, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.report import pictures
from gpr20_analysis.report.page import page
from gpr20_analysis.report.records import Report, Section

ALL = len(POINTS)
OPTIONS = ["--permittivity", "4", "--depth", "0", "0.02", "0.005"]
LOW = ["--height", "0.03"]  # the sweep of these surveys shows short delays only


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


def report(tmp_path, stored, outcome, changes=None, more=LOW, annotation=()):
    folder = make_survey(tmp_path, stored, outcome, changes or {})
    assert main(["annotate", str(folder), *annotation]) == 0
    output = tmp_path / "report.html"
    status = main(["report", str(folder), "--output", str(output), *OPTIONS, *more])
    return status, output.read_text(encoding="utf-8")


def test_the_page_loads_nothing_and_holds_its_figures(tmp_path):
    status, text = report(tmp_path, ALL, "finished")
    assert status == 0
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    figures = re.findall(r"data:image/png;base64,([^\"]+)", text)
    assert len(figures) >= 6
    assert all(base64.b64decode(one).startswith(b"\x89PNG") for one in figures)
    for words in ("complete and intact", "Coverage", "B-scan along x", "Maximum projections"):
        assert words in text


@pytest.mark.usefixtures("blank_figures")
def test_a_soil_is_enough_for_the_finer_figures(tmp_path):
    folder = make_survey(tmp_path, ALL, "finished")
    output = tmp_path / "report.html"
    soil = ["--soil", "dry-sand", *OPTIONS[2:], *LOW]
    assert main(["report", str(folder), "--output", str(output), *soil]) == 0
    assert "permittivity" in output.read_text(encoding="utf-8")


@pytest.mark.usefixtures("blank_figures")
def test_missing_samples_are_the_first_thing_that_is_said(tmp_path):
    status, text = report(tmp_path, ALL - 4, "stopped")
    assert status == 1
    assert text.index("4 of 18 samples have no data") < text.index("Coverage and quality")
    assert "No image was made" in text
    assert "missing: x " in text


@pytest.mark.usefixtures("blank_figures")
def test_warnings_of_the_robot_are_shown_in_the_language_of_the_reader(tmp_path, capsys):
    message = {
        "template": "The computer's clock was set back by {step_s:.1f} s.",
        "values": {"step_s": 120.0},
    }
    warning = {"time": "2026-09-21T14:13:20+00:00", "warning": "set back", "warning_message": None}
    recorded = {"warnings": [warning, {**warning, "warning_message": message}, 7]}
    folder = make_survey(
        tmp_path,
        ALL,
        "finished",
        at_end=lambda storage: storage.report(SURVEY, json.dumps(recorded)),
    )
    output = tmp_path / "report.html"
    main(["report", str(folder), "--output", str(output), *OPTIONS, *LOW])
    text = output.read_text(encoding="utf-8")
    for words in ("warning of the robot at 2026-09-21T14:13:20+00:00: set back", "120.0 s"):
        assert words in text[: text.index("<h2>Survey</h2>")]
    capsys.readouterr()
    assert main(["info", str(folder), "--language", "es"]) == 0
    assert "advertencia del robot a las 2026-09-21T14:13:20+00:00: set back" in (
        capsys.readouterr().out
    )
    assert main(["info", str(folder), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["warnings"]) == 2


@pytest.mark.usefixtures("blank_figures")
def test_words_of_a_survey_are_never_markup(tmp_path):
    remark = "<script>alert(1)</script>"
    note = ["--operator", "Lucía Peña", "--notes", f"wet\n{remark}", "--position", "4.6,-74.1"]
    _, text = report(tmp_path, ALL, "finished", {2: {"quality": (remark,)}}, annotation=note)
    assert "<script>" not in text
    for words in ("Lucía Peña", "wet\n&lt;script&gt;", "4.6, -74.1", "complete and intact"):
        assert words in text
    assert "&lt;script&gt;" in text
    assert "<b>" not in page(
        Report("<b>", [Section("<b>", "<b>", ["<b>"], ["<b>"], [("<b>",)])], footer="<b>")
    )


def test_a_report_must_be_html_or_pdf(tmp_path, refusals):
    assert main(["report", str(tmp_path), "--output", str(tmp_path / "r.txt")]) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]


@pytest.mark.usefixtures("blank_figures")
def test_the_verdict_comes_first_and_how_it_was_measured_is_told(tmp_path):
    _, text = report(tmp_path, ALL, "finished")
    assert text.index("<h2>Verdict</h2>") < text.index("<h2>Survey</h2>")
    assert '<section class="good"><h2>Verdict</h2>' in text
    for words in ("3 stops from 10.0 to 20.0 mm", "Data after the steps", "gpr20_analysis"):
        assert words in text


def test_views_end_a_little_below_the_image(whole):
    survey = load_survey(whole)
    options = ImageOptions(depth_m=(0.0, 0.02), permittivity=4.0)
    line = pictures.as_measured(survey, options).lines[0]
    shown_ns = float(re.search(r"up to ([\d.]+) ns", line).group(1))
    deepest_ns = 2.0 * (0.3 + 0.02 * 2.0) / 0.299792458
    assert shown_ns <= deepest_ns + 1.0


@pytest.mark.usefixtures("blank_figures")
def test_a_survey_without_heights_gets_a_report_that_says_so(tmp_path):
    changes = {index: {"antennae_height_m": math.nan} for index in range(ALL)}
    status, text = report(tmp_path, ALL, "finished", changes, more=())
    assert status == 0
    assert "not measured" in text and "No image was made" in text


def turn(gain_db, noise_db=-60.0, z_deg=0.0):
    figures = {"amplitude_rms_db": abs(gain_db), "phase_rms_deg": 1.5, "delay_ps": 2.0 * gain_db}
    return {"z_deg": z_deg, "gain_db": gain_db, "noise_db": noise_db, **figures}


@pytest.mark.usefixtures("blank_figures")
def test_drift_repeatability_and_noise_are_shown_with_their_number_of_visits(tmp_path):
    folder = make_survey(tmp_path, ALL, "finished")
    output = tmp_path / "report.html"

    def text_with(drift):
        describe_again(folder, report={"drift": drift})
        main(["report", str(folder), "--output", str(output), "--overwrite", *OPTIONS, *LOW])
        return output.read_text(encoding="utf-8")

    visit = {"time": "2026-09-21T15:00:00+00:00", "next_index": 6, "exceeded": False}
    visits = [
        {**visit, "rotations": [turn(0.1), turn(0.2, None, 90.0)]},
        {**visit, "rotations": [turn(-0.3, -55.0), turn(0.2, -70.0, 90.0)], "exceeded": True},
    ]
    text = text_with({"visits": visits, "limit_db": 0.25, "limit_deg": 10.0})
    for words in (
        "Visits of the first stop: 2.",
        "at most 0.300 dB and the phase by at most 1.50 deg",
        "at most -55.0 dB (pairs: 4)",
        # Of 0.1 and -0.3: 0.4 / sqrt(2).
        "of 2 visits: gain 0.283 dB, delay 0.57 ps",
        "before trace 6, the drift exceeded 0.25 dB or 10.0 deg",
        "<td>-0.300</td>",
    ):
        assert words in text
    assert "Drift was not measured" in text_with({})
    for odd in (7, {"visits": 7}, {"visits": [7, {"rotations": [7, {}]}]}):
        assert "Drift and repeatability" in text_with(odd)
