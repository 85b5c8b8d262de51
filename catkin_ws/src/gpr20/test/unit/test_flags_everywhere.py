"""Analysis, report, exports, window and markers say the same of every candidate and flag."""

import csv
import dataclasses
import json

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

import rospy
from candidate_examples import POSITIONS, candidate, candidate_list, candidate_lists
from hypothesis import HealthCheck, given, settings
from visualization_msgs.msg import Marker

from gpr20_analysis.candidates.files import write_candidates
from gpr20_analysis.candidates.table import (
    DOUBTFUL_TITLE,
    candidate_lines,
    candidate_row,
    tail_sentences,
)
from gpr20_analysis.high import candidate_topics
from gpr20_analysis.report import pictures
from gpr20_analysis.sentences import ENGLISH
from gpr20_operator.ground import texts as ground_texts
from gpr20_operator.jobs.result_texts import headline, why_line
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidates import Flag, json_text, list_from

# As it is documented: docs/imaging.md.
DOUBTFUL = {"clutter", "sidelobe"}
LABELS = {
    "surface-residue": "surface residue",
    "edge": "edge",
    "one-polarization": "one polarization",
    "clutter": "clutter",
    "sidelobe": "sidelobe",
    "unrated": "not rated",
    "of-a-later-version": "of-a-later-version",
}
HERE = AreaPosition(4.6, -74.1, 30.0)


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
    doubtful = {name for name, own in flags.items() if DOUBTFUL & set(own)}
    shown = [name for name in flags if name not in doubtful]
    shown += [name for name in flags if name in doubtful][:10]
    labels = {name: [LABELS[one] for one in own] for name, own in flags.items()}
    primary = len(flags) - len(doubtful) + found.omitted_primary

    # Files, for programs: everything that is listed.
    for facts, rows in (csv_rows(found, folder), geojson(found, folder)):
        assert [one["id"] for one in rows] == list(flags)
        for one in rows:
            own = one["flags"].split() if isinstance(one["flags"], str) else one["flags"]
            assert own == flags[one["id"]]
            assert bool(int(one["doubtful"])) == (one["id"] in doubtful)
        counts = [int(facts[name]) for name in ("listed", "omitted", "omitted_primary")]
        assert counts == [len(flags), found.omitted, found.omitted_primary]

    # Terminal and report.
    lines = candidate_lines(found)
    head = lines.index(str(DOUBTFUL_TITLE)) if str(DOUBTFUL_TITLE) in lines else None
    places = {one.split()[0]: at for at, one in enumerate(lines) if one.split()[0] in flags}
    assert list(places) == shown
    assert {one for one in shown if head is not None and places[one] > head} == doubtful & {*shown}
    section = report_section(found)
    assert [row[0] for row in section.rows] == shown
    for row in (*section.rows, *(candidate_row(one) for one in found.candidates)):
        assert labels_of(row[-1]) == labels[row[0]]
    first = tail_sentences(found, found.shown())[0]
    assert str(first) in section.lines[0]
    assert first.values["primary"] == primary
    assert first.values["secondary"] == len(flags) + found.omitted - primary

    # The window: result and ground, from what the node sends.
    received = list_from(json_text(found))
    for one in received.candidates:
        words = [str(line) for line in why_line(one).values["sentences"]]
        assert ("doubtful" in words[0]) == (one.id in doubtful)
        assert words[1:] == labels[one.id]
    if received.total:
        counted = str(headline(received))
        secondary = len(flags) + found.omitted - primary
        assert (f"doubtful: {secondary}" in counted) == (secondary > 0)
        assert f"of {len(flags) + found.omitted} places" in counted
    for one in received.candidates:
        lines = [str(line) for line in ground_texts.candidate_lines(one, measured=True)]
        assert lines[0].endswith("doubtful") == (one.id in doubtful)
        assert lines[len(lines) - len(one.flags) :] == labels[one.id]

    # The markers: everything that is listed.
    markers = candidate_topics.marker_array(found, "base_link", rospy.Time(0)).markers
    spheres = [one for one in markers if one.type == Marker.SPHERE and one.ns == "candidates"]
    names = [one for one in markers if one.type == Marker.TEXT_VIEW_FACING]
    colours = {one.text.split()[0]: one.color for one in names}
    assert [one.color for one in spheres] == list(colours.values())
    assert list(colours) == list(flags)
    for name, colour in colours.items():
        assert (colour == candidate_topics.DOUBTFUL) == (name in doubtful)


def report_section(found):
    no_figure = pictures.projections.candidate_map_figure
    pictures.projections.candidate_map_figure = lambda *_: None
    try:
        return pictures._candidates(None, found, ENGLISH)
    finally:
        pictures.projections.candidate_map_figure = no_figure


@each_case("flag", Flag)
def test_every_flag_means_the_same_everywhere(flag, tmp_path):
    assert list(map(str, candidate(flags=[flag]).labels)) == [LABELS[flag.value]]
    found = candidate_list([candidate(flags=[flag])], position=HERE)
    check(found, tmp_path)
    # Beside others, and beyond what is shown of doubtful ones.
    many = [candidate(number, flags=[flag]) for number in range(2, 15)]
    check(candidate_list([candidate(), *many], position=HERE, omitted=3), tmp_path)


@given(candidate_lists(POSITIONS))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_list_is_the_same_everywhere(tmp_path, found):
    check(dataclasses.replace(found, method="phase-shift"), tmp_path)
