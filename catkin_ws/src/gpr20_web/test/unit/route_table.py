"""Who may what: the table of the page, written by hand from what was agreed, not from the code."""

from __future__ import annotations

import re
from typing import Any, Mapping, NamedTuple, Optional
from urllib.parse import unquote

from login_kit import OTHER_PASSWORD, PASSWORD
from test_commands import PLAN
from view_kit import SURVEY

from gpr20_web.mid.remote_plan import plan_id
from gpr20_web.roles import Role

NOBODY, VIEW, OPERATE, ADMIN = Role
PRESS = {"press": "0" * 32}
# What the path of a request has for {folder}: a stored survey.
S = "/api/surveys/{folder}"


class Row(NamedTuple):
    """A route, who may use it, and a request that the page sends."""

    method: str
    path: str
    right: Role
    values: Mapping[str, Any] = {}


STOP = Row("POST", "/api/stop", VIEW, PRESS)
TABLE = (
    # Before the login there is the form alone.
    Row("GET", "/api/words", NOBODY),
    Row("GET", "/api/colours.css", NOBODY),
    Row("POST", "/api/login", NOBODY, {"name": "vera", "password": PASSWORD}),
    # Everybody with an account watches, and has a session and a password.
    Row("GET", "/api/live", VIEW),
    Row("GET", "/api/me", VIEW),
    Row("POST", "/api/logout", VIEW),
    Row("POST", "/api/logout_everywhere", VIEW),
    Row("POST", "/api/password", VIEW, {"old": PASSWORD, "new": OTHER_PASSWORD}),
    Row("GET", "/api/ground", VIEW),
    Row("GET", "/api/ground/map.png", VIEW),
    Row("GET", "/api/ground/section.png", VIEW),
    Row("GET", "/api/ground/bar.png", VIEW),
    Row("GET", "/api/ground/sign.png", VIEW),
    Row("GET", "/api/robots", VIEW),
    Row("GET", "/api/service", VIEW),
    # The stored surveys: search, verdict, candidates, downloads.
    Row("GET", "/api/surveys", VIEW),
    Row("GET", S, VIEW),
    Row("GET", f"{S}/candidates", VIEW),
    Row("POST", f"{S}/candidates", VIEW),
    Row("GET", f"{S}/zip", VIEW),
    Row("GET", f"{S}/made/report-pdf", VIEW),
    Row("GET", f"{S}/files/survey.json", VIEW),
    Row("POST", "/api/ground/focus", VIEW),
    # Notes, markers, found records, PAUSE from anywhere; STOP too, if the site allows it.
    Row("POST", f"{S}/notes", VIEW, {"text": "wet"}),
    Row("POST", f"{S}/markers", VIEW, {"x_mm": 1.0, "y_mm": 2.0, "text": "can"}),
    Row("POST", f"{S}/found", VIEW, {"what": "mine", "candidate": "c", "list": "l"}),
    Row("POST", "/api/pause", VIEW, PRESS),
    STOP,
    # START and RESUME, and control over them.
    Row("POST", "/api/start", OPERATE, {**PRESS, "plan": plan_id(PLAN)}),
    Row("POST", "/api/resume", OPERATE, {**PRESS, "survey": SURVEY}),
    Row("POST", "/api/control/take", OPERATE),
    Row("POST", "/api/control/release", OPERATE),
    Row("POST", "/api/control/pass", OPERATE, {"mark": "0" * 16}),
    Row("POST", "/api/control/keep", OPERATE),
    # What takes the robot's computer minutes, or shows how it is set up.
    Row("POST", "/api/ground/hide", OPERATE, {"target": "pmn"}),
    Row("POST", "/api/ground/cancel", OPERATE),
    Row("POST", "/api/service/bundle", OPERATE),
    Row("GET", "/api/service/bundle", OPERATE),
    # Users, audit.
    Row("GET", "/api/users", ADMIN),
    Row("POST", "/api/users", ADMIN, {"name": "eva", "role": "view", "password": PASSWORD}),
    Row("POST", "/api/users/eva", ADMIN, {"role": "operate"}),
    Row("DELETE", "/api/users/eva", ADMIN),
    Row("GET", "/api/audit", ADMIN),
)


def least_right(method: str, path: str) -> Optional[Role]:
    """Return the least role that a request needs; None: there is no such route.

    Args:
        method: Of the request.
        path: Of the request; names in it may be any.
    """
    for row in TABLE:
        pattern = re.sub("{folder}|eva|(?<=files/).*|report-pdf", "[^/]+", row.path)
        if row.method == method and re.fullmatch(pattern, unquote(path)):
            return row.right
    return None
