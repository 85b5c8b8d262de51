"""The folder of the surveys: the parameter, else the environment, else the home."""

from pathlib import Path

from case_kit import each_case

from gpr20_common.low.data_folder import data_folder

CASES = [
    ("/disk/a", {"GPR20_DATA": "/disk/b"}, Path("/disk/a")),
    ("/disk/a\n", {}, Path("/disk/a")),
    (" ", {"GPR20_DATA": "~/b"}, Path.home() / "b"),
    ("", {"GPR20_DATA": ""}, Path.home() / "gpr20_data"),
    ("a", {}, Path.cwd() / "a"),
]


@each_case("configured, environment, folder", CASES)
def test_the_parameter_comes_before_the_environment_and_that_before_the_home(
    configured, environment, folder
):
    assert data_folder(configured, environment) == folder
