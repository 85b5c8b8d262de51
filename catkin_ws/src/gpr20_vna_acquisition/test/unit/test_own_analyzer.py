"""The tutorial docs/extend/analyzer.md: a class outside this repository, and what becomes of it."""

from __future__ import annotations

import contextlib
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

import yaml
from case_kit import each_case
from driver_bench import SWEEP
from fault_kit import raises_fault
from test_socket_vna import *  # noqa: F403
from tutorial_code import code_blocks

from gpr20_common import faults as common_faults
from gpr20_common.low.clock import Clock
from gpr20_common.mid.codec import record_from
from gpr20_simulator.mid.analyzer.in_process import StepTime
from gpr20_survey.faults import VNA_FAILED, VNA_SILENT
from gpr20_vna_acquisition.errors import VnaClosedError, VnaConnectionError, VnaError
from gpr20_vna_acquisition.mid import vna_driver
from gpr20_vna_acquisition.mid.analyzers import (
    ForeignAnalyzer,
    load_analyzer,
    make_foreign_analyzer,
)
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

PAGE = Path(__file__).parents[5] / "docs/extend/analyzer.md"
# What ends only because a call was given up, ends long before this on a busy machine, too [s].
LIMIT_S = 100.0
# 3 connect_timeout_s, 2 answer_timeout_s, and 1.5 s.
USUAL_S = 20.5


def test_the_configuration_of_the_page_is_accepted():
    own = yaml.safe_load(code_blocks(PAGE, "yaml")["analyzer.yaml"])
    parameters = record_from(VnaParameters, own, "vna_acquisition")
    assert load_analyzer(parameters).__name__ == "SocketVna"
    assert asdict(parameters)["analyzer_options"] == {"port": 5025}


@each_case(
    "analyzer, options, shown",
    [
        ("no_such_module:Vna", {}, "no_such_module"),
        ("subprocess:Popen", {}, "calibration"),
        ("socket_vna:SocketVna", {"baud": 1}, "analyzer_options"),
    ],
)
def test_a_class_that_cannot_be_used_is_refused_with_the_reason(analyzer, options, shown):
    parameters = VnaParameters(analyzer=analyzer, analyzer_options=options)
    with raises_fault(common_faults.CONFIGURATION, shown):
        make_foreign_analyzer(parameters, RequestDeadline(Clock()))


class Scripted:
    """Does the same at each call of the driver."""

    trace_duration_s, remarks = None, ()

    def __init__(self, does) -> None:
        self.does = does

    def __getattr__(self, _name: str):
        return self.does


def test_an_exception_or_result_of_any_kind_counts_as_a_broken_link():
    def fail(*_arguments):
        raise ZeroDivisionError

    deadline = RequestDeadline(Clock())
    deadline.begin(10.0)
    for does, shown in ((fail, "ZeroDivisionError"), (lambda *_a: "other", "other")):
        analyzer = ForeignAnalyzer(Scripted(does), VnaParameters(), deadline)
        for action in (analyzer.sweep, analyzer.calibration):
            with raises_fault(VNA_SILENT, error=VnaConnectionError) as failure:
                action()
            assert shown in str(failure.value.message.details) or does is not fail
        analyzer.release()
        analyzer.disconnect()


# A call that does not return ends the process of the driver.


@each_case(
    "call, limit_s",
    [
        ("confirm", USUAL_S),
        ("disconnect", USUAL_S),
        ("sweep", 10.0 + USUAL_S),
        # As long as a set-up may take.
        ("configure", 40.0 + USUAL_S),
        ("check_sweep", 40.0 + USUAL_S),
    ],
)
def test_a_call_that_does_not_return_is_overdue_after_its_time(call, limit_s):
    clock, overdue = StepTime(), []
    deadline = RequestDeadline(clock)

    def hold(*_arguments):
        # A single look is not enough: after a pause of the whole process every call is late.
        for duration_s, looks in ((limit_s - 0.1, 2), (0.2, 1), (0.0, 1)):
            clock.sleep_until_s(clock.now_s() + duration_s)
            overdue.extend(deadline.overdue() for _look in range(looks))
        raise OSError

    parameters = VnaParameters(analyzer="a:B")
    analyzer = ForeignAnalyzer(Scripted(hold), parameters, deadline)
    analyzer.trace_duration_s = 1e-9
    is_set_up = call in ("configure", "check_sweep")
    deadline.begin(parameters.request_limit_s(), extensible=is_set_up)
    with contextlib.suppress(VnaError):
        getattr(analyzer, call)()
    assert overdue[:3] == [None] * 3 and f"a:B.{call}" in str(overdue[3].all_details)
    assert deadline.overdue() is None


def test_a_sweep_with_every_bit_of_the_one_before_is_refused(driver, vna):
    driver.set_frequency_sweep(SWEEP)
    shown = vna._seen()
    vna._seen = lambda: shown
    driver.get_trace()
    with raises_fault(VNA_FAILED):
        driver.get_trace()


def test_a_shutdown_does_not_wait_for_a_call(driver, monkeypatch):
    monkeypatch.setattr(vna_driver, "LAST_REQUEST_S", 0.01)
    holding, freed = threading.Event(), threading.Event()

    def hold():
        holding.set()
        assert freed.wait(LIMIT_S)
        raise OSError

    driver.set_frequency_sweep(SWEEP)
    monkeypatch.setattr(driver._analyzer._analyzer, "sweep", hold)
    with ThreadPoolExecutor(1) as pool:
        request = pool.submit(driver.get_trace)
        assert holding.wait(LIMIT_S)
        driver.shut_down()
        freed.set()
        assert isinstance(request.exception(LIMIT_S), VnaClosedError)
