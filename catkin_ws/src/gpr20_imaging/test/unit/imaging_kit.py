"""A fake command gpr20, and sticks that are folders."""

from __future__ import annotations

import json
import stat
import sys
import uuid

from gpr20_imaging.low.analysis_command import AnalysisCommand
from gpr20_imaging.low.usb_volumes import UsbVolumes

# It does what its first line says: focus answers, report and candidates write their output.
PROGRAM = """#!{python}
import json, os, sys, time
mode = open({mode!r}).read()
if mode == "refuse":
    sys.exit(print("the permittivity cannot be estimated", file=sys.stderr) or 3)
if mode == "hang":
    open({started!r}, "w").write(str(os.getpid()))
    time.sleep(600)
if sys.argv[1] == "focus":
    for line in sys.stdin:
        request = json.loads(line)
        open({asked!r}, "a").write(line)
        if mode == "error":
            record = {{"template": "too few {{what}}", "values": {{"what": "traces"}}}}
            print(json.dumps({{"error": json.dumps(record)}}), flush=True)
            continue
        if mode == "die":
            sys.exit(print("Killed by a test", file=sys.stderr) or 7)
        open(request["levels"], "wb").write(bytes(range(4)) * 8)
        answer = dict(traces=os.getpid(), x_mm=[1.0, 2.0], y_mm=[1.0, 2.0], depth_mm=[0.0, 3.0])
        print(json.dumps(dict(answer, candidates="{{}}")), flush=True)
    sys.exit()
for place in [sys.argv[at + 1] for at, one in enumerate(sys.argv) if one == "-o"]:
    open(place, "w").write(" ".join(sys.argv[1:]) + " No echo does not mean no mine")
print(json.dumps(sys.argv[1:]))
print("note: a remark", file=sys.stderr)
sys.exit(1)
"""


class FakeCommand:
    """The command; its program does what `mode` says."""

    def __init__(self, folder):
        self._mode = folder / "mode"
        self.asked = folder / "asked"
        self.started = folder / "started"
        program = folder / "gpr20"
        program.write_text(
            PROGRAM.format(
                python=sys.executable,
                mode=str(self._mode),
                started=str(self.started),
                asked=str(self.asked),
            )
        )
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        self.mode = ""
        self.command = AnalysisCommand(lambda: str(program))

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
    values = {"format": "gpr20-survey/1", "survey_id": survey_id, "simulated": simulated}
    (folder / "survey.json").write_text(json.dumps(values))
    for index in range(traces):
        (folder / "traces" / f"{index:06d}.json").write_bytes(b"0123456789" * 5000)
    return folder
