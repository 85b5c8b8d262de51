#!/usr/bin/env python3
"""No value that comes over a service reaches a file outside, grows memory or ends a node."""

import copy
import math
import shutil
import time
import unittest
import uuid
from xmlrpc.client import ServerProxy

import psutil
import rosgraph
import rosnode
import rospy
import rosservice
import rostest
from genpy.base import is_simple
from std_msgs.msg import Header
from survey_client import PARAMETERS, SurveyClient, json_traces

from gpr20_msgs.msg import ControlStatus, SurveyParameters, Trace
from gpr20_survey.frames import ANTENNA_LINK

NODES = (
    *(f"{axis}_axis/axis_driver" for axis in "xyz"),
    "height_sensor",
    "vna_acquisition",
    "vna_processing",
    "imaging",
    "main_control",
    "simulator",
)
SURVEY_ID = "0f8fad5b-d9cb-469f-a165-70867728950e"
LONG = 2_000_000
MANY = 300_000
LONGEST_ANSWER = 4000
ALLOWED_GROWTH_MIB = 200.0
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


def hostile_values(kind):
    """Return values of a field's type that no client of ours would send."""
    if kind.endswith("]"):
        element, size = kind[:-1].split("[")
        one = hostile_values(element)
        if size:  # a list of another length cannot be sent
            return [[value] * int(size) for value in one]
        ordinary = "x" if "string" in kind else one[0] * 0
        return [[], list(one)[:5], [ordinary] * MANY, [one[-1]]]
    if kind == "string":
        return TEXTS
    if kind == "bool":
        return (False, True)
    if kind in ("float32", "float64"):
        return NUMBERS
    if kind in ("time", "duration"):
        maker = rospy.Time if kind == "time" else rospy.Duration
        return (maker(0, 0), maker(2**31 - 1, 999_999_999))
    return INTEGERS[kind]


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


# Requests that are allowed, or as near to it as can be, by the end of the service's name; where
# there is no survey of this id, that is found out last.
USUAL = {
    "list_surveys": {"max_surveys": 10},
    "read_survey": {"survey": SURVEY_ID},
    "read_traces": {"survey": SURVEY_ID, "indices": [0, 1]},
    "reopen_survey": {"survey": SURVEY_ID},
    "resume_survey": {"survey": SURVEY_ID},
    "annotate_survey": {"survey": SURVEY_ID},
    "mark_survey": {"survey": SURVEY_ID, "marker_id": SURVEY_ID},
    "report_survey": {"survey_id": SURVEY_ID, "report_json": "{}"},
    "close_survey": {"survey_id": SURVEY_ID, "outcome": "stopped"},
    "connection": {"connect": True, "address": "127.0.0.1"},
    "service_move": {"axis": "x", "action": 1, "distance": 1.0},
    "freq_sweep_setup": {"start_frequency_hz": 1e9, "stop_frequency_hz": 2e9, "points": 11},
}


def usual_request(service, request_class):
    """Return a request of which one field at a time is changed, so that this field decides."""
    name = service.rsplit("/", 1)[-1]
    request = request_class(**USUAL.get(name, {}))
    if name == "set_survey_parameters":
        request.parameters = SurveyParameters(**PARAMETERS)
    elif name == "open_survey":
        request.survey_id, request.started = str(uuid.uuid4()), rospy.Time.now()
        request.metadata_json = '{"planned_traces": 18}'
    elif name == "store_data":
        request.trace = usual_trace()
    return request


def usual_trace():
    """Return a trace of the survey SURVEY_ID that can be stored."""
    now = rospy.Time.now()
    return Trace(
        header=Header(stamp=now, frame_id=ANTENNA_LINK),
        format="gpr20-trace/1",
        survey_id=SURVEY_ID,
        sample_id=str(uuid.uuid4()),
        timestamp=now,
        sweep_started=now,
        sweep_ended=now,
        frequency_hz=[1e9, 2e9],
        s21_real=[0.1, 0.2],
        s21_imag=[0.1, 0.2],
    )


def processes():
    """Return the process of each node."""
    master = rosgraph.Master(rospy.get_name())
    found = {}
    for node in NODES:
        uri = rosnode.get_api_uri(master, rospy.resolve_name(node), skip_cache=True)
        found[node] = psutil.Process(ServerProxy(uri).getPid(rospy.get_name())[2])
    return found


class HostileValuesTest(unittest.TestCase):
    """Asks every service of the graph."""

    def test_hostile_values_are_answered_and_do_no_harm(self):
        rospy.init_node("hostile_values_rostest")
        client = SurveyClient()
        top = client.data.parents[2]
        self.addCleanup(shutil.rmtree, top)
        before = processes()
        memory_mib = {node: process.memory_info().rss / 2**20 for node, process in before.items()}

        for service in sorted(self.our_services()):
            self.ask_all_about(service)
        self.ask_while_a_survey_is_open(client)

        after = processes()
        self.assertEqual(
            {n: p.pid for n, p in after.items()}, {n: p.pid for n, p in before.items()}
        )
        for node, process in after.items():
            growth_mib = process.memory_info().rss / 2**20 - memory_mib[node]
            self.assertLess(growth_mib, ALLOWED_GROWTH_MIB, node)
        outside = [path for path in top.rglob("*") if client.data not in path.parents]
        self.assertEqual(set(outside), {top / "deep", top / "deep/down", client.data})
        self.assertFalse(top.with_name("gpr20_outside").exists())
        self.assert_a_survey_still_works(client)

    def our_services(self):
        return [
            name
            for name in rosservice.get_service_list()
            if not name.endswith(("get_loggers", "set_logger_level", "homing", "stop"))
            and not name.endswith(("start_survey", "stop_survey", "set_zero", "set_fault"))
        ]

    def ask_while_a_survey_is_open(self, client):
        """Ask what is refused at once while there is none."""
        service = rospy.resolve_name("open_survey")
        kind = rosservice.get_service_class_by_name(service)
        request = usual_request(service, kind._request_class)
        request.survey_id = SURVEY_ID
        opened = rospy.ServiceProxy(service, kind)(request)
        self.assertTrue(opened.success, opened.message)
        # The last one closes it.
        for name in (
            "store_data",
            "report_survey",
            "annotate_survey",
            "mark_survey",
            "close_survey",
        ):
            self.ask_all_about(rospy.resolve_name(name))
        folder = client.folder(SURVEY_ID)
        (trace,) = (folder / "traces").iterdir()
        self.assertEqual(trace.name, "000000_X0000.00_Y0000.00_Z+000.00.json")
        self.assertEqual(json_traces(folder)[0]["survey_id"], SURVEY_ID)

    def ask_all_about(self, service):
        """Ask with every hostile value in every field."""
        kind = rosservice.get_service_class_by_name(service)
        proxy = rospy.ServiceProxy(service, kind)
        usual = usual_request(service, kind._request_class)
        for path, field_kind in fields(usual):
            for value in hostile_values(field_kind):
                begin_s = time.monotonic()
                answer = proxy(changed(usual, path, value))
                what = f"{service} {'.'.join(path)} = {value!r:.80}"
                self.assertLess(time.monotonic() - begin_s, 60.0, what)
                self.assertLess(len(answer.message), LONGEST_ANSWER, what)
                if not answer.success:
                    self.assertTrue(answer.message, what)
                self.close_what_was_opened(service, answer)

    def close_what_was_opened(self, service, answer):
        if service.endswith("open_survey") and answer.success:
            survey_id = answer.path.rsplit("/", 1)[-1]
            self.assertRegex(survey_id, r"^\d{8}T\d{6}_[0-9a-f]{8}$")
            close = rosservice.get_service_class_by_name(rospy.resolve_name("close_survey"))
            whole_id = answer.message.split()[1]
            closed = rospy.ServiceProxy("close_survey", close)(
                survey_id=whole_id, outcome="stopped", reason="a test"
            )
            self.assertTrue(closed.success, closed.message)

    def assert_a_survey_still_works(self, client):
        survey_id, status = client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertEqual(len(json_traces(client.folder(survey_id))), 18)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "hostile_values", HostileValuesTest)
