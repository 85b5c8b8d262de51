"""Plans of surveys and sweeps over a ground that is known, for the tests of map and radar."""

import dataclasses
import json
import math

import numpy as np
from survey_examples import AXES, PARAMETERS, TRAVEL

from gpr20_common.faults import DISK_FULL, MAY_MOVE
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.grid import planned_grid
from gpr20_operator.ground.sources import EchoSource
from gpr20_operator.robot.events import Configured, ControlState
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CLOCK_WRONG, COMPLETE
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.radar import delay_of_depth
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import Trace, TraceBlock

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
# Another survey, which is stored.
PAST = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
FOLDER = "20261121T051000_7c9e6679"
FREQUENCY_HZ = np.linspace(0.6e9, 6.0e9, 501)
NOW_US = 1_795_000_000_000_000
# Why a survey pauses or ends.
FULL = Message("the disk is full", details="errno 28").with_fault(
    Fault("disk.full", DISK_FULL.remedy)
)
MOVING = Message("a motor runs").with_fault(Fault("robot.may_move", MAY_MOVE.remedy, may_move=True))
ASKED_PAUSE = ASKED_STOP = Message("asked for").with_fault(
    Fault("survey.can_resume", severity=Severity.NOTE)
)
LOST = Message("lost").with_fault(Fault("survey.lost", COMPLETE.remedy, can_continue=False))
CLOCK = Message("the clock is late").with_fault(Fault("clock.late", CLOCK_WRONG.remedy))
PAUSED = "Paused: {reason}. Fix the fault and resume, or stop."
# Whenever STOP is pressed, they have said so after it.
RESTING = tuple(AxisReport(axis, 0.0, True, False, "", math.inf) for axis in AxisId)


def moving(*axes, owner=""):
    return tuple(AxisReport(axis, 0.0, True, axis in axes, owner, math.inf) for axis in AxisId)


def make_grid(
    x_points=5, y_points=4, rotations_deg=(0.0, 90.0), survey_id=SURVEY, permittivity=4.0, **changes
):
    """Return the grid of a survey with which a permittivity is stored, unless it is None."""
    values = {
        "frequency_points": 501,
        "x_start_mm": 100.0,
        "x_stop_mm": 200.0,
        "x_points": x_points,
        "y_start_mm": 50.0,
        "y_stop_mm": 110.0,
        "y_points": y_points,
        "polarizations_deg": tuple(rotations_deg),
    }
    parameters = dataclasses.replace(PARAMETERS, **{**values, **changes})
    grid = planned_grid(survey_id, True, parameters, TRAVEL)
    grid.permittivity = permittivity
    return grid


def description(**changes):
    axis = {"min_coord": 0.0, "max_coord": 650.0, "step_size": 0.01}
    turning = {"min_coord": -90.0, "max_coord": 90.0, "step_size": 1.8}
    values = {
        "survey_id": SURVEY,
        "started": "2026-11-21T05:10:00.000000+00:00",
        "simulated": True,
        "axes": {"x": axis, "y": {**axis, "max_coord": 800.0}, "z": turning},
        "parameters": {
            **make_grid().plan[0].__dict__,
            "polarizations_deg": [0.0, 90.0],
        },
    }
    return json.dumps({**values, **changes})


def noise(draw, level=1e-4):
    return level * (draw.standard_normal(501) + 1j * draw.standard_normal(501))


def depth_echo(depth_m, height_m=0.2, permittivity=4.0, level=1.0):
    delay_s = delay_of_depth(depth_m, height_m, permittivity)
    return level * np.exp(-2j * np.pi * FREQUENCY_HZ * delay_s)


def add_trace(model, trace):
    """Let a RadarModel take a trace; raise what it says against it."""
    for reason in model.add_block(TraceBlock.of(trace.survey_id, [trace])):
        raise SurveyNotReadableError(reason)


def trace_at(grid, index, s21=None, height_m=0.2, **changes):
    row, column, polarization = grid.cells(np.array(index))
    s21 = depth_echo(0.1) if s21 is None else s21
    values = {
        "survey_id": grid.survey_id,
        "index": index,
        "sample_id": f"sample-{index}",
        "timestamp_us": NOW_US,
        "x_coord_mm": float(grid.xs_mm[column]),
        "y_coord_mm": float(grid.ys_mm[row]),
        "z_coord_deg": grid.rotations_deg[int(polarization)],
        "antennae_height_m": height_m,
        "frequency_hz": FREQUENCY_HZ,
        "s21_real": np.ascontiguousarray(s21.real, np.float64),
        "s21_imag": np.ascontiguousarray(s21.imag, np.float64),
        "sweep_started_us": NOW_US - 200_000,
        "sweep_ended_us": NOW_US,
        "quality": (),
        "analyzer": AnalyzerSettings(),
    }
    return Trace(**{**values, **changes})


def b_scan(model, stop, settings):
    return EchoSource(model).section(model.grid.place_of(stop), settings)


def c_scan(model, settings):
    return EchoSource(model).slice(settings)


def state_of(code, message="as it is", survey_id="id", simulated=True):
    return ControlState(code, verbatim(message), survey_id, simulated)


def said(code, message):
    return ControlState(code, message, "id", True)


def paused(reason):
    return said(SurveyState.PAUSED, Message(PAUSED, reason=reason))


SITE = Site()


def configured(address="127.0.0.1", site=SITE):
    return Configured(RobotConfig(AXES, simulated=True), SurveySettings(), site, address)


def snapshot(code=None, alive=True, **other):
    values = {
        "control_alive": alive,
        "control_silent_s": 0.1 if alive else 7.9,
        "state": None if code is None else state_of(code),
        "robot": configured(),
        "axes": RESTING,
        **other,
    }
    return Snapshot(**values)


def past_survey(**changes):
    values = {
        "survey_id": PAST,
        "started": "2026-11-21T05:10:00.000000+00:00",
        "outcome": "stopped",
        "stored_traces": 7,
        "planned_traces": 40,
        "verdict": verbatim("INCOMPLETE: 7 of 40"),
        "simulated": True,
    }
    return SurveySummary(**{"folder": FOLDER, **values, **changes})
