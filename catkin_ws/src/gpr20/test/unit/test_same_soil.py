"""Window, imaging node, commands, report and API know the same soil, and the same doubts."""

from __future__ import annotations

import html
import json
import re
from contextlib import closing
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from planned_survey import AXES, TRAVEL
from storage_kit import Kit
from trace_examples import SURVEY, make_trace

import gpr20_analysis
from gpr20_analysis.candidates.table import candidate_row
from gpr20_analysis.commands.main import main
from gpr20_imaging.low.analysis_worker import Analysis
from gpr20_imaging.mid.imaging import Imaging as Node
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_operator.jobs.result import SurveyResult
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Antennas, Noise, Scene, Shape, Soil, Target
from gpr20_survey.folder.annotating import Fact, add_to_survey
from gpr20_survey.folder.log_content import LOG
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.soil_note import KIND, PLANNED, soil_values
from gpr20_survey.folder.survey_folder import MCAP_FILE
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.zero_history import UNPROVEN
from gpr20_survey.results.candidate_json import json_text, list_from
from gpr20_survey.results.focused_image import focus_fields, image_from

PARAMETERS = SurveyParameters(
    "127.0.0.1", 6e8, 6e9, 61, x_start_mm=40.0, x_stop_mm=200.0, x_points=9,
    y_start_mm=40.0, y_stop_mm=200.0, y_points=9, polarizations_deg=(0.0,),
)  # fmt: skip
TARGET = Target("can", Shape.SPHERE, 120.0, 110.0, 0.06, 0.02, 0.0, 0.05, 0.05)
SCENE = Scene(soil=Soil(4.0, 0.0), antennas=Antennas(), targets=(TARGET,), noise=Noise(-90.0))
NOW = "2026-10-01T10:00:00.000000+00:00"
TO_NETCDF = ("--format", "netcdf", "--overwrite")
TIME_US = 1_795_000_000_000_000


class Here(Analysis):
    """The analysis of the imaging node, in this process."""

    is_installed = True

    def focus(self, folder, permittivity, _stop):
        return super().focus(folder, permittivity)

    def find_candidates(self, folder, permittivity, language, _stop):
        return super().find_candidates(folder, permittivity, language)

    def close(self):
        pass


class Asked:
    """Answers the window at once, as storage and imaging node do."""

    def __init__(self, folder, node):
        self._folder, self._node = folder, node

    def ask(self, service, ticket, **fields):
        if service is Service.READ:
            found = recover(self._folder)
            log = [one.as_json() for one in found.found.records]
            text = json.dumps({**found.description, LOG: log})
            ticket.done(StoredSurvey(text, found.description["stored_traces"]))
            return
        found = self._node.focus("", fields["survey"], fields["permittivity"])
        ticket.done(image_from(SimpleNamespace(**focus_fields(found))))

    def cancel(self, _request_id):
        pass


def stored_survey(data, remarks=(), **more):
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
        s21 = ground.s21(frequency_hz, place, 0)
        kit.processing.store(
            make_trace(
                index, x_coord_mm=point.x_mm, y_coord_mm=point.y_mm, z_coord_deg=point.z_deg,
                antennae_height_m=SCENE.antennas.height_m, frequency_hz=frequency_hz,
                s21_real=s21.real, s21_imag=s21.imag, quality=remarks if index else (),
            )
        )  # fmt: skip
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    return folder


def enter(folder, permittivity):
    """Add the decision of a person about the soil to a survey that has ended."""
    fact = Fact(KIND, soil_values(permittivity, TIME_US))
    add_to_survey(folder, lambda _description: fact, NOW)


def answers(folder, capsys):
    """Return the lists of window, node, API and command, the report, and the window's notices."""
    with closing(Node(folder.parent, Here(), None, lambda *_: None)) as node:
        window = SurveyResult(Imaging(Asked(folder, node), lambda: 100.0))
        window.open(folder.name)
        window.keep()
        window.keep()
        asked = node.find_candidates("", folder.name, 0.0, "en").found
    survey = gpr20_analysis.load_survey(folder)
    cleaned = gpr20_analysis.process_survey(survey, "background:method=surface")
    image = gpr20_analysis.image_survey(cleaned, gpr20_analysis.ImageOptions())
    lists = {
        "window": window.image.found,
        "node": list_from(json_text(asked)),
        "API": gpr20_analysis.find_candidates(image),
        "command": of_command(folder, capsys),
    }
    page = folder.parent / "report.html"
    assert main(["report", str(folder), "-o", str(page), "--overwrite"]) == 0
    return lists, page.read_text(), texts.notices(window)


def of_command(folder, capsys, *options):
    """Return the list that gpr20 candidates prints."""
    capsys.readouterr()
    assert main(["candidates", str(folder), "--json", *options]) == 0
    return list_from(capsys.readouterr().out)


def rows_of(page):
    rows = [
        re.findall("<td[^>]*>([^<]*)</td>", one) for one in re.findall("<tr>.*?</tr>", page, re.S)
    ]
    return [tuple(map(html.unescape, one)) for one in rows if one and re.fullmatch(r"C\d+", one[0])]


def said_of(found):
    """Return how a list knows its soil."""
    return (found.permittivity, *found.permittivity_range, found.permittivity_source)


def test_all_parts_search_with_what_the_survey_knows(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda _figure, target, **_: target.write(b"-"))
    folder = stored_survey(tmp_path / "data", **{PLANNED: 4.0})
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
        lists, page, _notices = answers(folder, capsys)
        for name, found in lists.items():
            rows = [candidate_row(one) for one in found.shown(None)]
            assert said_of(found) == pytest.approx(expected), name
            assert rows == rows_of(page), name
        assert f"relative permittivity {words}" in page
        shown.append(rows_of(page))
    assert len({one[0] for one in shown}) == len(shown)
    given = of_command(folder, capsys, "--permittivity", "8")
    assert said_of(given) == pytest.approx((8.0, 7.2, 8.8, "given"))


def test_all_parts_say_that_nothing_proves_the_positions(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda _figure, target, **_: target.write(b"-"))
    folder = stored_survey(tmp_path / "data", (str(UNPROVEN),), **{PLANNED: 4.0})
    said = "80 traces refer to zeros of the axes that no measurement proved"
    lists, page, notices = answers(folder, capsys)
    for name, found in lists.items():
        assert any(said in str(one) for one in found.notes), name
    assert said in page and said in str(notices[0])
    exported = folder.parent / "exported.nc"
    for source in (folder, folder / MCAP_FILE, exported):
        capsys.readouterr()
        assert main(["info", str(source)]) == 0
        assert said in capsys.readouterr().err, source
        if source != exported:
            assert main(["export", str(source), str(exported), *TO_NETCDF]) == 0
