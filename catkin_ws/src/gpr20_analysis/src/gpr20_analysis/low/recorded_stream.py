"""Every message of an MCAP file in the order of time, as it was recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator

from mcap.reader import make_reader

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.low.recorded_survey import mcap_has_end
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage


def mcap_messages(path: Path) -> Iterator[RecordedMessage]:
    """Yield the messages of an MCAP file; of one that was cut off, what is whole.

    Raises:
        UnreadableFileError: The file is damaged before its end.
        OSError: It cannot be read.
    """
    if not mcap_has_end(path):
        stored = StoredMcap(path)
        yield from stored.messages()
        if stored.faults:
            raise UnreadableFileError("; ".join(stored.faults))
        return
    try:
        with path.open("rb") as stream:
            for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
                if schema is not None:
                    yield RecordedMessage(
                        channel.topic,
                        schema.name,
                        channel.metadata.get("md5sum", ""),
                        schema.data.decode(),
                        message.data,
                        message.log_time,
                        channel.metadata.get("latching") == "1",
                    )
    except OSError:
        raise
    except Exception as error:
        # The library fails in any way on damaged bytes.
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error
