"""Random damage to a survey's files: nothing is lost that an intact form holds, nothing is wrong,
and nothing is called intact or complete that is not, be it verified or reopened.

GPR20_SEED repeats the damages of a run."""

from __future__ import annotations

import random
from pathlib import Path

from annotation_examples import EXAMPLE
from log_examples import damaged, marker
from reopening_kit import REPORT, STORED, TRACES, assert_whole, tree
from run_seed import SEED, draws
from storage_kit import Kit
from trace_examples import assert_same_numbers, read_json

from gpr20_analysis.read.verdict import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import markers_of

SEAL = "manifest.json"
LOG_FILES = ("log.jsonl", "log.copy.jsonl")
LOG_FORMS = (*LOG_FILES, SEAL)
FORMS = ("traces", "survey.mcap", "survey.json", *LOG_FORMS)
LOOKS = 3


def damage(rng, folder, forms) -> None:
    for form in rng.sample(forms, rng.choice([1, 1, 1, 1, 2, 2, 3])):
        paths = [folder / form]
        if form == "traces":
            files = sorted((folder / "traces").iterdir())
            paths = rng.sample(files, rng.choice([1, 1, 2, len(files)]))
        for path in paths:
            if rng.random() < 0.15:
                path.unlink(missing_ok=True)
            elif path.exists():
                path.write_bytes(damaged(rng, path.read_bytes()))


def data_of(files):
    """Return all but the manifest, which also says when it was written, and what was kept."""
    return {
        name: content
        for name, content in files.items()
        if name != SEAL and not name.startswith("damaged/")
    }


def intact_forms(before, after, index):
    """Return the files that hold a trace and were not damaged."""
    name = next(one for one in before if one.startswith(f"traces/{index:06d}_"))
    return [one for one in (name, "survey.mcap") if after.get(one) == before[one]]


def is_noted(before, after) -> bool:
    """Return whether a file of the log was not damaged."""
    return any(after.get(one) == before[one] for one in LOG_FILES)


def check_facts(folder, before, after) -> None:
    """What was noted is all there, or what is missing is named; none of it is another."""
    description = read_description(folder)
    found = {one.marker_id: one for one in markers_of(description)}
    for number in (1, 2):
        one = found.pop(marker(number).marker_id, None)
        assert one.same_request(marker(number)) if one else description["unconfirmed"]
    assert not found
    assert annotation_of(description) == EXAMPLE or description["unconfirmed"]
    assert description.get("report") == REPORT or description["unconfirmed"]
    if is_noted(before, after):
        assert "unconfirmed" not in description


def check_verified(folder, before, after) -> None:
    """What was changed is named if there is a manifest, and is never called intact."""
    changed = [name for name in before if after.get(name) != before[name]]
    found = verify_survey(folder)
    if len(changed) == 1 and any(Path(changed[0]).name in str(one) for one in found.notes):
        # It looks as a power cut leaves it while its last line was added, which the other file has.
        assert changed[0] in LOG_FILES and before[changed[0]].startswith(after[changed[0]])
        return
    if not changed:
        return
    assert found.status != COMPLETE and "intact" not in str(found.verdict)
    if SEAL in before:
        assert found.status == DAMAGED
        named = [one for one in changed if Path(one).name in str([*map(str, found.faults)])]
        assert named and (len(changed) > 1 or named == changed)
    elif found.status == INCOMPLETE:
        assert "without a manifest, changes to" in str(found.verdict)


def reopen(kit, folder, before, after):
    """Return the reopened survey; None if it is complete, or nobody can say which one it is."""
    now = tree(folder)
    try:
        return kit.processing.reopen_survey(folder.name)
    except SurveyRefusedError as error:
        assert tree(folder) == now, "a survey that is refused was changed"
        if data_of(before) == data_of(now):
            assert error.message.fault_code == "survey.complete"
            return None
        for name in LOG_FILES:
            assert after.get(name) != before[name], str(error)
        return None


def check(rng, ending, folder, forms) -> None:
    if ending == "stopped" and rng.random() < 0.3:
        (folder / SEAL).unlink()  # the power was cut before it was written
    before = after = tree(folder)
    for _ in range(LOOKS):
        for name, content in before.items():
            (folder / name).write_bytes(content)
        damage(rng, folder, forms)
        after = tree(folder)
        check_verified(folder, before, after)
    kit = Kit(folder.parent)
    try:
        reopened = reopen(kit, folder, before, after)
        if reopened is None:
            return
        for index in range(STORED[ending]):
            assert index in reopened.stored_indices or not intact_forms(before, after, index)
        for path in (folder / "traces").iterdir():
            values = read_json(path)
            assert_same_numbers(TRACES[values["index"]], values)
        kit.finish(TRACES, reopened.stored_indices)
    finally:
        kit.processing.shut_down()
    assert_whole(folder, TRACES)
    check_facts(folder, before, after)
    found = verify_survey(folder)
    assert found.status == COMPLETE or (not found.faults and found.unconfirmed), found.faults
    assert found.status == COMPLETE or not is_noted(before, after), found.unconfirmed


def test_no_damage_loses_a_trace_or_makes_a_wrong_one(copies):
    for number in range(draws(24)):
        print(f"{number}: repeat with GPR20_SEED={SEED}")
        rng = random.Random(f"{SEED} {number}")
        # Half of them of what is noted alone.
        forms = FORMS if number % 2 else LOG_FORMS
        ending = rng.choice(["finished", "stopped", *["cut off"] * (number % 2)])
        check(rng, ending, copies(ending), forms)
