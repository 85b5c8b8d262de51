"""Whatever lies in a survey's folder, a command ends soon, follows no link and changes nothing."""

from __future__ import annotations

import os
import random
import shutil
import signal
import socket
import stat
import traceback
from pathlib import Path

import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands import main
from gpr20_analysis.read.recordings import open_recording
from gpr20_survey.errors import IrregularFileError
from gpr20_survey.files import file_sums

LIMIT_S = 60
"""Far more than any needs; without the checks a pipe takes for ever, 40 GB for minutes."""
SPARSE_BYTES = 40 << 30
DRAWS = 24
UNSEALED = "finished, without a manifest"
FILES = (
    *("survey.json", "survey.bag", "survey.mcap", "manifest.json", "log.jsonl", "traces"),
    *("one trace", "damaged/old.json", "notes.txt"),
)
COMMANDS = (
    ["verify"],
    ["verify", "--json"],
    ["repair"],
    ["info"],
    ["info", "--accept-damaged"],
    ["markers"],
    ["annotate"],
    ["replay"],
)


def put_pipe(path, _content, _elsewhere):
    os.mkfifo(str(path))


def put_socket(path, _content, _elsewhere):
    # The name of a socket is short.
    here = os.open(str(path.parent), os.O_RDONLY)
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(f"/proc/self/fd/{here}/{path.name}")
    finally:
        os.close(here)


def put_folder(path, _content, _elsewhere):
    path.mkdir()
    (path / "inside.json").write_text("{}")


def put_link_to_zeros(path, _content, _elsewhere):
    path.symlink_to("/dev/zero")


def put_link_to_pipe(path, _content, elsewhere):
    os.mkfifo(str(elsewhere / "pipe"))
    path.symlink_to(elsewhere / "pipe")


def put_link_to_itself(path, _content, _elsewhere):
    path.symlink_to(path)


def put_link_to_nothing(path, _content, elsewhere):
    path.symlink_to(elsewhere / "nothing")


def put_link_to_copy(path, content, elsewhere):
    (elsewhere / "copy").write_bytes(content)
    path.symlink_to(elsewhere / "copy")


def put_hole(path, _content, _elsewhere):
    path.touch()
    os.truncate(str(path), SPARSE_BYTES)


def put_hole_behind_content(path, content, _elsewhere):
    path.write_bytes(content)
    os.truncate(str(path), SPARSE_BYTES)


def put_hole_before_content(path, content, _elsewhere):
    with path.open("wb") as stream:
        stream.seek(SPARSE_BYTES)
        stream.write(content or b"x")


KINDS = [
    put_pipe, put_socket, put_folder, put_link_to_zeros, put_link_to_pipe, put_link_to_itself,
    put_link_to_nothing, put_link_to_copy, put_hole, put_hole_behind_content,
    put_hole_before_content,
]  # fmt: skip


KNOWN = [
    *(
        (outcome, name, put, command)
        for outcome, command in (("finished", ["verify"]), (UNSEALED, ["repair"]))
        for name in ("survey.bag", "survey.mcap")
        for put in (put_pipe, put_link_to_zeros, put_hole_behind_content)
    ),
    ("finished", "survey.mcap", put_pipe, ["replay"]),
]
"""What has hung."""


def run_limited(arguments):
    """Return the exit status of a command, or None if it was ended at its limit."""
    child = os.fork()
    if child == 0:
        status = 70
        try:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(LIMIT_S)
            status = main.main(arguments)
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    _, state = os.waitpid(child, 0)
    return os.WEXITSTATUS(state) if os.WIFEXITED(state) else None


def snapshot(folder):
    """Return all that is below a folder, without opening what is no small file."""
    found = {}
    for parent, folders, names in os.walk(str(folder)):
        for name in [*folders, *names]:
            path = os.path.join(parent, name)
            status = os.lstat(path)
            content = None
            if stat.S_ISREG(status.st_mode) and status.st_size < 1 << 20:
                with open(path, "rb") as stream:
                    content = stream.read()
            elif stat.S_ISLNK(status.st_mode):
                content = os.readlink(path)
            found[path] = (status.st_mode, status.st_size, content)
    return found


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    made = {}
    for outcome, stored in (("finished", len(POINTS)), ("interrupted", 9), (None, 9)):
        made[outcome] = make_survey(tmp_path_factory.mktemp("survey"), stored, outcome)
    place = tmp_path_factory.mktemp("survey") / made["finished"].name
    made[UNSEALED] = Path(shutil.copytree(str(made["finished"]), str(place)))
    (place / "manifest.json").unlink()
    return made


def cases():
    draw = random.Random(27)
    outcomes = ("finished", "interrupted", None, UNSEALED)
    drawn = [[draw.choice(one) for one in (outcomes, FILES, KINDS, COMMANDS)] for _ in range(DRAWS)]
    return [*KNOWN, *drawn]


def spoil(folder, name, put, elsewhere):
    path = next((folder / "traces").glob("000004_*")) if name == "one trace" else folder / name
    content = path.read_bytes() if path.is_file() else b""
    if path.is_dir():
        shutil.rmtree(str(path))
    path.parent.mkdir(exist_ok=True)
    if path.exists():
        path.unlink()
    put(path, content, elsewhere)
    return path


def test_a_command_ends_soon_and_believes_nothing_irregular(surveys, tmp_path):
    broken = []
    for number, (outcome, name, put, command) in enumerate(cases()):
        case = f"{put.__name__} as {name} in {outcome}, {' '.join(command)}"
        folder, elsewhere = tmp_path / f"{number}" / surveys[outcome].name, tmp_path / f"e{number}"
        elsewhere.mkdir()
        shutil.copytree(str(surveys[outcome]), str(folder))
        spoil(folder, name, put, elsewhere)
        before = snapshot(folder), snapshot(elsewhere)
        status = run_limited([*command, str(folder)])
        if status is None:
            broken.append(f"{case}: not finished after {LIMIT_S} s")
            continue
        if command[0] == "verify" and status not in (1, 2, 3):
            broken.append(f"{case}: status {status}")
        if command[0] == "verify" and outcome == "finished" and status == 1:
            broken.append(f"{case}: only incomplete")
        # What repair writes is the manifest; what lay there instead is then in damaged/.
        may_write = command[0] == "repair" and (outcome == UNSEALED or name == "manifest.json")
        if not may_write and (snapshot(folder), snapshot(elsewhere)) != before:
            broken.append(f"{case}: something was changed")
        if (outcome, name, put, command) in KNOWN and status not in (2, 3):
            broken.append(f"{case}: status {status}")
        shutil.rmtree(str(tmp_path / f"{number}"))
    assert not broken, "\n".join(broken)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
@pytest.mark.parametrize("outcome", ["finished", None])
def test_a_recording_that_is_named_may_be_a_link_but_no_pipe(surveys, tmp_path, name, outcome):
    link, pipe = tmp_path / name, tmp_path / f"pipe-{name}"
    link.symlink_to(surveys[outcome] / name)
    assert len(list(open_recording(link).traces)) in (9, len(POINTS))
    os.mkfifo(str(pipe))
    with pytest.raises(IrregularFileError):
        open_recording(pipe)


def test_a_file_of_another_length_is_not_read(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"abc")
    assert file_sums.sum_of_sized_file(path, [2, 4]) is None
    assert file_sums.sum_of_sized_file(path, [3]) == file_sums.sum_of(b"abc")


def test_a_hole_of_the_size_that_a_power_cut_may_leave_is_read(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"abc")
    os.truncate(str(path), 64 << 20)
    assert file_sums.sum_of_file(path).size == 64 << 20
    os.truncate(str(path), (64 << 20) + (1 << 21))
    with pytest.raises(IrregularFileError):
        file_sums.sum_of_file(path)
