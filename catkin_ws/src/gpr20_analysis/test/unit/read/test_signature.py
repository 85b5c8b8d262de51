"""A survey is signed with the robot's key; whoever changes it without that key is found."""

import os
import random
import shutil
import subprocess

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from run_seed import SEED, draws
from storage_kit import fingerprint, make_key, signers_line
from trace_examples import SURVEY

from gpr20_analysis.read.signature import Signature, check_signature
from gpr20_common.message import Severity
from gpr20_survey import faults
from gpr20_survey.errors import SigningError, StorageFailedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, signature
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.signature import (
    NAMESPACE,
    SIGNATURE_FILE,
    Signer,
    key_warning,
    try_to_sign,
)

WRITTEN = "2026-09-21T15:00:00.000000+00:00"
SEAL = "manifest.json"


def seal(folder, revision="1.2.3"):
    plan = LogRecord.after(None, Kind.PLAN, {"survey_id": SURVEY}, WRITTEN)
    manifest.write_manifest(folder, SURVEY, plan, revision, WRITTEN)


def make_folder(folder):
    (folder / "traces").mkdir(parents=True)
    for index in range(8):
        (folder / "traces" / f"{index}.json").write_bytes(b"{}\n" * index)
    (folder / "survey.json").write_bytes(b"{}\n")
    seal(folder)
    return folder


@pytest.fixture(scope="module")
def keys(tmp_path_factory):
    """Return the folder of the robot's key, of another one's and of one with a passphrase."""
    folder = tmp_path_factory.mktemp("keys")
    for name in ("robot", "other"):
        make_key(folder / name)
    make_key(folder / "secret", "a passphrase")
    (folder / "signers").write_text(f"# robots\n\n{signers_line(folder / 'robot')}")
    return folder


@pytest.fixture
def signers(keys):
    return keys / "signers"


@pytest.fixture
def robot(keys):
    return Signer(keys / "robot")


@pytest.fixture
def folder(tmp_path, robot):
    made = make_folder(tmp_path / "survey")
    robot.sign(made)
    return made


def found(folder, signers):
    return check_signature(folder, signers).state


def test_a_signed_survey_names_its_robot_and_its_key_and_openssh_alone_agrees(
    folder, keys, signers
):
    check = check_signature(folder, signers)
    assert (check.state, check.signer) == (Signature.VALID, "robot")
    assert check.fingerprint == fingerprint(keys / "robot")
    command = ["ssh-keygen", "-Y", "verify", "-f", str(signers), "-I", "robot"]
    command += ["-n", NAMESPACE, "-s", str(folder / SIGNATURE_FILE)]
    content = (folder / SEAL).read_bytes()
    assert subprocess.run(command, input=content, check=False).returncode == 0
    assert subprocess.run(command, input=content + b" ", check=False).returncode != 0


def test_each_changed_byte_of_the_manifest_or_the_signature_is_found(folder, signers):
    draw = random.Random(SEED)
    for name in (SEAL, SIGNATURE_FILE):
        content = (folder / name).read_bytes()
        changed = [content + b"\n", content[:-1], content.replace(b"\n", b"\r\n"), b""]
        for _ in range(draws(50)):
            where = draw.randrange(len(content))
            other = (content[where] + draw.randrange(1, 256)) % 256
            changed.append(content[:where] + bytes([other]) + content[where + 1 :])
        for one in changed:
            (folder / name).write_bytes(one)
            kind = found(folder, signers)
            assert kind not in (Signature.VALID, Signature.UNSIGNED), one
            assert kind is Signature.WRONG or name == SIGNATURE_FILE, one
        (folder / name).write_bytes(content)
    assert found(folder, signers) is Signature.VALID


@each_case("kind", [Signature.UNKNOWN_KEY, Signature.UNSIGNED, Signature.WRONG])
def test_a_survey_that_somebody_else_sealed_again_is_found(tmp_path, keys, signers, kind):
    """A trace is changed, and a manifest that fits is written, as a program of ours would."""
    folder = make_folder(tmp_path / kind.name)
    Signer(keys / "robot").sign(folder)
    (folder / "traces" / "3.json").write_bytes(b"{}")
    seal(folder)
    if kind is Signature.UNKNOWN_KEY:
        Signer(keys / "other").sign(folder)
    elif kind is Signature.UNSIGNED:
        (folder / SIGNATURE_FILE).unlink()
    assert found(folder, signers) is kind


def lines(keys):
    """Return signers files and what they make of a signature by the robot's key."""
    kind, blob = (keys / "robot.pub").read_text().split()[:2]
    key = f"{kind} {blob}"
    valid, unknown = Signature.VALID, Signature.UNKNOWN_KEY
    return [
        (f'"the robot" {key}', valid, "the robot"),
        (f'a {key}x\nb bad\nc\n\x00\xff\nd nonsense="1" {key}\ne {key}', valid, "e"),
        (f'a valid-after="20200101",valid-before="29990101" {key}', valid, "a"),
        (f'a namespaces="file" {key}', unknown, ""),
        (f"a cert-authority {key}", unknown, ""),
    ]


def test_the_signers_file_decides_whose_key_counts(tmp_path, folder, keys):
    path = tmp_path / "signers"
    for text, expected, signer in lines(keys):
        path.write_text(f"{text}\n", encoding="latin-1")
        check = check_signature(folder, path)
        assert (check.state, check.signer) == (expected, signer), text


def test_a_signature_for_another_purpose_does_not_count(folder, keys, signers):
    made = signature.use_key(
        keys / "robot", ("-Y", "sign", "-n", "file"), (folder / SEAL).read_bytes()
    )
    (folder / SIGNATURE_FILE).write_text(made)
    assert found(folder, signers) is Signature.WRONG


def make_link(path):
    target = path.with_name("target")
    path.rename(target)
    path.symlink_to(target)


def make_pipe(path):
    path.unlink()
    os.mkfifo(path)


def make_huge(path):
    with path.open("ab") as file:
        file.truncate(40 << 30)


def remove(path):
    path.unlink()


@each_case("change", [make_link, make_pipe, make_huge])
@each_case("name", [SIGNATURE_FILE, SEAL])
def test_what_is_no_file_or_has_no_end_is_wrong_and_never_read(
    tmp_path, folder, signers, name, change
):
    copy = tmp_path / change.__name__ / name
    shutil.copytree(folder, copy)
    change(copy / name)
    check = check_signature(copy, signers)
    assert check.state is Signature.WRONG
    assert name in str(check.message)


def test_a_survey_without_a_manifest_is_not_signed(folder, robot, signers):
    (folder / SEAL).unlink()
    assert found(folder, signers) is Signature.UNSIGNED
    with pytest.raises(StorageFailedError, match="no such file"):
        robot.sign(folder)


KEYS = {
    "missing": remove,
    "read by all": lambda key: key.chmod(0o644),
    "with a passphrase": lambda key: shutil.copyfile(key.with_name("secret"), key),
    "the public part": lambda key: shutil.copyfile(key.with_name("robot.pub"), key),
    "beside another's public part": lambda key: shutil.copyfile(
        key.with_name("other.pub"), key.with_name("robot.pub")
    ),
    "a pipe": make_pipe,
}


@each_case("case", KEYS)
def test_a_key_that_cannot_be_used_is_named_and_the_survey_stays_as_it_is(
    tmp_path, keys, signers, case, monkeypatch
):
    # An agent with a key, or somebody to ask, must not be needed or waited for.
    monkeypatch.setenv("SSH_ASKPASS", "/bin/cat")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("SSH_ASKPASS_REQUIRE", "force")
    place = tmp_path / case
    shutil.copytree(keys, place / "keys")
    key = place / "keys" / "robot"
    folder = make_folder(place / "survey")
    Signer(key).sign(folder)
    before = (folder / SIGNATURE_FILE).read_bytes()
    seal(folder, "2.0.0")
    KEYS[case](key)
    for action in (lambda: Signer(key).sign(folder), Signer(key).check):
        with raises_fault(faults.NOT_SIGNED, key, error=SigningError):
            action()
    for warning in (try_to_sign(Signer(key), folder), key_warning(Signer(key))):
        assert warning.cause.severity is Severity.WARNING and warning.cause.can_continue
        assert warning.fault_code == faults.NOT_SIGNED.code and warning.remedy is not None
    assert (folder / SIGNATURE_FILE).read_bytes() == before
    assert found(folder, signers) is Signature.WRONG


def test_a_full_disk_leaves_the_former_signature(folder, robot, monkeypatch):
    def full(_path, _content):
        raise OSError(28, "No space left on device")

    before = (folder / SIGNATURE_FILE).read_bytes()
    seal(folder, "2.0.0")
    monkeypatch.setattr(durable_files, "replace_file", full)
    assert try_to_sign(robot, folder).cause.severity is Severity.WARNING
    assert (folder / SIGNATURE_FILE).read_bytes() == before


OTHER_PROGRAMS = {
    "absent": None,
    "too old": "exit 1",
    "hangs": "exec sleep 60",
}


@each_case("case", OTHER_PROGRAMS)
def test_without_a_working_ssh_keygen_nothing_is_signed_and_nothing_is_called_wrong(
    tmp_path, folder, keys, signers, case
):
    script, place = OTHER_PROGRAMS[case], tmp_path / case
    place.mkdir()
    if script is not None:
        (place / "ssh-keygen").write_text(f"#!/bin/sh\n{script}\n")
        (place / "ssh-keygen").chmod(0o755)
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("PATH", f"{place}" if script is None else f"{place}:/bin:/usr/bin")
        if case == "hangs":
            patched.setattr(signature, "TIMEOUT_S", 0.3)
        with raises_fault(faults.NOT_SIGNED, "ssh-keygen", error=SigningError):
            Signer(keys / "robot").sign(folder)
        with raises_fault(faults.NOT_SIGNED, "ssh-keygen", error=SigningError):
            check_signature(folder, signers)
    assert found(folder, signers) is Signature.VALID


@each_case("change", [remove, make_pipe, make_huge])
def test_a_signers_file_that_cannot_be_read_is_refused(tmp_path, folder, keys, change):
    path = tmp_path / f"signers {change.__name__}"
    shutil.copyfile(keys / "signers", path)
    change(path)
    with raises_fault("value.not_allowed", path):
        check_signature(folder, path)
