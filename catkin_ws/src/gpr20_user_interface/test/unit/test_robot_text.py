import re
import string

import pytest
from said_sentences import said_by_the_robot
from window_helpers import application, show, snapshot, window

from gpr20_survey.plan.coverage import Coverage
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.errors import ProfileError
from gpr20_user_interface.low.profile_folder import ProfileFolder
from gpr20_user_interface.low.translation_file import FOLDER, read_translations
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.views.robot_sentences import SENTENCES
from gpr20_user_interface.views.robot_text import robot_text
from gpr20_user_interface.views.translation import Language, Languages

__all__ = ["application", "window"]


@pytest.fixture
def languages(application):
    languages = Languages(application, Language.SPANISH)
    yield languages
    languages.close()


@pytest.mark.parametrize(
    "text, spanish",
    [
        ("measuring", "midiendo"),
        ("pausing after this sample", "pausa tras esta medida"),
        (
            "complete: all 18 planned traces are stored",
            "completa: guardadas las 18 trazas previstas",
        ),
        (
            "INCOMPLETE: 710 of 882 planned traces are stored, 0 failed, 172 not visited",
            "INCOMPLETA: 710 de 882 trazas previstas guardadas, 0 fallidas, 172 sin visitar",
        ),
    ],
)
def test_standard_sentence_is_told_in_the_language_of_the_window(languages, text, spanish):
    assert robot_text(text) == spanish
    languages.use(Language.ENGLISH)
    assert robot_text(text) == text


@pytest.mark.parametrize(
    "text, spanish",
    [
        (
            "paused: vna_acquisition went silent and did not come back within 30 s; "
            "resume when it is mended, or stop",
            "en pausa: vna_acquisition dejó de responder y no volvió en 30 s; "
            "siga cuando esté arreglado, o pare",
        ),
        (
            "finished, complete: all 18 planned traces are stored; 18 traces in /data/survey",
            "terminada, completa: guardadas las 18 trazas previstas; 18 trazas en /data/survey",
        ),
        (
            "paused: get_data: the VNA's sweep failed 3 times: 9 of 402 numbers of the instrument "
            "are not finite",
            "en pausa: get_data: el barrido del VNA falló 3 veces: 9 de 402 números del "
            "instrumento no son finitos",
        ),
        (
            "the height sensor is stuck: 5 of 5 readings are 1023, the end of the converter's "
            "scale (short circuit)",
            "el sensor de altura está atascado: 5 de 5 lecturas son 1023, el extremo de la escala "
            "del convertidor (cortocircuito)",
        ),
        (
            "profile a/x_start_mm has too many digits for a number of type float",
            "el perfil a/x_start_mm tiene demasiadas cifras para un número de tipo float",
        ),
        (
            "/z_axis/homing: the axis is not homed; home it before moving it",
            "/z_axis/homing: el eje no tiene origen; llévelo a su origen antes de moverlo",
        ),
        (
            "no connection to the VNA at 10.0.0.2: [Errno 111] Connection refused; "
            "check the address, the cable and that it is on",
            "sin conexión con el VNA en 10.0.0.2: [Errno 111] conexión rechazada; "
            "compruebe la dirección, el cable y que esté encendido",
        ),
        (
            "service stop_survey did not answer within 2 s; check that its node runs and does "
            "not hang; the axes were told to stop instead; x axis: stopping; "
            "y axis does NOT answer: service y_axis/stop could not be called: "
            "[Errno 111] Connection refused; check that its node runs",
            "el servicio stop_survey no respondió en 2 s; compruebe que su nodo funciona y no "
            "está colgado; en su lugar se ordenó parar a los ejes; eje x: parando; "
            "el eje y NO responde: el servicio y_axis/stop no se pudo llamar: "
            "[Errno 111] conexión rechazada; compruebe que su nodo funciona",
        ),
    ],
)
def test_sentences_in_a_row_and_within_one_another_are_told_one_by_one(languages, text, spanish):
    assert robot_text(text) == spanish


@pytest.mark.parametrize(
    "content, spanish",
    [
        ("x_points: [1", "el perfil {path} no se puede leer: no es YAML: "),
        ("#" * 70_000, "el perfil {path} no se puede leer: ocupa más de 65536 bytes; guárdelo"),
        ("[1, 2]", "el perfil field debe ser un grupo de valores, pero es [1, 2]; guárdelo"),
        ("{a: 1}", "el perfil tiene un valor desconocido, field/a; se conocen "),
        ("vna_address: 5", "en el perfil, field/vna_address es 5; debe ser de tipo str; guárdelo"),
        ("x_points: 2.5", "falta en el perfil field/vna_address; guárdelo de nuevo"),
        (None, "el perfil {path} no se puede leer: [Errno 2] no existe el archivo o la carpeta: "),
    ],
)
def test_fault_of_a_profile_is_told_in_the_language_of_the_window(
    languages, tmp_path, content, spanish
):
    path = tmp_path / "field.yaml"
    if content is not None:
        path.write_text(content)
    with pytest.raises(ProfileError) as refused:
        Profiles(ProfileFolder(tmp_path)).load("field")
    assert robot_text(str(refused.value)).startswith(spanish.format(path=path))


def test_profile_that_cannot_be_written_is_told_in_the_language_of_the_window(languages, tmp_path):
    (tmp_path / "file").write_text("")
    folder = ProfileFolder(tmp_path / "file")
    with pytest.raises(ProfileError) as refused:
        Profiles(folder).save("field", default_parameters())
    told = robot_text(str(refused.value))
    assert "no se puede escribir: [Errno 17] el archivo ya existe: " in told
    assert told.endswith(
        "libere espacio en el disco o indique otra carpeta con el parámetro `profiles`"
    )


@pytest.mark.parametrize(
    "text, told",
    [
        ("", ""),
        ("the moon is full", "the moon is full"),
        ("measuring; the moon is full", "midiendo; the moon is full"),
        ("paused: {lost} and {0}", "en pausa: {lost} and {0}"),
        ("x" * 100_000, "x" * 100_000),
    ],
)
def test_what_is_not_known_stays_in_the_words_of_the_robot(languages, text, told):
    assert robot_text(text) == told


@pytest.mark.parametrize("template", SENTENCES)
def test_each_sentence_is_recognized_as_itself(languages, template):
    places = {name for _, name, _, _ in string.Formatter().parse(template) if name}
    told = robot_text(template.format(**{place: "7" for place in places}))
    spanish = read_translations(FOLDER / "es.ts")["RobotText", template]
    assert told == spanish.format(**{place: "7" for place in places})


@pytest.mark.parametrize("path, sentence", said_by_the_robot())
def test_whatever_the_robot_can_say_to_the_operator_is_known(languages, path, sentence):
    assert robot_text(sentence) != sentence, f"{path}: add it to robot_sentences and es.ts"


def test_status_and_top_bar_change_their_sentence_with_the_language(window, languages):
    state = ControlState(SurveyState.SURVEYING, "measuring", "id", True)
    show(window, snapshot(SurveyState.SURVEYING, state=state))
    assert window.status.message.message == "midiendo"
    assert window.top_bar.message.whole == "midiendo"
    languages.use(Language.ENGLISH)
    window.status.message.retranslate()
    window.top_bar.retranslate()
    assert window.status.message.message == "measuring"
    assert window.top_bar.message.whole == "measuring"


@pytest.mark.parametrize("stored, word", [([0, 1], "completa"), ([1], "INCOMPLETA")])
def test_verdict_as_the_coverage_words_it_is_translated(languages, stored, word):
    assert robot_text(Coverage(2, stored).verdict().text).startswith(f"{word}: ")


@pytest.mark.parametrize("template", [one for one in SENTENCES if one.startswith("{")])
def test_a_sentence_that_begins_with_a_value_leaves_those_around_it_in_spanish(languages, template):
    inner = re.sub(r"\{\w+\}", "7", template)
    told = robot_text(f"get_data: the VNA's sweep failed 3 times: {inner}")
    assert told == f"get_data: el barrido del VNA falló 3 veces: {robot_text(inner)}"
