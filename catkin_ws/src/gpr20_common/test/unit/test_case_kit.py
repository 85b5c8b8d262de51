"""A test of many cases fails for each case that breaks its rule, and names it."""

import pytest
from case_kit import each_case


def test_every_case_that_fails_is_named_and_the_others_are_not():
    seen = []

    @each_case("number, text", [(1, "a"), (2, "b"), (3, "c"), (4, "d")])
    def rule(number, text):
        seen.append((number, text))
        assert number != 2
        if number == 3:
            raise KeyError(text)
        if number == 4:
            with pytest.raises(ValueError):
                int("4")

    with pytest.raises(AssertionError) as failed:
        rule()
    assert seen == [(1, "a"), (2, "b"), (3, "c"), (4, "d")]
    said = str(failed.value)
    assert "(1, 'a')" not in said
    for case in ("(2, 'b'): AssertionError", "(3, 'c'): KeyError", "(4, 'd'): Failed"):
        assert f"number, text = {case}" in said


@each_case("last", "xy")
@each_case("first", "ab")
def test_cases_of_two_kinds_meet_and_fixtures_are_passed_on(tmp_path, first, last):
    path = tmp_path / (first + last)
    path.touch(exist_ok=False)
    assert (path.parent / (first + "x")).exists()


def test_a_test_without_cases_or_with_a_case_of_another_length_is_refused():
    with pytest.raises(ValueError, match="without cases"):
        each_case("number", [])
    with pytest.raises(ValueError, match="number, text"):
        each_case("number, text", [(1, "a", "b")])
