"""A survey is signed with the robot's key; whoever changes it without that key is found."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from trace_examples import SURVEY

from gpr20_common.message import Severity
from gpr20_survey import faults
from gpr20_survey.errors import SigningError
from gpr20_survey.files import durable_files, file_sums, ssh_keygen
from gpr20_survey.folder import manifest, sealing, signature
from gpr20_survey.folder.signature import (
    NAMESPACE,
    SIGNATURE_FILE,
    Signature,
    SignatureCheck,
    Signer,
    check_signature,
    key_warning,
    try_to_sign,
)

ROBOT = "GPR-20 norte"
WRITTEN = "2026-09-21T15:00:00.000000+00:00"


def seal(folder, revision="1.2.3"):
    sealing.write_manifest(folder, SURVEY, revision, WRITTEN)


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
        ssh_keygen.make_key(folder / name, ROBOT)
    secret = ("-q", "-t", "ed25519", "-N", "secret", "-C", ROBOT, "-f", folder / "secret")
    assert ssh_keygen.ask(secret).yes
    line = ssh_keygen.public_key(folder / "robot").signers_line(ROBOT, NAMESPACE)
    (folder / "signers").write_text(f"# robots\n\n{line}\n")
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
    return check_signature(folder, signers).signature


def test_a_signed_survey_names_its_robot_and_its_key(folder, keys, signers):
    fingerprint = ssh_keygen.public_key(keys / "robot").fingerprint
    check = check_signature(folder, signers)
    assert check == SignatureCheck(Signature.VALID, "GPR-20-norte", fingerprint)
    before = sorted(folder.rglob("*"))
    (folder / SIGNATURE_FILE).unlink()
    assert found(folder, signers) is Signature.UNSIGNED
    assert set(before) - set(folder.rglob("*")) == {folder / SIGNATURE_FILE}


def test_openssh_alone_checks_a_survey_as_well(folder, signers):
    command = ["ssh-keygen", "-Y", "verify", "-f", str(signers), "-I", "GPR-20-norte"]
    command += ["-n", NAMESPACE, "-s", str(folder / SIGNATURE_FILE)]
    content = (folder / "manifest.json").read_bytes()
    assert subprocess.run(command, input=content, check=False).returncode == 0
    assert subprocess.run(command, input=content + b" ", check=False).returncode != 0


def test_the_signature_is_no_file_of_the_manifest_and_the_next_seal_is_signed_again(
    folder, robot, signers
):
    seal(folder, "2.0.0")
    assert SIGNATURE_FILE not in manifest.read_manifest(folder).files
    robot.sign(folder)
    assert found(folder, signers) is Signature.VALID


def changed_byte(content, draw):
    where = draw.randrange(len(content))
    other = (content[where] + draw.randrange(1, 256)) % 256
    return content[:where] + bytes([other]) + content[where + 1 :]


def checked_in_threads(tmp_path, folder, signers, changes):
    """Return what is found in a copy of a folder after each change; it is applied to the copy."""

    def of_part(part):
        copy = tmp_path / f"part{part}"
        shutil.copytree(folder, copy)
        return [
            (change(copy), check_signature(copy, signers).signature)[1]
            for change in changes[part::4]
        ]

    with ThreadPoolExecutor(4) as pool:
        return [one for part in pool.map(of_part, range(4)) for one in part]


def test_2000_changed_bytes_of_the_manifest_are_all_found(tmp_path, folder, signers):
    content = (folder / "manifest.json").read_bytes()
    draw = random.Random(20)
    changed = [changed_byte(content, draw) for _ in range(2000)]
    changes = [lambda copy, one=one: (copy / "manifest.json").write_bytes(one) for one in changed]
    assert set(checked_in_threads(tmp_path, folder, signers, changes)) == {Signature.WRONG}


def test_200_changed_bytes_of_the_signature_are_all_found(tmp_path, folder, signers):
    content = (folder / SIGNATURE_FILE).read_bytes()
    draw = random.Random(21)
    changed = [changed_byte(content, draw) for _ in range(200)]
    changed += [content + b"\n", content[:-1], content.replace(b"\n", b"\r\n"), b"", content * 2]
    changes = [lambda copy, one=one: (copy / SIGNATURE_FILE).write_bytes(one) for one in changed]
    results = checked_in_threads(tmp_path, folder, signers, changes)
    assert Signature.VALID not in results and Signature.UNSIGNED not in results


def test_100_surveys_that_somebody_else_sealed_again_are_all_found(tmp_path, folder, keys, signers):
    draw = random.Random(22)
    other = Signer(keys / "other")

    def sealed_again(copy, kind):
        """Change a trace and write a manifest that fits, as a program of ours would."""
        shutil.copyfile(folder / SIGNATURE_FILE, copy / SIGNATURE_FILE)
        trace = copy / "traces" / f"{draw.randrange(8)}.json"
        trace.write_bytes(b"%d" % draw.getrandbits(64))
        seal(copy)
        if kind is Signature.UNKNOWN_KEY:
            other.sign(copy)
        elif kind is Signature.UNSIGNED:
            (copy / SIGNATURE_FILE).unlink()

    kinds = [Signature.UNKNOWN_KEY, Signature.UNSIGNED, Signature.STALE, Signature.STALE] * 25
    # In order, since each thread has every fourth: all of one kind.
    expected = sorted(kinds[:4], key=kinds[:4].index)
    changes = [lambda copy, kind=kind: sealed_again(copy, kind) for kind in kinds]
    results = checked_in_threads(tmp_path, folder, signers, changes)
    assert results == [kind for kind in expected for _ in range(25)]


def test_a_signature_of_an_earlier_manifest_is_not_valid_until_the_next_one(folder, robot, signers):
    # As after a power cut between the manifest and its signature.
    reopened = replace(manifest.read_manifest(folder), reopened=WRITTEN)
    durable_files.replace_file(folder / "manifest.json", reopened.encode())
    assert check_signature(folder, signers) == SignatureCheck(Signature.STALE, "GPR-20-norte")
    robot.sign(folder)
    assert found(folder, signers) is Signature.VALID


def test_the_manifest_of_another_survey_has_another_signature(tmp_path, folder, signers):
    other = make_folder(tmp_path / "other")
    seal(other, "1.2.4")
    shutil.copyfile(folder / SIGNATURE_FILE, other / SIGNATURE_FILE)
    assert found(other, signers) is Signature.STALE


def lines(keys):
    """Return signers files and what they make of a signature by the robot's key."""
    kind, blob = (keys / "robot.pub").read_text().split()[:2]
    key = f"{kind} {blob}"
    other = " ".join((keys / "other.pub").read_text().split()[:2])
    valid, unknown = Signature.VALID, Signature.UNKNOWN_KEY
    return [
        (f"* {key}", valid, "*"),
        (f"GPR-* {key} a comment", valid, "GPR-*"),
        (f"!x,GPR-?? {key}", valid, "GPR-??"),
        (f'"the robot" {key}', valid, "the robot"),
        (f"a,b {key}", valid, "a"),
        (f"a {other}\nb {key}", valid, "b"),
        (f'a namespaces="file,gpr20-*" {key}', valid, "a"),
        (f'a {key}x\nb bad\nc\n\x00\xff\nd nonsense="1" {key}\ne {key}', valid, "e"),
        (f'a valid-after="20200101",valid-before="29990101" {key}', valid, "a"),
        (f'a valid-before="20200101" {key}', unknown, ""),
        (f'a valid-after="29990101" {key}', unknown, ""),
        (f'a valid-before="yesterday" {key}', unknown, ""),
        (f'a namespaces="file" {key}', unknown, ""),
        # Of two lines for one key OpenSSH takes the first.
        (f'a namespaces="file" {key}\nb {key}', unknown, ""),
        (f"# a {key}", unknown, ""),
        (f"a {other}", unknown, ""),
        (f"a {key[:-8]}", unknown, ""),
        (f"a cert-authority {key}", unknown, ""),
        ("", unknown, ""),
    ]


def test_the_signers_file_decides_whose_key_counts(tmp_path, folder, keys):
    path = tmp_path / "signers"
    for text, expected, signer in lines(keys):
        path.write_text(f"{text}\n", encoding="latin-1")
        check = check_signature(folder, path)
        assert check.signature is expected, text
        assert signer == check.signer, text


def test_a_signature_for_another_purpose_does_not_count(folder, keys, signers):
    with (folder / "manifest.json").open("rb") as content:
        made = ssh_keygen.ask(("-Y", "sign", "-f", keys / "robot", "-n", "file"), content)
    (folder / SIGNATURE_FILE).write_text(made.output)
    assert found(folder, signers) is Signature.STALE


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


def make_zeros(path):
    path.unlink()
    path.symlink_to("/dev/zero")


def make_folder_of(path):
    path.unlink()
    path.mkdir()


ODD = [make_link, make_pipe, make_huge, make_zeros, make_folder_of]


@each_case("change", ODD)
@pytest.mark.parametrize("name", [SIGNATURE_FILE, "manifest.json"])
def test_what_is_no_file_or_has_no_end_is_wrong_and_never_read(
    tmp_path, folder, signers, name, change
):
    copy = tmp_path / change.__name__
    shutil.copytree(folder, copy)
    change(copy / name)
    check = check_signature(copy, signers)
    assert check.signature is Signature.WRONG
    assert name in str(check.reason)


@each_case("name", [SIGNATURE_FILE, "manifest.json"])
def test_a_survey_without_a_manifest_is_not_signed(tmp_path, keys, signers, name):
    folder = make_folder(tmp_path / f"without {name}")
    Signer(keys / "robot").sign(folder)
    (folder / name).unlink()
    assert found(folder, signers) is Signature.UNSIGNED
    (folder / "manifest.json").unlink(missing_ok=True)
    with raises_fault(faults.NOT_CLOSED, error=SigningError):
        Signer(keys / "robot").sign(folder)


def open_to(mode):
    def change(key):
        key.chmod(mode)

    return change


def write(content):
    def change(key):
        key.write_bytes(content)

    return change


def take_other_pub(key):
    shutil.copyfile(key.with_name("other.pub"), key.with_name("robot.pub"))


def take_secret(key):
    shutil.copyfile(key.with_name("secret"), key)


def take_public(key):
    shutil.copyfile(key.with_name("robot.pub"), key)


KEYS = {
    "missing": lambda key: key.unlink(),
    "read by all": open_to(0o644),
    "read by a group": open_to(0o640),
    "with a passphrase": take_secret,
    "the public part": take_public,
    "beside another's public part": take_other_pub,
    "empty": write(b""),
    "text": write(b"key\n"),
    "a folder": make_folder_of,
    "a pipe": make_pipe,
    "no end": make_zeros,
    "huge": make_huge,
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
    with raises_fault(faults.SIGNING_KEY, key, error=SigningError):
        Signer(key).sign(folder)
    with raises_fault(faults.SIGNING_KEY, key, error=SigningError):
        Signer(key).check()
    for warning in (try_to_sign(Signer(key), folder), key_warning(Signer(key))):
        assert warning.cause.severity is Severity.WARNING and warning.cause.can_continue
        assert warning.fault_code == faults.SIGNING_KEY.code and warning.remedy is not None
    assert (folder / SIGNATURE_FILE).read_bytes() == before
    assert found(folder, signers) is Signature.STALE


def test_a_key_may_be_a_link_to_a_disk_of_its_own(tmp_path, folder, keys, signers):
    link = tmp_path / "key"
    link.symlink_to(keys / "robot")
    (folder / SIGNATURE_FILE).unlink()
    assert try_to_sign(Signer(link), folder) is None
    assert found(folder, signers) is Signature.VALID


def test_a_robot_without_a_key_signs_nothing(folder, robot):
    (folder / SIGNATURE_FILE).unlink()
    assert try_to_sign(None, folder) is None
    assert key_warning(None) is None
    assert not (folder / SIGNATURE_FILE).exists()
    assert try_to_sign(robot, folder) is None
    assert key_warning(robot) is None
    assert (folder / SIGNATURE_FILE).is_file()


def test_a_full_disk_leaves_the_former_signature(folder, robot, monkeypatch):
    before = (folder / SIGNATURE_FILE).read_bytes()
    seal(folder, "2.0.0")
    monkeypatch.setattr(durable_files, "replace_file", _full)
    warning = try_to_sign(robot, folder)
    assert warning.cause.severity is Severity.WARNING
    assert (folder / SIGNATURE_FILE).read_bytes() == before


def _full(_path, _content):
    raise OSError(28, "No space left on device")


def program(tmp_path, name, script):
    """Make a program ssh-keygen; return the folder that holds it."""
    place = tmp_path / name
    place.mkdir()
    (place / "ssh-keygen").write_text(f"#!/bin/sh\n{script}\n")
    (place / "ssh-keygen").chmod(0o755)
    return place


OTHER_PROGRAMS = {
    "absent": None,
    "too old": "exit 1",
    "killed": "kill -9 $$",
    "hangs": "sleep 60",
}


@each_case("case", OTHER_PROGRAMS)
def test_without_a_working_ssh_keygen_nothing_is_signed_and_nothing_is_called_wrong(
    tmp_path, folder, keys, signers, case
):
    script = OTHER_PROGRAMS[case]
    place = tmp_path / "empty" if script is None else program(tmp_path, case, script)
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("PATH", f"{place}" if script is None else f"{place}:/bin:/usr/bin")
        patched.setattr(ssh_keygen, "TIMEOUT_S", 0.3)
        expected = faults.NOT_SIGNED if case == "hangs" else faults.NO_SSH_KEYGEN
        with raises_fault(expected, "ssh-keygen", error=SigningError):
            Signer(keys / "robot").sign(folder)
        with raises_fault(expected, "ssh-keygen", error=SigningError):
            check_signature(folder, signers)
    assert found(folder, signers) is Signature.VALID


def test_a_disk_that_cannot_be_read_is_not_called_a_wrong_signature(folder, signers, monkeypatch):
    def fail(_path, follow_link=False):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(signature, "_check_signers", lambda _path: None)
    monkeypatch.setattr(signature, "open_regular", fail)
    with pytest.raises(OSError, match="Input/output"):
        check_signature(folder, signers)


def test_a_user_without_a_name_is_told_so(folder, robot, signers, monkeypatch):
    monkeypatch.setattr(os, "getuid", lambda: 3_999_999)
    with raises_fault(faults.NO_SSH_KEYGEN, 3_999_999, error=SigningError):
        check_signature(folder, signers)
    with raises_fault(faults.NO_SSH_KEYGEN, 3_999_999, error=SigningError):
        robot.sign(folder)


@each_case("change", [lambda path: path.unlink(), make_pipe, make_huge, make_folder_of])
def test_a_signers_file_that_cannot_be_read_is_refused(tmp_path, folder, keys, change):
    path = tmp_path / f"signers {change.__name__}"
    shutil.copyfile(keys / "signers", path)
    change(path)
    with raises_fault(faults.SIGNERS_FILE, path):
        check_signature(folder, path)


def test_a_key_is_never_overwritten_and_only_its_owner_reads_it(tmp_path):
    path = tmp_path / "signing_key"
    ssh_keygen.make_key(path, ROBOT)
    assert path.stat().st_mode & 0o777 == 0o600
    before = path.read_bytes()
    with pytest.raises(FileExistsError):
        ssh_keygen.make_key(path, ROBOT)
    assert path.read_bytes() == before
    shown = subprocess.run(["ssh-keygen", "-l", "-f", path], stdout=subprocess.PIPE, check=True)
    assert ssh_keygen.public_key(path).fingerprint in shown.stdout.decode()


@each_case("name", ["GPR-20", "Ñandú 3", 'a"b,*!?\n# x y', "r@host.example", "名"])
def test_the_line_of_any_robot_accepts_its_signatures(tmp_path, keys, name):
    folder = make_folder(tmp_path / str(abs(hash(name))))
    Signer(keys / "robot").sign(folder)
    line = ssh_keygen.public_key(keys / "robot").signers_line(name, NAMESPACE)
    path = tmp_path / "line"
    path.write_text(line, encoding="ascii")
    assert found(folder, path) is Signature.VALID
    assert file_sums.sum_of_file(folder / SIGNATURE_FILE).size < 1000
