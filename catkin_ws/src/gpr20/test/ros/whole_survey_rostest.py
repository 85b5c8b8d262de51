#!/usr/bin/env python3
"""A survey through the whole graph: what is stored, what is refused, what a stop does."""

import json
import math
import os
import shutil
import subprocess
import threading
import unittest
import uuid

import rosbag
import rosgraph
import rospy
import rostest
from mcap_ros1.reader import read_ros1_messages
from rosbags.highlevel import AnyReader
from std_msgs.msg import String
from survey_client import LIMIT_S, SurveyClient, bits, json_traces, wait_until_connected

from gpr20_analysis.read.verification import verify_survey
from gpr20_msgs.msg import Annotation, ControlStatus, Coordinates, CurrentCoordinate
from gpr20_msgs.srv import AnnotateSurvey, MarkSurvey
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.markers import present_markers

AXIS_TOPICS = [
    *("current_coord", "axis/goal", "axis/cancel", "axis/status", "axis/result"),
    "axis_driver/description",
]
GRAPH_NODES = {
    "/x_axis/axis_driver",
    "/y_axis/axis_driver",
    "/z_axis/axis_driver",
    "/height_sensor",
    "/vna_acquisition",
    "/vna_processing",
    "/imaging",
    "/main_control",
    "/simulator",
    "/visualization",
}
# What nobody needs in a recording.
SERVICE_TOPICS = {"/x_axis/endstop", "/y_axis/endstop", "/service_status"}
IMAGING_TOPICS = {"/imaging/description", "/imaging_progress"}
STANDARD_TOPICS = {
    *("/tf", "/tf_static", "/joint_states", "/robot_description"),
    *("/b_scan", "/stops", "/survey_area"),
}
# Recorded if somebody publishes a list during the survey.
CANDIDATE_TOPICS = {"/candidates", "/candidate_markers"}
GRAPH_TOPICS = {
    *SERVICE_TOPICS,
    *STANDARD_TOPICS,
    *IMAGING_TOPICS,
    *(f"/{axis}_axis/{topic}" for axis in "xyz" for topic in AXIS_TOPICS),
    "/measured_height",
    "/trace",
    "/survey_log",
    "/survey_metadata",
    "/control_status",
    "/control_target_coordinate",
    "/control_current_coordinate",
    "/control_survey_data",
    "/survey_coverage",
    "/survey_parameters",
    "/diagnostics",
    *(f"/{node}/description" for node in ("height_sensor", "simulator", "vna_acquisition")),
    "/vna_processing/description",
    "/robot_configuration",
}
GRAPH_SERVICES = {
    *(f"/{axis}_axis/{service}" for axis in "xyz" for service in ("homing", "stop", "lease")),
    "/z_axis/set_zero",
    "/get_height",
    "/connection",
    "/freq_sweep_setup",
    "/get_freq",
    "/get_data",
    "/confirm_data",
    "/get_calibration_status",
    "/open_survey",
    "/reopen_survey",
    "/annotate_survey",
    "/mark_survey",
    "/note_survey",
    "/report_survey",
    "/list_surveys",
    "/read_survey",
    "/read_traces",
    "/store_data",
    "/close_survey",
    *("/focus_survey", "/find_candidates", "/map_hidden", "/export_survey"),
    *("/list_volumes", "/cancel_imaging"),
    "/set_survey_parameters",
    "/start_survey",
    "/pause_survey",
    "/stop_survey",
    "/resume_survey",
    "/service_move",
    "/test_analyzer",
    "/daily_check",
    "/simulator/set_fault",
}
# Of a user's own node; extra_topic/storage.yaml names it.
OWN_TOPIC = "/soil_probe/moisture"
NUMBERS = ("frequency_hz", "s21_real", "s21_imag")
# Of two clients; the evidence has more: docs/evidence/reliability.md.
ROUNDS = int(os.environ.get("GPR20_ROUNDS", "3"))
SCALARS = ("index", "x_coord_mm", "y_coord_mm", "z_coord_deg", "antennae_height_m")


class WholeSurveyTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("whole_survey_rostest")
        cls.client = SurveyClient()
        cls.own_topic = rospy.Publisher(OWN_TOPIC, String, queue_size=1, latch=True)
        cls.own_topic.publish("moist")
        cls.state = open_shared_state(shared_state_path("/"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def true_steps(self):
        return [self.state.steps(axis) for axis in AxisId]

    def assert_same_numbers(self, stored, message):
        for name in SCALARS:
            self.assertEqual(stored[name], getattr(message, name))
        for name in NUMBERS:
            self.assertEqual(bits(stored[name]), bits(list(getattr(message, name))))
        for name in ("survey_id", "sample_id", "format", "quality"):
            self.assertEqual(stored[name], getattr(message, name))

    def test_1_wrong_parameters_are_refused_with_their_limits_and_nothing_moves(self):
        before = self.true_steps()
        refusals = [
            ({"x_start_mm": math.nan}, "x start is nan mm; it must lie between 0 and 650 mm"),
            ({"start_frequency_hz": 6.0e9}, "must be below the stop frequency, 6000000000 Hz"),
            ({"x_points": 2}, "x points is 2; it must be at least 3"),
            ({"y_points": 2}, "y points is 2; it must be at least 3"),
            ({"x_stop_mm": 700.0}, "x stop is 700 mm; it must lie between 0 and 650 mm"),
            ({"y_stop_mm": 801.0}, "y stop is 801 mm; it must lie between 0 and 800 mm"),
            ({"frequency_points": 4001}, "4001; it must lie between 2 and 4000"),
            ({"vna_address": "192.168.1"}, "'192.168.1'; it must be four numbers"),
        ]
        for change, message in refusals:
            answer = self.client.set(**change)
            self.assertFalse(answer.success)
            self.assertIn(message, answer.message)
        self.assertFalse(self.client.start().success)
        self.assertEqual(self.true_steps(), before)

    def test_2_an_odd_number_of_columns(self):
        self.check_survey(x_points=3)

    def test_3_an_even_number_of_columns(self):
        self.check_survey(x_points=4, x_stop_mm=25.0)

    def check_survey(self, **changes):
        survey_id, status = self.client.run_to_end(**changes)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertTrue(status.simulated)
        folder = self.client.folder(survey_id)
        self.assertIn(str(folder), status.message)
        stored = json_traces(folder)
        self.check_points(stored, changes["x_points"], changes.get("x_stop_mm", 20.0))
        self.check_recordings(folder, stored)
        self.check_metadata(folder, survey_id, len(stored))
        self.client.wait(lambda: self.client.progress[-1].completion_percent == 100.0)
        self.assertEqual(self.client.progress[-1].remaining_points, 0)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            recorded = set(bag.get_type_and_topic_info().topics)
        # Nothing is cancelled in a survey that runs to its end.
        if changes["x_points"] == 3:
            # Of the first survey after the launch a topic's connection may still be missing.
            return
        commands = {f"/{axis}_axis/axis/{one}" for axis in "xyz" for one in ("goal", "cancel")}
        self.assertEqual(GRAPH_TOPICS - recorded, commands | SERVICE_TOPICS | IMAGING_TOPICS)
        self.assertIn(OWN_TOPIC, recorded)
        # Playing a recording beside a robot must not move it.
        self.assertFalse(recorded & commands)
        self.assertLessEqual({f"/{axis}_axis/axis/goal_recorded" for axis in "xyz"}, recorded)

    def check_points(self, stored, x_points, x_stop_mm):
        spacing_mm = (x_stop_mm - 10.0) / (x_points - 1)
        planned = {
            (10.0 + spacing_mm * column, 10.0 + 5.0 * row, z)
            for column in range(x_points)
            for row in range(3)
            for z in (0.0, 90.0)
        }
        visited = [(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored]
        self.assertEqual(len(visited), len(planned))
        self.assertEqual(set(visited), planned)
        for one in stored:
            self.assertEqual(len(one["s21_real"]), 51)
            # A trap of earlier software: the imaginary part was a copy of the real one.
            self.assertNotEqual(one["s21_real"], one["s21_imag"])
            self.assertAlmostEqual(one["antennae_height_m"], 0.20, delta=0.01)

    def check_recordings(self, folder, stored):
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            traces = [message for _topic, message, _time in bag.read_messages(["/trace"])]
            topics = set(bag.get_type_and_topic_info().topics)
        self.assertEqual(len(traces), len(stored))
        for one, message in zip(stored, sorted(traces, key=lambda trace: trace.index)):
            self.assert_same_numbers(one, message)
        self.assertLessEqual({"/trace", "/control_status", "/survey_metadata"}, topics)
        recorded = read_ros1_messages(str(folder / "survey.mcap"), topics=["/trace"])
        traces = sorted((one.ros_msg for one in recorded), key=lambda trace: trace.index)
        self.assertEqual(len(traces), len(stored))
        for one, message in zip(stored, traces):
            self.assert_same_numbers(one, message)
        with AnyReader([folder / "survey.bag"]) as reader:
            connections = [one for one in reader.connections if one.topic == "/trace"]
            traces = [
                reader.deserialize(raw, connection.msgtype)
                for connection, _time, raw in reader.messages(connections)
            ]
        self.assertEqual(len(traces), len(stored))
        for one, message in zip(stored, sorted(traces, key=lambda trace: trace.index)):
            self.assert_same_numbers(one, message)
        info = subprocess.run(
            ["rosbag", "info", str(folder / "survey.bag")],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        self.assertRegex(info, rf"/trace +{len(stored)} msgs +: gpr20_msgs/Trace")

    def check_metadata(self, folder, survey_id, traces):
        metadata = json.loads((folder / "survey.json").read_text())
        text = json.dumps(metadata)
        self.assertIn(survey_id, text)
        self.assertIn("Anritsu,MS2026C/2,SIMULATED", text)
        self.assertIs(metadata["simulated"], True)
        self.assertEqual(metadata["outcome"], "finished")
        self.assertEqual(metadata["stored_traces"], traces)

    def test_4_the_graph_during_a_survey_is_the_documented_one(self):
        targets, currents = [], []
        subscribers = [
            rospy.Subscriber("control_target_coordinate", Coordinates, targets.append),
            rospy.Subscriber("control_current_coordinate", Coordinates, currents.append),
        ]
        wait_until_connected(subscribers)
        self.client.begin()
        self.client.wait_for_status(ControlStatus.SURVEYING)
        state = rosgraph.Master(rospy.get_name()).getSystemState()
        listed = {
            command: set(subprocess.check_output([command, "list"], text=True).split())
            for command in ("rosnode", "rostopic", "rosservice")
        }
        self.client.wait_for_status(ControlStatus.FINISHED)
        own = {rospy.get_name(), "/rosout"}
        self.assertEqual(listed["rosnode"] - own, GRAPH_NODES)
        topics = {topic for topic in listed["rostopic"] if not topic.startswith("/rosout")}
        topics.remove(OWN_TOPIC)
        self.assertLessEqual(CANDIDATE_TOPICS, topics)
        topics -= CANDIDATE_TOPICS
        self.assertEqual(topics - {f"/{axis}_axis/axis/feedback" for axis in "xyz"}, GRAPH_TOPICS)
        loggers = ("/get_loggers", "/set_logger_level")
        services = {one for one in listed["rosservice"] if not one.endswith(loggers)}
        self.assertEqual(services, GRAPH_SERVICES)
        published = {topic for topic, _nodes in state[0]}
        self.assertLessEqual(GRAPH_TOPICS, published)
        self.assertTrue({(t.x_mm, t.y_mm, t.z_deg) for t in targets} >= {(20.0, 20.0, 90.0)})
        self.client.wait(lambda: targets[-1].x_mm == targets[-1].y_mm == targets[-1].z_deg == -1)
        self.assertTrue(any(current.x_mm > 10.0 for current in currents))
        for subscriber in subscribers:
            subscriber.unregister()

    def test_4b_an_annotation_is_stored_at_the_start_and_changed_during_and_after_it(self):
        annotate = rospy.ServiceProxy("annotate_survey", AnnotateSurvey)
        wrong = Annotation(has_position=True, latitude_deg=91.0)
        refused = self.client.start(annotation=wrong)
        self.assertFalse(refused.success)
        self.assertIn("latitude is 91 deg; it must lie between -90 and 90", refused.message)
        refused = self.client.start(permittivity=101.0)
        self.assertFalse(refused.success)
        self.assertIn("the permittivity is 101; it must lie between 1 and 100", refused.message)
        at_start = Annotation(operator="Lucía Peña", site="El Carmen", notes="dry\nsoil")
        survey_id = self.client.begin(at_start, x_stop_mm=300.0)
        self.client.wait_for_visited(1)
        folder = self.client.folder(survey_id)
        self.assertEqual(self.annotation(folder)["operator"], "Lucía Peña")
        self.assertEqual(json.loads((folder / "survey.json").read_text())["permittivity"], 4.0)
        self.assertIsNone(self.annotation(folder)["position"])
        later = Annotation(
            operator="Lucía Peña", notes="wet", has_position=True, latitude_deg=4.60283,
            longitude_deg=-74.06514,
        )  # fmt: skip
        answer = annotate("", later)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual((answer.survey_id, answer.path), (survey_id, str(folder)))
        self.client.wait_for_status(ControlStatus.FINISHED)
        expected = {
            "operator": "Lucía Peña",
            "site": "",
            "notes": "wet",
            "position": {"latitude_deg": 4.60283, "longitude_deg": -74.06514},
        }
        self.assertEqual(self.annotation(folder), expected)
        self.assertFalse(annotate("", later).success)
        for name, notes in ((survey_id, "closed"), (folder.name, "again")):
            later.notes = notes
            answer = annotate(name, later)
            self.assertTrue(answer.success, answer.message)
            self.assertEqual(self.annotation(folder), {**expected, "notes": notes})
            found = verify_survey(folder)
            self.assertEqual((found.status, found.faults), (0, []))
        self.assertIn("complete and intact", str(found.verdict))

    def test_4c_markers_are_stored_during_and_after_a_survey_that_refines_another(self):
        mark = rospy.ServiceProxy("mark_survey", MarkSurvey)
        coarse = str(uuid.uuid4())
        self.assertFalse(self.client.start(refines="../x").success)
        survey_id = self.client.begin(refines=coarse, x_stop_mm=300.0)
        self.client.wait_for_visited(1)
        folder = self.client.folder(survey_id)
        first, second = str(uuid.uuid4()), str(uuid.uuid4())
        place = {"x_mm": 12.5, "y_mm": 15.0, "has_depth": True, "depth_mm": 80.0}
        answer = mark(marker_id=first, text="metal", author="Lucía Peña", **place)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual((answer.survey_id, answer.path), (survey_id, str(folder)))
        description = json.loads((folder / "survey.json").read_text())
        self.assertEqual(description["refines"], coarse)
        self.assertEqual(json.loads(answer.markers_json), description["markers"])
        self.client.wait_for_status(ControlStatus.FINISHED)
        self.assertTrue(mark(survey=survey_id, marker_id=second, **place).success)
        self.assertTrue(mark(survey=folder.name, marker_id=first, remove=True).success)
        present = present_markers(json.loads((folder / "survey.json").read_text()))
        self.assertEqual([one.marker_id for one in present], [second])
        found = verify_survey(folder)
        self.assertEqual((found.status, found.faults), (0, []))
        refused = mark(survey=survey_id, marker_id=str(uuid.uuid4()), x_mm=float("nan"))
        self.assertFalse(refused.success)
        self.assertIn("X is nan mm", refused.message)

    def annotation(self, folder):
        return json.loads((folder / "survey.json").read_text())["annotation"]

    def test_5_a_stop_ends_the_survey_and_the_motion_and_keeps_what_was_measured(self):
        survey_id = self.client.begin(x_stop_mm=600.0)
        self.client.wait_for_visited(2)
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        steps = self.true_steps()
        resting = rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate, LIMIT_S)
        self.assertFalse(resting.moving)
        self.assertEqual(round(resting.coordinate * 100), steps[0])
        folder = self.client.folder(survey_id)
        stored = json_traces(folder)
        self.assertGreaterEqual(len(stored), 2)
        self.assertLess(len(stored), 18)
        self.assertIn(f"{len(stored)} of 18 traces", status.message)
        self.check_recordings(folder, stored)
        metadata = json.loads((folder / "survey.json").read_text())
        self.assertEqual(metadata["outcome"], "stopped")
        self.assertFalse(self.client.stop().success)

    def test_6_an_instrument_that_is_not_there_fails_the_survey_before_anything_moves(self):
        before = self.true_steps()
        _survey_id, status = self.client.run_to_end(vna_address="127.0.0.77")
        self.assertEqual(status.code, ControlStatus.FAILED)
        self.assertIn("127.0.0.77", status.message)
        self.assertEqual(self.true_steps(), before)

    def test_7_of_two_clients_none_measures_the_plan_of_the_other(self):
        for number in range(ROUNDS):
            together, started = threading.Barrier(2), {}

            def ask(x_start_mm, together=together, started=started):
                together.wait(LIMIT_S)
                plan = self.client.set(x_start_mm=x_start_mm)
                answer = self.client.start(plan_id=plan.plan_id) if plan.success else plan
                if answer.success:
                    started[answer.survey_id] = plan.plan_id, x_start_mm

            places_mm = (0.01 * number, 5.0 + 0.01 * number)
            clients = [threading.Thread(target=ask, args=(place,)) for place in places_mm]
            for one in clients:
                one.start()
            for one in clients:
                one.join(LIMIT_S)
            ((self.client.survey_id, (plan_id, x_start_mm)),) = started.items()
            self.client.wait_for_visited(1)
            self.assertTrue(self.client.stop().success)
            status = self.client.wait_for_status(ControlStatus.STOPPED)
            own = (plan_id, rospy.get_name())
            self.assertEqual((status.plan_id, status.plan_set_by), own)
            folder = self.client.folder(self.client.survey_id)
            description = json.loads((folder / "survey.json").read_text())
            self.assertEqual((description["plan_id"], description["plan_set_by"]), own)
            self.assertAlmostEqual(json_traces(folder)[0]["x_coord_mm"], x_start_mm, 6)
            self.client.forget()


if __name__ == "__main__":
    rostest.rosrun("gpr20", "whole_survey", WholeSurveyTest)
