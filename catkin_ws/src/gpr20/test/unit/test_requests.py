"""Requests to the nodes of the robot, as messages: what is answered, and what is refused."""

from __future__ import annotations

import copy
import math
import random
import sys
import threading
import uuid
from concurrent.futures import ThreadPoolExecutor

import psutil
import pytest

pytest.importorskip("rospy")

import rospy
from genpy.base import is_simple
from graph_in_process import Graph
from robot_in_process import (
    PARAMETERS,
    check_complete,
    check_pause,
    check_state,
    description_in,
    json_traces,
)
from robot_parts import AXES
from run_seed import SEED, draws
from simulated_world import LIMIT_S
from std_msgs.msg import Header

from gpr20_axis_driver.low.pins import RobotHardware
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_common.high.answers import message_from
from gpr20_common.mid.node_facts import Hardware
from gpr20_height_sensor.height_driver import HeightParameters
from gpr20_height_sensor.height_node import HeightNode
from gpr20_height_sensor.height_node import build_robot_node as build_height_sensor
from gpr20_imaging.high.imaging_node import ImagingNode
from gpr20_imaging.low.stick_files import UsbVolumes
from gpr20_imaging.mid.imaging import ImagingParameters
from gpr20_main_control.high.main_control_node import MainControlNode
from gpr20_main_control.high.survey_topics import SurveyTopics
from gpr20_msgs.msg import SurveyParameters, Trace
from gpr20_msgs.srv import ServiceMoveRequest
from gpr20_survey.axes import ANTENNA_LINK, AxisId
from gpr20_survey.faults import NO_PLAN, NOT_HOMED
from gpr20_survey.plan.robot_description import Sensors
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_vna_acquisition.high.vna_node import VNANode
from gpr20_vna_processing.high import processing_node
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

ROUNDS = draws(3)
HOME, JOG, SET_ZERO = ServiceMoveRequest.HOME, ServiceMoveRequest.JOG, ServiceMoveRequest.SET_ZERO
HARDWARE = Hardware("simulated", simulated=True)


@pytest.fixture
def graph(world, robot, monkeypatch):
    """Main control, analyzer and height sensor of the robot in one process, as nodes."""
    graph = Graph(monkeypatch)
    MainControlNode(robot.control, robot.parts, robot.status, SurveyTopics())
    VNANode(robot.driver, HARDWARE)
    HeightNode(robot.height_sensor.driver, HARDWARE)
    return graph


@pytest.fixture
def storage(world, graph, monkeypatch):
    """A storage and the imaging beside them, with a data folder of their own."""
    for name in ("TopicRecorder", "wait_for_nodes"):
        monkeypatch.setattr(processing_node, name, lambda *_arguments: None)
    data = world.folder / "deep/down/data"
    node = processing_node.ProcessingNode(ProcessingParameters(data=str(data)), Sensors())
    ImagingNode(ImagingParameters(data=str(data)), UsbVolumes(lambda: '{"blockdevices": []}'))
    yield data
    node._shut_down()


def as_message(**changes):
    values = {name: getattr(PARAMETERS, name) for name in SurveyParameters.__slots__[:-1]}
    return SurveyParameters(**{**values, **changes})


# Surveys.


def test_a_survey_is_planned_started_and_continued_by_messages(world, robot, graph):
    refused = graph.ask("set_survey_parameters", parameters=as_message(x_start_mm=math.nan))
    assert not refused.success and "x start is nan mm" in refused.message
    assert message_from(refused).sentence() == refused.message
    assert graph.ask("start_survey").fault.code == NO_PLAN.code
    own = graph.ask("set_survey_parameters", parameters=as_message())
    assert (own.success, own.total_points) == (True, 18)
    other = graph.ask("set_survey_parameters", client="/other", parameters=as_message(x_points=4))
    refused = graph.ask("start_survey", plan_id=own.plan_id)
    assert refused.fault.code == NO_PLAN.code and "/other" in refused.message
    own = graph.ask("set_survey_parameters", parameters=as_message())
    assert own.plan_id != other.plan_id
    robot.calls.at("sweep", 4, lambda: [world.fault("OTHER_SERIAL"), world.fault("DROP", count=1)])
    started = graph.ask("start_survey", plan_id=own.plan_id)
    assert started.success, started.message
    check_pause(robot, "vna.replaced", "SIMULATED-2")
    assert (robot.status.status.plan_id, robot.status.status.plan_set_by) == (
        own.plan_id,
        "/client",
    )
    answers = [graph.ask("resume_survey") for _twice in range(2)]
    assert not any(one.success for one in answers)
    accepted = answers[-1].other_analyzer
    assert "SIMULATED-2" in accepted
    check_state(robot, SurveyState.PAUSED)
    robot.history.clear()
    resumed = graph.ask("resume_survey", survey=started.survey_id, accept_analyzer=accepted)
    assert resumed.success, resumed.message
    check_state(robot, SurveyState.FINISHED)
    check_complete(robot)
    assert graph.ask("stop_survey").fault.code == ASKED_FOR.code
    assert graph.ask("pause_survey").fault.code == ASKED_FOR.code


def test_of_two_clients_none_starts_the_plan_of_the_other_and_each_knows_what_it_got(robot, graph):
    chance, surveys, together = random.Random(SEED), 0, threading.Barrier(2)

    def ask(client, x_start_mm, starts):
        """Set parameters and START in this order; return the plan and survey that were started."""
        together.wait(LIMIT_S)
        plan = None
        for start in starts:
            if not start:
                parameters = as_message(x_start_mm=x_start_mm)
                plan = graph.ask("set_survey_parameters", client=client, parameters=parameters)
                if not plan.success:  # the survey of the other one runs
                    return None
            elif plan is not None:
                answer = graph.ask("start_survey", client=client, plan_id=plan.plan_id)
                if answer.success:
                    return plan.plan_id, client, x_start_mm, answer.survey_id
                assert answer.fault.code in (NO_PLAN.code, IN_USE.code), answer.message
        return None

    for _round in range(ROUNDS):
        robot.calls.forget_plans()
        robot.calls.at("stored", 1, robot.control.stop)
        # In any order, but each sets its parameters and starts in the end.
        orders = [[*chance.choices([0, 1], k=chance.randrange(4)), 0, 1] for _client in range(2)]
        with ThreadPoolExecutor(2) as clients:
            answers = list(clients.map(ask, ("/one", "/other"), (0.0, 5.0), orders))
        (started,) = [one for one in answers if one is not None] or [None]
        if started is None:  # each has replaced the plan of the other
            continue
        plan_id, client, x_start_mm, survey_id = started
        status, surveys = check_state(robot, SurveyState.STOPPED), surveys + 1
        description = description_in(robot, survey_id)
        for said in (vars(status), description):
            own = said["plan_id"], said["plan_set_by"], said["survey_id"]
            assert own == (plan_id, client, survey_id)
        assert json_traces(robot, survey_id)[0]["x_coord_mm"] == pytest.approx(x_start_mm)
    assert surveys > ROUNDS / 4


# Maintenance.


def test_axes_are_homed_and_jogged_within_their_range(world, graph):
    for axis, action, distance, fault in (
        ("x", JOG, 10.0, NOT_HOMED),
        ("x", SET_ZERO, 0.0, NOT_HOMED),
        ("z", SET_ZERO, 0.0, None),
        ("z", JOG, 10.0, None),
        ("x", HOME, 0.0, None),
        ("x", JOG, 10.0, None),
        ("x", JOG, -100.0, None),
        *(("x", JOG, odd, NOT_ALLOWED) for odd in (0.0, math.nan, math.inf)),
    ):
        steps = world.state.steps(AxisId(axis))
        answer = graph.ask("service_move", axis=axis, action=action, distance=distance)
        assert answer.fault.code == (fault.code if fault else ""), answer.message
        assert (world.state.steps(AxisId(axis)) == steps) is bool(fault or action == SET_ZERO)
    assert graph.ask("service_move", axis="x", action=JOG, distance=-1.0).success
    assert (world.state.steps(AxisId.X), world.state.steps(AxisId.Z)) == (0, 6)


def test_the_analyzer_is_tested(graph):
    tested = graph.ask("test_analyzer")
    assert tested.success and "SIMULATED" in tested.identity and tested.calibration == "HIGH"
    assert tested.points == 101 and math.isfinite(tested.level_db) and tested.sweep_duration_s > 0.0
    assert graph.ask("test_analyzer", address="here").fault.code == NOT_ALLOWED.code


def test_a_robot_without_its_hardware_is_an_error_and_never_simulated(monkeypatch):
    for library in ("RPi", "spidev"):
        monkeypatch.setitem(sys.modules, library, None)
    for build in (
        lambda: RobotHardware(AXES[AxisId.X]).open_pins(),
        lambda: build_height_sensor(HeightParameters()),
    ):
        with pytest.raises(Gpr20Error, match="elsewhere launch with robot:=simulated"):
            build()


# Values that no client of ours would send.

SURVEY_ID = "0f8fad5b-d9cb-469f-a165-70867728950e"
LONG, MANY, LONGEST_ANSWER = 1_000_000, 100_000, 4000
ALLOWED_GROWTH_MIB = 300.0
TEXTS = (
    "",
    "../../../outside",
    "/tmp/gpr20_outside",
    "..",
    "a/b",
    "a\x00b",
    "$(touch /tmp/gpr20_outside)",
    "`touch /tmp/gpr20_outside`; touch /tmp/gpr20_outside",
    "!!python/object/apply:os.system ['touch /tmp/gpr20_outside']",
    '{"survey_id": "../../../outside", "planned_traces": 1e999}',
    "[" * 100_000,
    "%s%n {0.__class__}",
    "x" * LONG,
)
NUMBERS = (-1.0, 0.0, 1e308, -1e308, math.nan, math.inf, -math.inf)
# Of the types that a field can have; how far a number goes, its message checks already.
INTEGERS = {
    "uint8": (0, 255),
    "int32": (-(2**31), -1, 0, 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "uint64": (0, 2**64 - 1),
}
# Requests that are allowed, or as near to it as can be; where there is no survey of this id, that
# is found out last.
USUAL = {
    "list_surveys": {"max_surveys": 10},
    "read_survey": {"survey": SURVEY_ID},
    "read_traces": {"survey": SURVEY_ID, "indices": [0, 1]},
    "reopen_survey": {"survey": SURVEY_ID},
    "resume_survey": {"survey": SURVEY_ID},
    "add_fact": {"survey": SURVEY_ID, "kind": "report", "values_json": "{}"},
    "close_survey": {"survey_id": SURVEY_ID, "outcome": "stopped"},
    "connection": {"connect": True, "address": "127.0.0.1"},
    "service_move": {"axis": "x", "action": 1, "distance": 1.0},
    "freq_sweep_setup": {"start_frequency_hz": 1e9, "stop_frequency_hz": 2e9, "points": 11},
}
# The last one closes the survey.
OF_AN_OPEN_SURVEY = ("store_data", "add_fact", "close_survey")


def hostile_values(kind):
    """Return values of a field's type that no client of ours would send."""
    if kind.endswith("]"):
        element, size = kind[:-1].split("[")
        one = hostile_values(element)
        if size:  # a list of another length cannot be sent
            return [[value] * int(size) for value in one]
        ordinary = "x" if "string" in kind else one[0] * 0
        return [[], list(one)[:5], [ordinary] * MANY, [one[-1]]]
    if kind in ("time", "duration"):
        maker = rospy.Time if kind == "time" else rospy.Duration
        return (maker(0, 0), maker(2**31 - 1, 999_999_999))
    known = {"string": TEXTS, "bool": (False, True), "float32": NUMBERS, "float64": NUMBERS}
    return {**known, **INTEGERS}[kind]


def fields(message, path=()):
    """Yield (path, type) of every field that is no message itself."""
    for name, kind in zip(message.__slots__, message._slot_types):
        value = getattr(message, name)
        inner = kind.split("[")[0]
        if hasattr(value, "__slots__") and kind not in ("time", "duration"):
            yield from fields(value, (*path, name))
        elif is_simple(inner) or inner in ("string", "time", "duration"):
            yield (*path, name), kind


def changed(message, path, value):
    """Return a copy of a request with another value at a place."""
    request = copy.deepcopy(message)
    holder = request
    for name in path[:-1]:
        holder = getattr(holder, name)
    setattr(holder, path[-1], value)
    return request


def usual_request(name, request_class):
    """Return a request of which one field at a time is changed, so that this field decides."""
    request = request_class(**USUAL.get(name, {}))
    now = rospy.Time.from_sec(1.79e9)
    if name == "set_survey_parameters":
        request.parameters = as_message()
    elif name == "open_survey":
        request.survey_id, request.started = str(uuid.uuid4()), now
        request.metadata_json = '{"planned_traces": 18}'
    elif name == "store_data":
        request.trace = Trace(
            header=Header(stamp=now, frame_id=ANTENNA_LINK),
            format="gpr20-trace/1",
            survey_id=SURVEY_ID,
            sample_id=str(uuid.uuid4()),
            **{one: now for one in ("timestamp", "sweep_started", "sweep_ended")},
            frequency_hz=[1e9, 2e9],
            s21_real=[0.1, 0.2],
            s21_imag=[0.1, 0.2],
        )
    return request


def ask_all_about(graph, name):
    """Ask with every hostile value in every field."""
    usual = usual_request(name, graph.services[name][0]._request_class)
    for path, kind in fields(usual):
        for value in hostile_values(kind):
            answer = graph.ask(name, changed(usual, path, value))
            what = f"{name} {'.'.join(path)} = {value!r:.80}: {answer.message:.200}"
            assert answer.success or len(answer.message.split()) > 4, what
            assert len(answer.message) < LONGEST_ANSWER, what
            assert not answer.message.startswith("internal error"), what
            if name == "open_survey" and answer.success:
                closing = {"survey_id": answer.message.split()[1], "outcome": "stopped"}
                assert graph.ask("close_survey", reason="a test", **closing).success, what


def test_hostile_values_are_answered_and_do_no_harm(world, robot, graph, storage):
    outside = world.folder.parent / "outside"
    memory = psutil.Process().memory_info()
    asked = set(graph.services) - {"start_survey", "stop_survey"}
    for name in sorted(asked):
        ask_all_about(graph, name)
    opening = usual_request("open_survey", graph.services["open_survey"][0]._request_class)
    opening.survey_id = SURVEY_ID
    assert graph.ask("open_survey", opening).success
    for name in OF_AN_OPEN_SURVEY:
        ask_all_about(graph, name)
    (folder,) = storage.glob(f"*_{SURVEY_ID[:8]}")
    (trace,) = (folder / "traces").iterdir()
    assert trace.name == "000000_X0000.00_Y0000.00_Z+000.00.json"
    grown_mib = (psutil.Process().memory_info().rss - memory.rss) / 2**20
    assert grown_mib < ALLOWED_GROWTH_MIB
    # Nothing but the data folder, whose parents are there for "../../..".
    assert [one.name for one in storage.parent.iterdir()] == [storage.name]
    assert not outside.exists() and not (world.folder / "outside").exists()
    robot.begin()
    check_state(robot, SurveyState.FINISHED)
    check_complete(robot)
