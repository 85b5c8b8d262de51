"""Who may what: a table that was written by hand, and every cell of it over a real socket."""

from __future__ import annotations

from itertools import product
from typing import Any, Iterator, Mapping, Optional, Sequence
from uuid import uuid4

import pytest
from login_kit import PASSWORD
from route_table import ADMIN, NOBODY, OPERATE, STOP, TABLE, VIEW, Row, S
from whole_page_kit import WholePage, is_without_right

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.roles import Role

# What another page can make a browser send.
OF_OTHERS = ({"Sec-Fetch-Site": "same-site"}, {"Sec-Fetch-Site": "cross-site"})
WITHOUT_ORIGIN: Sequence[Mapping[str, Optional[str]]] = (
    {"Origin": None},
    {"Origin": "null"},
    {"Origin": "https://other.example"},
    {"Content-Type": "text/plain"},
    {"Content-Type": None},
)
CHANGES = [row for row in TABLE if row.method != "GET"]


def _named(row: Any) -> Any:
    return f"{row.method} {row.path}" if isinstance(row, Row) else None


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mapping[bool, WholePage]]:
    made = {
        may_stop: WholePage(tmp_path_factory.mktemp("page"), may_stop) for may_stop in (True, False)
    }
    yield made
    for page in made.values():
        page.close()
        assert page.foreign == []


def _path(page: WholePage, row: Row) -> str:
    return row.path.format(folder=page.surveys.whole)


def test_the_table_has_every_route_and_every_route_is_in_the_table(
    pages: Mapping[bool, WholePage],
) -> None:
    page = pages[True]
    found = {
        _named(row): [
            one for one in page.routes if one.method == row.method and one.match(path) is not None
        ]
        for row, path in ((row, _path(page, row)) for row in TABLE)
    }
    assert [row for row, routes in found.items() if len(routes) != 1] == []
    known = {id(routes[0]) for routes in found.values()}
    assert [one.pattern for one in page.routes if id(one) not in known] == []


@pytest.mark.parametrize("row", TABLE, ids=_named)
def test_each_route_is_for_the_roles_of_the_table(
    pages: Mapping[bool, WholePage], row: Row
) -> None:
    for (view_may_stop, page), role in product(pages.items(), Role):
        least = OPERATE if row is STOP and not view_may_stop else row.right
        page.renew()
        before = page.done()
        reply = page.ask(row.method, _path(page, row), role, row.values)
        assert is_without_right(reply) is (role < least)
        if role < least:
            assert reply.status == (401 if role is NOBODY else 403)
            assert page.done() == before


@pytest.mark.parametrize("row", TABLE, ids=_named)
def test_nothing_is_done_for_another_page(pages: Mapping[bool, WholePage], row: Row) -> None:
    page = pages[True]
    page.renew()
    before = page.done()
    for headers in OF_OTHERS if row.method == "GET" else (*OF_OTHERS, *WITHOUT_ORIGIN):
        reply = page.ask(row.method, _path(page, row), ADMIN, row.values, headers=headers)
        assert (reply.status, reply.values["code"]) == (403, "web.bad_request")
    assert page.done() == before


# These need a search, somebody who asks, or an imaging node that answers: other tests have them.
NOT_HERE = (
    "/api/control/pass",
    "/api/ground/focus",
    "/api/ground/hide",
    "/api/ground/cancel",
    f"{S}/found",
)
STATES = {"/api/pause": SurveyState.SURVEYING, "/api/resume": SurveyState.PAUSED}


@pytest.mark.parametrize("row", [one for one in CHANGES if one.path not in NOT_HERE], ids=_named)
def test_who_may_do_something_does_it(pages: Mapping[bool, WholePage], row: Row) -> None:
    page, role = pages[True], max(row.right, VIEW)
    page.renew()
    page.be(STATES.get(row.path, SurveyState.CONFIGURED))
    page.controller.holder = page.person(role)
    if row.path == "/api/users/eva" and page.accounts.find("eva") is None:
        page.accounts.add("eva", VIEW, PASSWORD)
    before = page.done()
    pressed = {"press": uuid4().hex, "pressed_ms": 1e3 * page.clock.time_s}
    reply = page.ask(row.method, _path(page, row), role, {**row.values, **pressed})
    assert reply.status == 200, reply.body
    assert page.done() != before
