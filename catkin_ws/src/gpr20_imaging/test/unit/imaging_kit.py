"""A fake analysis, the worker process with it, and sticks that are folders."""

import json
import os
import signal
import sys
import time
import uuid
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from candidate_examples import candidate, candidate_list

from gpr20_common.message import Fault, Message
from gpr20_imaging.faults import ImagingError
from gpr20_imaging.low import stick_files
from gpr20_imaging.low.stick_files import UsbVolumes
from gpr20_imaging.mid.worker import serve
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.results.answers import FocusedImage

REFUSAL = Message("no {what}", what="permittivity").with_fault(
    Fault("test.refused", Message("Give the permittivity."))
)
PROGRAM = "import sys; sys.path[:0] = {path!r}; import imaging_kit; imaging_kit.main({folder!r})"


def image_here():
    """Return an image with the number of this process as number of traces."""
    place, depth = np.array([1.0, 2.0]), np.array([0.0, 3.0])
    levels = np.arange(8, dtype=np.float32).reshape(2, 2, 2)
    found = candidate_list([candidate()])
    return FocusedImage(os.getpid(), place, place, depth, levels, found)


class FakeAnalysis:
    """It does what the file `mode` says; what it writes and lists says what it was asked for."""

    def __init__(self, folder):
        self._mode, self.asked, self.started = (folder / n for n in ("mode", "asked", "started"))
        self.command = [sys.executable, "-c", PROGRAM.format(path=sys.path, folder=str(folder))]

    @property
    def mode(self):
        return self._mode.read_text() if self._mode.exists() else ""

    @mode.setter
    def mode(self, mode):
        self._mode.write_text(mode)

    def focus(self, survey, permittivity):
        self._obey()
        with self.asked.open("a") as stream:
            print(survey, permittivity, file=stream)
        return image_here()

    def map_hidden(self, *_):
        raise NotImplementedError

    def write_report(self, survey, output, permittivity, language):
        self._obey()
        output.write_text(f"{survey} {permittivity} {language}: no echo is no clearance")

    write_candidates = write_report

    def _obey(self):
        if self.mode == "refuse":
            raise ImagingError(REFUSAL)
        if self.mode == "full":
            raise OSError(28, "No space left on device", "/tmp/x")
        if self.mode == "die":
            sys.exit(print("Killed by a test", file=sys.stderr) or 7)
        if self.mode == "leave":
            self.mode = ""
            os._exit(0)
        if self.mode == "hang":
            self.hang()

    def hang(self):
        self.started.write_text(str(os.getpid()))
        time.sleep(600)


class FakeSticks:
    """Folders that a fake lsblk lists as mounted sticks."""

    def __init__(self, folder):
        self.media, self._devices = folder / "media", folder / "devices"
        self.media.mkdir(exist_ok=True)
        self.volumes = UsbVolumes(self._devices.read_text, (self.media,))
        if not self._devices.exists():
            self.pull_out()

    def plug_in(self, name="BLUE", **more):
        path = self.media / name
        path.mkdir(exist_ok=True)
        partition = {"name": "sdb1", "label": name, "mountpoint": str(path), "tran": None, **more}
        disk = {"name": "sdb", "tran": "usb", "rm": True, "mountpoint": None}
        devices = json.loads(self._devices.read_text())
        devices["blockdevices"].append({**disk, "children": [partition]})
        self._devices.write_text(json.dumps(devices))
        return path

    def pull_out(self):
        self._devices.write_text('{"blockdevices": []}')


def main(folder):
    """Be the worker process: the file of its connection is the argument."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    analysis, sticks = FakeAnalysis(Path(folder)), FakeSticks(Path(folder))
    if analysis.mode == "hang at the stick":
        stick_files.SummedFile.flush = lambda _file: analysis.hang()
    with Connection(int(sys.argv[1])) as connection:
        serve(connection, analysis, sticks.volumes)


def store_survey(data, simulated=True, traces=3):
    """Write what the node looks at of a stored survey; return its folder."""
    survey_id = str(uuid.uuid4())
    folder = data / f"20260921T141320_{survey_id[:8]}"
    (folder / "traces").mkdir(parents=True)
    started = "2026-09-21T14:13:20.000000+00:00"
    values = {"format": "gpr20-survey/1", "survey_id": survey_id, "started": started}
    plan = LogRecord.after(None, Kind.PLAN, {**values, "simulated": simulated}, started)
    SurveyLog(folder, [plan], whole=False).write()
    for index in range(traces):
        (folder / "traces" / f"{index:06d}.json").write_bytes(b"0123456789" * 5000)
    return folder
