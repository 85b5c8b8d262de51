"""gpr20 batch: many surveys at once, whatever becomes of one of them or of a worker."""

import json
import os
import signal
import sys

import psutil
import pytest
from command_kit import TIME_LIMIT_S, begun, install
from distributed import Client, LocalCluster
from random_surveys import noise_survey
from run_seed import LONG
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands import batch_commands
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_common.faults import NOT_ALLOWED

COLUMNS = (6, 7, 8, 9) if LONG else (6, 9)
IMAGE = "image --permittivity 4 --depth 0 0.05 0.01 --method back-projection"
DEADLY = '''
import os, signal

def deadly(survey):
    """Kill this process if a survey has 9 columns."""
    if survey.sizes["x"] == 9:
        os.kill(os.getpid(), signal.SIGKILL)
    return survey
'''


def write_noise(path, columns):
    write_dataset(noise_survey(columns, 6, columns), path)


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    folder = tmp_path_factory.mktemp("surveys")
    paths = [folder / f"{columns}.nc" for columns in COLUMNS]
    for path, columns in zip(paths, COLUMNS):
        write_noise(path, columns)
    return [str(path) for path in paths]


@pytest.fixture
def batch(capsys):
    """Return a function that runs the command and returns exit status and records."""

    def run(*arguments):
        status = main(["batch", *map(str, arguments), "--json"])
        return status, json.loads(capsys.readouterr().out)["surveys"]

    return run


@pytest.fixture(scope="module")
def scheduler():
    """The option for a scheduler that runs, with a worker."""
    one = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**one) as cluster:
        yield ("--scheduler", cluster.scheduler_address)


def workers_of(process):
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def test_one_failure_stops_no_other_and_a_second_run_makes_what_is_missing_or_old(
    tmp_path, batch, scheduler
):
    data, into = tmp_path / "data", tmp_path / "into"
    data.mkdir()
    write_noise(data / "whole.nc", 6)
    (data / "torn.nc").write_bytes(b"not NetCDF")
    arguments = [data / "torn.nc", data / "whole.nc", "--into", into]
    arguments += ["--command", "candidates --permittivity 4 --depth 0 0.05 0.01", *scheduler]
    status, (torn, whole) = batch(*arguments)
    assert (status, torn["state"], whole["state"]) == (1, "failed", "done")
    assert torn["said"][1] == f"First: {faults.FILE_DAMAGED.remedy}"
    assert whole["result"] == str(into / "whole.csv")
    assert sorted(one.name for one in into.iterdir()) == ["whole.csv", "whole.csv.sha256"]
    made = (into / "whole.csv").stat().st_mtime_ns
    write_noise(data / "torn.nc", 7)
    status, records = batch(*arguments)
    assert status == 0
    assert [one["state"] for one in records] == ["done", "exists"]
    assert (into / "whole.csv").stat().st_mtime_ns == made
    assert [one["state"] for one in batch(*arguments, "--overwrite")[1]] == ["done", "done"]
    write_noise(data / "whole.nc", 8)
    assert [one["state"] for one in batch(*arguments)[1]] == ["exists", "done"]
    assert (into / "whole.csv").stat().st_mtime_ns > made


def test_what_a_survey_below_a_folder_lacks_is_said(tmp_path, batch, scheduler):
    data = make_survey(tmp_path / "data", len(POINTS) - 1, "stopped").parent
    arguments = [data, "--into", tmp_path / "into", *scheduler, "--command", "plot coverage"]
    status, (record,) = batch(*arguments)
    assert (status, record["state"]) == (0, "not complete")
    assert any("NO DATA" in remark for remark in record["said"])
    # A trace less or more is another state, though the description is the same.
    assert batch(*arguments)[1][0]["state"] == "exists"
    next((data / record["survey"] / "traces").iterdir()).unlink()
    assert batch(*arguments)[1][0]["state"] == "not complete"


@pytest.mark.timeout(300)
def test_a_survey_that_kills_each_worker_is_named_and_the_others_are_done(
    surveys, tmp_path, batch, monkeypatch
):
    (tmp_path / "deadly.py").write_text(DEADLY)
    install(tmp_path, "[gpr20_analysis.steps]\ndeadly = deadly:deadly\n", "deadly")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    command = "process --step deadly"
    arguments = [*surveys, "--into", tmp_path / "into", "--workers", 1, "--command", command]
    status, records = batch(*arguments)
    assert status == 1
    assert [one["state"] for one in records] == ["done"] * (len(COLUMNS) - 1) + ["failed"]
    assert records[-1]["said"] == [batch_commands.KILLED]


@pytest.fixture
def cluster():
    """A scheduler in this process, without workers."""
    with LocalCluster(n_workers=0, processes=False, dashboard_address=None) as cluster:
        yield cluster


def lost_calls(client, limit_s):
    found = batch_commands.outcomes(client, [["info", "a"], ["info", "b"]], limit_s)
    return {number: said for number, _state, said in found}


def test_every_survey_ends_when_no_worker_is_left_or_the_scheduler_goes_away(cluster, monkeypatch):
    lost = {0: [batch_commands.LOST], 1: [batch_commands.LOST]}
    with Client(cluster.scheduler_address) as client:
        assert lost_calls(client, 0.1) == lost
    waited = batch_commands.wait

    def wait(*arguments, **named):
        cluster.close()
        return waited(*arguments, **named)

    monkeypatch.setattr(batch_commands, "wait", wait)
    with Client(cluster.scheduler_address, timeout=5.0) as client:
        assert lost_calls(client, 60.0) == lost


def test_an_interrupted_batch_leaves_results_but_no_parts_and_no_processes(surveys, tmp_path):
    into = tmp_path / "into"
    arguments = ["batch", *surveys, "--into", into, "--workers", 1, "--command", IMAGE]
    process = begun(arguments, lambda: list(into.glob(".gpr20-*/*")))
    try:
        workers = workers_of(process)
        os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C does
        _, error = process.communicate(timeout=TIME_LIMIT_S)
    finally:
        process.kill()
    assert process.returncode == 3
    assert error == "gpr20 batch: interrupted; no partial output is left\n"
    assert not list(into.glob(".gpr20-*"))
    assert not psutil.wait_procs(workers, timeout=TIME_LIMIT_S)[1]


def test_an_address_where_nobody_answers_is_refused(surveys, tmp_path, refusals, monkeypatch):
    monkeypatch.setattr("gpr20_analysis.commands.batch_commands.CONNECT_LIMIT_S", 0.5)
    arguments = ["batch", *surveys, "--into", str(tmp_path), "--scheduler", "tcp://127.0.0.1:9"]
    assert main(arguments) == 3
    assert refusals == [NOT_ALLOWED.code]


def test_what_cannot_be_done_for_many_surveys_is_refused(tmp_path, refusals):
    for arguments in (["a.nc", "--command", "verify"], ["one/a.nc", "two/a.nc"]):
        assert main(["batch", *arguments, "--into", str(tmp_path / "into")]) == 3
        assert refusals.pop() == NOT_ALLOWED.code and not list(tmp_path.iterdir())
