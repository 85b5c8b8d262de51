"""No card contradicts a table of right first steps, which was written from the sentences alone.

Three files, each written without sight of the others' contents:

- `first_steps.tsv`: sentences of faults, the first steps that are right and those that mislead, as
  an engineer judged them who saw neither codes nor remedies; in the last column the codes that the
  sentence reported then. A reworded sentence keeps its row.
- `remedy_actions.tsv`: which of these steps each remedy asks for, judged from the remedies alone.
- `actions.tsv`: what each step means.
"""

from pathlib import Path

import pytest
from fault_table import fault_table
from wings_kit import NEEDS_ALL

# The table holds sentences of every package.
pytestmark = NEEDS_ALL

DATA = Path(__file__).parent / "data"
ANY = "any"


def rows(name):
    return [line.split("\t") for line in (DATA / name).read_text("utf-8").splitlines()]


@pytest.fixture(scope="module")
def table():
    return fault_table()


def test_no_first_step_contradicts_the_table(table):
    asked = {remedy: actions.split(",") for remedy, actions in rows("remedy_actions.tsv")}
    contradictions = []
    for sentence, right, misleading, codes in rows("first_steps.tsv"):
        for code in codes.split(","):
            remedy = table.faults[code].remedy.template
            steps = asked[remedy]
            if right != ANY and (
                not set(steps) & set(right.split(",")) or steps[0] in misleading.split(",")
            ):
                contradictions.append((sentence, code, remedy, right))
    assert contradictions == []


def test_the_table_holds_286_sentences_and_each_that_is_unchanged_reports_its_codes(table):
    sentences = rows("first_steps.tsv")
    assert len(sentences) == 286
    unchanged = 0
    for sentence, _right, _misleading, codes in sentences:
        present = table.codes_of(sentence)
        assert not present or set(present) == set(codes.split(",")), sentence
        unchanged += bool(present)
    # Of a table about sentences that nobody says any more, nothing would follow.
    assert unchanged > 200


def test_every_step_is_explained():
    known = {action for action, _meaning in rows("actions.tsv")}
    for _sentence, right, misleading, _codes in rows("first_steps.tsv"):
        assert {*right.split(","), *misleading.split(",")} - {""} <= known
    for _remedy, actions in rows("remedy_actions.tsv"):
        assert set(actions.split(",")) <= known
