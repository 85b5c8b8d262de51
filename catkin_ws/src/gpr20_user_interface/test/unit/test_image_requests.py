"""When the window asks for a focused image, and what it makes of the answer."""

import dataclasses

import map_kit
import pytest
from result_kit import Now, Requests
from view_kit import SURVEY

from gpr20_common.message import verbatim
from gpr20_operator.jobs.pictures import (
    FEWEST_TRACES,
    MOST_IMAGES,
    PERIOD_S,
    SETTLED_S,
    Imaging,
    Pictures,
    Wanted,
)


@pytest.fixture
def now():
    return Now()


@pytest.fixture
def node():
    return Requests()


@pytest.fixture
def imaging(node, now):
    return Imaging(node, now)


def focused(node, survey=SURVEY):
    node.ticket("focus").done(map_kit.focused(survey_id=survey))


def test_new_traces_lead_to_a_new_image_at_most_every_10_s(imaging, node, now):
    wanted = Wanted(SURVEY, 20, 4.0)
    for step in range(40):
        now.s += 1.0
        imaging.keep(wanted._replace(traces=20 + step))
        if step % 3 == 0:
            focused(node)
    # An answer comes up to three seconds later.
    assert 3 <= len(node.of("focus")) <= 5
    assert imaging.pictures.image(SURVEY) is not None
    assert imaging.pictures.image("another") is None


def test_nothing_is_asked_without_new_traces_or_while_an_answer_is_on_its_way(imaging, node, now):
    wanted = Wanted(SURVEY, 20, 4.0)
    for traces in [20] + 100 * [30]:
        imaging.keep(wanted._replace(traces=traces))
        now.s += 1.0
    assert len(node.of("focus")) == 1
    focused(node)
    for _ in range(100):
        imaging.keep(wanted._replace(traces=30))
        now.s += 1.0
        if len(node.of("focus")) == 2:
            focused(node)
    assert len(node.of("focus")) == 2


def test_another_survey_is_asked_for_at_once_and_another_permittivity_when_it_rests(
    imaging, node, now
):
    wanted = Wanted(SURVEY, 20, 4.0)
    imaging.keep(wanted)
    focused(node)
    imaging.keep(wanted._replace(survey_id="another"))
    focused(node, "another")
    assert [one[0] for one in node.of("focus")] == [SURVEY, "another"]
    for permittivity in (5.0, 6.0, 7.0):
        now.s += SETTLED_S / 2
        imaging.keep(Wanted("another", 20, permittivity))
    assert len(node.of("focus")) == 2
    now.s += SETTLED_S
    imaging.keep(Wanted("another", 20, 7.0))
    assert node.of("focus")[-1] == ("another", 7.0)


def test_too_few_traces_are_not_asked_about(imaging, node):
    imaging.keep(Wanted(SURVEY, FEWEST_TRACES - 1, 4.0))
    imaging.keep(Wanted("", 100, 4.0))
    assert node.asked == []


def test_a_failure_is_kept_until_there_is_an_image(imaging, node, now):
    wanted = Wanted(SURVEY, 20, 4.0)
    imaging.keep(wanted)
    node.ticket("focus").fail(verbatim("the analysis is not installed"))
    assert str(imaging.problem) == "the analysis is not installed"
    imaging.keep(wanted)
    assert len(node.of("focus")) == 1
    now.s += PERIOD_S
    imaging.keep(wanted._replace(traces=21))
    focused(node)
    assert imaging.problem is None


def test_images_of_other_surveys_come_one_at_a_time_and_all_end_with_the_window(imaging, node):
    imaging.keep(Wanted(SURVEY, 20, 4.0))
    assert imaging.focus("finer", 4.0) and not imaging.focus("another", 4.0)
    assert [one[0] for one in node.of("focus")] == [SURVEY, "finer"]
    imaging.end()
    assert len(node.cancelled) == 2
    assert imaging.focus("another", 4.0)


def test_of_many_images_those_that_are_looked_at_stay():
    pictures = Pictures()
    pictures.add_image(map_kit.focused())
    for number in range(3 * MOST_IMAGES):
        assert pictures.image(SURVEY) is not None
        pictures.add_image(map_kit.focused(survey_id=str(number)))
    kept = [one for one in range(3 * MOST_IMAGES) if pictures.image(str(one)) is not None]
    assert len(kept) == MOST_IMAGES - 1 and kept[-1] == 3 * MOST_IMAGES - 1


def test_an_image_that_another_page_has_replaced_is_made_again(imaging, node, now):
    wanted = Wanted(SURVEY, 20, 9.0)
    imaging.keep(wanted)
    found = map_kit.focused().found
    node.ticket("focus").done(
        dataclasses.replace(map_kit.focused(), found=dataclasses.replace(found, permittivity=9.0))
    )
    now.s += PERIOD_S
    imaging.keep(wanted)
    assert len(node.of("focus")) == 1
    imaging.pictures.add_image(map_kit.focused())  # with 4
    for _ in range(3):
        imaging.keep(wanted)
        now.s += PERIOD_S
    assert node.of("focus")[1:] == [(SURVEY, 9.0)]
