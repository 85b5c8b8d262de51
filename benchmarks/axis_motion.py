"""How exactly the axes move: time of moves, lateness of pulses, steps lost, time of a stop.

Run with: scripts/bench.sh axis_motion [--part moves|steps|stops] [--quick]
The results are in docs/motion.md.
"""

from __future__ import annotations

import argparse
import random
import statistics
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, List

import actionlib
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from robot_kit import simulated_robot

from gpr20_axis_driver.axis_exceptions import MotionStopped
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_client import PulseClient
from gpr20_msgs.msg import AxisAction, AxisGoal, ControlStatus, CurrentCoordinate, SurveyParameters
from gpr20_msgs.srv import Command, SetSurveyParameters, StartSurvey
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import SharedState, open_shared_state
from gpr20_simulator.mid.axis_hardware import SimulatedHardware
from gpr20_simulator.mid.scene import X_AXIS
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.axes.ramp import Ramp

LIMIT_S = 120.0
X = AxisParameters(13, 15, 0.01, 0.0015, 0.0050, 0.0001, 0.0, 650.0, "LIN", 16)
Y = AxisParameters(37, 38, 0.01, 0.0025, 0.0050, 0.0001, 0.0, 800.0, "LIN", 40)
SURVEY = {
    "vna_address": "127.0.0.1",
    "start_frequency_hz": 600.0e6,
    "stop_frequency_hz": 6.0e9,
    "frequency_points": 51,
    "x_points": 3,
    "y_points": 3,
    "polarizations_deg": [0.0, 90.0],
}


def ramp_of(parameters: AxisParameters) -> Ramp:
    return Ramp(parameters.min_step, parameters.max_step, parameters.delta_step)


def braking_s(parameters: AxisParameters) -> float:
    """How long the axis needs from its top speed to its slowest [s]."""
    ramp = ramp_of(parameters)
    return ramp.duration_s(2 * ramp.braking_steps(ramp.min_pause_s)) / 2.0


class XAxis:
    """The x axis as a client sees it, with the truth beside it."""

    def __init__(self) -> None:
        self.client = actionlib.SimpleActionClient("x_axis/axis", AxisAction)
        assert self.client.wait_for_server(rospy.Duration(LIMIT_S))
        self.state: SharedState = open_shared_state(shared_state_path("/"))
        self._changed = threading.Condition()
        self._readings = 0
        self._values: dict = {}
        self._subscribers = [
            rospy.Subscriber("x_axis/current_coord", CurrentCoordinate, self._count),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._keep),
        ]

    def home(self) -> None:
        """Find the zero."""
        rospy.wait_for_service("x_axis/homing", LIMIT_S)
        response = rospy.ServiceProxy("x_axis/homing", Command)()
        assert response.success, response.message

    def move(self, target_mm: float) -> float:
        """Move and return the client's waiting time [s]."""
        begin_s = time.monotonic()
        self.client.send_goal(AxisGoal(target_coordinate=target_mm))
        while not self.ended():
            assert time.monotonic() - begin_s < LIMIT_S, "the goal never ended"
            time.sleep(0.001)
        waited_s = time.monotonic() - begin_s
        result = self.client.gh.get_result()
        assert result.success, result.message
        return waited_s

    def ended(self) -> bool:
        """Whether the last goal has ended.

        Not by wait_for_result: SimpleActionClient loses a result that comes before it has kept
        the goal's handle, and would wait for ever.
        """
        return self.client.gh.get_comm_state() == actionlib.CommState.DONE

    def last_motion(self) -> dict:
        """What the node reports of the motion that has just ended."""
        with self._changed:
            self._values = {}
            # The report after the next one surely began after now.
            for _ in range(2):
                self._values = {}
                assert self._changed.wait_for(lambda: self._values, LIMIT_S)
            return self._values

    @property
    def readings(self) -> int:
        """How many coordinates the node has published."""
        return self._readings

    def _count(self, _message: CurrentCoordinate) -> None:
        self._readings += 1

    def _keep(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith("x_axis/axis_driver"):
                with self._changed:
                    self._values = {one.key: one.value for one in status.values}
                    self._changed.notify_all()


def measure_moves(x: XAxis, quick: bool) -> None:
    print(f"pulses: {x.last_motion()['pulses']}")
    print(
        "| move mm | n | ideal s | pulses / ideal: median, max | client / ideal: median "
        "| median us | 99 % us | max us | slowed | Hz |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    for distance_mm, repeats in (
        ((1, 2), (10, 2), (100, 1)) if quick else ((1, 20), (10, 8), (100, 3))
    ):
        ideal_s = ramp_of(X).duration_s(X.distance_steps(distance_mm))
        rows, waits, rates = [], [], []
        position_mm = 0.0
        for _ in range(repeats):
            target_mm = (
                position_mm + distance_mm if position_mm < 100.0 else position_mm - distance_mm
            )
            readings, begin_s = x.readings, time.monotonic()
            waits.append(x.move(target_mm))
            rates.append((x.readings - readings) / (time.monotonic() - begin_s))
            rows.append(x.last_motion())
            position_mm = target_mm
        x.move(0.0)
        ratios = sorted(float(row["last motion [s]"]) / ideal_s for row in rows)
        print(
            f"| {distance_mm} | {repeats} | {ideal_s:.3f} | {statistics.median(ratios):.5f}, "
            f"{ratios[-1]:.5f} | {statistics.median(waits) / ideal_s:.4f} | "
            f"{median(rows, 'lateness median [us]')} | "
            f"{worst(rows, 'lateness 99 % [us]')} | {worst(rows, 'lateness max [us]')} | "
            f"{worst(rows, 'edges that slowed it down')} | {statistics.mean(rates):.1f} |"
        )


def median(rows: List[dict], key: str) -> int:
    return round(statistics.median(int(row[key]) for row in rows))


def worst(rows: List[dict], key: str) -> int:
    return max(int(row[key]) for row in rows)


def stop_after(limit_s: float) -> Callable[[], bool]:
    """Return a question that is answered with yes once this time has passed [s]."""
    deadline_s = time.monotonic() + limit_s
    return lambda: time.monotonic() > deadline_s


def measure_steps(quick: bool) -> None:
    """Compare the commanded and the simulated carriage over random moves and stops."""
    moves = 500 if quick else 10_000
    chance = random.Random(1)
    stopped = wrong = 0
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        path = Path(folder) / "state"
        state = open_shared_state(path, {AxisId.X: 800})
        pulses = PulseClient(SimulatedHardware(X, path, AxisId.X, X_AXIS, 200.0, None))
        driver = AxisDriver(X, pulses)
        driver.homing()
        begin_s = time.monotonic()
        for _ in range(moves):
            target_mm = chance.randrange(0, 2001) / 100
            try:
                driver.move_to_coordinate(target_mm, stop_after(chance.uniform(0.0, 0.02)))
            except MotionStopped:
                stopped += 1
            else:
                wrong += driver.current_coord != target_mm
            wrong += round(driver.current_coord * 100) != state.steps(AxisId.X)
        took_s = time.monotonic() - begin_s
        pulses.close()
    print(f"{moves} random moves, {stopped} of them stopped: {wrong} wrong, {took_s:.0f} s")


def show(name: str, times_s: List[float], ramp_s: float) -> None:
    ordered = sorted(time_s * 1e3 for time_s in times_s)
    last = len(ordered) - 1
    print(
        f"| {name} | {len(ordered)} | {ordered[0]:.0f} | {ordered[last // 2]:.0f} | "
        f"{ordered[round(0.9 * last)]:.0f} | {ordered[last]:.0f} | {ramp_s * 1e3:.0f} |"
    )


def measure_stops(x: XAxis, quick: bool) -> None:
    count = 3 if quick else 30
    chance = random.Random(2)
    print("| stopped by | n | min ms | median ms | 90 % ms | max ms | ramp from top speed ms |")
    print("|---|---|---|---|---|---|---|")
    cancels = [cancelled_move(x, chance) for _ in range(count)]
    show("cancelled goal (x)", cancels, braking_s(X))
    control = Control()
    stops = [stopped_survey(x, control, chance, place) for place in range(count)]
    show("stop_survey (x, y)", stops, max(braking_s(X), braking_s(Y)))


def last_pulse_after(x: XAxis, request: Callable[[], object], resting: Callable[[], bool]) -> float:
    """Request a stop; return the time from the request to the last pulse of any axis [s]."""
    requested_ns = time.monotonic_ns()
    request()
    deadline_s = time.monotonic() + LIMIT_S
    while not resting():
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
    last_ns = 0
    while last_ns != max(x.state.last_pulse_ns(axis) for axis in AxisId):
        last_ns = max(x.state.last_pulse_ns(axis) for axis in AxisId)
        time.sleep(0.3)
    return max(0.0, (last_ns - requested_ns) * 1e-9)


def cancelled_move(x: XAxis, chance: random.Random) -> float:
    target_mm = 0.0 if x.state.steps(AxisId.X) > 20000 else 600.0
    x.client.send_goal(AxisGoal(target_coordinate=target_mm))
    time.sleep(chance.uniform(0.5, 1.5))
    return last_pulse_after(x, x.client.cancel_goal, x.ended)


class Control:
    """The survey, begun and stopped."""

    def __init__(self) -> None:
        for name in ("set_survey_parameters", "start_survey", "stop_survey"):
            rospy.wait_for_service(name, LIMIT_S)
        self._set = rospy.ServiceProxy("set_survey_parameters", SetSurveyParameters)
        self._start = rospy.ServiceProxy("start_survey", StartSurvey)
        self.stop = rospy.ServiceProxy("stop_survey", Command)
        self.code = -1
        self._subscriber = rospy.Subscriber("control_status", ControlStatus, self._note)

    def _note(self, message: ControlStatus) -> None:
        self.code = message.code

    def begin(self, x_mm: float, y_mm: float) -> None:
        """Begin a survey whose first point is there."""
        places = {
            "x_start_mm": x_mm, "x_stop_mm": x_mm + 10.0,
            "y_start_mm": y_mm, "y_stop_mm": y_mm + 10.0,
        }  # fmt: skip
        answer = self._set(SurveyParameters(**SURVEY, **places))
        assert answer.success, answer.message
        started = self._start()
        assert started.success, started.message

    def wait_for(self, code: int) -> None:
        """Wait for a status."""
        deadline_s = time.monotonic() + LIMIT_S
        while self.code != code:
            assert time.monotonic() < deadline_s, f"status {self.code}"
            time.sleep(0.01)


def stopped_survey(x: XAxis, control: Control, chance: random.Random, place: int) -> float:
    """Stop a survey on its way to its first point."""
    control.begin(*((600.0, 600.0) if place % 2 == 0 else (5.0, 5.0)))
    control.wait_for(ControlStatus.SURVEYING)
    steps = [x.state.steps(axis) for axis in (AxisId.X, AxisId.Y)]
    while any(x.state.steps(a) == s for a, s in zip((AxisId.X, AxisId.Y), steps)):
        time.sleep(0.01)
    time.sleep(chance.uniform(0.5, 1.5))
    return last_pulse_after(x, control.stop, lambda: control.code == ControlStatus.STOPPED)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--part", choices=("moves", "steps", "stops"), help="only this one")
    options.add_argument("--quick", action="store_true", help="few repetitions, to try it out")
    arguments = options.parse_args()
    parts = [arguments.part] if arguments.part else ["moves", "steps", "stops"]
    if "steps" in parts:
        measure_steps(arguments.quick)
    if parts == ["steps"]:
        return
    with simulated_robot():
        rospy.init_node("axis_motion_benchmark", disable_signals=True)
        x = XAxis()
        x.home()
        if "moves" in parts:
            measure_moves(x, arguments.quick)
        if "stops" in parts:
            measure_stops(x, arguments.quick)
        rospy.signal_shutdown("measured")


if __name__ == "__main__":
    main()
