"""``ravengc dvrk`` from its options to what it prints and its exit codes."""

from __future__ import annotations

import json

import pytest

from ravengc.cli import main


def printed(capsys: pytest.CaptureFixture[str], code: int, *options: str) -> str:
    assert main(["dvrk", *options]) == code
    return capsys.readouterr().out


def test_table(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 0, "table", "--poses", "20")
    for expected in (
        "Kinematics, standard",
        "Gravity, modified",
        "NO, NO (? Not sure), YES",
        "-7.080490",
        "-10.804879",
        "1.862195",
        "dvrk_mtml",
        "standard against modified table: YES",
    ):
        assert expected in out


def test_table_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    about = json.loads(printed(capsys, 0, "table", "--poses", "20", "--json"))
    assert about["complete"]
    assert len(about["rows"]) == 4
    for row in about["rows"]:
        assert row["cells"]["NumPy reference"]["agrees"]
        assert set(row["page"]) == {"cisst", "KDL", "Matlab"}
    assert [arm["agrees"] for arm in about["mtm"]] == [True, True]


@pytest.mark.parametrize(
    ("options", "said"),
    [(("table", "--poses", "0"), "poses is 0"), (("table", "--pykdl", "/nonexistent"), "cannot be asked for PyKDL")],
)
def test_bad_input(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str) -> None:
    assert main(["dvrk", *options]) == 2
    assert said in capsys.readouterr().err
