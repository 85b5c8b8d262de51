"""What the robot says of itself, sentence by sentence, to be translated.

Sentences are told in rows with "; " between them; each entry is one of a row. A place to fill in
holds a value, or the sentence of a part whose words are known here as well.
"""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

# In the order in which they are tried: those that match more come later.
SENTENCES: Tuple[str, ...] = (
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
    QT_TRANSLATE_NOOP("RobotText", "check that its node runs and does not hang"),
    QT_TRANSLATE_NOOP("RobotText", "check that its node runs"),
    QT_TRANSLATE_NOOP("RobotText", "check that its axis_driver node runs"),
    QT_TRANSLATE_NOOP("RobotText", "no survey is open"),
    # Axes.
    QT_TRANSLATE_NOOP("RobotText", "homed"),
    QT_TRANSLATE_NOOP("RobotText", "not homed"),
    QT_TRANSLATE_NOOP("RobotText", "homing the {axis} axis failed: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis is not homed: its position is unknown"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis has lost its zero"),
    QT_TRANSLATE_NOOP("RobotText", "resume the survey to home it"),
    QT_TRANSLATE_NOOP("RobotText", "home it"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the {axis} axis did not end its move to {target} {unit} within {limit} s",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check its motor and its node"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis did not reach {target} {unit}: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the {axis} axis stands at {coordinate} {unit} instead of {target} {unit_too}",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis is silent: nothing on {topic} for {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "the axes moved during the sweep at point {index}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the axes stand at {position} instead of {planned} before the sweep at point {index}",
    ),
    QT_TRANSLATE_NOOP("RobotText", "nobody else may move them during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the axis is not homed"),
    QT_TRANSLATE_NOOP("RobotText", "home it before moving it"),
    QT_TRANSLATE_NOOP("RobotText", "the axis is busy with another motion"),
    QT_TRANSLATE_NOOP("RobotText", "it ended without a result"),
    QT_TRANSLATE_NOOP("RobotText", "homing was stopped"),
    QT_TRANSLATE_NOOP("RobotText", "the endstop says where this axis has its zero"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the zero of this axis is not known: it has no endstop, and nothing says where it "
        "stopped last",
    ),
    QT_TRANSLATE_NOOP("RobotText", "home the axis"),
    QT_TRANSLATE_NOOP("RobotText", "home the axis, and lighten the load of this computer"),
    QT_TRANSLATE_NOOP("RobotText", "turn the antennas to their mark and call the service set_zero"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop was pressed at {coordinate} {unit}, where it should be open: steps were "
        "lost or the switch is stuck",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "stopped at {coordinate} {unit}, before the target {target} {unit_too}",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "a pulse was {late} ms late near {coordinate} {unit} at a speed at which the motor "
        "can lose steps: the position is not trusted",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop was not reached within {length} {unit}: it is stuck open, unplugged, or "
        "the motor does not turn",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop is still pressed {length} {unit} away from it: it is stuck closed or "
        "the motor does not turn",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop stayed pressed for {length} {unit}: it is stuck closed, "
        "short-circuited, or the motor does not turn",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check the switch, its cable and the motor"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop switched {length} {unit} from where the carriage had backed off by "
        "{backoff} {unit_too}: it does not switch at one place",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check the switch and the belt"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the process that makes the pulses made no step for {limit} s and was ended",
    ),
    QT_TRANSLATE_NOOP("RobotText", "look at what else this computer does, and home the axis"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the last motion was slowed down by {count} late edges, the latest pulse by {late} "
        "ms: this computer does too much else",
    ),
    QT_TRANSLATE_NOOP("RobotText", "pulses without real-time scheduling, refused: {refused}"),
    # Height.
    QT_TRANSLATE_NOOP("RobotText", "height {height} m"),
    QT_TRANSLATE_NOOP("RobotText", "no height measured yet"),
    QT_TRANSLATE_NOOP("RobotText", "the antenna height could not be measured: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the measurement was given up"),
    QT_TRANSLATE_NOOP("RobotText", "no height: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height sensor is stuck: {count} of {all} readings are {rail}, the end of the "
        "converter's scale ({reason})",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the sensor is off or unplugged"),
    QT_TRANSLATE_NOOP("RobotText", "the height sensor's node is being shut down"),
    QT_TRANSLATE_NOOP("RobotText", "check its plug and supply"),
    QT_TRANSLATE_NOOP("RobotText", "the height sensor reads {distance} m"),
    QT_TRANSLATE_NOOP("RobotText", "it measures from {lowest} to {highest} m"),
    QT_TRANSLATE_NOOP("RobotText", "check that it sees the ground and how high the antennas hang"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height sensor is stuck: its last {count} readings are the very same, without "
        "any noise",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "hold a hand under it: if that ends this, it works, and frozen_readings may be "
        "larger, or 0 for no such check",
    ),
    QT_TRANSLATE_NOOP("RobotText", "if not, replace it"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height readings scatter by {spread} m (from {lowest} to {highest} m)",
    ),
    QT_TRANSLATE_NOOP("RobotText", "at most {limit} m is allowed"),
    QT_TRANSLATE_NOOP("RobotText", "check the sensor's supply and that the antennas stand still"),
    QT_TRANSLATE_NOOP("RobotText", "the SPI bus failed: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "no MCP3008 answers on the SPI bus (it gave {reply})"),
    QT_TRANSLATE_NOOP("RobotText", "check wiring and supply"),
    QT_TRANSLATE_NOOP("RobotText", "check the wiring"),
    # VNA.
    QT_TRANSLATE_NOOP("RobotText", "connected to {identity}"),
    QT_TRANSLATE_NOOP("RobotText", "not connected"),
    QT_TRANSLATE_NOOP("RobotText", "no connection to the VNA at {address}: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "check the address, the cable and that it is on"),
    QT_TRANSLATE_NOOP("RobotText", "check the VNA and its network cable"),
    QT_TRANSLATE_NOOP("RobotText", "setting up the VNA failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "reading the VNA's calibration failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's sweep failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's sweep was given up: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "setting up the VNA was given up: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "it takes longer than {limit} s in all"),
    QT_TRANSLATE_NOOP("RobotText", "it failed before with: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "look at the VNA's display, and switch it off and on if this goes on",
    ),
    QT_TRANSLATE_NOOP("RobotText", "{action} at {address} failed: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{action} failed: the link to {address} is closed"),
    QT_TRANSLATE_NOOP("RobotText", "no complete answer within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "the connection was closed by the other side"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA is not connected"),
    QT_TRANSLATE_NOOP("RobotText", "call the service connection first"),
    QT_TRANSLATE_NOOP("RobotText", "no sweep is configured"),
    QT_TRANSLATE_NOOP("RobotText", "call the service freq_sweep_setup first"),
    QT_TRANSLATE_NOOP("RobotText", "the sweep of {points} points did not end within {limit} s"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "check that the instrument is in VNA mode and not operated by hand",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check that it is in VNA mode and not operated by hand"),
    QT_TRANSLATE_NOOP("RobotText", "check that nobody operates it by hand"),
    QT_TRANSLATE_NOOP("RobotText", "nobody may operate it by hand during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's number of points changed to {points} by itself"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the instrument gave the very same data as for the sweep before",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA says it is {identity}"),
    QT_TRANSLATE_NOOP("RobotText", "expected is {expected}"),
    QT_TRANSLATE_NOOP("RobotText", "check the address, or the parameters maker and model"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA at {address} is now {identity} and was {former}"),
    QT_TRANSLATE_NOOP("RobotText", "call the service connection again"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA is not calibrated"),
    QT_TRANSLATE_NOOP("RobotText", "calibrate it before going on"),
    QT_TRANSLATE_NOOP("RobotText", "calibrate it again"),
    QT_TRANSLATE_NOOP("RobotText", "the calibration is moderate: its power level was another"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the calibration is moderate: the VNA is more than 5 degrees warmer or colder than then",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the calibration is low: the VNA is more than 10 degrees warmer or colder than then",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's calibration status is {status} ({meaning})"),
    QT_TRANSLATE_NOOP("RobotText", "no calibration"),
    QT_TRANSLATE_NOOP("RobotText", "calibrated, accuracy high"),
    QT_TRANSLATE_NOOP("RobotText", "moderate, the power level was changed"),
    QT_TRANSLATE_NOOP("RobotText", "moderate, the temperature moved by more than 5 degrees"),
    QT_TRANSLATE_NOOP("RobotText", "low, the temperature moved by more than 10 degrees"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "calibrate it, or change accepted_calibrations (now {accepted})",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA accepted {accepted} instead of {asked}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA measured {setting} instead of {asked}"),
    QT_TRANSLATE_NOOP("RobotText", "nobody else may set it up during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's frequencies are no longer those of this survey"),
    QT_TRANSLATE_NOOP("RobotText", "stop it and start anew"),
    QT_TRANSLATE_NOOP("RobotText", "every number of the trace is zero"),
    QT_TRANSLATE_NOOP("RobotText", "nothing was measured"),
    QT_TRANSLATE_NOOP("RobotText", "the imaginary part of the trace is a copy of its real part"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "S21 is weak: {level} dB in the middle, expected are {limit} dB or more",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check that both antennas are connected"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "S21 is strong: up to {level} dB, expected are {limit} dB at most",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the receiver may be overloaded or the calibration be another setup's",
    ),
    QT_TRANSLATE_NOOP("RobotText", "{count} of {all} points in a row are the very same number"),
    QT_TRANSLATE_NOOP("RobotText", "check that the VNA sweeps and is not in zero span"),
    QT_TRANSLATE_NOOP("RobotText", "the sweep took {duration} s, usual are {usual} s"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "check that nobody changed the VNA's bandwidth, and its network",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the sweep was repeated {times}: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{missing} of {all} numbers of the instrument are not finite"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the data block is cut: {arrived} of {announced} announced bytes arrived",
    ),
    # Storage.
    QT_TRANSLATE_NOOP("RobotText", "{count} traces stored"),
    QT_TRANSLATE_NOOP("RobotText", "{count} traces were not stored within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "check the disk and the processing node"),
    QT_TRANSLATE_NOOP("RobotText", "trace {index} could not be stored: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "only {free} MB are free on the disk"),
    QT_TRANSLATE_NOOP("RobotText", "make space"),
    QT_TRANSLATE_NOOP("RobotText", "make space and store again"),
    QT_TRANSLATE_NOOP("RobotText", "messages of other topics were dropped"),
    QT_TRANSLATE_NOOP("RobotText", "the disk is too slow"),
    QT_TRANSLATE_NOOP("RobotText", "{what} could not be written to {path}: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{what} could not be read again from {path}: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "make the folder and what is in it readable and writable for this user",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "what is in the folder must belong to this user, and its file system know hard links",
    ),
    QT_TRANSLATE_NOOP("RobotText", "it is gone"),
    QT_TRANSLATE_NOOP("RobotText", "if the survey's folder was moved or renamed, put it back"),
    QT_TRANSLATE_NOOP("RobotText", "this is a folder, no file"),
    QT_TRANSLATE_NOOP("RobotText", "this is a file, no folder"),
    QT_TRANSLATE_NOOP("RobotText", "move it away"),
    QT_TRANSLATE_NOOP("RobotText", "the disk is full"),
    QT_TRANSLATE_NOOP("RobotText", "the disk quota is used up"),
    QT_TRANSLATE_NOOP("RobotText", "the disk is read-only"),
    QT_TRANSLATE_NOOP("RobotText", "look for disk errors with dmesg and mount it writable"),
    QT_TRANSLATE_NOOP("RobotText", "permission denied"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "a file of this name exists with other content and was left alone",
    ),
    QT_TRANSLATE_NOOP("RobotText", "move it out of the survey's folder and store again"),
    QT_TRANSLATE_NOOP("RobotText", "not permitted"),
    QT_TRANSLATE_NOOP("RobotText", "nothing was stored"),
    QT_TRANSLATE_NOOP("RobotText", "nothing was stored, check the disk"),
    QT_TRANSLATE_NOOP("RobotText", "the storage is shutting down"),
    QT_TRANSLATE_NOOP("RobotText", "{count} jobs were waiting for the disk for {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "it was not begun"),
    QT_TRANSLATE_NOOP("RobotText", "it may still end, asking again is safe"),
    QT_TRANSLATE_NOOP("RobotText", "check the disk"),
    QT_TRANSLATE_NOOP("RobotText", "the disk did not take everything within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "the disk did not finish within {limit} s ({reason})"),
    QT_TRANSLATE_NOOP("RobotText", "the disk of {path} cannot be asked: {error}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the survey needs {needed} MB and {reserve} MB are kept in reserve, but the disk of "
        "{path} has only {free} MB free",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the computer's clock says {time}"),
    QT_TRANSLATE_NOOP("RobotText", "set it, or every time in the recordings would be wrong"),
    # The simulated robot.
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED robot works"),
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED robot has faults: {faults}"),
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED VNA was reset and lost its network settings"),
    # A service's name before its words.
    QT_TRANSLATE_NOOP("RobotText", "{service}: {reason}"),
)
