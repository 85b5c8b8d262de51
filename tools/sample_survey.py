"""Record the sample survey of gpr20_analysis; started by sample_survey.sh."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Dict

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from robot_kit import simulated_robot

from gpr20_analysis import verify_survey

SCENES = Path(__file__).resolve().parents[1] / "catkin_ws" / "src" / "gpr20_simulator" / "scenes"
SCENE = SCENES / "imaging_targets.yaml"
SURVEY = (
    *("--x-start-mm", "60", "--x-stop-mm", "420", "--x-points", "21"),
    *("--y-start-mm", "60", "--y-stop-mm", "420", "--y-points", "21"),
    *("--frequency-points", "101"),
    *("--site", "simulated ground imaging_targets"),
)
# The traces, and what describes them. The other topics, such as those of the motors, would make the
# file four times as large.
TOPICS = ("trace", "survey_metadata", "survey_parameters", "description")
CHUNK_BYTES = 4 << 20


def copy_traces(recorded: Path, output: Path) -> None:
    """Copy the messages of `TOPICS`, byte for byte, and all attachments and metadata."""
    with recorded.open("rb") as source, output.open("wb") as target:
        reader, writer = make_reader(source), Writer(
            target, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD
        )  # fmt: skip
        header = reader.get_header()
        writer.start(header.profile, header.library)
        for attached in reader.iter_attachments():
            writer.add_attachment(
                attached.create_time,
                attached.log_time,
                attached.name,
                attached.media_type,
                attached.data,
            )
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        schemas: Dict[int, int] = {}
        channels: Dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if schema is None or channel.topic.split("/")[-1] not in TOPICS:
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id], channel.metadata
                )
            writer.add_message(
                channels[channel.id],
                message.log_time,
                message.data,
                message.publish_time,
                message.sequence,
            )
        writer.finish()


def main() -> None:
    """Record the survey and copy its traces into the file that is named."""
    output = Path(sys.argv[1])
    with simulated_robot(f"scene:={SCENE}", "time_scale:=50") as robot:
        status = robot.client(*SURVEY).wait()
        if status:
            raise SystemExit(f"the survey did not finish (status {status})")
        (folder,) = (one.parent for one in robot.data.glob("*/survey.json"))
        verification = verify_survey(folder)
        print(verification.verdict)
        if verification.status:
            raise SystemExit(verification.status)
        copy_traces(folder / "survey.mcap", output)
    print(output, output.stat().st_size)


if __name__ == "__main__":
    main()
