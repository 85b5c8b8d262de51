"""Analysis, report, exports, window and markers say the same of every candidate and flag."""

import csv
import dataclasses
import json

import pytest

pytest.importorskip("rospy")

import rospy
from candidate_examples import POSITIONS, candidate_lists
from hypothesis import HealthCheck, given, settings
from visualization_msgs.msg import Marker

from gpr20_analysis.candidates.files import write_candidates
from gpr20_analysis.candidates.table import (
    WEAKER_TITLE,
    candidate_lines,
    candidate_row,
    places_sentence,
)
from gpr20_analysis.report.sections import places_section
from gpr20_analysis.sentences import ENGLISH
from gpr20_imaging.high import imaging_node
from gpr20_operator.ground import texts as ground_texts
from gpr20_operator.jobs.result_texts import headline, why_line
from gpr20_survey.results.candidates import json_text, list_from

# As it is documented: docs/imaging.md.
WEAKER = {"clutter", "sidelobe"}
LABELS = {
    "surface-residue": "surface residue",
    "edge": "edge",
    "one-polarization": "in one rotation only",
    "clutter": "clutter",
    "sidelobe": "sidelobe",
    "brightest": "only the brightest",
    "of-a-later-version": "of-a-later-version",
}


def csv_rows(found, folder):
    path = folder / "list.csv"
    write_candidates(found, path)
    lines = path.read_text(encoding="utf-8").splitlines()
    facts = dict(one[2:].split(": ", 1) for one in lines if one.startswith("# "))
    return facts, list(csv.DictReader(one for one in lines if not one.startswith("#")))


def geojson(found, folder):
    path = folder / "list.geojson"
    write_candidates(found, path)
    values = json.loads(path.read_text(encoding="utf-8"))
    return values["gpr20"], [one["properties"] for one in values["features"]]


def labels_of(text):
    return [] if text in ("-", "—") else text.split(", ")


def check(found, folder):
    flags = {one.id: [flag.value for flag in one.flags] for one in found.candidates}
    weaker = {name for name, own in flags.items() if WEAKER & set(own)}
    shown = [name for name in flags if name not in weaker]
    labels = {name: [LABELS[one] for one in own] for name, own in flags.items()}
    assert [list(map(str, one.labels)) for one in found.candidates] == list(labels.values())

    # Files, for programs: everything that is listed.
    for facts, rows in (csv_rows(found, folder), geojson(found, folder)):
        assert [one["id"] for one in rows] == list(flags)
        for one in rows:
            own = one["flags"].split() if isinstance(one["flags"], str) else one["flags"]
            assert own == flags[one["id"]]
            assert bool(int(one["doubtful"])) == (one["id"] in weaker)
        assert [int(facts[name]) for name in ("listed", "omitted")] == [len(flags), found.omitted]

    # Terminal and report.
    for all_of_them in (False, True):
        lines = candidate_lines(found, weaker=all_of_them)
        rows = [one.split()[0] for one in lines if one.split()[0] in flags]
        assert rows == (list(flags) if all_of_them else shown)
        assert (str(WEAKER_TITLE) in lines) == (all_of_them and bool(weaker))
        said = f"{len(weaker) + found.omitted} weaker echoes; show them"
        assert any(said in one for one in lines) == (not all_of_them and found.weaker > 0)
    section = places_section(found, ENGLISH)
    assert [row[0] for row in section.rows] == shown
    assert [row[0] for row in section.more[1]] == [one for one in flags if one in weaker]
    for row in (*section.rows, *(candidate_row(one) for one in found.candidates)):
        assert labels_of(row[-1]) == labels[row[0]]
    assert places_sentence(found).values["count"] == len(shown)

    # The window: result and ground, from what the node sends.
    received = list_from(json_text(found))
    for one in received.candidates:
        words = [str(line) for line in why_line(one).values["sentences"]]
        assert words[1:] == labels[one.id]
        lines = [str(line) for line in ground_texts.candidate_lines(one, measured=True)]
        assert lines[0].endswith("weaker echo") == (one.id in weaker)
        assert lines[len(lines) - len(one.flags) :] == labels[one.id]
    if shown:
        counted = str(headline(received))
        assert (f"{received.weaker} weaker echo" in counted) == (received.weaker > 0)
        assert counted.startswith(f"{len(shown)} place")

    # The markers: everything that is listed.
    markers = imaging_node.marker_array(found, "base_link", rospy.Time(0)).markers
    spheres = [one for one in markers if one.type == Marker.SPHERE and one.ns == "candidates"]
    names = [one for one in markers if one.type == Marker.TEXT_VIEW_FACING]
    colours = {one.text.split()[0]: one.color for one in names}
    assert [one.color for one in spheres] == list(colours.values())
    assert list(colours) == list(flags)
    for name, colour in colours.items():
        assert (colour == imaging_node.DOUBTFUL) == (name in weaker)


@given(candidate_lists(POSITIONS))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_list_is_the_same_everywhere(tmp_path, found):
    check(dataclasses.replace(found, method="phase-shift"), tmp_path)
