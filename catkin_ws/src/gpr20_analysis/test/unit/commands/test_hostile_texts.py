"""No text or name in a survey controls the terminal, fakes a line or ends a command."""

from __future__ import annotations

import json
import os
import random
import shutil

from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_common.terminal_text import is_shown

DRAWS = 40
HOSTILE = (
    *("\x1b]0;owned\x07", "\x1b[2J\x1b[H", "\x9b31m", "\rcomplete and intact", "\x08" * 20),
    *("\nFAULT: faked\n", "a\u202eb", "\u2028line", "\ud800", "\udcff"),
)
COMMANDS = (
    *(["info"], ["info", "--accept-damaged"], ["verify", "--all"], ["repair"], ["markers"]),
    *(["annotate"], ["info", "--json"], ["verify", "--json"], ["markers", "--json"]),
)
MORE = {
    "instrument": {"identity": "ANRITSU,MS2026C,1,1", "calibration": "applied"},
    "nodes": [{"name": "vna", "simulated": False, "hardware": "MS2026C", "host": "pi"}],
    "robot": {"name": "robot1", "site": "Bogota", "operator": "Ana"},
    "annotation": {"name": "x", "operator": "y", "site": "z", "notes": "n", "position": None,
                   "heading_deg": None},
}  # fmt: skip


def texts_of(values, place=()):
    """Yield where the texts of a JSON object are."""
    items = values.items() if isinstance(values, dict) else enumerate(values)
    for key, value in items:
        if isinstance(value, (dict, list)):
            yield from texts_of(value, (*place, key))
        elif isinstance(value, str):
            yield (*place, key)


def put_text(folder, draw):
    path = draw.choice([folder / "survey.json", *sorted((folder / "traces").iterdir())[:3]])
    values = json.loads(path.read_text())
    *above, last = draw.choice([one for one in texts_of(values) if one[-1] != "format"])
    inner = values
    for key in above:
        inner = inner[key]
    inner[last] = draw.choice(HOSTILE) + draw.choice(["", inner[last]])
    path.write_text(json.dumps(values, indent=2) + "\n")


def put_name(folder, draw):
    name = os.fsencode("x" + draw.choice(HOSTILE[:8])) + draw.choice([b"", b"\xff.json"])
    place = os.fsencode(draw.choice([folder, folder / "traces"]))
    with open(os.path.join(place, name), "wb") as stream:
        stream.write(b"{}")


def test_whatever_a_survey_says_is_shown_on_the_lines_of_the_command(tmp_path, capsys):
    stored = make_survey(tmp_path / "stored", len(POINTS), "finished", more=MORE)
    draw = random.Random(27)
    broken = []
    for number in range(DRAWS):
        folder = tmp_path / str(number) / stored.name
        shutil.copytree(str(stored), str(folder))
        if draw.random() < 0.6:
            (folder / "manifest.json").unlink()
        put = draw.choice([put_text, put_name])
        put(folder, draw)
        command = draw.choice(COMMANDS)
        main([*command, str(folder)])
        printed = capsys.readouterr()
        shown = (printed.out + printed.err).split("\n")
        case = f"{number}: {' '.join(command)} after {put.__name__}"
        if any(not is_shown(one) for line in shown for one in line):
            broken.append(f"{case}: {shown!r}")
        if any(line.startswith("FAULT: faked") for line in shown):
            broken.append(f"{case}: a line is faked")
        if "program error" in printed.err:
            broken.append(f"{case}: {printed.err}")
    assert not broken, "\n".join(broken)
