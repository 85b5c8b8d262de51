"""An analyzer that is less kind than its manual: what is read, what is stored, how it ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from simulated_world import World
from stored_surveys import (
    check_acknowledged,
    check_complete,
    check_state,
    description_in,
    json_traces,
)

from gpr20_simulator.mid.analyzer.in_process import CONNECT
from gpr20_simulator.mid.world.medium import probed_sweep
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

OWN = AnalyzerSettings(10_000.0, 1, "HIGH")
# Changes by hand, and what they change.
HANDS = {
    "HAND_BANDWIDTH": "the IF bandwidth",
    "HAND_AVERAGES": "the number of averages",
    "HAND_POWER": "the output power",
    "HAND_START": "the start frequency",
}
POINTS, SLOW_POINT_S = 51, 0.01


@pytest.fixture
def world(tmp_path):
    # A sweep of slow points takes longer than the bit of the sweep before stays set.
    return World(tmp_path, late_bit_s=0.3, late_memory_s=0.9, slow_point_s=SLOW_POINT_S)


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


@pytest.mark.parametrize("messages", [7, 40, 101])
def test_an_instrument_that_is_switched_back_to_continuous_sweeps_changes_nothing(
    world, robot, messages
):
    counted = []

    def press(message):
        counted.append(message)
        if len(counted) % messages == 0:
            world.vna.instrument.execute(b":INIT:CONT ON")

    robot.calls.at("sweep", 1, lambda: setattr(world.vna, "on_message", press))
    robot.begin()
    if robot.wait_for_end().state is SurveyState.PAUSED:
        # Pressed so often that no attempt succeeds, the key is let go.
        world.vna.on_message = lambda _message: None
        robot.go_on()
    check_state(robot, SurveyState.FINISHED)
    assert len(counted) > 2 * messages
    sweeps = [one["s21_real"][0] for one in check_complete(robot)]
    assert sweeps == sorted(sweeps)


def finish(robot, settings=OWN):
    """Wait for the end of a survey that never pauses; return its traces, checked."""
    check_state(robot, SurveyState.FINISHED)
    assert not [one for one in robot.history if one.state is SurveyState.PAUSED]
    stored = check_complete(robot)
    for one in stored:
        assert AnalyzerSettings(*(one[name] for name in vars(settings))) == settings
    return stored


@pytest.mark.parametrize("slow", [("LATE_BIT", "SLOW_POINTS"), ("LATE_MEMORY",)], ids="/".join)
@pytest.mark.parametrize("from_sweep", [0, 4], ids=["from the start", "during the survey"])
def test_a_bit_or_display_that_is_late_gives_fresh_sweeps(world, robot, slow, from_sweep):
    if from_sweep:
        robot.calls.at("sweep", from_sweep, lambda: world.fault(*slow))
    else:
        world.fault(*slow)
    robot.begin()
    finish(robot)
    if "SLOW_POINTS" in slow and not from_sweep:
        # Its duration is learned. A bit of the sweep before, believed, would end it too early.
        lasted_us = [one.sweep_ended_us - one.sweep_started_us for one in world.acknowledged]
        assert min(lasted_us) > POINTS * SLOW_POINT_S * 1e6


def test_slow_and_averaged_sweeps_are_whole_and_the_next_survey_sets_everything_back(robot):
    averaged = replace(OWN, averages=4)
    for wanted in (AnalyzerSettings(20.0, 1, "LOW"), averaged, OWN):
        survey_id = robot.begin(**vars(wanted))
        if wanted is averaged:
            # The numbers of a sweep are no longer those of one place.
            check_state(robot, SurveyState.FINISHED)
            stored = json_traces(robot)
            assert [one["averages"] for one in stored] == [4] * 18
        else:
            stored = finish(robot, wanted)
        assert {len(one["s21_real"]) for one in stored} == {51}
        parameters = description_in(robot, survey_id)["parameters"]
        assert {name: parameters[name] for name in vars(wanted)} == vars(wanted)


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
