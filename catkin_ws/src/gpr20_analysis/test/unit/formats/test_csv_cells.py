"""No spreadsheet finds a formula in a CSV file of gpr20, and the texts can be read back."""

from __future__ import annotations

import csv
import io
import math

from candidate_examples import candidate_list
from case_kit import each_case
from hypothesis import example, given
from hypothesis import strategies as st
from survey_kit import POINTS, make_survey

from gpr20_analysis import cell_text, export_survey, load_survey, write_candidates, write_markers
from gpr20_analysis.candidates.marker_list import MarkerList
from gpr20_analysis.formats.csv_cells import csv_cell
from gpr20_common.message import verbatim
from gpr20_common.terminal_text import is_shown
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate

SEPARATORS = (",", ";", "\t")
FORMULA = tuple("=+-@\t\r\n\uff1d\uff0b\uff0d\uff20")
TEXTS = st.lists(
    st.one_of(
        st.sampled_from(
            [*FORMULA, *SEPARATORS, "'", '"', " ", "\u00a0", "cmd", "1", "HYPERLINK()"]
        ),
        st.text(max_size=3),
    ),
    max_size=8,
).map("".join)


def is_number(cell):
    try:
        return math.isfinite(float(cell)) and "_" not in cell
    except ValueError:
        return False


def live_cells(text):
    """Return the cells of a file that a spreadsheet may take for a formula."""
    found = []
    for separator in SEPARATORS:
        for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_NONE):
            lines = io.StringIO(text, newline="")
            for row in csv.reader(lines, delimiter=separator, quoting=quoting):
                cells = (one.lstrip(' "\u00a0') for one in row)
                found += [one for one in cells if one.startswith(FORMULA) and not is_number(one)]
    return found


def as_file(*cells):
    stream = io.StringIO(newline="")
    csv.writer(stream).writerow(cells)
    return stream.getvalue()


@given(TEXTS)
@example("'=1")
@example("''-5")
@example("x;=1+1")
@example('x;"=1+1"')
@example("-90 -45")
def test_a_text_is_no_formula_and_is_read_back(text):
    cell = csv_cell(text)
    assert cell_text(cell) == text
    # The writer ends a line by itself, so only what is in a line may begin like that.
    assert not live_cells(as_file("id", cell, "end")), repr(cell)
    assert not live_cells(as_file(cell)), repr(cell)


@each_case("value", [0, -1.5, 1e-300, -12, "-90", "+5.25", "0.1", "plain, text; with 3 - 1", ""])
def test_numbers_and_plain_texts_stay(value):
    assert csv_cell(value) == value
    assert csv_cell(None) == ""


SHOWN = TEXTS.map(lambda text: "".join(filter(is_shown, text)))


@given(SHOWN, SHOWN, TEXTS)
def test_files_of_markers_hold_no_formula(tmp_path_factory, text, author, survey_id):
    path = tmp_path_factory.mktemp("csv") / "markers.csv"
    marker = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", -12.5, 20.0, 80.0, text, author)
    write_markers(MarkerList(survey_id, True, (marker,)), path)
    content = _content(path)
    assert not live_cells(content)
    lines = io.StringIO(content, newline="")
    rows = [row for row in csv.reader(lines) if not row[0].startswith("#")]
    (row,) = (dict(zip(rows[0], one)) for one in rows[1:])
    assert (cell_text(row["text"]), cell_text(row["author"])) == (text, author)
    assert float(row["x_m"]) == -0.0125


@given(TEXTS, TEXTS, TEXTS)
def test_files_of_candidates_hold_no_formula(tmp_path_factory, survey_id, method, note):
    path = tmp_path_factory.mktemp("csv") / "candidates.csv"
    one = Candidate("C01", -0.1, 0.2, 0.1, 0.0, 0.0, 0.0, 20.0, 1e-9, (-90.0, -45.0), -0.1, ())
    listed = candidate_list([one], survey_id=survey_id, method=method, notes=(verbatim(note),))
    write_candidates(listed, path)
    content = _content(path)
    assert not live_cells(content)
    row = list(csv.reader(io.StringIO(content, newline="")))[-1]
    assert "-90 -45" in map(cell_text, row) and "-0.1" in row


def _content(path):
    with path.open(encoding="utf-8", newline="") as stream:
        return stream.read()


def test_a_table_of_samples_holds_no_formula(tmp_path):
    survey = load_survey(make_survey(tmp_path, len(POINTS), "finished"))
    unit = '";=cmd|,\n=1'
    survey["aux_soil"] = survey["height"].assign_attrs(units=unit)
    export_survey(survey, tmp_path / "table.csv", "csv")
    assert not live_cells(_content(tmp_path / "table.csv"))
