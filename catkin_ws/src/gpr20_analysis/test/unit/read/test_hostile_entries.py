"""Whatever lies in a survey's folder, a command ends soon, follows no link and changes nothing."""

import os
import random
import shutil
import signal
import socket
import stat
import traceback
from pathlib import Path

import pytest
from run_seed import draws
from storage_kit import with_bag
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands import main
from gpr20_analysis.read.sources import open_source
from gpr20_survey.errors import IrregularFileError

LIMIT_S = 60
"""Far more than any needs; without the checks a pipe takes for ever, 40 GB for minutes."""
SPARSE_BYTES = 40 << 30
UNSEALED = "finished, without a manifest"
FILES = (
    *("survey.json", "survey.bag", "survey.mcap", "manifest.json", "log.jsonl", "traces"),
    *("log.copy.jsonl", "one trace", "damaged/old.json", "notes.txt"),
)
COMMANDS = (
    *(["verify"], ["verify", "--repair"], ["info"], ["info", "--accept-damaged"]),
    *(["annotate"], ["replay"]),
)


def put_socket(path, *_):
    # The name of a socket is short.
    here = os.open(str(path.parent), os.O_RDONLY)
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(f"/proc/self/fd/{here}/{path.name}")
    os.close(here)


def put_folder(path, *_):
    path.mkdir()
    (path / "inside.json").write_text("{}")


def put_link_to_copy(path, content, elsewhere):
    (elsewhere / "copy").write_bytes(content)
    path.symlink_to(elsewhere / "copy")


def put_hole(path, content, *_):
    path.write_bytes(content)
    os.truncate(str(path), SPARSE_BYTES)


KINDS = {
    "pipe": lambda path, *_: os.mkfifo(str(path)),
    "socket": put_socket,
    "folder": put_folder,
    "link to zeros": lambda path, *_: path.symlink_to("/dev/zero"),
    "link to itself": lambda path, *_: path.symlink_to(path),
    "link to nothing": lambda path, _, elsewhere: path.symlink_to(elsewhere / "nothing"),
    "link to copy": put_link_to_copy,
    "hole behind content": put_hole,
}
KNOWN = [
    *(
        (outcome, name, kind, command)
        for outcome, command in (("finished", ["verify"]), (UNSEALED, ["verify", "--repair"]))
        for name in ("survey.bag", "survey.mcap")
        for kind in ("pipe", "link to zeros", "hole behind content")
    ),
    ("finished", "survey.mcap", "pipe", ["replay"]),
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
        if outcome is not None:
            with_bag(made[outcome])
    place = tmp_path_factory.mktemp("survey") / made["finished"].name
    made[UNSEALED] = Path(shutil.copytree(str(made["finished"]), str(place)))
    (place / "manifest.json").unlink()
    return made


def cases():
    draw = random.Random(27)
    outcomes = ("finished", "interrupted", None, UNSEALED)
    drawn = [[draw.choice(one) for one in (outcomes, FILES, list(KINDS), COMMANDS)]
             for _ in range(draws(6))]  # fmt: skip
    return [*KNOWN, *drawn]


def spoil(folder, name, kind, elsewhere):
    path = next((folder / "traces").glob("000004_*")) if name == "one trace" else folder / name
    content = path.read_bytes() if path.is_file() else b""
    if path.is_dir():
        shutil.rmtree(str(path))
    path.parent.mkdir(exist_ok=True)
    if path.exists():
        path.unlink()
    KINDS[kind](path, content, elsewhere)


def test_a_command_ends_soon_and_believes_nothing_irregular(surveys, tmp_path):
    broken = []
    for number, (outcome, name, kind, command) in enumerate(cases()):
        case = f"{kind} as {name} in {outcome}, {' '.join(command)}"
        folder, elsewhere = tmp_path / f"{number}" / surveys[outcome].name, tmp_path / f"e{number}"
        elsewhere.mkdir()
        shutil.copytree(str(surveys[outcome]), str(folder))
        spoil(folder, name, kind, elsewhere)
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
        may_write = "--repair" in command and (outcome == UNSEALED or name == "manifest.json")
        if not may_write and (snapshot(folder), snapshot(elsewhere)) != before:
            broken.append(f"{case}: something was changed")
        if (outcome, name, kind, command) in KNOWN and status not in (2, 3):
            broken.append(f"{case}: status {status}")
        shutil.rmtree(str(tmp_path / f"{number}"))
    assert not broken, "\n".join(broken)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
def test_a_recording_that_is_named_may_be_a_link_but_no_pipe(surveys, tmp_path, name):
    link, pipe = tmp_path / name, tmp_path / f"pipe-{name}"
    link.symlink_to(surveys["finished"] / name)
    assert len(list(open_source(link).traces())) == len(POINTS)
    os.mkfifo(str(pipe))
    with pytest.raises(IrregularFileError):
        open_source(pipe)
