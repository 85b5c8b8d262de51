"""Numbers and moments on the page, in the language of its reader."""

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
        found = {"/api/live": page.shell.document(Language.SPANISH)}
        assert found["/api/live"]["job"]["place"].startswith("X 12,5 mm, Y 20,2 mm, 90 ")
        for row in TABLE:
            # What is downloaded is for programs.
            if row.method != "GET" or row.path == "/api/live" or row.path.endswith("/zip"):
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
def test_the_script_writes_numbers_and_moments_as_the_catalogue_says():
    """With the functions of the page, out of its script."""
    script = (STATIC / "app.js").read_text(encoding="utf-8")
    methods = re.search(r"  word\(name.*?(?=\n  get\()", script, re.DOTALL).group()
    code = f"""
class App {{
  constructor(words) {{ this.words = words; }}
{methods}
}}
const said = {{}};
const forms = {{ en: [".", "{{year}}-{{month}}-{{day}} {{time}}"],
  es: [",", "{{day}}/{{month}}/{{year}} {{time}}"] }};
for (const [name, [point, moment]] of Object.entries(forms)) {{
  const app = new App({{ "shell.point": point, "shell.moment": moment, a: "{{x:g}} mm {{y}}" }});
  said[name] = [app.word("a", {{ x: 0.5, y: "1.2.3" }}), app.moment("2026-11-30T14:05:09Z"),
    app.moment("2026-11-30T14:05:09Z", 17), app.number(-2.25)];
}}
console.log(JSON.stringify(said));
"""
    done = subprocess.run(
        ["node", "-e", code], capture_output=True, text=True, check=True, env={"TZ": "UTC"}
    )
    assert json.loads(done.stdout) == {
        "en": ["0.5 mm 1.2.3", "2026-11-30 14:05", "2026-11-30 14:05:09 GMT+0000", "-2.25"],
        "es": ["0,5 mm 1.2.3", "30/11/2026 14:05", "30/11/2026 14:05:09 GMT+0000", "-2,25"],
    }
