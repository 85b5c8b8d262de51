import pytest
from window_helpers import application, click, enter, snapshot, window

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.low.profile_folder import ProfileFolder
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.profiles_presenter import ProfilesPresenter

__all__ = ["application", "window"]


@pytest.fixture
def presenter(window, tmp_path):
    window.refresh(snapshot(SurveyState.IDLE))
    return ProfilesPresenter(window, Profiles(ProfileFolder(tmp_path)))


def save(window, name):
    click(window.control.profiles)
    click(window.profiles.save)
    for character in name:
        window.name_pad.press(character)
    click(window.name_pad.accept_button)


def names(window):
    return [window.profiles.names.item(row).text() for row in range(window.profiles.names.count())]


def test_fields_are_saved_and_loaded_with_fingers_alone(window, presenter):
    enter(window, "x_points", "9")
    save(window, "field-1")
    assert names(window) == ["field-1"]
    enter(window, "x_points", "4")
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.load)
    assert not window.profiles.isVisible()
    assert window.control.parameters.x_points == 9


def test_a_taken_or_forbidden_name_cannot_be_accepted(window, presenter):
    save(window, "a")
    click(window.profiles.save)
    assert not window.name_pad.accept_button.isEnabled()
    window.name_pad.press("a")
    assert not window.name_pad.accept_button.isEnabled()
    window.name_pad.press("b")
    assert window.name_pad.accept_button.isEnabled()


@pytest.mark.parametrize("name", ["a ", "-a", "a" * 33])
def test_a_name_that_is_refused_says_what_is_allowed(window, presenter, name):
    click(window.control.profiles)
    click(window.profiles.save)
    window.name_pad.edit.setText(name)
    assert not window.name_pad.accept_button.isEnabled()
    hint = window.name_pad.hint.text()
    assert all(words in hint for words in ("at most 32", "first a letter", "no blank last"))


def test_deleting_takes_two_touches(window, presenter):
    save(window, "a")
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.delete)
    assert names(window) == ["a"]
    assert window.profiles.delete.text() == "SURE?"
    click(window.profiles.delete)
    assert names(window) == []


def test_wrong_fields_cannot_be_saved(window, presenter):
    enter(window, "x_points", "1")
    click(window.control.profiles)
    assert not window.profiles.save.isEnabled()


def test_damaged_profile_opens_a_dialog(window, presenter, tmp_path):
    (tmp_path / "a.yaml").write_text("[")
    click(window.control.profiles)
    window.profiles.names.setCurrentRow(0)
    click(window.profiles.load)
    assert window.notice.isVisible()
    assert "cannot be read" in window.notice.reason.toPlainText()
    assert window.notice.title.text() == "The profile cannot be used."


def test_profiles_are_locked_while_a_survey_runs(window, presenter):
    window.refresh(snapshot(SurveyState.SURVEYING))
    assert not window.control.profiles.isEnabled()


@pytest.mark.parametrize("asks_name", [False, True])
def test_profiles_that_are_open_when_a_survey_begins_elsewhere_are_closed(
    window, presenter, asks_name
):
    click(window.control.profiles)
    if asks_name:
        click(window.profiles.save)
    window.refresh(snapshot(SurveyState.CHECKING))
    assert not window.profiles.isVisible() and not window.name_pad.isVisible()
