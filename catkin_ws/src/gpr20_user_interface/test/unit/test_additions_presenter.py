import pytest
from asked_storage import Storage
from map_kit import DOUBTED, FINER, MARKER, SURE, focused
from view_kit import SURVEY

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import (
    RETRY_REFRESHES,
    AdditionsFailed,
    AdditionsPresenter,
    AdditionsRead,
    MarkersStored,
    RelatedSurvey,
)
from gpr20_operator.ground.geometry import Area
from gpr20_operator.jobs.pictures import MOST_IMAGES

RELATED = RelatedSurvey(FINER, "20261121T061000_7c9e6679", True, Area(1.0, 2.0, 3.0, 4.0))


@pytest.fixture
def storage():
    return Storage()


@pytest.fixture
def additions(storage):
    additions = AdditionsPresenter(storage, lambda: "Ana")
    additions.follow(SURVEY, can_read=True)
    return additions


def test_what_belongs_to_a_survey_is_asked_for_once_and_shown(storage, additions):
    additions.follow(SURVEY, can_read=True)
    assert storage.asked == [("additions", SURVEY)]
    additions.on_event(AdditionsRead(SURVEY, (MARKER,), (RELATED,)))
    assert (additions.markers, additions.related) == ((MARKER,), (RELATED,))


def test_nothing_of_another_survey_is_shown(additions):
    additions.on_event(AdditionsRead(FINER, (MARKER,), (RELATED,)))
    additions.on_event(MarkersStored(FINER, (MARKER,)))
    additions.pictures.add_image(focused(survey_id=FINER))
    assert (additions.markers, additions.related, additions.candidates) == ((), (), ())
    additions.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    additions.follow(FINER, can_read=True)
    assert additions.markers == ()
    assert additions.candidates == (SURE, DOUBTED)


def test_a_replay_has_no_storage_to_ask(storage):
    additions = AdditionsPresenter(storage, str)
    additions.follow(SURVEY, can_read=False)
    assert storage.asked == []
    assert not additions.can_mark


def test_a_failure_is_followed_by_another_request_later(storage, additions):
    additions.on_event(AdditionsFailed(SURVEY, verbatim("no")))
    for _ in range(RETRY_REFRESHES - 1):
        additions.refresh()
    assert len(storage.asked) == 1
    additions.refresh()
    assert storage.asked == 2 * [("additions", SURVEY)]


def test_a_marker_is_shown_when_the_storage_has_it(storage, additions):
    additions.add_marker(SURVEY, 1.0, 2.0, None, "metal")
    _kind, survey, marker = storage.asked[-1]
    assert (survey, marker.text, marker.author, marker.depth_mm) == (SURVEY, "metal", "Ana", None)
    assert additions.markers == ()
    additions.on_event(MarkersStored(SURVEY, (marker,)))
    assert additions.markers == (marker,)
    additions.remove_marker(marker.marker_id)
    assert storage.asked[-1] == ("remove marker", SURVEY, marker.marker_id, "Ana")


def test_a_marker_that_is_not_allowed_is_not_sent(storage, additions):
    with pytest.raises(InvalidValueError):
        additions.add_marker(SURVEY, 1.0, 2.0, None, "a\nb")
    assert len(storage.asked) == 1


def test_images_of_finer_surveys_are_kept_but_not_without_end(additions):
    additions.on_event(AdditionsRead(SURVEY, (), (RELATED,)))
    additions.pictures.add_image(focused())
    additions.pictures.add_image(focused(survey_id=FINER))
    assert [one.survey_id for one in additions.finer_images] == [FINER]
    for number in range(2 * MOST_IMAGES):
        assert additions.image is not None  # it is looked at
        additions.pictures.add_image(focused(survey_id=str(number)))
    assert additions.candidates == (SURE, DOUBTED)
    assert additions.finer_images == ()


def test_a_finer_survey_is_focused_once_and_laid_over_the_coarse_one(storage):
    asked = []
    additions = AdditionsPresenter(storage, str, None, lambda *wanted: asked.append(wanted))
    additions.follow(SURVEY, can_read=True)
    additions.on_event(AdditionsRead(SURVEY, (), (RELATED,)))
    additions.focus_finer()
    assert additions.laid_image is None
    coarse = focused()
    additions.pictures.add_image(coarse)
    assert additions.laid_image is coarse
    for _ in range(3):
        additions.focus_finer()
    assert asked == [(FINER, coarse.found.permittivity)]
    fine = focused(survey_id=FINER)
    fine.levels_db[:] = 20.0
    additions.pictures.add_image(fine)
    laid = additions.laid_image
    assert laid.survey_id == SURVEY
    assert laid.levels_db.max() == 20.0
    assert additions.laid_image is laid
