"""Whatever is sent: no error but those of the project, nothing without right, the page answers."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Iterator

import pytest
from fuzz_kit import Fuzz
from run_seed import SEED
from whole_page_kit import WholePage

from gpr20_web.roles import Role

# More: GPR20_FUZZ_REQUESTS.
REQUESTS = int(os.environ.get("GPR20_FUZZ_REQUESTS", "2000"))


@pytest.fixture
def page(tmp_path: Path) -> Iterator[WholePage]:
    made = WholePage(tmp_path)
    yield made
    made.close()
    assert made.foreign == []


def test_random_requests_do_nothing_without_right_and_the_page_answers(page: WholePage) -> None:
    fuzz, began_s = Fuzz(page, SEED), time.monotonic()
    fuzz.run(REQUESTS)
    page.renew()
    assert page.ask("GET", "/api/me", Role.VIEW).values["name"] == "vera"
    # Without these, the requests would only show that rubbish is refused.
    assert fuzz.answers[200] > REQUESTS / 10
    assert {role.word for role in Role if role is not Role.NOBODY} <= set(fuzz.acts)
    answers = ", ".join(f"{status}: {count}" for status, count in sorted(fuzz.answers.items()))
    print(f"{REQUESTS} requests in {time.monotonic() - began_s:.0f} s; answers {answers}")
    print(f"acts {dict(fuzz.acts)}; foreign exceptions {len(page.foreign)}")
