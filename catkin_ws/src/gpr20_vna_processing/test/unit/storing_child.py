"""Stores traces as fast as it can and prints the index of each one acknowledged."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

from storage_kit import Kit, open_mcap, text_message
from trace_examples import make_trace

from gpr20_survey.recording.bag_writer import BagFile


def open_both(folder, *arguments):
    return [BagFile(folder / "survey.bag"), *open_mcap(folder, *arguments)]


def main() -> None:
    kit = Kit(Path(sys.argv[1]), open_both)
    print(kit.open(), flush=True)
    for index in itertools.count():
        for number in range(5):
            kit.processing.record(text_message("/t", f"{index} {number}"))
        kit.processing.store(make_trace(index))
        print(index, flush=True)


main()
