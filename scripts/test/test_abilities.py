"""Tests of what a machine does not allow are skipped with the reason."""

from __future__ import annotations

import os

import pytest
from pytest_gpr20.abilities import ABILITIES, reason_against

FAILING = """#!/bin/sh
echo "$@" >>"{calls}"
echo "mount: must be superuser" >&2
exit 1
"""


def test_the_machine_is_tried_once_and_the_reason_is_what_its_program_says(tmp_path, monkeypatch):
    calls, program = tmp_path / "calls", tmp_path / "mount"
    program.write_text(FAILING.format(calls=calls))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    reason_against.cache_clear()
    try:
        reasons = {reason_against("mounts") for _test in range(2)}
    finally:
        reason_against.cache_clear()
    assert reasons == {"no mounts here: mount: must be superuser"}
    assert len(calls.read_text().splitlines()) == 1


@pytest.mark.parametrize("ability", ABILITIES)
def test_without_its_programs_a_machine_lacks_an_ability_or_needs_none(
    ability, tmp_path, monkeypatch
):
    monkeypatch.setenv("PATH", str(tmp_path))
    reason_against.cache_clear()
    try:
        reason = reason_against(ability)
    finally:
        reason_against.cache_clear()
    assert bool(reason) == (ability in ("network namespaces", "firewall", "mounts", "packages"))
