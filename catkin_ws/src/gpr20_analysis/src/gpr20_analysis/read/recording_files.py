"""Opening bags and MCAP files: never a pipe, a device, or a file that is mostly a hole."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import BinaryIO, Iterator

from rosbags.rosbag1 import Reader

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.read.unindexed_bag import has_whole_index
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey.files.regular_file import open_regular

BAG, MCAP = ".bag", ".mcap"
BAG_MAGIC, MCAP_MAGIC = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n"
INDEX_POSITION = b"index_pos="


def is_bag(path: Path) -> bool:
    """Return whether a name is that of a bag; `rosbag record` names one that it writes .active."""
    return path.name.endswith((BAG, f"{BAG}.active"))


def is_recording(path: Path) -> bool:
    """Return whether a name is that of a bag or an MCAP file."""
    return is_bag(path) or path.suffix == MCAP


def opened(path: Path, follow_link: bool) -> BinaryIO:
    """Return a recording that is open for reading.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        OSError: It cannot be read, or is no regular file.
    """
    return open(open_regular(path, follow_link), "rb")


def is_finished(path: Path, follow_link: bool) -> bool:
    """Return whether a bag or an MCAP file has its index.

    Raises:
        UnreadableFileError: It is neither.
        OSError: It cannot be read.
    """
    magic = BAG_MAGIC if is_bag(path) else MCAP_MAGIC
    with opened(path, follow_link) as stream:
        if stream.read(len(magic)) != magic:
            kind = "bag" if is_bag(path) else "MCAP"
            raise UnreadableFileError(
                Message(
                    "{file} is not a {kind} file: it begins differently", file=path.name, kind=kind
                ),
                fault=faults.RECORDING_DAMAGED,
            )
        if path.suffix == MCAP:
            stream.seek(max(len(magic), stream.seek(0, os.SEEK_END) - len(magic)))
            return stream.read() == magic
        head = stream.read(4096)
        whole_index = has_whole_index(stream)
    place = head.find(INDEX_POSITION)
    if place < 0:
        raise UnreadableFileError(
            Message("{file} has no bag header", file=path.name), fault=faults.RECORDING_DAMAGED
        )
    place += len(INDEX_POSITION)
    return head[place : place + 8] != bytes(8) and whole_index


@contextlib.contextmanager
def bag_reader(path: Path, follow_link: bool) -> Iterator[Reader]:
    """Return an open bag that has its index.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        Exception: Of any kind, for damaged bytes.
    """
    # The library opens a name: that of the descriptor is the file that was checked.
    with opened(path, follow_link) as stream, Reader(f"/dev/fd/{stream.fileno()}") as reader:
        yield reader


@contextlib.contextmanager
def failing_as_unreadable(path: Path) -> Iterator[None]:
    """Turn every exception of a reader of recordings into one that names the file.

    Raises:
        UnreadableFileError: The body raised an exception.
    """
    try:
        yield
    except UnreadableFileError:
        raise
    except OSError as error:
        raise UnreadableFileError(
            Message("{file}: {reason}", file=path.name, reason=os_reason(error)),
            fault=faults.RECORDING_DAMAGED,
        ) from error
    except Exception as error:
        # The libraries unpack without checks: damaged bytes raise exceptions of any kind.
        raise UnreadableFileError(
            Message("{file} is damaged", file=path.name, details=repr(error)),
            fault=faults.RECORDING_DAMAGED,
        ) from error
