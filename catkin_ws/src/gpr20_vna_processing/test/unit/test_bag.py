"""The bag of a survey that has ended, by the stock tools of ROS: whole, or not there and named."""

from __future__ import annotations

import collections
import itertools
import random
import shutil
import subprocess
import sys
from dataclasses import replace

import mcap.writer
import pytest
from failing_disk import FailingDisk, Failure
from fault_kit import raises_fault
from log_examples import NOW, add_marker
from reopening_kit import TRACES, resume, traces_in_bag, tree
from run_seed import SEED, draws
from storage_kit import Kit, bag_messages, bag_traces, mcap_traces, text_message, with_bag
from trace_examples import SURVEY, assert_same_numbers
from wait_kit import wait_until

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.verdict import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.folder.recovery import add_to_survey
from gpr20_survey.recording.bag import write_bag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_vna_processing.low import bag_processes
from gpr20_vna_processing.low.bag_processes import BagProcesses, bag_bytes

FREE_BYTES = 10**12
LIMIT_S = 200.0  # far more than a process needs


@pytest.fixture
def folder(copies):
    """A finished survey without a bag."""
    return copies("finished")


@pytest.fixture
def bags():
    """Makes bags in processes on a disk that has this much free."""
    made = BagProcesses(lambda _: FREE_BYTES, disk_reserve_bytes=1)
    yield made
    made.stop(0.0)


def assert_complete_without_bag(folder):
    """Check that nothing of a bag is there, and that verify says so of a complete survey."""
    assert not any("survey.bag" in one.name for one in folder.iterdir())
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE, [])
    assert f"gpr20 export --format bag {folder}" in " ".join(map(str, found.notes))


def assert_complete_with_bag(folder):
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE, [])
    assert "bag" not in " ".join(map(str, found.notes))
    for trace, message in zip(TRACES, traces_in_bag(folder)):
        assert_same_numbers(trace, message)


def test_the_stock_tools_find_every_message_as_it_was_recorded(folder):
    rosbag = pytest.importorskip("rosbag")  # part of ROS
    path = with_bag(folder) / "survey.bag"
    recorded = list(StoredMcap(folder / "survey.mcap").messages())
    subprocess.run(["rosbag", "check", str(path)], capture_output=True, check=True)
    in_bag = bag_messages(path)
    assert sorted(in_bag, key=repr) == sorted(recorded, key=repr)
    with rosbag.Bag(str(path)) as bag:
        counts = {
            one: topic.message_count for one, topic in bag.get_type_and_topic_info()[1].items()
        }
        assert counts == collections.Counter(one.topic for one in recorded)
        assert collections.Counter(one for one, _, _ in bag.read_messages()) == counts
        latching = {one.topic: one.header["latching"] for one in bag._connections.values()}
    # So that a replay latches it.
    assert (latching["/survey_metadata"], latching["/trace"]) == (b"1", b"0")


@pytest.mark.parametrize("ending", ["cut off", "stopped", "interrupted"])
def test_a_survey_that_is_resumed_gets_a_new_bag_with_every_trace(copies, ending):
    folder = copies(ending)
    if ending != "cut off":
        with_bag(folder)
    kit = Kit(folder.parent)
    stored = kit.processing.reopen_survey(SURVEY).stored_indices
    assert not (folder / "survey.bag").exists()
    kit.finish(TRACES, stored)
    kit.processing.shut_down()
    assert_complete_without_bag(folder)
    with_bag(folder)
    assert_complete_with_bag(folder)
    for read, name in ((bag_traces, "survey.bag"), (mcap_traces, "survey.mcap")):
        assert sorted(one.index for one in read(folder / name)) == list(range(len(TRACES)))
    add_to_survey(folder, add_marker(3), NOW)
    assert_complete_with_bag(folder)


def test_a_bag_is_kept_beside_a_recording_that_was_damaged_after_the_end(copies):
    folder = with_bag(copies("stopped"))
    bag, path = (folder / "survey.bag").read_bytes(), folder / "survey.mcap"
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2] + b"#" + content[len(content) // 2 + 1 :])
    resume(folder)
    assert (folder / "damaged" / "survey.bag").read_bytes() == bag


def test_each_flip_of_a_bag_is_found(folder):
    path, chance = with_bag(folder) / "survey.bag", random.Random(SEED)
    content = path.read_bytes()
    for _ in range(draws(20)):
        place = chance.randrange(len(content))
        flipped = bytes([content[place] ^ 1 << chance.randrange(8)])
        path.write_bytes(content[:place] + flipped + content[place + 1 :])
        found = verify_survey(folder)
        assert found.status == DAMAGED and "survey.bag" in str(found.faults[0]), place
    assert main(["export", "--format", "bag", str(folder)]) == 0
    assert path.read_bytes() == content
    assert_complete_with_bag(folder)


@pytest.mark.parametrize("other", ["of another survey", "garbage"])
def test_a_bag_that_the_log_does_not_name_is_unconfirmed_until_it_is_made(folder, copies, other):
    content = b"garbage"
    if other != "garbage":
        content = (with_bag(copies("stopped")) / "survey.bag").read_bytes()
    (folder / "survey.bag").write_bytes(content)
    found = verify_survey(folder)
    assert (found.status, found.unconfirmed) == (INCOMPLETE, ("survey.bag",))
    assert "UNCONFIRMED" in str(found.verdict)
    assert main(["export", "--format", "bag", str(folder)]) == 0
    assert_complete_with_bag(folder)


def test_a_disk_that_refuses_or_loses_its_power_anywhere_leaves_no_half_bag(copies, tmp_path):
    seen = set()
    for calls in itertools.count():
        folder = copies("finished")
        after = tmp_path / f"after{calls}" / folder.name
        disk = FailingDisk(folder)
        try:
            disk.begin(Failure(calls, calls % 2 == 1), after)
            with_bag(folder)
            disk.end()
            done = not disk.has_failed
        except StorageFailedError:
            done = False
        finally:
            disk.release()
        left = after if after.exists() else folder
        found = verify_survey(left)
        # Of a bag whose entry was lost nothing is known.
        unconfirmed = ("survey.bag",) * (found.status == INCOMPLETE)
        assert (found.faults, found.unconfirmed) == ([], unconfirmed), calls
        seen.add(found.status)
        (left / ".survey.bag.0123abcd.tmp").write_bytes(b"#")  # of a maker that was killed
        with_bag(left)
        assert not list(left.glob(".survey.bag*"))
        assert_complete_with_bag(left)
        shutil.rmtree(str(folder.parent))
        if done:
            break
    assert calls > 5 and seen == {COMPLETE, INCOMPLETE}


@pytest.mark.parametrize("end", [-1, -100, 300, 0])
def test_no_bag_is_made_of_a_recording_that_is_damaged_or_cut(folder, end, capsys):
    path = folder / "survey.mcap"
    content = path.read_bytes()
    path.write_bytes(content[:end] + (b"#" + content[end + 1 :] if end == 300 else b""))
    before = tree(folder)
    assert main(["export", "--format", "bag", str(folder)]) == 3
    said = capsys.readouterr().err
    assert "survey.mcap" in said and "First: Resume the survey" in said
    assert tree(folder) == before


def test_no_bag_is_made_of_a_recording_that_another_another_one_has_replaced(folder, monkeypatch):
    from gpr20_survey.recording import bag

    real = bag.write_bag

    def write(messages, path):
        real(messages, path)
        shutil.copy(str(folder / "survey.mcap"), str(folder / ".copy.tmp"))
        (folder / ".copy.tmp").replace(folder / "survey.mcap")

    monkeypatch.setattr(bag, "write_bag", write)
    with raises_fault("survey.locked", error=SurveyRefusedError):
        with_bag(folder)
    assert_complete_without_bag(folder)


def test_the_storage_makes_the_bag_beside_the_next_survey(tmp_path, bags):
    kit = Kit(tmp_path / "data", bags=bags)
    folder = kit.open()
    kit.processing.store(TRACES[0])
    kit.processing.close_survey(SURVEY, "stopped")
    wait_until((folder / "survey.bag").exists)
    wait_until(lambda: bags.outstanding_bytes() == 0)
    assert len(list(bag_traces(folder / "survey.bag"))) == 1
    # A survey that is shut down is interrupted, and has a bag when the node has ended.
    kit.processing.reopen_survey(SURVEY)
    assert not (folder / "survey.bag").exists()
    kit.processing.shut_down()
    bags.stop(LIMIT_S)
    assert (folder / "survey.bag").exists() and bags.problem() is None


@pytest.mark.parametrize("is_noise", [True, False])
@pytest.mark.parametrize("length", [0, 4000, 100_000])
@pytest.mark.parametrize("topics", [1, 300])
def test_a_bag_takes_no_more_space_than_is_counted_and_not_much_less(
    tmp_path, is_noise, length, topics
):
    chance, count = random.Random(SEED), 400
    recording = McapFile(tmp_path / "survey.mcap")
    for number in range(count):
        noise = chance.getrandbits(8 * length + 1) >> 1 if is_noise else 0
        message = text_message(f"/{number % topics}", "")
        message = replace(message, data=noise.to_bytes(length, "big"), definition="#" * 4000)
        recording.write_alone(message) if number % 3 else recording.write(message)
    recording.commit()
    torn = bag_bytes(tmp_path)
    recording.finish()
    write_bag(StoredMcap(tmp_path / "survey.mcap").messages(), tmp_path / "survey.bag")
    size = (tmp_path / "survey.bag").stat().st_size
    assert size <= torn <= bag_bytes(tmp_path) < 1.01 * count * (length + 500) + (5 << 20)


NEVER = (sys.executable, "-c", "import signal; signal.pause()")


def test_a_survey_starts_only_if_there_is_space_for_the_bags_that_are_not_made_yet(
    folder, bags, monkeypatch, tmp_path
):
    monkeypatch.setattr(bag_processes, "PROGRAM", NEVER)
    bags.make(folder)
    outstanding = bags.outstanding_bytes()
    assert outstanding == bag_bytes(folder) > 0
    kit = Kit(tmp_path / "new", bags=bags, free_bytes=500_001_000 + outstanding)
    with raises_fault("disk.full", error=SurveyRefusedError):
        kit.open(needed_bytes=1001)
    other = kit.open(needed_bytes=1000)
    kit.processing.shut_down()
    # One that cannot be resumed gets its bag, a survey that is resumed none.
    with raises_fault("survey.complete", error=SurveyRefusedError):
        Kit(folder.parent, bags=bags).processing.reopen_survey(SURVEY)
    assert bags.outstanding_bytes() > outstanding
    for one in (folder, other):
        bags.cancel(one)
    assert bags.outstanding_bytes() == 0 and bags.problem() is None


ENDED = (sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGKILL)")


@pytest.mark.parametrize("case", ["killed", "no recording", "no space"])
def test_a_bag_that_could_not_be_made_is_named_with_the_command_until_it_is_there(
    folder, bags, monkeypatch, case
):
    if case == "killed":
        monkeypatch.setattr(bag_processes, "PROGRAM", ENDED)
    elif case == "no space":
        monkeypatch.setattr(bags, "_free_bytes", lambda _: 100)
    else:
        (folder / "survey.mcap").rename(folder.parent / "away")
    bags.make(folder)
    wait_until(lambda: bags.problem() is not None)
    problem = bags.problem()
    assert f"gpr20 export --format bag {folder}" in str(problem)
    code = {"killed": "storage.bag_missing", "no space": "disk.full"}
    assert problem.fault_code == code.get(case, "storage.folder_moved")
    if case == "no recording":
        (folder.parent / "away").rename(folder / "survey.mcap")
    assert_complete_without_bag(folder)
    assert main(["export", "--format", "bag", str(folder)]) == 0
    assert bags.problem() is None
    assert_complete_with_bag(folder)


def test_a_bag_is_exported_of_a_survey_that_was_cut_off(copies, tmp_path, capsys):
    folder, path = copies("cut off"), tmp_path / "it.bag"
    before = tree(folder)
    assert main(["export", "--format", "bag", str(folder), str(path)]) == 1
    assert "cut off" in capsys.readouterr().err and tree(folder) == before
    assert sorted(one.index for one in bag_traces(path)) == list(range(6))
    assert main(["export", "--format", "csv", str(folder)]) == 3
    with (tmp_path / "other.mcap").open("wb") as stream:
        other = mcap.writer.Writer(stream)
        other.start("ros1", "of another program")
        other.finish()
    assert main(["export", "--format", "bag", str(tmp_path / "other.mcap"), str(path)]) == 3
