"""Tables of a trial: every bad cell is named with its place, whatever the table holds."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from trial_kit import LANES, TARGETS

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.trial.ground import read_lanes, read_targets
from gpr20_common.errors import InvalidValueError

LANE_MAP = read_lanes(LANES.encode(), "lanes.csv")


def refusal(targets):
    with pytest.raises(UnreadableFileError) as caught:
        read_targets(targets.encode(), "targets.csv", LANE_MAP)
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("T2,L1", "T1,L1", ("line 3", "two rows", "'T1'")),
        ("T2,L1", ",L1", ("line 3", "''", "column target")),
        ("T2,L1", "T2,L9", ("T2", "L9", "L1, L2")),
        ("T2,L1,2.5", "T2,L1,4.5", ("T2", "not in its lane, L1")),
        ("T2,L1,2.5", "T2,L1,nan", ("line 3", "'nan'", "column x_m")),
        ("T2,L1,2.5", "T2,L1,2.5.0", ("line 3", "'2.5.0'", "column x_m", "-1000 ... 1000")),
        ("0.5,0.10,PMN", "0.5,-1,PMN", ("line 3", "'-1'", "column depth_m", "0 ... 10")),
        ("0.10,PMN", "0.10,", ("line 3", "column type")),
        ("T2,L1,2.5,0.5", "T2,L1,2.5", ("line 3", "as many cells")),
        ("depth_m", "x_m", ("line 1", "each column once", "depth_m")),
        ("T3", '"T3', ("CSV",)),
    ],
)
def test_a_bad_cell_is_named_with_file_line_value_and_what_is_allowed(old, new, said):
    text = refusal(TARGETS.replace(old, new, 1))
    assert "targets.csv" in text
    assert all(one in text for one in said), text


def test_tables_of_a_spreadsheet_with_decimal_commas_are_read():
    table = TARGETS.replace(",", ";").replace(".", ",")
    usual = read_targets(TARGETS.encode(), "t", LANE_MAP)
    for content in (table.encode(), table.replace("\n", "\r\n").encode("utf-8-sig")):
        assert [one.place_m for one in read_targets(content, "t", LANE_MAP)] == [
            one.place_m for one in usual
        ]


def test_a_lane_whose_ends_are_exchanged_and_an_empty_table_are_refused():
    with pytest.raises(InvalidValueError, match="L1: x_max_m is 0 m; .* between 4.01 and"):
        read_lanes(LANES.replace("0,4", "4,0", 1).encode(), "lanes.csv")
    with pytest.raises(UnreadableFileError, match="heading"):
        read_lanes(b"", "lanes.csv")


def test_text_in_another_encoding_is_refused():
    with pytest.raises(UnreadableFileError, match=r"t.csv as CSV in UTF-8"):
        read_targets(TARGETS.replace("T2", "Ñ").encode("latin-1"), "t.csv", LANE_MAP)


CELLS = st.one_of(
    st.text(max_size=8),
    st.floats().map(str),
    st.sampled_from(["T1", "L1", "1e999", "-0", "=1+1", '"', "\0", "٣", "1_0", "inf", "0x1"]),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.lists(CELLS, min_size=1, max_size=10), max_size=5), st.sampled_from(",;\t"))
@example([["T1", "L1", "1", "٣", "0", "a", "", "", ""]], ",")
def test_any_table_is_read_or_refused_with_a_sentence(rows, comma):
    heading = TARGETS.splitlines()[0].replace(",", comma)
    content = "\n".join([heading, *(comma.join(one) for one in rows)])
    try:
        targets = read_targets(content.encode("utf-8", "replace"), "targets.csv", LANE_MAP)
    except UnreadableFileError as error:
        assert "targets.csv" in str(error)
    else:
        assert all(LANE_MAP[one.lane].contains(one.place_m) for one in targets)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_no_table_and_nothing_else_happens(content):
    with pytest.raises(UnreadableFileError):
        read_targets(content, "targets.csv", LANE_MAP)
