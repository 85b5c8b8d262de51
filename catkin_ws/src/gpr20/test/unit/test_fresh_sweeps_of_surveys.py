"""No trace can hold a sweep that began before the antennas stood still."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from stored_surveys import check_acknowledged, check_complete, check_state

from gpr20_survey.plan.survey_state import SurveyState


def sent_values(block):
    """Return the complex values of a captured data block, read without the driver's parser."""
    digits = int(block[1:2])
    length = int(block[2 : 2 + digits])
    numbers = np.frombuffer(block[2 + digits : 2 + digits + length], dtype="<f4")
    return numbers.astype(np.float64)


def bits(values):
    return np.array(values, np.float64).tobytes()


def test_every_trace_is_one_sweep_made_at_its_own_place_and_stored_bit_for_bit(world, robot):
    # It has been sweeping by itself since it was switched on.
    world.time.sleep_until_s(world.time.now_s() + 5.0)
    begun = world.sweeper.sweep_number
    assert begun > 10
    robot.begin()
    check_state(robot, SurveyState.FINISHED)
    stored = check_complete(robot)
    assert stored[0]["s21_real"][0] > begun
    sweeps = [one["s21_real"][0] for one in stored]
    assert sweeps == sorted(sweeps)
    sent = {
        (bits(numbers[0::2]), bits(numbers[1::2]))
        for numbers in map(sent_values, world.sent["sdat"])
    }
    assert {(bits(one["s21_real"]), bits(one["s21_imag"])) for one in stored} <= sent
    check_acknowledged(robot, world.acknowledged)


@pytest.mark.parametrize("messages", [7, 40, 101])
def test_an_instrument_that_is_switched_back_to_continuous_sweeps_changes_nothing(
    world, robot, messages
):
    counted = []

    def press(message):
        counted.append(message)
        if len(counted) % messages == 0:
            world.instrument.execute(b":INIT:CONT ON")

    robot.calls.at("sweep", 1, lambda: setattr(world, "on_message", press))
    robot.begin()
    if robot.wait_for_end().state is SurveyState.PAUSED:
        # Pressed so often that no attempt succeeds, the key is let go.
        world.on_message = lambda _message: None
        robot.go_on()
    check_state(robot, SurveyState.FINISHED)
    assert len(counted) > 2 * messages
    sweeps = [one["s21_real"][0] for one in check_complete(robot)]
    assert sweeps == sorted(sweeps)


def test_the_robot_in_one_process_needs_no_ros():
    asked = (
        "import sys, stored_surveys; print([one for one in sys.modules if "
        "one.split('.')[0] in ('rospy', 'rosgraph', 'genpy', 'actionlib', 'gpr20_msgs')])"
    )
    environment = {"PYTHONPATH": ":".join(filter(None, sys.path))}
    found = subprocess.run(
        [sys.executable, "-c", asked], env=environment, stdout=subprocess.PIPE, check=True
    )
    assert found.stdout.strip() == b"[]"
