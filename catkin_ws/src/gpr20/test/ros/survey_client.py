"""A client of a running robot, and the folders of its surveys, for the tests."""

import json
import struct
import subprocess
import threading
import time
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rospy

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_msgs.msg import (
    Annotation,
    ControlStatus,
    NodeDescription,
    SurveyData,
    SurveyParameters,
)
from gpr20_msgs.srv import Command, ResumeSurvey, SetSurveyParameters, StartSurvey
from gpr20_simulator.srv import SetFault
from gpr20_survey.files.durable_files import writer_of

LIMIT_S = 200.0
# Of all nodes: where these are, every node is there.
SERVICES = (
    *(f"{axis}_axis/{name}" for axis in "xyz" for name in ("homing", "stop")),
    *("connection", "freq_sweep_setup", "get_freq", "get_data", "confirm_data"),
    "get_calibration_status",
    *("open_survey", "reopen_survey", "store_data", "add_fact", "close_survey"),
    *("list_surveys", "read_survey", "read_traces", "get_height", "simulator/set_fault"),
    *("set_survey_parameters", "start_survey", "stop_survey", "pause_survey", "resume_survey"),
)
GOING_ON = (ControlStatus.CHECKING, ControlStatus.HOMING, ControlStatus.SURVEYING)
PARAMETERS = {
    "vna_address": "127.0.0.1",
    "start_frequency_hz": 600.0e6,
    "stop_frequency_hz": 6.0e9,
    "frequency_points": 51,
    "x_start_mm": 10.0,
    "x_stop_mm": 20.0,
    "x_points": 3,
    "y_start_mm": 10.0,
    "y_stop_mm": 20.0,
    "y_points": 3,
    "polarizations_deg": [0.0, 90.0],
}


def wait_until_connected(subscribers):
    """Wait until each subscriber has a publisher: earlier messages are lost."""
    for subscriber in subscribers:
        wait_until(subscriber.get_num_connections, f"nobody publishes {subscriber.name}")


def wait_for_bag(folder):
    """Wait until the bag of a survey that has ended is made, and named in its log."""
    bag = folder / "survey.bag"
    wait_until(lambda: bag.exists() and writer_of(folder) is None, "there is no bag")


def wait_until(condition, failure):
    """Wait until a condition holds."""
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, failure
        time.sleep(0.05)


def run(*command, **options):
    """Run a command; return its exit status and all that it said."""
    ended = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
        check=False,
        **options,
    )
    return ended.returncode, ended.stdout


def described(node):
    """Return the configuration with which a node says that it started."""
    message = rospy.wait_for_message(f"{node}/description", NodeDescription, LIMIT_S)
    return json.loads(message.configuration_json)


class SurveyClient:
    """Requests to main_control, and everything it has published.

    Args:
        robot: Namespace of the robot; empty: that of the test.
    """

    def __init__(self, robot=""):
        self._changed = threading.Condition()
        self.statuses = []
        self.progress = []
        self.survey_id = ""
        prefix = f"{robot}/" if robot else ""
        for name in SERVICES:
            rospy.wait_for_service(prefix + name, LIMIT_S)

        def service(name, kind):
            return rospy.ServiceProxy(prefix + name, kind)

        self.pause = service("pause_survey", Command)
        self.set_parameters = service("set_survey_parameters", SetSurveyParameters)
        self.start = service("start_survey", StartSurvey)
        self.stop = service("stop_survey", Command)
        self.resume = service("resume_survey", ResumeSurvey)
        self.set_fault = service("simulator/set_fault", SetFault)
        self._subscribers = [
            rospy.Subscriber(f"{prefix}{name}", kind, self._note, kept)
            for name, kind, kept in (
                ("control_status", ControlStatus, self.statuses),
                ("control_survey_data", SurveyData, self.progress),
            )
        ]
        wait_until_connected(self._subscribers)
        self.data = Path(described(f"{prefix}vna_processing")["data"])

    def _note(self, message, kept):
        with self._changed:
            kept.append(message)
            self._changed.notify_all()

    def wait(self, condition, limit_s=LIMIT_S):
        """Wait until a condition on the received messages holds."""
        with self._changed:
            assert self._changed.wait_for(condition, limit_s), (
                f"still {self.statuses[-1:]} {self.progress[-1:]}"
            )

    def forget(self):
        """Forget the received statuses."""
        with self._changed:
            self.statuses.clear()

    def set(self, **changes):
        """Set parameters that differ from the usual ones; return the answer."""
        return self.set_parameters(SurveyParameters(**{**PARAMETERS, **changes}))

    def begin(self, annotation=None, refines="", permittivity=4.0, **changes):
        """Set parameters and start; return the survey's id."""
        answer = self.set(**changes)
        assert answer.success, answer.message
        with self._changed:
            self.statuses.clear()
            self.progress.clear()
        started = self.start(
            plan_id=answer.plan_id,
            annotation=annotation or Annotation(),
            refines=refines,
            permittivity=permittivity,
        )
        assert started.success, started.message
        self.survey_id = started.survey_id
        # Messages about the survey before may arrive after the answer.
        self.wait(lambda: any(one.survey_id == started.survey_id for one in self.statuses))
        return started.survey_id

    def go_on(self, survey_id):
        """Resume a paused survey; statuses received before are forgotten."""
        self.forget()
        answer = self.resume(survey=survey_id)
        assert answer.success, answer.message
        # The old state may be received once more after the answer.
        self.wait(lambda: any(one.code in GOING_ON for one in self.statuses))

    def wait_for_status(self, *codes):
        """Wait for one of the codes and return that status."""
        self.wait(lambda: self.statuses and self.statuses[-1].code in codes)
        return self.statuses[-1]

    def finished(self):
        """Wait until the survey has finished, and has not paused before; return the status."""
        ended = (ControlStatus.FINISHED, ControlStatus.PAUSED, ControlStatus.FAILED)
        status = self.wait_for_status(*ended, ControlStatus.STOPPED)
        assert status.code == ControlStatus.FINISHED, status.message
        assert ControlStatus.PAUSED not in [one.code for one in self.statuses]
        return status

    def check_complete(self, survey_id, traces):
        """Check that it has finished, and that its folder holds every trace once."""
        self.finished()
        folder = self.folder(survey_id)
        stored = json_traces(folder)
        assert [one["index"] for one in stored] == list(range(traces))
        places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
        assert len(places) == traces
        wait_for_bag(folder)
        found = verify_survey(folder)
        assert (found.status, found.faults) == (COMPLETE, [])

    def wait_for_visited(self, points):
        """Wait until so many points of the survey that was begun last are stored."""
        self.wait(
            lambda: any(
                one.survey_id == self.survey_id and one.visited_points >= points
                for one in self.progress
            )
        )

    def folder(self, survey_id):
        """Return the folder of a survey."""
        (folder,) = self.data.glob(f"*_{survey_id[:8]}")
        return folder


def node_pid(name):
    """Return the process of a node."""
    # Not from its cache: a restarted node has another address.
    server = rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), name, skip_cache=True)
    _code, _message, pid = ServerProxy(server).getPid(rospy.get_name())
    return pid


def json_traces(folder):
    """Return the JSON traces of a survey, in the order of their index."""
    return [json.loads(path.read_text()) for path in sorted((folder / "traces").glob("*.json"))]


def bits(values):
    """Return float64 numbers as their bits, so that equal means equal to the last one."""
    return struct.pack(f"<{len(values)}d", *values)
