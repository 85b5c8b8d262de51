"""The list of past surveys: how each ended, and what a search finds."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from view_kit import past_survey

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.message import verbatim
from gpr20_operator.ground.past_surveys import PastSurveys, searchable
from gpr20_operator.words import local_time

SPANISH = read_catalogue(Language.SPANISH)
WORDS = ("importada", "Salado", "salado", "PÉREZ", "perez", "North", "lane", "2026", "11-2", "")
TEXTS = st.lists(st.sampled_from(WORDS), max_size=3).map(" ".join)
SURVEYS = st.builds(
    replace,
    st.just(past_survey()),
    name=TEXTS,
    site=TEXTS,
    operator=TEXTS,
    complete=st.booleans(),
    outcome=st.sampled_from(["", "stopped", "finished", "imported"]),
    problem=st.sampled_from([None, None, verbatim("damaged")]),
)


@given(st.lists(SURVEYS, max_size=12), TEXTS, st.integers(0, 12))
def test_a_search_is_a_plain_filter_of_all_pages_by_names_time_and_ending(surveys, text, split):
    folders = [f"20261121T{99 - number:06d}_7c9e6679" for number in range(len(surveys))]
    numbered = tuple(map(lambda one, folder: replace(one, folder=folder), surveys, folders))
    past = PastSurveys()
    past.take("", numbered[:split], True)
    past.take(past.next_before, numbered[split:], False)

    def wanted(survey):
        begun = local_time(survey.started, survey.folder)
        shown = map(SPANISH.text, (begun, past.ending(survey)))
        written = searchable("\n".join((survey.name, survey.site, survey.operator, *shown)))
        return all(searchable(word) in written for word in text.split())

    assert past.found(text, SPANISH.text) == tuple(filter(wanted, numbered))
