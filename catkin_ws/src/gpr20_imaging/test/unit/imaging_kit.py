"""A fake command gpr20, and sticks that are folders."""

from __future__ import annotations

import json
import stat
import sys
import uuid

from candidate_examples import candidate, candidate_list

from gpr20_common.message import Fault, Message
from gpr20_common.sent_message import message_fields
from gpr20_imaging.low.analysis_command import AnalysisCommand
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_survey.results.candidate_json import json_text

REFUSAL = Message("no {what}", what="permittivity").with_fault(
    Fault("test.refused", Message("Give the permittivity."))
)
# It does what its first line says: focus answers, report and candidates write their output.
PROGRAM = """#!{python}
import json, os, sys, time
def listed(survey, note):
    found = json.loads({listed!r})
    found["survey_id"] = json.load(open(survey + "/survey.json"))["survey_id"]
    return json.dumps(dict(found, notes=note))
mode = open({mode!r}).read()
if mode == "refuse":
    print("the permittivity cannot be estimated", file=sys.stderr)
    sys.exit(print({refusal!r} if "--json" in sys.argv else "") or 3)
if mode == "crash":
    sys.exit(print("Killed by a test", file=sys.stderr) or 7)
if mode == "hang":
    open({started!r}, "w").write(str(os.getpid()))
    time.sleep(600)
if sys.argv[1] == "focus":
    for line in sys.stdin:
        request = json.loads(line)
        open({asked!r}, "a").write(line)
        if mode == "error":
            print({refusal!r}, flush=True)
            continue
        if mode == "die":
            sys.exit(print("Killed by a test", file=sys.stderr) or 7)
        open(request["levels"], "wb").write(bytes(range(4)) * 8)
        answer = dict(traces=os.getpid(), x_mm=[1.0, 2.0], y_mm=[1.0, 2.0], depth_mm=[0.0, 3.0])
        answer["candidates_json"] = "{{}}" if mode == "damage" else listed(request["survey"], [])
        print(json.dumps(answer), flush=True)
    sys.exit()
for place in [sys.argv[at + 1] for at, one in enumerate(sys.argv) if one == "-o"]:
    open(place, "w").write(" ".join(sys.argv[1:]) + " No echo does not mean no mine")
if sys.argv[1] == "candidates":
    print("{{}}" if mode == "damage" else listed(sys.argv[2], sys.argv[1:]))
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
                refusal=json.dumps({"error": message_fields(REFUSAL)}),
                listed=json_text(candidate_list([candidate()])),
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
