import pytest

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import problems
from gpr20_user_interface.terminal.follower import ExitStatus, Mode, OnPause
from gpr20_user_interface.terminal.survey_arguments import Bar, terminal_language
from gpr20_user_interface.terminal.survey_arguments import parse_arguments as parse


def parse_arguments(arguments):
    return parse(arguments, Catalogue())


def test_defaults_are_a_survey_that_can_be_run():
    options = parse_arguments([])
    assert problems(options.parameters, DOCUMENTED_TRAVEL) == []
    assert options.parameters.vna_address == ""
    assert not options.parameters.sweep_settings.analyzer.is_known
    assert options.permittivity == 0.0 and options.annotation == EMPTY
    assert (options.mode, options.on_pause, options.bar) == (Mode.START, OnPause.EXIT, Bar.AUTO)


def test_a_survey_that_exists_can_be_followed():
    for line, mode, resume_id, analyzer in (
        ("--attach", Mode.ATTACH, "", ""),
        ("--resume --accept-analyzer A,B/2", Mode.RESUME, "", "A,B/2"),
        ("--resume 1234", Mode.RESUME, "1234", ""),
        ("--resume /data/20260921T141320_0f8fad5b/", Mode.RESUME, "20260921T141320_0f8fad5b", ""),
    ):
        options = parse_arguments(line.split())
        found = options.mode, options.resume_id, options.accept_analyzer
        assert found == (mode, resume_id, analyzer)


def test_wrong_command_line_has_status_2_and_names_the_fault(capsys):
    for arguments, words in (
        (["--x-points", "three"], "three"),
        (["--polarizations-deg", "0,x"], "0,x"),
        (["--wait", "0"], "'0'"),
        (["--attach", "--resume"], "not allowed with"),
        (
            ["--attach", "--y-stop", "9", "--polar", "0"],
            "--y-stop-mm, --polarizations-deg cannot be given with",
        ),
        (["--position", "91,0"], "latitude is 91 deg; it must lie between -90 and 90 deg"),
        (["--operator", "a\nb"], "operator holds U+000A"),
        (["--resume", "--site", ""], "--site cannot be given with --resume"),
        (["--permittivity", "0.5"], "'0.5' is no permittivity of a soil"),
        (["--resume", "--permittivity", "4"], "--permittivity cannot be given with --resume"),
        (["--attach", "--accept-analyzer", "B"], "only with --resume"),
    ):
        with pytest.raises(SystemExit) as caught:
            parse_arguments(arguments)
        assert caught.value.code == 2
        assert words in capsys.readouterr().err, arguments


FIELDS = (
    *("vna-address", "start-frequency-mhz", "stop-frequency-mhz", "frequency-points"),
    *("x-start-mm", "x-stop-mm", "x-points", "y-start-mm", "y-stop-mm", "y-points"),
    *("polarizations-deg", "if-bandwidth-hz", "averages", "output-power", "permittivity"),
    *("name", "operator", "site", "notes", "position"),
)


def test_help_lists_fields_and_exit_statuses_in_the_language_of_the_catalogue_as_faults_are(
    capsys,
):
    spanish = read_catalogue(Language.SPANISH)
    with pytest.raises(SystemExit) as caught:
        parse(["--help"], spanish)
    assert caught.value.code == 0
    text = capsys.readouterr().out
    assert all(f"\n  {status:>3}  " in text for status in (2, *map(int, ExitStatus)))
    assert all(f"\n  --{name} " in text for name in FIELDS)
    assert "(por defecto 15)" in " ".join(text.split())
    with pytest.raises(SystemExit):
        parse(["--wait", "0"], spanish)
    assert "'0' no es un número de segundos mayor que cero" in capsys.readouterr().err


def test_language_is_that_of_the_command_line_or_the_terminal():
    peru = {"LANG": "es_PE.UTF-8"}
    for line, environment, language in (
        ("", peru, Language.SPANISH),
        ("--language en", peru, Language.ENGLISH),
        ("--attach --language=es --wait 3", {}, Language.SPANISH),
        # Refused by the parser that comes next.
        ("--language fr", peru, Language.SPANISH),
        ("--language", {}, Language.ENGLISH),
    ):
        assert terminal_language(line.split(), environment) == language, line
