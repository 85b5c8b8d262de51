"""Adds and removes markers as fast as it can; prints each one that was acknowledged."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

from storage_kit import Kit
from trace_examples import SURVEY

from gpr20_survey.plan.markers import Marker
from gpr20_survey.recording.recordings import open_recordings


def marker(number: int) -> Marker:
    return Marker(f"00000000-0000-4000-8000-{number:012x}", 10.0 + number % 7, 20.0, text="ñ")


def main() -> None:
    kit = Kit(Path(sys.argv[1]), open_recordings)
    survey = SURVEY
    if sys.argv[2] == "open":
        kit.processing.reopen_survey(survey)
    print("ready", flush=True)
    for number in itertools.count():
        kit.processing.add_marker(survey, marker(number))
        print(number, flush=True)
        if number % 3 == 0:
            kit.processing.remove_marker(survey, marker(number).marker_id, "Ana")
            print(f"-{number}", flush=True)


if __name__ == "__main__":
    main()
