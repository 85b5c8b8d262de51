"""When the window asks for a focused image, and what it makes of the answer."""

import map_kit
import pytest
from view_kit import SURVEY
from window_helpers import ImagingNode

from gpr20_common.message import verbatim
from gpr20_operator.jobs.images import (
    FEWEST_TRACES,
    LOST_S,
    PERIOD_S,
    SETTLED_S,
    FocusedImages,
    Wanted,
)
from gpr20_operator.jobs.imaging import ImageFailed, ImageFocused


class Clock:
    now_s = 1000.0


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def node():
    return ImagingNode()


@pytest.fixture
def images(node, clock):
    return FocusedImages(node, lambda: clock.now_s)


def focused(images, survey=SURVEY):
    images.on_event(ImageFocused(map_kit.focused(survey_id=survey)))


def test_new_traces_lead_to_a_new_image_at_most_every_10_s(images, node, clock):
    wanted = Wanted(SURVEY, 20, 4.0)
    for step in range(40):
        clock.now_s += 1.0
        images.keep(wanted._replace(traces=20 + step))
        if step % 3 == 0:
            focused(images)
    # An answer comes up to three seconds later.
    assert 4 <= len(node.of("focus")) <= 5
    assert images.image(SURVEY) is not None
    assert images.image("another") is None


def test_nothing_is_asked_without_new_traces_or_while_an_answer_is_on_its_way(images, node, clock):
    wanted = Wanted(SURVEY, 20, 4.0)
    images.keep(wanted)
    for _ in range(100):
        clock.now_s += 1.0
        images.keep(wanted._replace(traces=30))
    assert len(node.of("focus")) == 1
    focused(images, SURVEY)
    clock.now_s += PERIOD_S
    images.keep(wanted._replace(traces=30))
    focused(images, SURVEY)
    for _ in range(100):
        clock.now_s += 1.0
        images.keep(wanted._replace(traces=30))
    assert len(node.of("focus")) == 2


def test_another_survey_is_asked_for_at_once_and_another_permittivity_when_it_rests(
    images, node, clock
):
    wanted = Wanted(SURVEY, 20, 4.0)
    images.keep(wanted)
    focused(images, SURVEY)
    images.keep(wanted._replace(survey_id="another"))
    focused(images, "another")
    assert [one[0] for one in node.of("focus")] == [SURVEY, "another"]
    for permittivity in (5.0, 6.0, 7.0):
        clock.now_s += SETTLED_S / 2
        images.keep(Wanted("another", 20, permittivity))
    assert len(node.of("focus")) == 2
    clock.now_s += SETTLED_S
    images.keep(Wanted("another", 20, 7.0))
    assert node.of("focus")[-1] == ("another", 7.0)


def test_too_few_traces_are_not_asked_about(images, node):
    images.keep(Wanted(SURVEY, FEWEST_TRACES - 1, 4.0))
    images.keep(Wanted("", 100, 4.0))
    assert node.asked == []


def test_a_failure_is_kept_until_there_is_an_image(images, node, clock):
    wanted = Wanted(SURVEY, 20, 4.0)
    images.keep(wanted)
    images.on_event(ImageFailed(SURVEY, verbatim("the analysis is not installed")))
    assert str(images.problem) == "the analysis is not installed"
    images.keep(wanted)
    assert len(node.of("focus")) == 1
    clock.now_s += PERIOD_S
    images.keep(wanted._replace(traces=21))
    focused(images, SURVEY)
    assert images.problem is None


def test_a_node_that_never_answers_is_asked_again(images, node, clock):
    images.keep(Wanted(SURVEY, 20, 4.0))
    clock.now_s += LOST_S
    images.keep(Wanted(SURVEY, 20, 4.0))
    assert len(node.of("focus")) == 2
