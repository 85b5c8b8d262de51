"""SURVEYS: forms and whole surveys are downloaded as they are, and nothing else can be named."""

import contextlib
import http.client
import io
import os
import random
import re
import zipfile

import pytest
from fault_kit import raises_fault
from run_seed import SEED, draws
from web_kit import Site

from gpr20_common.errors import Gpr20Error
from gpr20_operator.jobs.pictures import NOT_KNOWN, Exported
from gpr20_survey.files.folder_lock import locked
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.survey_folder import FOLDER_NAME
from gpr20_web import faults
from gpr20_web.errors import NotFoundError, NotNowError
from gpr20_web.low.handlers import COOKIE
from gpr20_web.mid.survey_files import FILES, folder_of


def content_of(body):
    return b"".join(body.content)


def zip_of(surveys, folder):
    body = surveys.get(folder, "/zip")
    assert (body.name, body.kind) == (f"{folder}_survey.zip", "application/zip")
    return zipfile.ZipFile(io.BytesIO(content_of(body)))


def test_each_form_and_the_whole_survey_can_be_downloaded(surveys):
    folder = surveys.data / surveys.whole
    for one in surveys.get(surveys.whole)["files"]:
        body = surveys.get(surveys.whole, f"/files/{one['name']}")
        assert content_of(body) == (folder / one["name"]).read_bytes()
        assert body.name == f"{surveys.whole}_{one['name']}"
    with zip_of(surveys, surveys.whole) as archive:
        files = {
            f"{surveys.whole}/{one.relative_to(folder)}": one.read_bytes()
            for one in folder.rglob("*")
            if one.is_file()
        }
        assert {name: archive.read(name) for name in archive.namelist()} == files


def test_a_survey_that_is_written_is_not_downloaded(surveys):
    with locked(surveys.data / surveys.whole):
        for rest in ("/zip", "/files/survey.json"):
            with raises_fault(faults.NOT_NOW, error=NotNowError):
                surveys.get(surveys.whole, rest)
        shown = surveys.get(surveys.whole)
        assert shown["files"] == [] and len(shown["problems"]) == 1
    assert surveys.get(surveys.whole)["files"]


def test_no_link_leads_out_of_the_data_folder(surveys, tmp_path):
    outside = tmp_path / "outside"
    (surveys.data / surveys.part).rename(outside)
    (surveys.data / surveys.part).symlink_to(outside)
    with pytest.raises(NotFoundError):
        surveys.get(surveys.whole, "/files/manifest.json.sig")
    for rest in ("", "/zip", "/files/survey.json"):
        with pytest.raises(NotFoundError):
            surveys.get(surveys.part, rest)
    form = surveys.data / surveys.whole / "manifest.json"
    form.unlink()
    form.symlink_to(outside / "manifest.json")
    with pytest.raises(Gpr20Error):
        surveys.get(surveys.whole, "/files/manifest.json")
    with pytest.raises(Gpr20Error):
        content_of(surveys.get(surveys.whole, "/zip"))


def test_random_names_reach_no_route_and_no_file(surveys, tmp_path):
    (tmp_path / "secret").write_text("secret")
    draw = random.Random(SEED)
    pieces = ["..", ".", "/", "\\", "%2e%2e", "\0", "~", "secret", "data", "traces", "survey.json"]
    pieces += [surveys.whole, surveys.part[:8], "T141320_0f8fad5b", "٣", "\n", str(tmp_path)]
    for _ in range(draws(500)):
        name = "".join(draw.choices(pieces, k=draw.randint(1, 6)))
        for path in (f"/api/surveys/{name}", f"/api/surveys/{surveys.whole}/files/{name}"):
            for route in surveys.page.routes:
                found = re.fullmatch(route.pattern, path)
                parts = {"folder": surveys.whole} if found is None else found.groupdict()
                assert FOLDER_NAME.fullmatch(parts["folder"])
                assert parts.get("name", MANIFEST_FILE) in FILES
        if name not in (surveys.whole, surveys.part):
            with pytest.raises(Gpr20Error):
                folder_of(surveys.data, name)


def test_a_survey_that_cannot_be_read_says_why_and_can_be_downloaded(surveys):
    folder = surveys.data / surveys.part
    for name in ("log.jsonl", "log.copy.jsonl", "survey.mcap", "manifest.json"):
        (folder / name).write_bytes(b"nothing")
    shown = surveys.get(surveys.part)
    assert shown["problems"] and shown["state"] == "unreadable" and not shown["can_search"]
    assert zip_of(surveys, surveys.part).namelist()


def test_a_large_survey_comes_as_it_is_and_what_fails_is_never_taken_for_a_whole_one(surveys):
    path = surveys.data / surveys.whole / "survey.mcap"
    path.write_bytes(os.urandom(30_000_000))
    with contextlib.closing(Site(surveys.page.routes)) as site:
        reply = site.ask("GET", f"/api/surveys/{surveys.whole}/zip", session="watch")
        assert f'filename="{surveys.whole}_survey.zip"' in reply.headers["Content-Disposition"]
        with zipfile.ZipFile(io.BytesIO(reply.body)) as archive:
            assert archive.testzip() is None
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


def test_a_report_is_made_as_the_window_makes_it(surveys):
    for kind in ("survey-zip", "report", "..%2f", "report-html/"):
        with pytest.raises(LookupError):
            surveys.get(surveys.whole, f"/made/{kind}")
    surveys.services.export = lambda *_: Exported(("a.pdf",), b"%PDF")
    body = surveys.get(surveys.whole, "/made/report-html")
    assert (body.content, body.name) == (b"%PDF", "a.pdf")
    _service, survey, fields = surveys.services.asked[-1]
    assert (survey, fields["kinds"], fields["volume"]) == (surveys.whole, ["report-html"], "")
    assert (fields["language"], fields["permittivity"]) == ("en", NOT_KNOWN)
