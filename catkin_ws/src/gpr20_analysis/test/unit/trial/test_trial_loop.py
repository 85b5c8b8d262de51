"""gpr20 trial from the plan to the score: nothing that was sealed changes unseen."""

from __future__ import annotations

import ast
import hashlib
import json
import random
import re
from pathlib import Path

import pytest
from candidate_examples import candidate, candidate_list
from trial_kit import LANES, TARGET_HEADING, TARGETS, Trial, flipped, marks_at

import gpr20_analysis
from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_survey.results.candidate_json import json_text

pytestmark = pytest.mark.usefixtures("blank_figures")
CHANGES = 100
# What no output of a trial ever calls ground, in English and Spanish.
NEVER = re.compile(
    r"\b(clear(ed|ance|s)?|free(d|ly)?|safe(ly|ty)?|libres?|segur[oa]s?|despejad[oa]s?)\b", re.I
)


@pytest.fixture
def trial(tmp_path):
    made = Trial(tmp_path)
    assert made.plan() == 0
    assert made.seal("L1", marks_at([(0.5, 0.5), (1.5, 0.5)])) == 0
    assert made.seal("L2", marks_at([(0.5, 0.45)])) == 0
    return made


def test_a_trial_goes_from_plan_to_score(trial, capsys):
    report = trial.folder / "report.json"
    assert trial.score("-o", str(report)) == 0
    values = json.loads(report.read_text())
    first = values["groups"][0]
    assert (first["targets"], first["found"], first["alarms"]) == (4, 2, 1)
    assert first["detection_range"] == pytest.approx([0.0676, 0.9324], abs=1e-4)
    finds = [
        (name, one and one["id"]) for lane in values["lanes"] for name, one in lane["found"].items()
    ]
    assert finds == [("T1", "C01"), ("T2", None), ("T3", "C01"), ("T4", None)]
    assert "2/4" in capsys.readouterr().out


def test_some_hundred_random_trials_are_scored_as_they_were_made(tmp_path):
    chance = random.Random(5)
    for number in range(200):
        folder = tmp_path / str(number)
        folder.mkdir()
        columns = [at for at in range(7) if chance.random() < 0.8] or [0]
        rows = [f"T{at},L1,{0.3 + at * 0.5:.3f},0.5,0.05,PMN,,," for at in columns]
        trial = Trial(folder, targets="\n".join([TARGETS.splitlines()[0], *rows, ""]))
        assert trial.plan() == 0
        seen = [at for at in columns if chance.random() < 0.7]
        false = chance.randrange(4)
        places = [(0.3 + at * 0.5 + chance.uniform(-0.06, 0.06), 0.5) for at in seen]
        assert trial.seal("L1", marks_at([*places, *[(0.2 + at, 0.9) for at in range(false)]])) == 0
        report = folder / "report.json"
        assert trial.score("-o", str(report)) == 0
        first = json.loads(report.read_text())["groups"][0]
        assert (first["targets"], first["found"], first["alarms"]) == (
            len(columns), len(seen), false,
        )  # fmt: skip


def test_the_plan_promises_the_truth_and_does_not_reveal_it(trial):
    plan = trial.file.read_text()
    both = trial.salt.read_bytes() + trial.truth.read_bytes()
    assert json.loads(plan)["truth_sha256"] == hashlib.sha256(both).hexdigest()
    assert hashlib.sha256(trial.truth.read_bytes()).hexdigest() not in plan
    assert trial.salt.read_text().strip() not in plan
    # The time of planning may hold "T1" by itself: 2026-01-01T10:00:00.
    without_times = re.sub(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?", "", plan)
    assert not any(one in without_times for one in ("PMN", "T1", "0.05", "2026-10-01"))


def test_an_altered_truth_is_refused_100_of_100_times(trial, refusals, capsys):
    chance, truth = random.Random(1), trial.truth.read_bytes()
    digits = [at for at, one in enumerate(truth) if chr(one).isdigit()]
    seen = set()
    while len(seen) < CHANGES:
        # Half of the changes keep the table a table: another digit.
        changed = flipped(truth, chance)
        if len(seen) % 2:
            at = chance.choice(digits)
            changed = truth[:at] + str((truth[at] - 47) % 10).encode() + truth[at + 1 :]
        seen.add(changed)
        trial.truth.write_bytes(changed)
        assert trial.score("-o", str(trial.folder / "report.json")) == 3
    assert refusals == [faults.FILE_CHANGED.code] * len(refusals) and len(refusals) >= CHANGES
    assert "found" not in capsys.readouterr().out.replace("found by", "")
    assert not (trial.folder / "report.json").exists()


@pytest.mark.parametrize(
    "change",
    [
        lambda truth: truth + b"\n",
        lambda truth: truth.replace(b"\n", b"\r\n"),
        lambda truth: b"\xef\xbb\xbf" + truth,
        lambda truth: b"".join([*truth.splitlines(True)[:3], *truth.splitlines(True)[3:][::-1]]),
        lambda truth: truth.replace(b"0.5,", b"0.50,", 1),
    ],
)
def test_a_truth_that_says_the_same_in_other_bytes_is_refused(trial, refusals, change):
    trial.truth.write_bytes(change(trial.truth.read_bytes()))
    assert trial.score() == 3 and refusals == [faults.FILE_CHANGED.code]


@pytest.mark.parametrize("which", ["salt", "plan", "sealed list"])
def test_a_changed_byte_of_salt_plan_or_sealed_list_is_refused_100_of_100_times(
    trial, refusals, which
):
    path = {"salt": trial.salt, "plan": trial.file, "sealed list": trial.sealed[1]}[which]
    chance, content = random.Random(2), path.read_bytes()
    for _ in range(CHANGES):
        path.write_bytes(flipped(content, chance))
        assert trial.score() == 3
    assert refusals == [faults.FILE_CHANGED.code] * CHANGES
    path.write_bytes(content)
    assert trial.score() == 0


def test_salt_and_truth_cannot_share_their_bytes_in_another_way(trial):
    # The salt has one length, so the promise has one reading.
    trial.truth.write_bytes(trial.salt.read_bytes()[-1:] + trial.truth.read_bytes())
    trial.salt.write_bytes(trial.salt.read_bytes()[:-1])
    assert trial.score() == 3


def test_a_plan_that_was_changed_and_hashed_again_fits_no_sealed_list(trial, refusals):
    values = json.loads(trial.file.read_text())
    del values["sha256"]
    values["halo_m"] = 0.5
    trial.file.write_bytes(hashed(values))
    assert trial.score() == 3 and refusals == [faults.FILE_CHANGED.code]


def hashed(values):
    values = {key: value for key, value in values.items() if key != "sha256"}
    own = hashlib.sha256((json.dumps(values, indent=2) + "\n").encode()).hexdigest()
    return (json.dumps({**values, "sha256": own}, indent=2) + "\n").encode()


def test_a_list_that_was_sealed_for_another_plan_is_refused(trial, tmp_path, refusals):
    other = tmp_path / "other.json"
    own = ("--halo", "0.2", "--strata", "type", "-o", str(other))
    assert main(["trial", "plan", str(trial.lanes), str(trial.truth), *own]) == 0
    trial.file = other
    assert trial.score() == 3 and refusals == [faults.FILE_CHANGED.code]


def test_nothing_of_a_trial_is_replaced(trial, capsys):
    before = {one: one.read_bytes() for one in (trial.file, trial.salt, *trial.sealed)}
    assert trial.plan() == 3
    listed = trial.sealed[0].with_suffix(".csv")
    assert trial.seal_file(listed, trial.sealed[0], "L1") == 3
    assert "never replaced" in capsys.readouterr().err
    assert {one: one.read_bytes() for one in before} == before


def test_nothing_of_a_trial_is_written_into_a_survey(trial, capsys):
    survey = trial.folder / "survey"
    (survey / "traces").mkdir(parents=True)
    (survey / "survey.json").touch()
    listed = trial.sealed[0].with_suffix(".csv")
    assert trial.seal_file(listed, survey / "sealed.json", "L1") == 3
    assert "measured data" in capsys.readouterr().err
    assert not (survey / "sealed.json").exists()


def test_a_plan_with_wrong_options_is_refused_and_leaves_nothing(tmp_path, capsys):
    trial = Trial(tmp_path)
    before = sorted(tmp_path.iterdir())
    for options, said in (
        (("--strata", "type,colour"), "colour"),
        (("--strata", ""), "heading"),
    ):
        assert trial.plan(*options) == 3
        assert said in capsys.readouterr().err
    assert trial.plan(halo_m=0.0) == 3
    assert "halo radius" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("salt", [b"", b"0" * 64, b"0" * 64 + b"\r\n", b"A" * 64 + b"\n"])
def test_a_salt_that_no_plan_wrote_is_refused_and_left_as_it_is(tmp_path, capsys, salt):
    trial = Trial(tmp_path)
    trial.salt.write_bytes(salt)
    assert trial.plan() == 3
    assert "targets.csv.salt" in (said := capsys.readouterr().err) and "delete it" in said
    assert not trial.file.exists() and trial.salt.read_bytes() == salt


@pytest.mark.parametrize("option", ["--method", "--operator"])
@pytest.mark.parametrize("text", ["", " "])
def test_a_list_is_not_sealed_without_the_name_of(trial, option, text, capsys):
    sealed, listed = trial.folder / "sealed.json", trial.sealed[0].with_suffix(".csv")
    own = ("--lane", "L1", "--method", "m", "--operator", "o", option, text, "-o", str(sealed))
    assert main(["trial", "seal", str(trial.file), str(listed), *own]) == 3
    assert f"{option} is" in capsys.readouterr().err and not sealed.exists()


@pytest.mark.parametrize("column", ["Doubtful", "doubtful", "above_clutter_db"])
def test_a_list_with_a_column_that_would_not_count_is_refused(trial, column, capsys):
    listed, sealed = trial.folder / "list.csv", trial.folder / "sealed.json"
    listed.write_text(f"id,x_m,y_m,{column}\nA,1,0.5,1\n")
    assert trial.seal_file(listed, sealed, "L1") == 3
    said = capsys.readouterr().err
    assert f"'{column}'" in said and "id, x_m, y_m" in said and not sealed.exists()


def test_a_list_that_was_sealed_for_two_lanes_is_refused(trial, refusals, capsys):
    listed = trial.folder / "list.csv"
    listed.write_text("id,x_m,y_m\nA,1,0.5\n")
    trial.sealed = [trial.folder / "a.json", trial.folder / "b.json"]
    for sealed, lane in zip(trial.sealed, ("L1", "L2")):
        assert trial.seal_file(listed, sealed, lane) == 0
    assert trial.score() == 3 and refusals == [faults.FILE_CHANGED.code]
    assert "for radar, L1 and for radar, L2" in capsys.readouterr().err


def test_false_alarms_are_counted_where_nothing_is_buried(tmp_path, capsys):
    trial = Trial(tmp_path, LANES.splitlines()[0] + "\nL1,0,4,0,1,sand\n", TARGET_HEADING + "\n")
    assert trial.plan() == trial.seal("L1", marks_at([(0.5, 0.5)])) == 0
    assert trial.score("-o", str(tmp_path / "report.html")) == 0
    rows = [one for one in capsys.readouterr().out.splitlines() if "0/0 | - |" in one]
    assert ["| 1 | 4.00 | 0.250 |" in one for one in rows] == [True, True]


def test_the_planner_learns_how_many_targets_there_are(tmp_path, capsys):
    Trial(tmp_path).plan()
    printed = capsys.readouterr().out
    assert "29 targets" in printed and "     4  all targets" in printed


def test_a_list_of_gpr20_candidates_is_sealed_with_its_hash_and_what_it_shows(trial, capsys):
    listed = trial.folder / "list.json"
    found = candidate_list([candidate(1, 500.0, 500.0), candidate(2, 2500.0, 500.0)])
    listed.write_text(json_text(found), encoding="utf-8")
    sealed = trial.folder / "sealed.json"
    assert trial.seal_file(listed, sealed, "L1", "other") == 0
    values = json.loads(sealed.read_text())
    assert values["list_sha256"] == hashlib.sha256(listed.read_bytes()).hexdigest()
    assert (values["simulated"], values["area_m2"], values["operator"]) == (True, 0.25, "Eva")
    trial.sealed.append(sealed)
    assert trial.score() == 0
    printed = capsys.readouterr().out
    assert "SIMULATED" in printed and "other surveyed only 0.25 m2" in printed
    assert "1 only by other" in printed


def test_a_survey_in_place_of_a_list_is_refused_with_the_command_that_makes_one(trial, capsys):
    assert trial.seal_file(trial.folder, trial.folder / "sealed.json", "L1") == 3
    assert "gpr20 candidates SURVEY -o LIST.json" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["list.json", "list.csv", "list.txt"])
def test_what_is_no_list_is_not_sealed(trial, name, capsys):
    listed = trial.folder / name
    listed.write_text('{"format": "other"}')
    assert trial.seal_file(listed, trial.folder / "sealed.json", "L1") == 3
    assert not (trial.folder / "sealed.json").exists() and name in capsys.readouterr().err


def test_an_unknown_lane_is_refused_with_those_of_the_plan(trial, capsys):
    assert trial.seal("L7", marks_at([(1.0, 0.5)])) == 3
    assert "L7" in (printed := capsys.readouterr().err) and "L1, L2" in printed


def without_pictures(text):
    return re.sub(r"base64,[A-Za-z0-9+/=]+", "", text)


def test_no_output_says_that_ground_is_what_only_people_may_say(trial, capsys):
    assert trial.seal("L1", marks_at([(0.5, 0.5), (9.0, 9.0)]), "detector") == 0
    said = []
    for language in ("en", "es"):
        for ending in ("html", "json"):
            report = trial.folder / f"{language}.{ending}"
            assert trial.score("-o", str(report), "--language", language) == 0
            said.append(without_pictures(report.read_text()))
        said += [trial.file.read_text(), *(one.read_text() for one in trial.sealed)]
        for action in ((), ("plan",), ("seal",), ("score",)):
            main(["trial", *action, "--help"])
        trial.plan("--language", language)
        printed = capsys.readouterr()
        said += [printed.out, printed.err]
    assert all(len(one) > 100 for one in said[:3])
    assert [found.group() for one in said for found in NEVER.finditer(one)] == []


def test_no_sentence_of_the_sources_of_trials_says_it_either():
    package = Path(gpr20_analysis.__file__).parent
    sources = [*package.glob("trial/*.py"), package / "report/trial_report.py"]
    sources += [package / f"commands/{name}_command.py" for name in ("trial", "found")]
    sources += [package / "plotting/froc.py"]
    texts = [
        node.value
        for source in sources
        for node in ast.walk(ast.parse(source.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    assert len(texts) > 100
    assert [one for one in texts if NEVER.search(one)] == []
