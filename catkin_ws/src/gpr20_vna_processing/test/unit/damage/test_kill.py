from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

rosbag = pytest.importorskip("rosbag")  # part of ROS; all else here runs without it

from storage_kit import Kit  # noqa: E402
from test_mcap_file import read_forward, traces_of  # noqa: E402
from trace_examples import SURVEY, assert_same_numbers, make_trace, read_json  # noqa: E402

from gpr20_survey.recording.recordings import open_recordings  # noqa: E402

pytestmark = pytest.mark.real_time

HERE = Path(__file__).resolve().parents[1]
REINDEX = "import rosbag; rosbag.rosbagmain(['rosbag', 'reindex', '--quiet', {!r}])"


def store_until_killed(data, after):
    """Kill a process in the middle of its stores; return its folder and its last answer."""
    child = subprocess.Popen(
        [sys.executable, str(HERE / "storing_child.py"), str(data)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), *sys.path])},
    )
    folder = Path(child.stdout.readline().strip())
    for line in child.stdout:
        if int(line) >= after:
            break
    child.kill()
    answered = [int(line) for line in child.communicate()[0].split()]
    return folder, answered[-1] if answered else after


@pytest.mark.parametrize("after", [0, 12])
def test_a_killed_storage_loses_no_acknowledged_trace(tmp_path, after):
    folder, last = store_until_killed(tmp_path, after)
    acknowledged = [make_trace(index) for index in range(last + 1)]

    files = sorted((folder / "traces").glob("*.json"))
    assert len(files) in (last + 1, last + 2)
    for trace, path in zip(acknowledged, files):
        assert_same_numbers(trace, read_json(path))

    in_mcap = traces_of(read_forward((folder / "survey.mcap").read_bytes()))
    assert len(in_mcap) in (last + 1, last + 2)
    for trace, message in zip(acknowledged, in_mcap):
        assert_same_numbers(trace, message)

    path = str(folder / "survey.bag")
    subprocess.run([sys.executable, "-c", REINDEX.format(path)], check=True, timeout=60)
    with rosbag.Bag(path) as bag:
        in_bag = [message for _, message, _ in bag.read_messages(topics=["/trace"])]
    assert len(in_bag) in (last + 1, last + 2)
    for trace, message in zip(acknowledged, in_bag):
        assert_same_numbers(trace, message)


def test_a_survey_goes_on_after_its_storage_was_killed(tmp_path):
    folder, last = store_until_killed(tmp_path, 5)
    survey = read_json(folder / "survey.json")
    assert (survey["ended"], survey["outcome"]) == (None, None)
    kit = Kit(tmp_path, open_recordings)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices in (tuple(range(last + 1)), tuple(range(last + 2)))
    count = last + 6
    for index in range(len(reopened.stored_indices), count):
        kit.processing.store(make_trace(index))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    with rosbag.Bag(str(folder / "survey.bag")) as bag:
        in_bag = [message for _, message, _ in bag.read_messages(topics=["/trace"])]
    in_mcap = traces_of(read_forward((folder / "survey.mcap").read_bytes()))
    files = [read_json(path) for path in sorted((folder / "traces").iterdir())]
    assert len(in_bag) == len(in_mcap) == len(files) == count
    for found in (files, *(sorted(one, key=lambda m: m.index) for one in (in_bag, in_mcap))):
        for index, values in enumerate(found):
            assert_same_numbers(make_trace(index), values)
