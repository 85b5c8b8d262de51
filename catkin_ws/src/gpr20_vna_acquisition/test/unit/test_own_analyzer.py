"""The tutorial docs/extend/analyzer.md: a class outside this repository."""

import sys
import tempfile
from dataclasses import asdict, replace
from pathlib import Path

import yaml
from case_kit import each_case
from fault_kit import raises_fault
from tutorial_code import code_blocks

from gpr20_common import faults as common_faults
from gpr20_common.low.clock import Clock
from gpr20_common.mid.codec import record_from
from gpr20_survey.faults import VNA_SILENT
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.mid.analyzer_record import passed
from gpr20_vna_acquisition.mid.analyzers import (
    ForeignAnalyzer,
    load_analyzer,
    make_foreign_analyzer,
)
from gpr20_vna_acquisition.mid.conformance import Bench, Extent, results
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

PAGE = Path(__file__).parents[5] / "docs/extend/analyzer.md"
CODE = code_blocks(PAGE, "python")

# The modules of the page, importable as those of an installed package are.
_folder = tempfile.TemporaryDirectory()
for _name, _code in CODE.items():
    Path(_folder.name, _name).write_text(_code)
sys.path.insert(0, _folder.name)

from test_socket_vna import *  # noqa: E402, F403


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


@each_case("analyzer", ["", "ms2027c", "scikit_rf", "os.system", "a:b:c"])
def test_an_analyzer_of_no_kind_is_refused_with_what_is_allowed(analyzer):
    with raises_fault(common_faults.NOT_ALLOWED, "ms2026c", "gpr20_scikit_rf:ScikitRfAnalyzer"):
        VnaParameters(analyzer=analyzer)
    with raises_fault(common_faults.CONFIGURATION):
        replace(VnaParameters(), analyzer_options={"port": 1})


class BrokenAnalyzer:
    """Raises what no analyzer should."""

    trace_duration_s, remarks = None, ()

    def fail(self, *_arguments):
        raise ZeroDivisionError

    connect = identify = configure = sweep = confirm = calibration = release = disconnect = fail
    check_sweep = fail


def test_an_exception_of_any_kind_counts_as_a_broken_link():
    deadline = RequestDeadline(Clock())
    deadline.begin(10.0)
    analyzer = ForeignAnalyzer(BrokenAnalyzer(), VnaParameters(), deadline)
    for action in (analyzer.identify, analyzer.sweep, analyzer.confirm, analyzer.calibration):
        with raises_fault(VNA_SILENT, "ZeroDivisionError", error=VnaConnectionError):
            action()
    analyzer.release()
    analyzer.disconnect()


def test_the_class_of_the_page_passes_its_check(vna):
    parameters = VnaParameters(
        analyzer="socket_vna:SocketVna",
        analyzer_options={"port": vna.port},
        address="127.0.0.1",
        maker="CMT",
        model="S5085",
        answer_timeout_s=0.5,
        sweep_timeout_s=0.5,
    )
    extent = Extent(21, (1e4,), sweeps=2, limit_s=60.0)
    found = list(results(Bench(parameters, lambda _address: None, extent)))
    assert passed(found), [str(one.text) for one in found]
