"""gpr20 trial from the plan to the score: nothing that was sealed changes unseen."""

import hashlib
import json
import random
import re

import pytest
from candidate_examples import candidate, candidate_list
from log_examples import flipped
from run_seed import draws
from trial_kit import Trial, marks_at

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_survey.results.candidates import json_text

pytestmark = pytest.mark.usefixtures("blank_figures")
CHANGES = draws(25)
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


def test_the_plan_promises_the_truth_and_does_not_reveal_it(trial):
    plan = trial.file.read_text()
    both = trial.salt.read_bytes() + trial.truth.read_bytes()
    assert json.loads(plan)["truth_sha256"] == hashlib.sha256(both).hexdigest()
    assert hashlib.sha256(trial.truth.read_bytes()).hexdigest() not in plan
    assert trial.salt.read_text().strip() not in plan
    # The time of planning may hold "T1" by itself: 2026-01-01T10:00:00.
    without_times = re.sub(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?", "", plan)
    assert not any(one in without_times for one in ("PMN", "T1", "0.05", "2026-10-01"))


@pytest.mark.parametrize("which", ["truth", "salt", "plan", "sealed list"])
def test_a_changed_byte_is_refused_each_time(trial, refusals, which):
    files = {"truth": trial.truth, "salt": trial.salt, "plan": trial.file}
    path = files.get(which, trial.sealed[1])
    chance, content = random.Random(2), path.read_bytes()
    changed = [flipped(chance, content) for _ in range(CHANGES)]
    if which == "truth":  # it may say the same in other bytes, or stay a table
        rows = content.splitlines(True)
        changed += [content + b"\n", b"\xef\xbb\xbf" + content, content.replace(b"\n", b"\r\n")]
        changed += [b"".join([rows[0], *rows[:0:-1]]), content.replace(b"0.5,", b"0.50,", 1)]
        digits = [at for at, one in enumerate(content) if chr(one).isdigit()]
        for at in chance.sample(digits, CHANGES):
            other = str((content[at] - 47) % 10).encode()
            changed.append(content[:at] + other + content[at + 1 :])
    report = trial.folder / "report.json"
    for one in changed:
        path.write_bytes(one)
        assert trial.score("-o", str(report)) == 3
    assert refusals == [faults.FILE_DAMAGED.code] * len(changed) and not report.exists()
    path.write_bytes(content)
    assert trial.score() == 0


def test_what_would_not_count_is_not_sealed(trial, capsys):
    listed, sealed = trial.folder / "own.csv", trial.folder / "sealed.json"
    survey = trial.folder / "survey"
    (survey / "traces").mkdir(parents=True)
    (survey / "survey.json").touch()

    def refused(said, listed=listed, sealed=sealed, *more):
        own = ("--lane", "L1", "--method", "m", "--operator", "o", *more, "-o", str(sealed))
        assert main(["trial", "seal", str(trial.file), str(listed), *own]) == 3
        assert said in capsys.readouterr().err and not sealed.exists()

    listed.write_text("id,x_m,y_m,Doubtful\nA,1,0.5,1\n")
    refused("'Doubtful'")
    listed.write_text("id,x_m,y_m\nA,1,0.5\n")
    refused("measured data", listed, survey / "sealed.json")
    refused("gpr20 candidates SURVEY -o LIST.json", trial.folder)
    refused("--operator is", listed, sealed, "--operator", " ")
    refused("L1, L2", listed, sealed, "--lane", "L7")
    listed.write_text('{"format": "other"}')
    refused(listed.name)


def test_nothing_of_a_trial_is_replaced(trial, capsys):
    before = {one: one.read_bytes() for one in (trial.file, trial.salt, *trial.sealed)}
    assert trial.plan() == 3
    listed = trial.sealed[0].with_suffix(".csv")
    assert trial.seal_file(listed, trial.sealed[0], "L1") == 3
    assert "never replaced" in capsys.readouterr().err
    assert {one: one.read_bytes() for one in before} == before


def test_a_plan_with_wrong_options_or_the_salt_of_another_is_refused_and_leaves_nothing(
    tmp_path, capsys
):
    trial = Trial(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert trial.plan("--strata", "type,colour") == 3
    assert "colour" in capsys.readouterr().err
    assert trial.plan(halo_m=0.0) == 3
    assert "halo radius" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before
    # A salt that no plan wrote is left as it is.
    for salt in (b"", b"0" * 64, b"0" * 64 + b"\r\n"):
        trial.salt.write_bytes(salt)
        assert trial.plan() == 3
        assert "targets.csv.salt" in capsys.readouterr().err
        assert not trial.file.exists() and trial.salt.read_bytes() == salt


def test_a_list_that_was_sealed_for_two_lanes_is_refused(trial, refusals):
    listed = trial.folder / "list.csv"
    listed.write_text("id,x_m,y_m\nA,1,0.5\n")
    trial.sealed = [trial.folder / "a.json", trial.folder / "b.json"]
    for sealed, lane in zip(trial.sealed, ("L1", "L2")):
        assert trial.seal_file(listed, sealed, lane) == 0
    assert trial.score() == 3 and refusals == [faults.FILE_DAMAGED.code]


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


def test_no_output_says_that_ground_is_what_only_people_may_say(trial, capsys):
    assert trial.seal("L1", marks_at([(0.5, 0.5), (9.0, 9.0)]), "detector") == 0
    said = []
    for language in ("en", "es"):
        for ending in ("html", "json"):
            report = trial.folder / f"{language}.{ending}"
            assert trial.score("-o", str(report), "--language", language) == 0
            said.append(re.sub(r"base64,[A-Za-z0-9+/=]+", "", report.read_text()))
        said += [trial.file.read_text(), *(one.read_text() for one in trial.sealed)]
        for action in ((), ("plan",), ("seal",), ("score",)):
            main(["trial", *action, "--help"])
        trial.plan("--language", language)
        printed = capsys.readouterr()
        said += [printed.out, printed.err]
    assert all(len(one) > 100 for one in said[:3])
    assert [found.group() for one in said for found in NEVER.finditer(one)] == []
