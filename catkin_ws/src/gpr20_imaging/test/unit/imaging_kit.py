"""A fake analysis, and sticks that are folders."""

import json
import pickle
import sys
import uuid

from candidate_examples import candidate, candidate_list

from gpr20_common.message import Fault, Message
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_log import SurveyLog

REFUSAL = Message("no {what}", what="permittivity").with_fault(
    Fault("test.refused", Message("Give the permittivity."))
)
# It does what the file `mode` says; what it writes and lists says what it was asked for. It imports
# no tests, because that takes long.
WORKER = """
import os, pickle, sys, time
from multiprocessing.connection import Connection
from pathlib import Path
import numpy as np
sys.path[:0] = {path!r}
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.analysis_worker import serve
from gpr20_survey.results.focused_image import FocusedImage

folder = Path({folder!r})
REFUSAL, FOUND = pickle.loads((folder / "answers").read_bytes())

def obey():
    mode = (folder / "mode").read_text()
    if mode == "refuse":
        raise ImagingError(REFUSAL)
    if mode == "full":
        raise OSError(28, "No space left on device", "/tmp/x")
    if mode == "die":
        sys.exit(print("Killed by a test", file=sys.stderr) or 7)
    if mode == "hang":
        (folder / "started").write_text(str(os.getpid()))
        time.sleep(600)

class Fake:
    def focus(self, survey, permittivity):
        obey()
        with (folder / "asked").open("a") as stream:
            print(survey, permittivity, file=stream)
        place, depth = np.array([1.0, 2.0]), np.array([0.0, 3.0])
        levels = np.arange(8, dtype=np.float32).reshape(2, 2, 2)
        return FocusedImage(os.getpid(), place, place, depth, levels, FOUND)

    def write_report(self, survey, output, permittivity, language):
        obey()
        output.write_text(f"{{survey}} {{permittivity}} {{language}}: no echo is no clearance")

    write_candidates = write_report

with Connection(int(sys.argv[1])) as connection:
    serve(connection, Fake())
"""


class FakeAnalysis:
    """The analysis; its process does what `mode` says."""

    def __init__(self, folder):
        self._mode = folder / "mode"
        self.asked = folder / "asked"
        self.started = folder / "started"
        (folder / "answers").write_bytes(pickle.dumps((REFUSAL, candidate_list([candidate()]))))
        program = folder / "worker.py"
        program.write_text(WORKER.format(path=sys.path, folder=str(folder)))
        self.command = [sys.executable, str(program)]
        self.mode = ""
        self.process = AnalysisProcess(self.command)

    @property
    def mode(self):
        return self._mode.read_text()

    @mode.setter
    def mode(self, mode):
        self._mode.write_text(mode)


class FakeSticks:
    """Folders that a fake lsblk lists as mounted sticks."""

    def __init__(self, media):
        self.media = media
        self.devices = []
        media.mkdir()
        self.volumes = UsbVolumes(lambda: json.dumps({"blockdevices": self.devices}), (media,))

    def plug_in(self, name="BLUE", **more):
        path = self.media / name
        path.mkdir(exist_ok=True)
        partition = {"name": "sdb1", "label": name, "mountpoint": str(path), "tran": None, **more}
        disk = {"name": "sdb", "tran": "usb", "rm": True, "mountpoint": None}
        self.devices.append({**disk, "children": [partition]})
        return path

    def pull_out(self):
        self.devices.clear()


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
