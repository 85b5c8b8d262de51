import pytest
from finger import place_of
from PyQt5.QtWidgets import QLabel
from view_kit import snapshot
from window_helpers import click, enter, hold, show

from gpr20_operator import faults
from gpr20_survey.plan.survey_state import SurveyState


@pytest.fixture(autouse=True)
def idle(window):
    show(window, snapshot(SurveyState.IDLE))


def save(window, name):
    click(window.control.saved)
    click(window.profiles.save)
    for character in name:
        window.profiles.pad.press(character)
    click(window.profiles.pad.accept_button)


def names(window):
    return [window.profiles.names.item(row).text() for row in range(window.profiles.names.count())]


def test_fields_are_saved_and_loaded_with_fingers_alone(window):
    enter(window, "x_points", "9")
    save(window, "field-1")
    assert names(window) == ["field-1"]
    enter(window, "x_points", "4")
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.load)
    assert not window.profiles.isVisible()
    assert window.control.parameters.x_points == 9


def test_a_taken_or_forbidden_name_cannot_be_accepted(window):
    save(window, "a")
    click(window.profiles.save)
    assert not window.profiles.pad.accept_button.isEnabled()
    window.profiles.pad.press("a")
    assert not window.profiles.pad.accept_button.isEnabled()
    window.profiles.pad.press("b")
    assert window.profiles.pad.accept_button.isEnabled()


def test_the_empty_name_is_not_red_before_typing(window):
    click(window.control.saved)
    click(window.profiles.save)
    pad = window.profiles.pad
    assert pad.hint.property("level") != "wrong"
    assert pad.hint.text() == "at most 32 characters"
    assert not pad.accept_button.isEnabled()
    pad.press("-")
    assert pad.hint.property("level") == "wrong"


def test_a_name_that_is_refused_says_what_is_allowed(window):
    click(window.control.saved)
    click(window.profiles.save)
    pad = window.profiles.pad
    for name in ("a ", "-a", "a" * 33):
        pad.edit.setPlainText(name)
        assert not pad.accept_button.isEnabled()
        assert "1 to 32 of a to z, 0 to 9, - and _, inside also spaces" in pad.hint.text()


def test_deleting_is_asked_elsewhere_and_takes_a_hold(window):
    save(window, "a")
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.delete)
    confirm = window.profiles.confirm
    assert confirm.isVisible()
    assert "a" in [label.text() for label in confirm.findChildren(QLabel)]
    places = [place_of(window, button) for button in (confirm.hold, window.profiles.delete)]
    assert not places[0].intersects(places[1])
    hold(confirm.hold, 0.9)
    click(confirm.hold)
    assert names(window) == ["a"]
    hold(confirm.hold)
    assert names(window) == []
    assert not confirm.isVisible() and window.profiles.isVisible()


def test_a_profile_that_is_not_deleted_after_all_stays(window):
    save(window, "a")
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.delete)
    click(window.profiles.confirm.cancel)
    assert names(window) == ["a"]


def test_wrong_fields_cannot_be_saved(window):
    enter(window, "x_points", "1")
    click(window.control.saved)
    assert not window.profiles.save.isEnabled()


def test_damaged_profile_opens_a_dialog(window, tmp_path):
    (tmp_path / "a.yaml").write_text("[")
    click(window.control.saved)
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.load)
    assert window.notice.isVisible()
    assert faults.PROFILE_UNREADABLE.code in window.notice.details.toPlainText()
    assert window.notice.title.text() == "The profile cannot be used."


def test_profiles_that_are_open_when_a_survey_begins_elsewhere_are_closed_and_locked(window):
    click(window.control.saved)
    click(window.profiles.save)
    show(window, snapshot(SurveyState.CHECKING))
    assert not window.profiles.isVisible() and not window.profiles.pad.isVisible()
    assert not window.control.saved.isEnabled()
