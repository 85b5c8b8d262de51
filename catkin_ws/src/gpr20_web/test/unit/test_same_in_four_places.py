"""Window, page, terminal client and the answer itself say one code, sentence and remedy."""

from __future__ import annotations

import contextlib
import importlib
import io
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Tuple

import pytest

pytest.importorskip("rospy")

from translations import module_files
from web_kit import Site
from window_helpers import close, opened_window

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.high.answers import message_fields, message_from
from gpr20_common.message import Fault, Message
from gpr20_msgs.srv import CommandResponse
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_user_interface.terminal.follower import Display, first_step
from gpr20_web.calls import Call, Role, Route
from gpr20_web.faults import NotNowError

HANDS_OFF = {
    Language.ENGLISH: "Keep your hands clear: the robot may still move. ",
    Language.SPANISH: "Mantenga las manos alejadas: el robot puede seguir en movimiento. ",
}
FIRST = {Language.ENGLISH: "Do this first: ", Language.SPANISH: "Haga esto primero: "}
MODULES = [one for one in module_files() if one.endswith(".faults")]
FAULTS: List[Tuple[str, Fault]] = [
    (f"{module} {name}", fault)
    for module in MODULES
    for name, fault in vars(importlib.import_module(module)).items()
    if isinstance(fault, Fault)
]


class Said(NamedTuple):
    code: str
    sentence: str
    remedy: str


@pytest.fixture(autouse=True)
def shown_is_translated() -> None:
    """What only commands of analysts report is English."""


@pytest.fixture(scope="module", params=(Language.ENGLISH, Language.SPANISH))
def places(
    request: Any, application: Any, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[[Message], Dict[str, Said]]]:
    """A function that returns what each place shows of a refusal."""
    language: Language = request.param
    catalogue = read_catalogue(language)
    refused: List[Message] = []

    def refuse(_call: Call) -> Dict[str, Any]:
        raise NotNowError(refused[-1])

    window = opened_window(application, language, folder=tmp_path_factory.mktemp("window"))
    site = Site([Route("GET", "/api/refused", Role.NOBODY, refuse)])

    def show(message: Message) -> Dict[str, Said]:
        refused.append(message)
        window.notice.show_notice(refusal_notice(Refused.START, message))
        card = window.notice
        code = card.details.toPlainText().split("\n")[0]
        values = site.ask("GET", f"/api/refused?language={language.value}").values
        lines = io.StringIO()
        for one in (message, first_step(message)):
            Display(lines, catalogue).note(one)
        sentence, step = lines.getvalue().splitlines()
        remedy, _bracket, own_code = step[len(FIRST[language]) :].rpartition(" (")
        return {
            "window": Said(code, card.reason.toPlainText(), card.first.text()),
            "page": Said(values["code"], values["error"], values["remedy"]),
            "terminal": Said(own_code[:-1], sentence, remedy),
        }

    show.language, show.catalogue = language, catalogue  # type: ignore[attr-defined]
    with contextlib.closing(site):
        yield show
    close(window)


def _differs(places: Any, name: str, fault: Fault) -> Iterator[Tuple[str, str, Said, Said]]:
    sent, answer = io.BytesIO(), CommandResponse()
    fields = message_fields(Message("the disk is full").with_fault(fault))
    CommandResponse(**fields).serialize(sent)
    answer.deserialize(sent.getvalue())
    sentence, remedy = answer.message, answer.fault.remedy
    if places.language is not Language.ENGLISH:
        sentence = places.catalogue.template("the disk is full")
        remedy = places.catalogue.text(fault.remedy) if fault.remedy else ""
    # Where the remedy does not say it, a client says more.
    remedies = {remedy, HANDS_OFF[places.language] + remedy} if fault.may_move else {remedy}
    for place, said in places(message_from(answer)).items():
        # The window writes the capital letter of a sentence of its own.
        same = said.sentence[1:] == sentence[1:] and said.remedy in remedies
        if said.code != fault.code or not same:
            yield name, place, Said(fault.code, sentence, remedy), said


def test_every_fault_is_the_same_in_all_four_places(places: Any) -> None:
    assert len(FAULTS) > len({fault.code for _name, fault in FAULTS}) > 90
    assert [one for name, fault in FAULTS for one in _differs(places, name, fault)] == []
