"""What the storage says of traces, files and the disk."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

STORAGE: Tuple[str, ...] = (
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
    QT_TRANSLATE_NOOP(
        "RobotText",
        "if the survey's folder was moved or renamed, put it back, then resume the survey",
    ),
    QT_TRANSLATE_NOOP("RobotText", "it was moved, removed or replaced while it was written"),
    QT_TRANSLATE_NOOP("RobotText", "this is no ordinary file"),
    QT_TRANSLATE_NOOP("RobotText", "this is a symbolic link, which is not followed"),
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
)
