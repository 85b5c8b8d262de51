"""A survey's folder with a log of every kind of fact, for tests; it has no traces."""

from __future__ import annotations

import hashlib
import json
import os
import random
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

from annotation_examples import EXAMPLE
from failing_disk import CALLS
from trace_examples import STARTED_US, SURVEY

from gpr20_survey.folder import manifest, survey_metadata
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import Change, Fact, RecoveredSurvey
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import START
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import Marker, markers_of
from gpr20_survey.trace import utc_time

NOW = "2026-11-21T05:10:00.000000+00:00"
FILES = ("log.jsonl", "log.copy.jsonl")
KILLED, DONE = 9, 0
PLAN: Dict[str, Any] = {
    "format": survey_metadata.FORMAT,
    "survey_id": SURVEY,
    "started": utc_time.iso_text(STARTED_US),
    **START,
    "software_revision": "1.2.3",
    "simulated": True,
    "parameters": {"x_points": 3, "polarizations_deg": [0.0, 90.0], "y_stop_mm": 110.5},
}
END = {"ended": NOW, "outcome": "stopped", "reason": "by the operator", "stored_traces": 0}


def marker(number: int) -> Marker:
    """Return a marker of which no number occurs twice in a log."""
    return Marker(
        f"00000000-0000-4000-8000-{number:012x}", 110.25 + number, 20.0, 80.0, f"ñ {number}", "Ana"
    )


def new_marker(number: int) -> Fact:
    return Fact(Kind.MARKER, asdict(replace(marker(number), time=NOW)))


def add_marker(number: int) -> Change:
    def change(description: Dict[str, Any]) -> Optional[Fact]:
        known = {one.marker_id for one in markers_of(description)}
        return None if marker(number).marker_id in known else new_marker(number)

    return change


def facts() -> List[Fact]:
    """Return what is noted of the survey after its plan, in this order."""
    made = [Fact(Kind.REPORT, {"verdict": "none"}), Fact(Kind.ANNOTATION, EXAMPLE.values())]
    made += [new_marker(number) for number in (1, 2, 3)]
    removed = {"marker_id": marker(2).marker_id, "removed": NOW, "removed_by": "Luis"}
    return [
        *made,
        Fact(Kind.REPORT, {"verdict": "some", "coverage": "m-"}),
        Fact(Kind.MARKER_REMOVED, removed),
        Fact(Kind.PAUSE, {"reason": "rain"}),
        Fact(Kind.REPORT, {"verdict": "all", "coverage": "mm"}),
        Fact(Kind.END, END),
    ]


def write_log(folder: Path) -> SurveyLog:
    """Write the log of the survey as the storage does, fact by fact."""
    plan = LogRecord.after(None, Kind.PLAN, PLAN, PLAN["started"])
    log = SurveyLog(folder, [plan], whole=False)
    log.write()
    for fact in facts():
        log.add(log.next(fact.kind, fact.values, NOW))
    return log


def make_survey(folder: Path, sealed: bool = True) -> SurveyLog:
    """Make the folder of a survey that was stopped, or cut off before its manifest was written."""
    (folder / "traces").mkdir(parents=True)
    (folder / "traces" / "one.json").write_bytes(b"{}\n")
    log = write_log(folder)
    log.write_description()
    if sealed:
        manifest.write_manifest(folder, SURVEY, log.last, "1.2.3", NOW)
    return log


def assert_everything_acknowledged(found: RecoveredSurvey) -> None:
    """Check that a survey has every fact of `facts`, and no other."""
    description = found.description
    assert annotation_of(description) == EXAMPLE
    first, second, third = markers_of(description)
    for number, one in zip((1, 3), (first, third)):
        assert one.is_present and one.same_request(marker(number))
    assert not second.is_present and second.same_request(marker(2))
    assert second.removed_by == "Luis"
    assert description["report"] == {"verdict": "all", "coverage": "mm"}
    assert {key: description[key] for key in END} == END
    assert description["parameters"] == PLAN["parameters"]
    assert "unconfirmed" not in description


def flipped(chance: random.Random, content: bytes) -> bytes:
    """Return a content of which one bit is another."""
    changed = bytearray(content)
    changed[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def damaged(chance: random.Random, content: bytes) -> bytes:
    """Flip a bit or 30, cut, overwrite, delete, insert or empty."""
    start = chance.randrange(len(content))
    end = min(len(content), start + chance.choice([1, 30, 500, 5000]))
    more = bytes(chance.randrange(256) for _ in range(end - start))
    kept = chance.choice([b"", more, bytes(end - start), more + content[start:end]])
    changed = content
    for _ in range(chance.choice([1, 1, 30])):
        changed = flipped(chance, changed)
    return chance.choice([changed, content[:start], content[:start] + kept + content[end:], b""])


def both_files(folder: Path) -> Dict[str, bytes]:
    """Return the content of the two files of the log."""
    return {name: (folder / name).read_bytes() for name in FILES}


def change_digit(folder: Path, name: str, number: int) -> None:
    """Change the first digit of the place of a marker in one file of the log."""
    path = folder / name
    wanted = str(marker(number).x_mm).encode()
    content = path.read_bytes()
    assert wanted in content
    path.write_bytes(content.replace(wanted, b"9" + wanted[1:]))


def entries(folder: Path) -> List[Dict[str, Any]]:
    return [json.loads(one) for one in (folder / "log.jsonl").read_text().splitlines()]


def with_own_sum(values: Dict[str, Any]) -> bytes:
    """Return the content of a manifest that ends with its checksum."""
    own_sum = hashlib.sha256(survey_metadata.encode(values)).hexdigest()
    return survey_metadata.encode({**values, "sha256": own_sum})


def ended_at_call(number: int, work: Callable[[], object]) -> int:
    """Do some work in a process that dies in its n-th call of the disk; return how it ended.

    A write of the last call is torn in its middle.
    """
    child = os.fork()
    if child:
        return os.WEXITSTATUS(os.waitpid(child, 0)[1])
    calls = []
    real_pwrite = os.pwrite

    def dying(name: str, real: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: Any, **options: Any) -> object:
            calls.append(name)
            if len(calls) < number:
                return real(*arguments, **options)
            if name == "pwrite":
                descriptor, data, offset = arguments
                real_pwrite(descriptor, bytes(data)[: len(data) // 2], offset)
            os._exit(KILLED)

        return call

    try:
        for name in CALLS:
            setattr(os, name, dying(name, getattr(os, name)))
        work()
        os._exit(DONE)
    finally:
        os._exit(1)
