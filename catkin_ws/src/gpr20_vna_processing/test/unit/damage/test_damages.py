"""One table: a survey's files damaged in every way, and what load, verify and reopen make of it.

Nothing is lost that an intact form holds, nothing wrong is believed, and whatever is lost is named
for ever. `test_random_damage.py` draws other damages.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, replace
from typing import Callable, Collection, Optional, Sequence, Union

import pytest
from annotation_examples import EXAMPLE
from case_kit import each_case
from fault_kit import raises_fault
from log_examples import (
    NOW,
    add_marker,
    change_digit,
    with_own_sum,
)
from reopening_kit import (
    REPORT,
    STORED,
    TRACES,
    assert_whole,
    fill,
    noted,
    resume,
    texts,
    trace_file,
    tree,
)
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import METADATA, SURVEY

from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verdict import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest, trace_files
from gpr20_survey.folder.log_record import Kind, LogHead
from gpr20_survey.folder.recovery import add_to_survey, open_log, read_description, recover
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.trace import trace_message
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys

VIEW, SEAL = "survey.json", "manifest.json"
LOG, COPY = "log.jsonl", "log.copy.jsonl"
MCAP, TRACE = "survey.mcap", "a trace"
SIX = tuple(range(6))
WITHOUT_2 = (0, 1, 3, 4, 5)
TRACE_NAME = "000002_X0020.00_Y0010.00_Z+000.00.json"
OTHER_NAME = "000002_X0030.00_Y0010.00_Z+000.00.json"


def path_of(folder, name):
    return trace_file(folder, 2) if name == TRACE else folder / name


def gone(*names):
    def change(folder, _older):
        for name in names:
            path = path_of(folder, name)
            shutil.rmtree(str(path)) if path.is_dir() else path.unlink()

    return change


def content(name, make):
    """Give a file another content, made of its own."""

    def change(folder, _older):
        path = path_of(folder, name)
        changed = make(path.read_bytes())
        assert changed != path.read_bytes()
        path.write_bytes(changed)

    return change


def emptied(name):
    return content(name, lambda _: b"")


def cut(name):
    return content(name, lambda whole: whole[:-20])


def flipped(name, wanted=None, place=0.5):
    """Flip a bit at a place, or in the last byte of a text."""

    def flip(whole):
        at = int(place * len(whole)) if wanted is None else whole.rindex(wanted) + len(wanted) - 1
        return whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]

    return content(name, flip)


def replaced(name, old, new):
    return content(name, lambda whole: whole.replace(old, new, 1))


def digit(*names):
    """Change a digit of marker 1 in files of the log."""

    def change(folder, _older):
        for name in names:
            change_digit(folder, name, 1)

    return change


def older(*names):
    """Put older files back, from before marker 2."""

    def change(folder, source):
        for name in names:
            shutil.copy(str(source / name), str(folder / name))

    return change


def both(*changes):
    def change(folder, source):
        for one in changes:
            one(folder, source)

    return change


def other_history(folder, source):
    """Put the copy of the log of a survey in its place to which marker 3 was added."""
    other = folder.parent.parent / "other" / folder.name
    shutil.copytree(str(source), str(other))
    add_to_survey(other, add_marker(3), NOW)
    shutil.copy(str(other / COPY), str(folder / COPY))


def other_trace(folder, _older):
    """Put another trace in the place of one, with a right checksum."""
    path = trace_file(folder, 2)
    trace = trace_files.read_trace(path, SURVEY)
    path.write_bytes(trace_files.encode(replace(trace, antennae_height_m=0.7)))


def renamed_trace(folder, _older):
    """Let the name of a trace's file say another place."""
    trace_file(folder, 2).rename(folder / "traces" / OTHER_NAME)


def foreign_trace(folder, _older):
    """Put a trace of another survey in the place of one in the MCAP, and remove its JSON file."""
    trace_file(folder, 2).unlink()
    messages = list(StoredMcap(folder / MCAP).messages())
    (folder / MCAP).unlink()
    file, own = McapFile(folder / MCAP), trace_message.encode(TRACES[2])
    foreign = trace_message.encode(replace(TRACES[2], survey_id=OTHER_SURVEY))
    for one in messages:
        file.write_alone(replace(one, data=foreign) if one.data == own else one)
    file.commit()
    file.abandon()


def foreign_manifest(folder, _older):
    """Put the manifest of another survey, whose log is longer, in the place of its own."""
    sealed, head = manifest.read_manifest(folder), LogHead(40, "0" * 64)
    foreign = replace(sealed, survey_id=OTHER_SURVEY, log=head)
    (folder / SEAL).write_bytes(foreign.encode())


def later_manifest(whole):
    values = json.loads(whole)
    del values["sha256"]
    return with_own_sum({**values, "format": "gpr20-manifest/2"})


def later_trace(whole):
    covered = whole[: whole.rindex(b', "sha256"')] + b"}"
    return trace_files.sealed(covered.replace(b"gpr20-trace/1", b"gpr20-trace/2"))


@dataclass(frozen=True)
class Damage:
    """A damage, and what follows.

    Attributes:
        ending: How the survey ended.
        change: Damages its folder.
        names: What verify names: files and others.
        kept: Files that are kept in `damaged/` as they were.
        repaired: What the repairs, or the refusal, name; None: what verify names.
        loaded: The traces that are read, or the code of the refusal; None: all that are stored.
        stored: The traces that are there when it is reopened; None: all that were.
        refused: The code with which reopening it is refused.
        markers: The markers that are noted in the end.
        doubts: What nothing vouches for, for ever.
    """

    ending: str
    change: Callable[..., None]
    names: Sequence[str] = ()
    kept: Collection[str] = ()
    repaired: Optional[Sequence[str]] = None
    loaded: Union[str, Sequence[int], None] = None
    stored: Optional[Sequence[int]] = None
    refused: str = ""
    markers: Sequence[int] = (1, 2)
    doubts: Collection[str] = ()


STOPPED, CUT_OFF, FINISHED, INTERRUPTED = "stopped", "cut off", "finished", "interrupted"
LOST, OTHER_VERSION = "survey.log_lost", "survey.other_version"
LINE_AND_MORE = content(LOG, lambda whole: whole[:-3] + b"#}\n")
DAMAGES = {
    # survey.json decides nothing; the manifest shows that it was changed.
    "nothing": Damage(STOPPED, both()),
    "view gone": Damage(FINISHED, gone(VIEW), [VIEW]),
    "view gone of one that was cut off": Damage(CUT_OFF, gone(VIEW)),
    # Each file of the log replaces the other.
    "log gone": Damage(CUT_OFF, gone(LOG), [LOG]),
    "marker in the log": Damage(STOPPED, digit(LOG), [LOG], [LOG]),
    "another plan in the log": Damage(
        CUT_OFF, replaced(LOG, b'"y_stop_mm":20.0', b'"y_stop_mm":30.0'), [LOG], [LOG]
    ),
    "marker in both files": Damage(
        CUT_OFF, digit(LOG, COPY), [LOG, COPY, "entry 1"], [LOG, COPY], [LOG, COPY, "record 1"],
        markers=[2], doubts=["record 1"],
    ),
    "last line of the log, no copy": Damage(
        CUT_OFF, both(LINE_AND_MORE, gone(COPY)), ["entry 4"], [LOG], [LOG, COPY, "record 4"],
        markers=[1], doubts=["record 4"],
    ),
    "no log": Damage(STOPPED, gone(LOG, COPY), [LOG, COPY], loaded=LOST, refused=LOST),
    "no plan": Damage(
        CUT_OFF, both(content(LOG, lambda whole: whole[9:]), gone(COPY)), [LOG, COPY],
        loaded=LOST, refused=LOST,
    ),
    # Older files, each right by itself.
    "older log and copy": Damage(
        STOPPED, older(LOG, COPY), repaired=[], markers=[1]
    ),
    "log cut to before the end": Damage(
        STOPPED, both(*(content(name, lambda whole: b"\n".join(whole.split(b"\n")[:4]) + b"\n")
                        for name in (LOG, COPY))),
        ["entry 4"], repaired=["record 4"], markers=[1], doubts=["record 4"],
    ),
    "older copy": Damage(INTERRUPTED, older(COPY), repaired=[]),
    "copy of another history": Damage(STOPPED, other_history, [COPY], doubts=["record 5"]),
    # The manifest.
    "manifest flipped": Damage(STOPPED, flipped(SEAL), [SEAL], [SEAL]),
    "manifest gone": Damage(FINISHED, gone(SEAL), [SEAL], repaired=[]),
    "manifest of another survey": Damage(
        STOPPED, foreign_manifest, [SEAL, OTHER_SURVEY], [SEAL]
    ),
    # Another version is no damage.
    "later manifest": Damage(
        STOPPED, content(SEAL, later_manifest), [SEAL], repaired=["gpr20-manifest/2"],
        refused=OTHER_VERSION,
    ),
    "later trace": Damage(
        CUT_OFF, content(TRACE, later_trace), [TRACE], repaired=["gpr20-trace/2"],
        refused=OTHER_VERSION,
    ),
    # Traces.
    "trace gone": Damage(STOPPED, gone(TRACE), [TRACE]),
    "space in a trace": Damage(STOPPED, replaced(TRACE, b": ", b":  "), [TRACE], [TRACE]),
    "name of a trace": Damage(CUT_OFF, renamed_trace, [OTHER_NAME]),
    "trace of another survey": Damage(
        CUT_OFF, foreign_trace, [OTHER_SURVEY], loaded=WITHOUT_2, stored=WITHOUT_2
    ),
    "another trace": Damage(
        CUT_OFF, other_trace, ["trace 2", MCAP], [MCAP], [TRACE], doubts=["traces/000002"]
    ),
    "trace cut, no mcap": Damage(
        CUT_OFF, both(cut(TRACE), gone(MCAP)), [TRACE, MCAP], [TRACE],
        loaded=WITHOUT_2, stored=WITHOUT_2,
    ),
    "trace and mcap gone": Damage(
        STOPPED, gone(TRACE, MCAP), [TRACE, MCAP], [], [MCAP], WITHOUT_2, WITHOUT_2
    ),
    "all traces": Damage(STOPPED, gone("traces"), ["traces/"], repaired=[TRACE],
                         loaded="storage.folder_moved"),
    # The MCAP: what cannot be read of it is in the JSON files.
    "mcap flipped": Damage(STOPPED, flipped(MCAP, place=0.6), [MCAP], [MCAP]),
}  # fmt: skip


def said(messages):
    return " ".join(map(str, messages))


def check_loaded(folder, damage):
    """Read the traces: each is as it was stored, or is named with a reason."""
    count = STORED[damage.ending]
    if isinstance(damage.loaded, str):
        with raises_fault(damage.loaded):
            StoredSurveys(folder.parent).traces(SURVEY, range(count))
        return
    found = StoredSurveys(folder.parent).traces(SURVEY, range(count))
    indices = found.block.indices.tolist()
    assert indices == [*(range(count) if damage.loaded is None else damage.loaded)]
    assert sorted([*indices, *found.unreadable]) == [*range(count)]
    for index, samples in zip(indices, found.block.s21):
        own = TRACES[index].s21_real + 1j * TRACES[index].s21_imag
        assert samples.tolist() == own.astype(samples.dtype).tolist()


def check_verified(folder, damage):
    """Verify the survey: what is damaged is named, and nothing damaged is called intact."""
    found = verify_survey(folder)
    for name in damage.names:
        assert name.replace(TRACE, TRACE_NAME) in said(found.faults)
    assert found.status == (DAMAGED if damage.names or damage.refused else INCOMPLETE)
    # What nothing vouches for is said wherever the survey is read.
    if found.unconfirmed:
        shown = load_survey(folder, accept_damaged=True).attrs["doubts"]
        (listed,), _more = StoredSurveys(folder.parent).list("", 1)
        for name in found.unconfirmed:
            assert name in said(shown) and name in str(listed.verdict)


def check_reopened(folder, damage, damaged):
    """Reopen the survey: it has every trace, and what was damaged is repaired and kept."""
    stored = range(STORED[damage.ending]) if damage.stored is None else damage.stored
    reopened = resume(folder, "stopped")
    assert reopened.stored_indices == tuple(stored)
    repaired = damage.names if damage.repaired is None else damage.repaired
    for name in repaired:
        assert name.replace(TRACE, TRACE_NAME) in said(reopened.repairs)
    assert bool(reopened.repairs) == bool(repaired)
    kept = {one.name: one.read_bytes() for one in (folder / "damaged").glob("*")}
    for name in damage.kept:
        place = f"traces/{TRACE_NAME}" if name == TRACE else name
        assert kept[TRACE_NAME if name == TRACE else name] == damaged[place]


def check_finished(folder, damage):
    """Finish the survey: it is whole for every reader, and what nothing vouches for is named."""
    resume(folder)
    traces = list(TRACES)
    if damage.change is other_trace:
        traces[2] = replace(TRACES[2], antennae_height_m=0.7)
    assert_whole(folder, traces)
    found = verify_survey(folder)
    assert (found.status, found.faults) == (INCOMPLETE if damage.doubts else COMPLETE, [])
    assert len(found.unconfirmed) == len(damage.doubts)
    assert "survey.mcap alone" not in said(found.notes)
    for name in damage.doubts:
        assert any(one.startswith(name) for one in found.unconfirmed)
    assert noted(folder) == texts(*damage.markers)
    description = read_description(folder)
    if damage.markers:
        assert (annotation_of(description), description["report"]) == (EXAMPLE, REPORT)


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_named_and_costs_nothing_that_another_form_holds(copies, surveys, name):
    damage = DAMAGES[name]
    folder = copies(damage.ending)
    damage.change(folder, surveys[damage.ending].older)
    damaged = tree(folder)
    check_loaded(folder, damage)
    check_verified(folder, damage)
    assert tree(folder) == damaged
    if damage.refused:
        kit = Kit(folder.parent)
        with raises_fault(damage.refused, *(damage.repaired or ()), error=SurveyRefusedError):
            kit.processing.reopen_survey(folder.name)
        kit.processing.shut_down()
        assert tree(folder) == damaged
        return
    check_reopened(folder, damage, damaged)
    check_finished(folder, damage)


def test_a_trace_that_contradicts_the_manifest_is_not_taken_from_the_mcap(copies, kit):
    source = kit.open(metadata_json=METADATA)
    other = replace(TRACES[2], antennae_height_m=0.7)
    fill(kit, [*TRACES[:2], other, *TRACES[3:6]])
    kit.processing.close_survey(SURVEY, STOPPED)
    folder = copies(STOPPED)
    trace_file(folder, 2).unlink()
    shutil.copy(str(source / MCAP), str(folder / MCAP))
    replacement = (folder / MCAP).read_bytes()
    reopened = resume(folder, STOPPED)
    assert reopened.stored_indices == WITHOUT_2
    assert f"{TRACE_NAME} differs from the manifest" in said(reopened.repairs)
    assert (folder / "damaged" / MCAP).read_bytes() == replacement
    assert any(one.startswith("traces/000002") for one in verify_survey(folder).unconfirmed)
    resume(folder)
    assert_whole(folder, TRACES)


def test_a_manifest_refutes_a_trace_also_while_the_survey_is_being_reopened(copies):
    folder = copies(STOPPED)
    log = open_log(folder, recover(folder), NOW)
    log.add(log.next(Kind.RESUME, {"stored_traces": 6}, NOW))  # and then it was killed
    other_trace(folder, None)
    reopened = resume(folder)
    assert reopened.stored_indices == SIX
    assert f"{TRACE_NAME} differs from the manifest" in said(reopened.repairs)
    assert_whole(folder, TRACES)


@each_case("change", [digit(LOG, COPY), flipped(SEAL), foreign_manifest, other_history])
def test_nothing_is_added_to_a_survey_of_which_something_is_lost_or_damaged(
    copies, surveys, change
):
    folder = copies(FINISHED)
    change(folder, surveys[FINISHED].older)
    before = tree(folder)
    with raises_fault(("survey.can_resume", "survey.manifest_damaged")):
        add_to_survey(folder, add_marker(3), NOW)
    assert tree(folder) == before


def test_the_manifest_holds_what_was_acknowledged_and_not_what_is_on_the_disk_at_the_end(kit):
    folder = kit.open(metadata_json=METADATA)
    kit.processing.store(TRACES[2])
    other_trace(folder, None)
    kit.processing.close_survey(SURVEY, "stopped")
    assert trace_file(folder, 2).name in said(verify_survey(folder).faults)


def test_a_trace_that_is_in_json_alone_is_put_into_the_recordings(copies):
    folder = copies(CUT_OFF)
    shutil.copy(str(trace_file(copies(FINISHED), 7)), str(folder / "traces"))
    assert resume(folder).stored_indices == (*SIX, 7)
    assert_whole(folder, TRACES)


def test_what_was_never_finished_is_removed_and_is_never_data(copies):
    folder = copies(CUT_OFF)
    torn = [folder / "traces" / ".000006_X0050.00.json.0a.tmp", folder / ".survey.json.0a.tmp"]
    for path in torn:
        path.write_text("{")
    reopened = resume(folder)
    assert reopened.repairs[0].values["count"] == 2
    assert not any(path.exists() for path in torn)
    assert reopened.stored_indices == SIX
    assert_whole(folder, TRACES)
