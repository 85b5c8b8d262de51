"""What main_control does and refuses, and what it says of the nodes."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

CONTROL: Tuple[str, ...] = (
    # What main_control does.
    QT_TRANSLATE_NOOP("RobotText", "set the parameters of a survey"),
    QT_TRANSLATE_NOOP("RobotText", "ready for {count} traces"),
    QT_TRANSLATE_NOOP("RobotText", "checking the robot"),
    QT_TRANSLATE_NOOP("RobotText", "checking the robot before going on"),
    QT_TRANSLATE_NOOP("RobotText", "homing the axes"),
    QT_TRANSLATE_NOOP("RobotText", "measuring"),
    QT_TRANSLATE_NOOP("RobotText", "measuring point {index} again as a control"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "measured again as a control, point {index} differs by {difference} dB from the "
        "stored trace, the height by {height} mm",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "measured again as a control, point {index} differs by {difference} dB from the "
        "stored trace",
    ),
    QT_TRANSLATE_NOOP("RobotText", "pausing after this sample"),
    QT_TRANSLATE_NOOP("RobotText", "paused: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "on request"),
    QT_TRANSLATE_NOOP("RobotText", "resume when it is mended, or stop"),
    QT_TRANSLATE_NOOP("RobotText", "holding: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the survey goes on by itself when every node is back"),
    QT_TRANSLATE_NOOP("RobotText", "resuming with {pending} of {planned} traces to go"),
    QT_TRANSLATE_NOOP("RobotText", "survey {survey} was still open and is closed as interrupted"),
    QT_TRANSLATE_NOOP("RobotText", "resume_survey goes on with it later"),
    QT_TRANSLATE_NOOP("RobotText", "stopping: storing what has been measured"),
    QT_TRANSLATE_NOOP("RobotText", "stopped on request"),
    QT_TRANSLATE_NOOP("RobotText", "AN AXIS STILL MOVES: switch the motors off"),
    QT_TRANSLATE_NOOP("RobotText", "{stored} of {planned} traces in {folder}"),
    QT_TRANSLATE_NOOP("RobotText", "{stored} traces in {folder}"),
    QT_TRANSLATE_NOOP("RobotText", "finished, {verdict}"),
    QT_TRANSLATE_NOOP("RobotText", "complete: all {planned} planned traces are stored"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "INCOMPLETE: {stored} of {planned} planned traces are stored, {failed} failed, "
        "{missing} not visited",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the survey's folder holds {stored} of {planned} traces"),
    QT_TRANSLATE_NOOP("RobotText", "the survey is not ended yet: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the recordings could not be finished: {reason}"),
    # What main_control refuses.
    QT_TRANSLATE_NOOP("RobotText", "not resumed: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "no parameters have been set"),
    QT_TRANSLATE_NOOP("RobotText", "set them, then start"),
    QT_TRANSLATE_NOOP("RobotText", "a survey is {state}: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the parameters cannot be changed"),
    QT_TRANSLATE_NOOP("RobotText", "another survey cannot start"),
    QT_TRANSLATE_NOOP("RobotText", "another survey cannot be resumed"),
    QT_TRANSLATE_NOOP("RobotText", "stop it or wait for its end"),
    QT_TRANSLATE_NOOP("RobotText", "no survey is measuring (the control is {state})"),
    QT_TRANSLATE_NOOP("RobotText", "there is nothing to pause"),
    QT_TRANSLATE_NOOP("RobotText", "no survey is running"),
    QT_TRANSLATE_NOOP("RobotText", "there is nothing to stop"),
    QT_TRANSLATE_NOOP("RobotText", "no survey is paused (the control is {state})"),
    QT_TRANSLATE_NOOP("RobotText", "name the survey that shall go on"),
    QT_TRANSLATE_NOOP("RobotText", "the paused survey is {survey}, not {other}"),
    QT_TRANSLATE_NOOP("RobotText", "stop it first"),
    QT_TRANSLATE_NOOP("RobotText", "the former survey has not ended within {limit} s: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "another request is still being carried out after {limit} s (opening a large survey "
        "again takes long)",
    ),
    QT_TRANSLATE_NOOP("RobotText", "ask again when it has ended"),
    QT_TRANSLATE_NOOP("RobotText", "try again"),
    QT_TRANSLATE_NOOP("RobotText", "the survey in {folder} was measured by {kind} robot"),
    QT_TRANSLATE_NOOP("RobotText", "it cannot go on with {kind} one"),
    QT_TRANSLATE_NOOP("RobotText", "a simulated"),
    QT_TRANSLATE_NOOP("RobotText", "the real"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the survey in {folder} cannot go on, its survey.json is not whole: {error}",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the survey in {folder} was measured with {name} {former} of the {axis} axis, which "
        "is {present} now: its points would lie elsewhere",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the survey in {folder} holds trace {index}, its parameters give only {planned}: its "
        "survey.json is not that of its traces",
    ),
    QT_TRANSLATE_NOOP("RobotText", "launch with the former parameters, or start a new survey"),
    # Nodes.
    QT_TRANSLATE_NOOP("RobotText", "{silent} went silent, {anew} started anew"),
    QT_TRANSLATE_NOOP("RobotText", "{lost} and did not come back within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "{lost}, {count} times with no trace in between"),
    QT_TRANSLATE_NOOP("RobotText", "{nodes} went silent"),
    QT_TRANSLATE_NOOP("RobotText", "{nodes} started anew"),
    QT_TRANSLATE_NOOP("RobotText", "{nodes} do not answer"),
    QT_TRANSLATE_NOOP("RobotText", "{nodes} does not answer"),
    QT_TRANSLATE_NOOP("RobotText", "service {service} did not answer within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "service {service} could not be called: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "the call was given up"),
    QT_TRANSLATE_NOOP("RobotText", "check that its node runs and does not hang"),
    QT_TRANSLATE_NOOP("RobotText", "check that its node runs"),
    QT_TRANSLATE_NOOP("RobotText", "check that its axis_driver node runs"),
    QT_TRANSLATE_NOOP("RobotText", "no survey is open"),
)
