"""What somebody else put into a survey's folder: nothing hangs, fills memory or leads outside.

What is not a survey's file keeps no survey from going on or ending, and is named.
"""

import os
import shutil

import pytest
from fault_kit import raises_fault
from log_examples import marker
from reopening_kit import TRACES, trace_file, tree
from storage_kit import with_bag
from trace_examples import SURVEY

from gpr20_analysis.read.checks import is_sealed, manifest_differences
from gpr20_survey.errors import ProcessingError, StorageFailedError, SurveyRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder.recovery import recover
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys

FOREIGN = "somebody else's"


@pytest.fixture
def folder(copies):
    """A survey that was stopped."""
    return with_bag(copies("stopped"))


@pytest.fixture
def data(folder):
    return folder.parent


def path_of(folder, part):
    return trace_file(folder, 1) if part == "trace" else folder / part


def go_on_and_close(kit):
    """Reopen the survey, finish it, and return what was repaired."""
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == tuple(range(6))
    kit.finish(TRACES, reopened.stored_indices)
    return [(one.values.get("file"), one.fault_code) for one in reopened.repairs]


def refusal_of(action):
    """Return what an action refuses with, or None; one that hangs is ended with the test."""
    try:
        action()
    except ProcessingError as error:
        return error
    return None


def put_folder(path):
    path.mkdir()
    (path / "inside").write_text(FOREIGN)


def put_link(path):
    path.symlink_to("/nowhere")


def put_pipe(path):
    os.mkfifo(str(path))


def put_file(path):
    path.write_text(FOREIGN)


def differences(folder):
    recovered = recover(folder, asking_manifest=True)
    assert is_sealed(recovered)
    return manifest_differences(folder, recovered)


@pytest.mark.parametrize(
    "part", ["survey.json", "log.jsonl", "log.copy.jsonl", "traces", "survey.bag", "damaged"]
)
def test_a_survey_part_of_which_lies_elsewhere_is_not_gone_on_with(kit, folder, tmp_path, part):
    outside = tmp_path / "outside"
    if part == "damaged":
        outside.mkdir()
    else:
        (folder / part).rename(outside)
    (folder / part).symlink_to(outside)
    # These would be cleared away or moved, were the link followed.
    if outside.is_dir():
        (outside / ".torn.json.0123abcd.tmp").write_text(FOREIGN)
        (outside / "000001_wrong.json").write_text(FOREIGN)
    before = tree(tmp_path)
    with raises_fault("file.damaged", part, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    "part", ["survey.json", "log.jsonl", "log.copy.jsonl", "survey.mcap", "survey.bag", "trace"]
)
def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(kit, folder, part):
    path = path_of(folder, part)
    path.unlink()
    put_pipe(path)
    assert refusal_of(lambda: StoredSurveys(folder.parent).traces(SURVEY, range(3))) is None
    assert refusal_of(lambda: kit.add_marker(SURVEY, marker(3))) is None
    refused = refusal_of(lambda: kit.processing.reopen_survey(SURVEY))
    if part == "survey.mcap":
        assert refused.message.fault_code == "file.damaged"
    else:
        assert refused is None  # another file holds the same
        assert path.is_file() or part == "survey.bag"  # made when the survey ends
    assert refusal_of(lambda: StoredSurveys(folder.parent).list("", 10)) is None


@pytest.mark.parametrize("put", [put_folder, put_link, put_pipe])
def test_what_is_named_like_a_trace_file_is_put_aside_and_the_survey_ends(kit, folder, put):
    trace, more = trace_file(folder, 1), "000009_X0001.00_Y0001.00_Z+000.00.json"
    trace.unlink()
    put(trace)
    put(folder / "traces" / more)
    assert (trace.name, "survey.damaged") in go_on_and_close(kit)
    aside = sorted(one.name for one in (folder / "damaged").iterdir())
    assert aside == [trace.name, more]
    assert len(list((folder / "traces").iterdir())) == len(TRACES)
    assert not differences(folder)


def test_another_users_file_of_which_no_second_name_may_be_made_is_moved(folder, monkeypatch):
    def refuse(*_names, **_options):
        raise PermissionError(1, "Operation not permitted")

    torn = trace_file(folder, 1)
    torn.write_bytes(b"")
    monkeypatch.setattr(os, "link", refuse)
    target = durable_files.move_aside(torn, folder / "damaged")
    assert target.read_bytes() == b"" and not torn.exists()


def test_foreign_things_that_are_no_obstacle_are_left_alone_or_told(kit, folder):
    never_finished = [folder / place / ".survey.json.0123abcd.tmp" for place in (".", "traces")]
    for path in never_finished:
        put_folder(path)
    with open(os.fsencode(str(folder / "traces")) + b"/\xff\xfe.json", "wb") as stream:
        stream.write(b"x")
    put_link(folder / "link.txt")
    put_pipe(folder / "pipe.txt")
    assert (r"\xff\xfe.json", "survey.damaged") in go_on_and_close(kit)
    assert all((path / "inside").is_file() for path in never_finished)
    assert sorted(one.values["file"] for one in differences(folder)) == [
        "link.txt",
        "pipe.txt",
    ]


@pytest.mark.parametrize(
    ("part", "put", "code"),
    [
        ("survey.bag", put_folder, "file.damaged"),
        ("traces", put_file, "storage.file_exists"),
        ("damaged", put_file, "storage.file_exists"),
    ],
)
def test_what_is_in_the_way_is_named(kit, folder, part, put, code):
    trace_file(folder, 1).write_bytes(b"")
    if (folder / part).is_dir():
        shutil.rmtree(str(folder / part))
    elif part != "damaged":
        (folder / part).unlink()
    put(folder / part)
    with raises_fault(code, part, error=StorageFailedError):
        kit.processing.reopen_survey(SURVEY)
