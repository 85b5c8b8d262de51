"""Window, page, viewer, commands, report and API say the same of a survey: soil, list, doubts."""

from __future__ import annotations

import html
import json
import re
import sys
from contextlib import closing
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from ground_kit import SCENES, read_scene, survey_of
from matplotlib.figure import Figure
from result_kit import Now
from storage_kit import Kit
from surveys_kit import Services
from trace_examples import AXES, SURVEY, TRAVEL, make_trace
from view_kit import snapshot
from web_kit import route_of

import gpr20_analysis
from gpr20_analysis.candidates.table import candidate_table
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.exports import ENDINGS
from gpr20_analysis.plotting.style import remarks_of
from gpr20_analysis.work import no_progress
from gpr20_imaging.mid.worker import Analysis
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.jobs.result import SurveyResult, list_sum
from gpr20_operator.plan.fields import SPECS, default_parameters
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Antennas, Noise, Scene, Shape, Soil, Target
from gpr20_survey.faults import UNCONFIRMED
from gpr20_survey.folder.log_record import PLANNED_PERMITTIVITY, Kind, soil_values
from gpr20_survey.folder.recovery import Fact, add_to_survey
from gpr20_survey.folder.survey_folder import MCAP_FILE
from gpr20_survey.plan.recorded_plan import UNPROVEN
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.results.answers import focus_fields, image_from
from gpr20_survey.results.candidates import list_from
from gpr20_viewer.session import ViewSession
from gpr20_web.calls import Call, Person, Role
from gpr20_web.mid.ground_page import GroundPage
from gpr20_web.mid.survey_values import result_of
from gpr20_web.mid.surveys_page import SurveysPage

PARAMETERS = SurveyParameters(
    "127.0.0.1", 6e8, 6e9, 61, x_start_mm=40.0, x_stop_mm=200.0, x_points=9,
    y_start_mm=40.0, y_stop_mm=200.0, y_points=9, polarizations_deg=(0.0,),
)  # fmt: skip
TARGET = Target("can", Shape.SPHERE, 120.0, 110.0, 0.06, 0.02, 0.0, 0.05, 0.05)
SCENE = Scene(soil=Soil(4.0, 0.0), antennas=Antennas(), targets=(TARGET,), noise=Noise(-90.0))
NOW = "2026-10-01T10:00:00.000000+00:00"
# As it is documented: docs/imaging.md.
WEAKER = {"clutter", "sidelobe"}
TIME_US = 1_795_000_000_000_000


class Here(Analysis):
    """The worker of the imaging node, in this process.

    Attributes:
        searched: How often it was asked.
    """

    has_analysis, searched = True, 0

    def start(self):
        pass

    def ask(self, _limit_s, _report, name, *arguments):
        self.searched += 1
        return getattr(self, name)(*arguments)

    end = close = start


class AtOnce:
    """Lets storage and imaging node answer jobs at once, by what is sent."""

    def __init__(self, services):
        self._services = services

    def ask(self, service, ticket, **fields):
        if service is Service.TRACES:
            return  # nobody looks at the echoes
        found = self._services.ask(service, **fields)
        if service is Service.FOCUS:
            found = image_from(SimpleNamespace(**focus_fields(found)))
        ticket.done(found)

    def cancel(self, _request_id):
        pass


def stored_survey(data, remarks=(), at_end=lambda _processing: None, **more):
    """Store a survey over a can, and return its folder; remarks: of each trace but the first."""
    kit, points = Kit(data), survey_points(PARAMETERS, TRAVEL)
    metadata = {
        **{"planned_traces": len(points), "simulated": True, "parameters": asdict(PARAMETERS)},
        **{"axes": AXES, **more},
    }
    folder = kit.open(metadata_json=json.dumps(metadata))
    frequency_hz = np.linspace(6e8, 6e9, PARAMETERS.frequency_points)
    ground = Ground(SCENE)
    for index, point in enumerate(points):
        place = AntennaPosition(point.x_mm, point.y_mm, point.z_deg)
        # With remarks the second trace is a copy of the first.
        if not (remarks and index == 1):
            s21 = ground.s21(frequency_hz, place, 0)
        kit.processing.store(
            make_trace(
                index, x_coord_mm=point.x_mm, y_coord_mm=point.y_mm, z_coord_deg=point.z_deg,
                antennae_height_m=SCENE.antennas.height_m, frequency_hz=frequency_hz,
                s21_real=s21.real, s21_imag=s21.imag, quality=remarks if index else (),
            )
        )  # fmt: skip
    at_end(kit.processing)
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    return folder


def enter(folder, permittivity):
    """Add the decision of a person about the soil to a survey that has ended."""
    fact = Fact(Kind.DECISION, soil_values(permittivity, TIME_US))
    add_to_survey(folder, lambda _description: fact, NOW)


def answers(folder, capsys):
    """Return the lists of window, API, command and viewer, the report, and the window's result.

    The window finds; what the page lists is compared with that, and is not searched for again.
    """
    worker = Here()
    with closing(Services(folder.parent, worker=worker)) as services:
        window = SurveyResult(Imaging(AtOnce(services), lambda: 100.0))
        window.open(folder.name)
        window.keep()
        window.keep()
        check_page(folder, services, window)
        assert worker.searched == 1
    survey = gpr20_analysis.load_survey(folder)
    viewer = ViewSession(survey, gpr20_analysis.ImageOptions())
    lists = {
        "window": window.image.found,
        "API": gpr20_analysis.answer(survey, gpr20_analysis.ImageOptions()).found,
        "command": of_command(folder, capsys),
        "viewer": viewer.compute(viewer.first_request, no_progress).candidates,
    }
    page = folder.parent / "report.html"
    assert main(["report", str(folder), "-o", str(page), "--overwrite"]) == 0
    return lists, page.read_text(), window


def check_page(folder, services, window):
    """Check that SURVEYS and MAP show what the window has found."""
    found, here = window.image.found, {"survey": folder.name}
    surveys = SurveysPage(services.ask, services.cancel, folder.parent)
    listed = got(surveys, f"/api/surveys/{folder.name}")["candidates"]
    assert listed["list"] == list_sum(found)
    assert listed["headline"] == str(texts.headline(found))
    assert listed["weaker"] == str(texts.weaker_line(found))
    now = Now()
    ground = GroundPage(AtOnce(services), now, print)
    got(ground, "/api/ground", **here)
    ground.show_state(snapshot())
    shown = got(ground, "/api/ground", **here)["ground"]
    assert str(texts.headline(found)) in shown["lines"]
    marked = [one["place"] for one in shown["marks"]]
    assert sorted(marked) == sorted([one.x_mm, one.y_mm, one.depth_mm] for one in found.shown())


def got(page, path, **values):
    """Return what a page answers a person who watches."""
    route, parts = route_of(page.routes, "GET", path)
    return route.answer(Call(Person("ana", Role.WATCH, "s", "::1"), "::1", values, parts))


def of_command(folder, capsys, *options):
    """Return the list that gpr20 candidates prints."""
    capsys.readouterr()
    assert main(["candidates", str(folder), "--json", *options]) == 0
    text = capsys.readouterr().out
    for one in json.loads(text)["candidates"]:
        assert one["doubtful"] == bool(WEAKER & {*one["flags"]})
    return list_from(text)


def rows_of(page):
    rows = [
        re.findall("<td[^>]*>([^<]*)</td>", one) for one in re.findall("<tr>.*?</tr>", page, re.S)
    ]
    return [tuple(map(html.unescape, one)) for one in rows if one and re.fullmatch(r"C\d+", one[0])]


def said_of(found):
    """Return how a list knows its soil."""
    of_list = ("permittivity", "permittivity_lowest", "permittivity_highest")
    return (*(getattr(found, name) for name in of_list), found.permittivity_source)


def test_all_parts_search_with_what_the_survey_knows(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda _figure, target, **_: target.write(b"-"))
    folder = stored_survey(tmp_path / "data", **{PLANNED_PERMITTIVITY: 4.0})
    alone = of_command(folder / MCAP_FILE, capsys)
    assert said_of(alone) == pytest.approx((4.0, 3.0, 5.0, "of the plan"))
    shown = []
    for entered, expected, words in (
        ((), (4.0, 3.0, 5.0, "of the plan"), "4, of the plan of the survey"),
        ((9.5, 7.0), (7.0, 6.3, 7.7, "entered later"), "7, entered later, in the log"),
        ((None,), (5.0, 2.0, 16.0, "assumed"), "5, ASSUMED, as nothing is known of the ground"),
    ):
        for one in entered:
            enter(folder, one)
        lists, page, _window = answers(folder, capsys)
        for name, found in lists.items():
            rows = candidate_table(found, found.candidates)[1:]
            assert said_of(found) == pytest.approx(expected), name
            assert rows == rows_of(page), name
        assert f"permittivity is {words}" in page
        shown.append(rows_of(page))
    assert len({one[0] for one in shown}) == len(shown)
    given = of_command(folder, capsys, "--permittivity", "8")
    assert said_of(given) == pytest.approx((8.0, 7.2, 8.8, "given"))


DOUBTED = {PLANNED_PERMITTIVITY: 4.0, "instrument": {"calibration_status": 3}}
LOST = Fact(Kind.UNCONFIRMED, {"entries": {"outcome": {"reason": "lost"}}, "lost": []})
REPORT = {
    "analyzers": [{"identity": "A", "from_index": 0}, {"identity": "B", "from_index": 40}],
}
VISIT = {"time": NOW, "limit_db": 0.5, "limit_deg": 5, "next_index": 40, "exceeded": True}
SAID = {
    "analysis.zeros_unproven": "80 traces refer to zeros of the axes that no measurement proved",
    "survey.unconfirmed": "nothing vouches for 1 entries of the survey: outcome",
    "analysis.sweep_repeated": "1 samples have exactly the values of another sample",
    "analysis.calibration": "start of the survey: moderate, temperature changed by more than 5",
    "analysis.drifted": "the drift exceeded 0.5 dB or 5 deg at 1 visits of the first stop",
    "analysis.settings_changed": "from trace 40 on another VNA measured: B",
    "analysis.clock": "times may be wrong: the clock was set back by 60 s",
}
# To ROS 2 only newer versions of rosbags convert.
EXPORTS = ("netcdf", "csv", "ros2")[: 3 if sys.version_info >= (3, 10) else 2]


def doubt(processing):
    note = {"time": NOW, "text": "the clock was set back by 60 s", "message": None}
    processing.add_fact("", Kind.CLOCK.value, json.dumps(note))
    processing.add_fact("", Kind.DRIFT.value, json.dumps(VISIT))
    processing.add_fact(SURVEY, Kind.REPORT.value, json.dumps(REPORT))


def content_of(path):
    """Return all that the files of an export hold, in small letters."""
    found = [one for one in (path, *path.rglob("*")) if one.is_file()]
    return b"".join(one.read_bytes() for one in found).decode("latin-1").lower()


def test_every_doubt_is_said_by_every_reader_export_and_page(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda _figure, target, **_: target.write(b"-"))
    folder = stored_survey(tmp_path / "data", (str(UNPROVEN),), doubt, **DOUBTED)
    add_to_survey(folder, lambda _description: LOST, NOW)
    # The recordings do not know what the folder has lost since.
    of_mcap = [code for code in SAID if code != UNCONFIRMED.code]
    lists, page, window = answers(folder, capsys)
    survey = gpr20_analysis.load_survey(folder)
    warnings = result_of(window, str)["candidates"]["warnings"]
    all_sentences = {
        **{f"list of {name}": found.notes for name, found in lists.items()},
        **{"window": texts.doubts(window), "web page": warnings, "figure": remarks_of(survey)},
        **{"load_survey": survey.attrs["doubts"], "report": [html.unescape(page)]},
    }
    said = {name: "\n".join(map(str, sentences)) for name, sentences in all_sentences.items()}
    capsys.readouterr()
    main(["verify", str(folder)])
    said["verify"] = capsys.readouterr().out
    exported = {form: tmp_path / f"{form}{ENDINGS[form]}" for form in EXPORTS}
    for form, path in exported.items():
        assert main(["export", str(folder), str(path), "--format", form]) == 0
        said[f"export to {form}"] = capsys.readouterr().err
    assert main(["export", str(folder), "--format", "bag"]) == 0
    said["export to bag"] = capsys.readouterr().err
    for form, path in exported.items():
        words = [*(of_mcap if form == "ros2" else SAID), "simulated"]
        assert [one for one in words if one not in content_of(path)] == [], form
    for path in (folder, folder / MCAP_FILE, exported["netcdf"]):
        capsys.readouterr()
        assert main(["info", str(path)]) == 0
        said[f"info {path.name}"] = capsys.readouterr().err
    for reader, text in said.items():
        is_mcap = reader in (f"info {MCAP_FILE}", "export to ros2", "export to bag")
        codes = of_mcap if is_mcap else SAID
        assert [code for code in codes if SAID[code] not in text] == [], reader
    assert [one.fault_code for one in texts.doubts(window)] == [*SAID]
    # What is damaged is left out for the window, and refused elsewhere.
    next((folder / "traces").iterdir()).write_text("{")
    found = gpr20_analysis.GrowingSurvey(folder).load().attrs["doubts"]
    assert "1 parts of the survey are damaged" in found[1]


def test_the_first_plan_shows_a_body_of_the_first_scene_where_it_is():
    scene, plan = read_scene(str(SCENES / "two_targets.yaml")), default_parameters()
    x_mm = np.linspace(plan.x_start_mm, plan.x_stop_mm, plan.x_points)
    y_mm = np.linspace(plan.y_start_mm, plan.y_stop_mm, plan.y_points)
    survey = survey_of(scene, x_mm, y_mm, np.linspace(6e8, 6e9, plan.frequency_points))
    (one,) = gpr20_analysis.focus(survey, float(SPECS["permittivity"].default)).found.shown()
    body = scene.targets[0]
    assert not one.flags
    assert (one.x_mm, one.y_mm) == pytest.approx((body.x_mm, body.y_mm), abs=10.0)
    assert abs(one.depth_m - body.depth_m) < one.depth_uncertainty_m
