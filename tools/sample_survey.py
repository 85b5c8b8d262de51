"""Record the survey that gpr20_analysis ships as a sample, on the simulated robot, and verify it.

    source scripts/environment.sh; gpr20_use_workspace
    ROS_IP=127.0.0.1 PYTHONPATH="$GPR20_TOOLS:$PYTHONPATH" python tools/sample_survey.py [FILE.mcap]

Without a file it goes into the sources of gpr20_analysis.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from robot_kit import simulated_robot

from gpr20_analysis import verify_survey
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile

PACKAGES = Path(__file__).resolve().parents[1] / "catkin_ws/src"
SCENE = PACKAGES / "gpr20_simulator/scenes/imaging_targets.yaml"
SAMPLE = PACKAGES / "gpr20_analysis/src/gpr20_analysis/sample/survey.mcap"
SURVEY = (
    *("--x-start-mm", "60", "--x-stop-mm", "420", "--x-points", "21"),
    *("--y-start-mm", "60", "--y-stop-mm", "420", "--y-points", "21"),
    *("--frequency-points", "101"),
    *("--site", "simulated ground imaging_targets"),
)
# The traces, and what describes them. The other topics, such as those of the motors, would make the
# file four times as large.
TOPICS = ("replay", "trace", "survey_metadata", "survey_log", "survey_parameters", "description")


def copy_traces(recorded: Path, output: Path) -> None:
    """Copy the messages of `TOPICS` as a survey is recorded, each trace in a chunk of its own."""
    target = McapFile(output)
    for message in StoredMcap(recorded).messages():
        name = message.topic.split("/")[-1]
        if name in TOPICS:
            (target.write_alone if name == "trace" else target.write)(message)
    target.finish()


def main() -> None:
    """Record the survey and copy its traces into a file."""
    output = Path(sys.argv[1]) if sys.argv[1:] else SAMPLE
    with simulated_robot(f"scene:={SCENE}", "time_scale:=50") as robot:
        if robot.client(*SURVEY).wait():
            raise SystemExit("the survey did not finish")
        (folder,) = (one.parent for one in robot.data.glob("*/survey.json"))
        verification = verify_survey(folder)
        print(verification.verdict)
        if verification.status:
            raise SystemExit(verification.status)
        copied = robot.data / "sample.mcap"
        copy_traces(folder / "survey.mcap", copied)
        shutil.move(str(copied), str(output))
    print(output, output.stat().st_size)


if __name__ == "__main__":
    main()
