"""Faults of robot and analyzer: what the operator reads, and that the survey continues.

A survey that meets a fault pauses; nothing wrong is stored; once the fault is gone it ends
with every point exactly once.
"""

from __future__ import annotations

import numpy as np
import pytest
from robot_in_process import (
    check_acknowledged,
    check_complete,
    check_pause,
    check_resumed,
    check_state,
)
from simulated_world import STEP_MM

from gpr20_simulator.mid.analyzer.simulated_analyzer import CONNECT
from gpr20_simulator.mid.world.medium import probed_sweep
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep import AnalyzerSettings

FAR_MM = 600.0
OWN = AnalyzerSettings(10_000.0, 1, "HIGH")
# Changes by hand, and what they change.
HANDS = {
    "HAND_BANDWIDTH": "the IF bandwidth",
    "HAND_AVERAGES": "the number of averages",
    "HAND_POWER": "the output power",
    "HAND_START": "the start frequency",
}


def test_an_endstop_that_closes_in_a_move_and_stays_closed_at_homing(world, robot):
    # The second row leads towards the endstop of x.
    robot.calls.at("sweep", 8, lambda: world.fault("STUCK_CLOSED", device="endstop_x"))
    robot.begin(x_stop_mm=FAR_MM)
    check_pause(robot, "axis.endstop")
    robot.go_on()
    check_pause(robot, "axis.endstop")
    world.fault("NONE", device="endstop_x")
    check_resumed(robot)
    # The axis has its zero back: it is where it reports to be.
    assert world.state.steps(AxisId.X) == round(FAR_MM / STEP_MM)


@pytest.mark.parametrize(
    "device, fault, code, values",
    [
        ("vna", "HANG", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "DROP", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "SILENT", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "LATE", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "TRUNCATE", "vna.failed", []),
        ("vna", "NAN", "vna.failed", []),
        ("vna", "GARBAGE", "vna.wrong_instrument", ["MS2026C"]),
        ("vna", "STALE", "vna.failed", []),
        ("vna", "ENDLESS_DIGITS", "vna.failed", []),
        ("adc", "STUCK", "sensor.failed", []),
        ("adc", "OUT_OF_RANGE", "height.no_ground", ["0.1", "0.8"]),
    ],
    ids=str,
)
def test_a_fault_pauses_the_survey_and_once_it_is_gone_the_survey_ends_complete(
    world, robot, device, fault, code, values
):
    robot.calls.at("sweep", 4, lambda: world.fault(fault, device=device))
    robot.begin()
    check_pause(robot, code, *values)
    world.fault("NONE", device=device)
    check_resumed(robot)


def bits(values):
    return np.array(values, np.float64).tobytes()


def sent_values(block):
    """Return the complex values of a captured data block, read without the driver's parser."""
    digits = int(block[1:2])
    length = int(block[2 : 2 + digits])
    numbers = np.frombuffer(block[2 + digits : 2 + digits + length], dtype="<f4")
    return bits(numbers[0::2]), bits(numbers[1::2])


def test_every_trace_is_one_sweep_made_at_its_own_place_and_stored_bit_for_bit(world, robot):
    # It has been sweeping by itself since it was switched on.
    world.time.sleep_until_s(world.time.now_s() + 20.0)
    begun = world.vna.sweeper.sweep_number
    assert begun > 10
    robot.begin()
    stored = finish(robot)
    sweeps = [probed_sweep(one["s21_real"][0] + 0j) for one in stored]
    assert sweeps == sorted(sweeps) and sweeps[0] > begun
    sent = set(map(sent_values, world.vna.sent["sdat"]))
    assert {(bits(one["s21_real"]), bits(one["s21_imag"])) for one in stored} <= sent
    check_acknowledged(robot, world.acknowledged)


def finish(robot):
    """Wait for the end of a survey that never pauses; return its traces, checked."""
    check_state(robot, SurveyState.FINISHED)
    assert not [one for one in robot.history if one.state is SurveyState.PAUSED]
    stored = check_complete(robot)
    for one in stored:
        assert AnalyzerSettings(*(one[name] for name in vars(OWN))) == OWN
    return stored


def test_a_hand_at_the_front_panel_makes_the_robot_go_back(world, robot):
    for number, fault in enumerate(HANDS):
        robot.calls.at("sweep", 3 + 3 * number, lambda fault=fault: world.fault(fault, count=1))
    robot.begin()
    finish(robot)
    changed = [
        str(one.full_message)
        for one in robot.history
        if one.full_message.fault_code == "vna.settings"
    ]
    for fault, setting in HANDS.items():
        assert [one for one in changed if setting in one], f"{fault}: nobody was informed"


@pytest.mark.parametrize("outage_s", [2, 20])
def test_a_link_that_is_lost_for_half_the_limit_is_waited_for(world, robot, outage_s):
    robot.calls.at("sweep", 4, lambda: world.fault("LINK_GONE", count=outage_s))
    said = "survey.takes_long"

    def look(message):
        if message == CONNECT and not world.vna.instrument.is_reachable() and outage_s > 2:
            # While the link is gone, the control says what it waits for.
            robot.clock.more_s += 1.0
            robot.wait(lambda: robot.clock.more_s < 5.0 or said in codes(robot))

    robot.begin()
    world.vna.on_message = look
    finish(robot)
    assert (said in codes(robot)) == (outage_s > 2)


def codes(robot):
    """Return the faults that the control has said since the survey began."""
    return [one.full_message.fault_code for one in robot.history]
