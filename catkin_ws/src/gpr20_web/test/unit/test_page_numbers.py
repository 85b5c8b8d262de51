"""Numbers on the page, in the language of its reader."""

import contextlib
import dataclasses
import json
import re
import shutil
import subprocess

import pytest
from web_kit import STATIC
from whole_page_kit import TABLE, WholePage

from gpr20_common.catalogue import Language
from gpr20_operator.robot.events import CurrentPosition
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role

# Keys whose texts programs read, and what people have typed.
OF_PROGRAMS = (
    "id",
    "folder",
    "since",
    "created",
    "time_utc",
    "notes",
    "markers",
    "colours",
    "code",
)
WITH_POINT = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])|\d{4}-\d\d-\d\d")


def texts_of(value, key=""):
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, (list, tuple)):
        for one in value:
            yield from texts_of(one, key)
    elif isinstance(value, dict):
        for name, one in value.items():
            yield from texts_of(one, name)


def test_no_text_of_the_spanish_page_has_a_decimal_point(tmp_path):
    with contextlib.closing(WholePage(tmp_path)) as page:
        page.be(SurveyState.SURVEYING)
        place = CurrentPosition(12.5, 20.25, 90.0)
        page.shell.refresh(dataclasses.replace(page.model.snapshot(), current=place))
        members = "".join(page.shell.document(Language.SPANISH)).rstrip(",")
        found = {"/api/live": json.loads(f"{{{members}}}")}
        assert found["/api/live"]["job"]["place"].startswith("X 12,5 mm, Y 20,2 mm, 90 ")
        for row in TABLE:
            # What is downloaded is for programs.
            if row.method != "GET" or row.path == "/api/live" or "/files/" in row.path:
                continue
            path = row.path.format(folder=page.surveys.whole)
            again = "&" if "?" in path else "?"
            reply = page.ask("GET", f"{path}{again}language=es", Role.CONTROL)
            with contextlib.suppress(ValueError):
                found[path] = json.loads(reply.body)
        assert "/api/words" in found and len(found) > 5
        wrong = [
            (path, key, text)
            for path, answer in found.items()
            for key, text in texts_of(answer)
            if key not in OF_PROGRAMS and WITH_POINT.search(text)
        ]
        assert wrong == []


@pytest.mark.skipif(shutil.which("node") is None, reason="no Node.js")
def test_the_script_writes_numbers_as_the_catalogue_says():
    """With the functions of the page, out of its script."""
    script = (STATIC / "app.js").read_text(encoding="utf-8")
    methods = re.search(r"  word\(name.*?(?=\n  get\()", script, re.DOTALL).group()
    code = f"""
class App {{
  constructor(words) {{ this.words = words; }}
{methods}
}}
const said = [".", ","].map((point) => {{
  const app = new App({{ "shell.point": point, a: "{{x:g}} mm {{y}}" }});
  return [app.word("a", {{ x: 0.5, y: "1.2.3" }}), app.number(-2.25)];
}});
console.log(JSON.stringify(said));
"""
    done = subprocess.run(["node", "-e", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [["0.5 mm 1.2.3", "-2.25"], ["0,5 mm 1.2.3", "-2,25"]]
