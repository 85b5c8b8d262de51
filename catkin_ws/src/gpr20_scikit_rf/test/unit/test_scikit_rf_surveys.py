"""Surveys with an analyzer of scikit-rf, and what analyzer.yaml may say of one."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from case_kit import each_case
from fault_kit import raises_fault
from robot_in_process import RobotInProcess, check_state, description_in, json_traces
from scpi_analyzers import PnaAnalyzer, ScpiServer
from simulated_world import World
from tutorial_code import code_blocks
from wait_kit import wait_until

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_common.mid.codec import record_from
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_vna_acquisition.mid.analyzers import make_foreign_analyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

README = Path(__file__).parents[2] / "README.md"
OF_README = code_blocks(README, "yaml")["analyzer.yaml"]


@pytest.fixture
def vna():
    return PnaAnalyzer()


@pytest.fixture
def server(vna):
    one = ScpiServer(vna)
    yield one
    one.stop()


@pytest.fixture
def robot(tmp_path, vna, server):
    """The robot in one process with an analyzer that numbers its sweeps."""
    world = World(tmp_path)
    world.time = vna.clock
    parameters = VnaParameters(
        analyzer="gpr20_scikit_rf:ScikitRfAnalyzer",
        analyzer_options={"scikit_rf_class": "keysight.PNA"},
        address=server.address,
        maker=vna.maker,
        model=vna.model,
        accepted_calibrations=(5,),
        clear_on_connect=False,
        answer_timeout_s=30.0,
        sweep_timeout_s=30.0,
        max_level_db=100.0,
        antenna_delay_ns=0.3,
    )
    robot = RobotInProcess(world, parameters)
    yield robot
    robot.close()


def test_a_survey_stores_fresh_sweeps_of_the_configured_address(robot, vna, server):
    robot.begin(polarizations_deg=(0.0,), vna_address="")
    check_state(robot, SurveyState.FINISHED)
    traces, survey = json_traces(robot), description_in(robot)
    # Each is a whole sweep that was made after the one before.
    sweeps = [trace["s21_real"] for trace in traces]
    assert [set(one) for one in sweeps] == [{one[0]} for one in sweeps]
    order = [one[0] for one in sweeps]
    assert len(order) == 9 and order == sorted(set(order))
    assert survey["instrument"]["identity"] == vna.identity
    assert survey["instrument"]["address"] == server.address
    assert survey["instrument"]["calibration_status"] == 5
    assert survey["analyzer"]["antenna_delay_ns"] == 0.3
    assert {trace["averages"] for trace in traces} == {1}
    assert {trace["if_bandwidth_hz"] for trace in traces} == {1e5}
    # It sweeps by itself again; the last command has no answer.
    wait_until(lambda: vna.is_continuous)


# The configuration.


def made(text):
    """Return the analyzer of a configuration, as the check before a launch makes it."""
    parameters = record_from(VnaParameters, yaml.safe_load(text), "vna_acquisition")
    return make_foreign_analyzer(parameters, RequestDeadline(Clock()))


def test_the_configuration_of_the_readme_is_accepted():
    assert made(OF_README).trace_duration_s is None


@each_case(
    "former, new, fault, shown",
    [
        ("{scikit_rf_class: keysight.PNA}", "{}", faults.CONFIGURATION, "scikit_rf_class"),
        ("keysight.PNA", "nanovna.NanoVNAv2", faults.NOT_ALLOWED, "keysight.PNA, keysight.Fiel"),
        ("TCPIP0::192.168.1.5::inst0::INSTR", "1.2.3.4", faults.NOT_ALLOWED, "::inst0::INSTR"),
    ],
)
def test_what_no_such_analyzer_has_is_refused_before_a_launch(former, new, fault, shown):
    assert former in OF_README
    with raises_fault(fault, shown, error=InvalidValueError):
        made(OF_README.replace(former, new))


@each_case("address", ["TCPIP0::1.2.3.4::hislip0,4880::INSTR", "GPIB0::16::INSTR"])
def test_names_of_visa_resources_are_accepted(address):
    made(OF_README.replace("TCPIP0::192.168.1.5::inst0::INSTR", address))


@each_case("address", ["192.168.1.5", "'GPIB0::'", "'::INSTR'", "A::b c", "A::ñ"])
def test_other_texts_are_no_visa_resources(address):
    with raises_fault(faults.NOT_ALLOWED, address.strip("'"), error=InvalidValueError):
        made(OF_README.replace("TCPIP0::192.168.1.5::inst0::INSTR", address))
