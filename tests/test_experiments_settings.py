"""Settings of experiments: kinds, ranges, files, and what their errors say."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.experiments import EXPERIMENTS, Settings, run_experiment, setting, settings_from, settings_table
from ravengc.experiments.files import read_settings

if TYPE_CHECKING:
    from pathlib import Path


@dataclasses.dataclass(frozen=True, kw_only=True)
class Example(Settings):
    mass: float = setting(1.0, 0.5, 2.0, "kg", "a mass")
    tilts: tuple[float, ...] = setting((1.0, 2.0), 0.0, 90.0, "deg", "tilts")
    place: tuple[float, ...] = setting((0.0, 0.0, 0.0), -1.0, 1.0, "m", "a place", count=3)
    count: int = setting(1, 0, 5, "", "a count")
    flag: bool = setting(default=False)
    kind: str = setting("stick", choices=("stick", "soft"))

    def check(self) -> None:
        if self.flag and self.count == 0:
            raise ConfigError("count is 0; expected at least 1 with flag")


def test_values_take_the_kind_of_the_default() -> None:
    found = settings_from(Example, {"mass": 2, "tilts": [3, 4], "count": 2, "flag": True, "kind": "soft"})
    assert found == Example(mass=2.0, tilts=(3.0, 4.0), count=2, flag=True, kind="soft")
    assert isinstance(found.mass, float)
    assert all(isinstance(tilt, float) for tilt in found.tilts)
    assert settings_from(Example, {"tilts": 5}).tilts == (5.0,)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"mas": 1.0}, r"arm: unknown key 'mas'; did you mean 'mass'\? \(known: 'count', 'flag',"),
        ({"mass": -1.0}, "arm: mass is -1.0; expected a number from 0.5 to 2 kg"),
        ({"mass": math.nan}, "mass is nan; expected a number from 0.5 to 2 kg"),
        ({"mass": "1"}, "mass is '1'; expected a number"),
        ({"mass": True}, "mass is True; expected a number"),
        ({"mass": [1.0]}, r"mass is \[1.0\]; expected a number"),
        ({"mass": None}, "mass is None"),
        ({"mass": 10**400}, "mass is 1000.*; expected a number"),
        ({"tilts": []}, r"tilts is \[\]; expected 1 to 64 values"),
        ({"tilts": [1.0, 91.0]}, "tilts is 91.0; expected a list of: a number from 0 to 90 deg"),
        ({"place": [0.0, 0.0]}, r"place is \[0.0, 0.0\]; expected 3 values"),
        ({"count": 1.0}, "count is 1.0; expected a whole number from 0 to 5"),
        ({"flag": 1}, "flag is 1; expected true or false"),
        ({"kind": "sof"}, "kind is 'sof'; expected one of 'stick', 'soft'; did you mean 'soft'"),
        ({"flag": True, "count": 0}, "arm: count is 0; expected at least 1 with flag"),
    ],
)
def test_the_error_says_the_key_and_what_is_allowed(table: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        settings_from(Example, table, "arm")


def test_whoever_builds_settings_is_checked() -> None:
    with pytest.raises(ConfigError, match="mass is 9"):
        Example(mass=9.0)
    with pytest.raises(ConfigError, match="mass is 9"):
        dataclasses.replace(Example(), mass=9.0)


KEYS = st.sampled_from(["mass", "tilts", "place", "count", "flag", "kind", "x"])
VALUES = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.lists(st.floats(), max_size=4)
)


@given(st.dictionaries(KEYS, VALUES, max_size=4))
@hypothesis_settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_table_gives_settings_or_an_error_of_ours(table: dict[str, Any]) -> None:
    try:
        found = settings_from(Example, table)
    except ConfigError:
        return
    assert settings_from(Example, dataclasses.asdict(found)) == found


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_setting_of_every_experiment_is_described(name: str) -> None:
    settings = EXPERIMENTS[name].settings()
    assert settings_from(type(settings), dataclasses.asdict(settings)) == settings
    for key, value, unit, allowed, meaning in settings_table(settings):
        assert meaning, key
        assert "from" in allowed
        assert unit or "deg" not in key
        for entry in value if isinstance(value, tuple) else (value,):
            with pytest.raises(ConfigError, match=f"^{key} is "):
                dataclasses.replace(settings, **{key: type(entry)(1) * 10**300 if isinstance(entry, int) else 1e300})


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_experiments_say_what_they_are(name: str) -> None:
    experiment = EXPERIMENTS[name]
    assert experiment.name == name
    assert experiment.title
    assert experiment.about.endswith(".")
    assert experiment.source
    assert EXPERIMENTS[name].tasks(experiment.settings())


def test_settings_of_another_experiment_are_refused() -> None:
    with pytest.raises(ArgumentError, match="settings is a Rocking; expected a Ship"):
        run_experiment(EXPERIMENTS["ship"], EXPERIMENTS["rocking"].settings())


def test_a_file_sets_what_it_names(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('[ship]\nroll_deg = 5\nplace = [1, 2, 3]\n\n["moving-base-terms"]\nhz = 2.0\n', encoding="utf-8")
    found = read_settings(file)
    assert found["ship"] == settings_from(EXPERIMENTS["ship"].settings, {"roll_deg": 5.0, "place": (1.0, 2.0, 3.0)})
    assert set(found) == {"ship", "moving-base-terms"}


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("[shp]\n", ConfigError, r"my.toml: \[shp\]: there is no experiment 'shp'; did you mean 'ship'"),
        ("ship = 3\n", ConfigError, r"my.toml: ship is 3; expected a table, \[ship\]"),
        (
            "[base-feedback]\nmass = -2.0\n",
            ConfigError,
            r"\[base-feedback\]: mass is -2.0; expected a number from 0.01",
        ),
        ("[base-feedback]\ninertia = 0.1\n", ConfigError, "inertia is 0.1; expected at least mass x length"),
        ("[rocking]\nhz = 1e9\n", ConfigError, r"\[rocking\]: hz is 1000000000.0; expected a number from 0.01 to 5 Hz"),
        ("[rocking]\nlow_deg = 30\n", ConfigError, "low_deg is 30; expected less than high_deg, 20"),
        ("[rocking]\nHz = 1.0\n", ConfigError, "unknown key 'Hz'; did you mean 'hz'"),
        ("", ConfigError, r"my.toml: no settings in it; expected a table per experiment, such as \[static-poses\]"),
        ("# [rocking]\n", ConfigError, "my.toml: no settings in it"),
        ("[rocking\n", ParseError, "my.toml: not valid TOML"),
    ],
)
def test_a_file_with_a_slip_is_refused(tmp_path: Path, text: str, error: type[Exception], message: str) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(error, match=message):
        read_settings(file)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParseError, match="cannot be read"):
        read_settings(tmp_path / "none.toml")
