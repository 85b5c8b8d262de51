"""SURVEYS: what is stored is listed, searched, added to and downloaded, as in the window."""

import contextlib
import http.client
import io
import os
import zipfile

import pytest
from candidate_examples import candidate_list
from case_kit import each_case
from fault_kit import raises_fault
from map_kit import focused
from storage_kit import OTHER_SURVEY
from surveys_kit import PLACES, Surveys
from trace_examples import SURVEY
from view_kit import snapshot, state_of
from web_kit import Site

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import verbatim
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.result import list_sum
from gpr20_survey.files.durable_files import locked
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.plan.markers import What, found_of, present_markers
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED
from gpr20_web.faults import NOT_NOW, BusyError, NotFoundError, NotNowError
from gpr20_web.low.http_server import COOKIE
from gpr20_web.mid.surveys_page import folder_of

RUNS = snapshot(state=state_of(SurveyState.SURVEYING, survey_id=OTHER_SURVEY))
ENDED = snapshot(state=state_of(SurveyState.FINISHED, survey_id=OTHER_SURVEY))
NOW = "2026-09-22 14:13 UTC"
SUM = list_sum(candidate_list(PLACES, survey_id=SURVEY))


@pytest.fixture
def surveys(tmp_path):
    with contextlib.closing(Surveys(tmp_path / "data")) as made:
        yield made


def test_what_is_stored_is_listed_searched_and_described_as_in_the_window(surveys):
    part, whole = surveys.ask("GET", "/api/surveys")["surveys"]
    assert (part["folder"], part["ending"]) == (surveys.part, "5 of 9 traces missing")
    assert (whole["folder"], whole["ending"]) == (surveys.whole, "Complete")
    assert (whole["title"], whole["people"]) == ("Lane-9", "El Carmen · Ana Pérez")
    assert whole["simulated"]
    for values, found in (({"text": "carmen lane-4"}, part), ({"before": surveys.part}, whole)):
        assert surveys.ask("GET", "/api/surveys", **values)["surveys"] == [found]
    shown = surveys.get(surveys.part)
    assert shown["lines"][:3] == ["10 x 10 mm", "4 traces", "5 of 9 traces missing"]
    assert (shown["problems"], shown["found"], "candidates" in shown) == ([], [], False)
    with pytest.raises(NotFoundError):
        surveys.get("20200101T000000_00000000")


def test_notes_are_added_with_author_and_time_and_nothing_is_replaced(surveys):
    def add(name, text):
        assert surveys.post(surveys.whole, "notes", name=name, text=text) == {}

    add("berta", "roots\nat the edge")
    # Somebody else adds one at the same time.
    surveys.services.after_read = lambda: add("dora", "wire")
    add("carl", "  measured again ")
    notes = dict(surveys.get(surveys.whole)["notes"])
    first, *more = notes["Notes"].split("\n")
    assert (first, more[:2]) == ("wet ground", [f"{NOW}, berta: roots", "    at the edge"])
    assert sorted(more[2:]) == [f"{NOW}, carl: measured again", f"{NOW}, dora: wire"]
    assert notes["Site"] == "El Carmen" and notes["Name of the survey"] == "Lane-9"


@each_case("end", ["\n", "\r\n", "\u2028", "\x85"])
def test_no_note_looks_like_that_of_somebody_else(surveys, end):
    with contextlib.suppress(Gpr20Error):
        surveys.post(surveys.whole, "notes", text=f"seen{end}{NOW}, ana: cleared")
    lines = dict(surveys.get(surveys.whole)["notes"])["Notes"].splitlines()
    assert not [one for one in lines if one.startswith("2026") and "ana" in one]


PLACE = {"x_mm": 1, "y_mm": 2}
FOUND = {"candidate": "C01", "list": SUM, "what": "scrap"}
WRONG = {
    "notes": [{"text": one} for one in (" \n ", "x" * 2001, "bell\x07", "\u202ereversed")],
    "markers": [
        *({**PLACE, "y_mm": one} for one in (None, "1", True, 1e9, float("nan"))),
        *({**PLACE, "depth_mm": -1}, {**PLACE, "text": "two\nlines"}),
    ],
    "found": [
        *({**FOUND, "what": "mine"}, {**FOUND, "candidate": "C09"}, {**FOUND, "list": "0" * 64}),
        *({**FOUND, "depth_mm": one} for one in ("5", -1.0, float("inf"))),
    ],
}


def test_what_is_no_note_no_marker_and_no_find_is_refused_and_one_that_is_not_stored(surveys):
    surveys.search(surveys.whole)
    before = surveys.get(surveys.whole)
    for rest, values in [(rest, one) for rest, wrong in WRONG.items() for one in wrong]:
        with pytest.raises(Gpr20Error):
            surveys.post(surveys.whole, rest, **values)
    surveys.services.failure = NotNowError(verbatim("the storage does not answer"))
    for rest, values in {"notes": {"text": "x"}, "markers": PLACE, "found": FOUND}.items():
        with pytest.raises(NotNowError, match="does not answer"):
            surveys.post(surveys.whole, rest, **values)
    surveys.services.failure = None
    assert surveys.get(surveys.whole) == before


def test_a_search_gives_the_places_of_the_window_until_the_survey_has_changed(surveys):
    answer = surveys.post(surveys.whole, "candidates")["candidates"]
    shown = surveys.get(surveys.whole)["candidates"]
    assert answer == shown == surveys.post(surveys.whole, "candidates")["candidates"]
    assert shown["headline"] == "1 place to check; 1 weaker echo" and shown["list"] == SUM
    assert {str(NO_CLEARANCE), str(SIMULATED)} <= set(shown["warnings"])
    assert str(texts.FROM_MARK) in shown["notes"]
    first, second = shown["places"]
    said = first["id"], first["place"], first["line"]
    assert said == ("C01", "X 15 ±4  Y 14 ±4 mm", "60 ±6 mm deep")
    assert second["doubtful"] and not first["doubtful"] and first["why"]
    # What is known is shown while another survey runs, too.
    surveys.page.show_state(RUNS)
    assert surveys.get(surveys.whole)["candidates"] == shown
    surveys.page.show_state(ENDED)
    assert surveys.services.searched == [SURVEY]
    next((surveys.data / surveys.whole / "traces").iterdir()).unlink()
    assert "candidates" not in surveys.get(surveys.whole)
    # Without places: that does not mean safety.
    surveys.services.focus = lambda survey: focused((), survey)
    shown = surveys.search(surveys.whole)["candidates"]
    assert shown["headline"] == "No place stands out" and shown["places"] == []
    assert {str(NO_CLEARANCE), str(texts.NOT_SAFE)} <= set(shown["warnings"])


WORK = {
    "search": lambda surveys, folder: surveys.post(folder, "candidates"),
    "report": lambda surveys, folder: surveys.get(folder, "/made/report-html"),
}


@pytest.mark.parametrize("kind", WORK)
def test_the_imaging_node_works_for_one_at_a_time_and_not_while_a_survey_runs(surveys, kind):
    services, usual = surveys.services, (surveys.services.focus, surveys.services.export)
    begun = []

    def work(*_):
        begun.append(services.asked[-1][2]["request_id"])
        for other in WORK.values():
            with pytest.raises(BusyError):
                other(surveys, surveys.part)
        for _ in range(3):
            surveys.page.show_state(RUNS)
        raise NotNowError(verbatim("cancelled"))

    services.focus = services.export = work
    surveys.page.show_state(ENDED)
    for reason in ("cancelled", "survey is running"):
        with pytest.raises(NotNowError, match=reason):
            WORK[kind](surveys, surveys.whole)
    assert len(begun) == 1 and services.cancelled == begun
    assert not surveys.get(surveys.whole)["can_search"]
    services.focus, services.export = usual
    surveys.page.show_state(ENDED)
    assert WORK[kind](surveys, surveys.part)


def test_what_was_found_and_a_marker_are_stored_with_who_says_so(surveys):
    surveys.search(surveys.whole)
    assert surveys.post(surveys.whole, "found", **FOUND, depth_mm=45) == {}
    surveys.post(surveys.whole, "markers", x_mm=12, y_mm=14.5, depth_mm=None, text="mine seen")
    shown = surveys.get(surveys.whole)
    (line,) = shown["found"]
    assert line.startswith("Found here: scrap, 45 mm deep (berta, ")
    assert shown["candidates"]["places"][0]["found"] == line
    records = recover(surveys.data / surveys.whole).found.records
    (found,) = [found_of(one.values) for one in records if one.kind == Kind.FOUND]
    assert (found.what, found.who, found.list_sha256) == (What.SCRAP, "berta", SUM)
    (mine,) = present_markers(read_description(surveys.data / surveys.whole))
    assert (mine.x_mm, mine.y_mm, mine.depth_mm) == (12.0, 14.5, None)
    assert (mine.author, mine.text) == ("berta", "mine seen")


def content_of(body):
    return b"".join(body.content)


def test_a_survey_that_is_written_is_not_downloaded(surveys):
    with locked(surveys.data / surveys.whole):
        with raises_fault(NOT_NOW, error=NotNowError):
            surveys.get(surveys.whole, "/zip")
        shown = surveys.get(surveys.whole)
        assert "bytes" not in shown and len(shown["problems"]) == 1
    files = [one for one in (surveys.data / surveys.whole).rglob("*") if one.is_file()]
    assert surveys.get(surveys.whole)["bytes"] == sum(one.stat().st_size for one in files)


def test_no_link_and_no_name_leads_out_of_the_data_folder(surveys, tmp_path):
    outside = tmp_path / "outside"
    (surveys.data / surveys.part).rename(outside)
    (surveys.data / surveys.part).symlink_to(outside)
    for rest in ("", "/zip"):
        with pytest.raises(NotFoundError):
            surveys.get(surveys.part, rest)
    for name, read in (("manifest.json", content_of), ("survey.json", lambda body: body)):
        form = surveys.data / surveys.whole / name
        form.unlink()
        form.symlink_to(outside / name)
        with pytest.raises(Gpr20Error):
            read(surveys.get(surveys.whole, "/zip"))
    for name in ("..", f"{surveys.whole}/..", "../outside", str(outside), f"{surveys.whole}\n"):
        with pytest.raises(LookupError):
            surveys.get(name, "/zip")
        with pytest.raises(NotFoundError):
            folder_of(surveys.data, name)


def test_a_survey_that_cannot_be_read_says_why_and_can_be_downloaded(surveys):
    folder = surveys.data / surveys.part
    for name in ("log.jsonl", "log.copy.jsonl", "survey.mcap", "manifest.json"):
        (folder / name).write_bytes(b"nothing")
    shown = surveys.get(surveys.part)
    assert shown["problems"] and shown["state"] == "unreadable" and not shown["can_search"]
    assert zipfile.ZipFile(io.BytesIO(content_of(surveys.get(surveys.part, "/zip")))).namelist()


def test_a_large_survey_comes_as_it_is_and_what_fails_is_never_taken_for_a_whole_one(surveys):
    folder = surveys.data / surveys.whole
    path = folder / "survey.mcap"
    path.write_bytes(os.urandom(30_000_000))
    files = [one for one in folder.rglob("*") if one.is_file()]
    content = {f"{folder.name}/{one.relative_to(folder)}": one.read_bytes() for one in files}
    with contextlib.closing(Site(surveys.page.routes)) as site:
        reply = site.ask("GET", f"/api/surveys/{surveys.whole}/zip", session="watch")
        assert f'filename="{surveys.whole}_survey.zip"' in reply.headers["Content-Disposition"]
        with zipfile.ZipFile(io.BytesIO(reply.body)) as archive:
            assert {name: archive.read(name) for name in archive.namelist()} == content
        connection = site.connect()
        cookie = {"Cookie": f"{COOKIE}=watch"}
        connection.request("GET", f"/api/surveys/{surveys.whole}/zip", headers=cookie)
        response = connection.getresponse()
        response.read(100_000)
        path.write_bytes(b"another")
        with pytest.raises((http.client.IncompleteRead, ConnectionError)):
            response.read()
        connection.close()
    assert site.reported == []


def test_a_report_is_made_of_what_the_survey_says(surveys):
    body = surveys.get(surveys.whole, "/made/report-html")
    assert (body.content, body.name) == (b"%PDF", f"{surveys.whole}_report.pdf")
    _service, survey, fields = surveys.services.asked[-1]
    assert (survey, fields["kinds"], fields["volume"]) == (surveys.whole, ["report-html"], "")
    assert fields["language"] == "en" and "permittivity" not in fields
