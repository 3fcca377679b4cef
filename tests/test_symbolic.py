"""Formulas are what the core computes, whatever the robot; and where a textbook has them, they are the textbook's."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from functools import cache
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from ravengc import symbolic
from ravengc.config import bundled_names
from ravengc.config import spec_for as read_spec
from ravengc.dvrk import mtm_with_special_terms
from ravengc.errors import ArgumentError, ConfigError, MissingExtraError
from ravengc.spec import CouplingSpec, DhRow, LinkSpec, Pose, RobotSpec
from strategies import robots
from symbolic_c import compiled

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from ravengc.symbolic import Formulas

sympy = pytest.importorskip("sympy")

from ravengc.symbolic import algebra, closed, mechanism, steps  # noqa: E402 -- behind the skip
from ravengc.symbolic.code import function_name  # noqa: E402

NAMES = bundled_names()
QUANTITIES = symbolic.QUANTITIES
DYNAMICS = ("inverse-dynamics", "inverse-dynamics-regressor")
spec_for = cache(read_spec)
theorem = settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)


def lines(found: Formulas) -> list[str]:
    """The formulas as text, one per line and without comments."""
    text = re.sub(r"\n    +", " ", symbolic.written(found))
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def agrees(found: Formulas, states: int = 2) -> bool:
    result = symbolic.check(found, states)
    assert result.holds, str(result)
    return True


# The core agrees


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("options", [{}, {"gravity": "level", "lengths": True}, {"numbers": True, "form": "steps"}])
def test_gravity_of_every_bundled_robot(name: str, options: dict[str, Any]) -> None:
    found = symbolic.formulas(spec_for(name), **options)
    assert agrees(found, 5)
    assert not (options.get("numbers") and found.parameters)


@pytest.mark.parametrize("what", QUANTITIES[1:])
@pytest.mark.parametrize("name", ["rrbot_modified", "raven2_gold", "dvrk_psm_si", "panda"])
def test_every_quantity_of_arms_of_every_kind(name: str, what: symbolic.Quantity) -> None:
    """Both conventions, explicit frames, a prismatic joint, a coupled mechanism."""
    assert agrees(symbolic.formulas(spec_for(name), what, moving_base=what in DYNAMICS))


@theorem
@given(data=st.data())
def test_any_robot_any_quantity(data: st.DataObject) -> None:
    """Trees, couplings, fixed links, any base and tool; in steps, or written out where that is short."""
    spec = data.draw(robots(most=4))
    what = data.draw(st.sampled_from(QUANTITIES))
    moving = what in DYNAMICS and data.draw(st.booleans())
    gravity = "vector" if moving else data.draw(st.sampled_from(("vector", "level", (1.5, 0.0, -9.0))))
    numbers, lengths = data.draw(st.booleans()), data.draw(st.booleans())
    frame = data.draw(st.sampled_from(("base", "tool", *(link.name for link in spec.links))))
    form = data.draw(st.sampled_from(("auto", "steps")))
    options = {"numbers": numbers, "lengths": lengths, "gravity": gravity, "frame": frame, "form": form}
    assert agrees(symbolic.formulas(spec, what, moving_base=moving, **options))


@settings(theorem, max_examples=15)
@given(spec=robots(most=3), what=st.sampled_from(("gravity", "kinematics", "regressor")))
def test_written_out_is_the_same(spec: RobotSpec, what: symbolic.Quantity) -> None:
    found = symbolic.formulas(spec, what, form="closed")
    assert not found.steps
    assert agrees(found)


@settings(theorem, max_examples=8)
@given(spec=robots(most=3, solid=True), data=st.data())
def test_regressor_times_parameters_is_the_torque(spec: RobotSpec, data: st.DataObject) -> None:
    def of(what: symbolic.Quantity) -> Callable[..., np.ndarray]:
        return symbolic.function(symbolic.formulas(spec, what, moving_base=what in DYNAMICS, form="steps"))

    robot, n = ravengc.Robot(spec), len(spec.coordinate_names)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    q, qd, qdd, f, w, dw = (rng.normal(0.0, 2.0, size).tolist() for size in (n, n, n, 3, 3, 3))
    ten = robot.inertial_parameters().reshape(-1, 10)
    tau, rows = (of(what) for what in ("gravity", "regressor"))
    np.testing.assert_allclose(rows(q, f) @ ten[:, :4].ravel(), tau(q, f), rtol=1e-10, atol=1e-10)
    tau, rows = (of(what) for what in DYNAMICS)
    expected = tau(q, qd, qdd, f, w, dw)
    np.testing.assert_allclose(rows(q, qd, qdd, f, w, dw) @ ten.ravel(), expected, rtol=1e-10, atol=1e-9)


def test_columns_name_what_they_multiply() -> None:
    found = symbolic.formulas(spec_for("rrbot"), "regressor")
    assert found.columns == ("m1", "hx1", "hy1", "hz1", "m2", "hx2", "hy2", "hz2")
    many = symbolic.formulas(spec_for("rrbot"), "inverse-dynamics-regressor").columns
    assert many[:10] == ("m1", "hx1", "hy1", "hz1", "Ixx1", "Ixy1", "Ixz1", "Iyy1", "Iyz1", "Izz1")


@pytest.mark.parametrize("what", ["gravity", "inverse-dynamics"])
@pytest.mark.parametrize("form", ["auto", "steps"])
def test_symbols_are_what_they_are_called(what: symbolic.Quantity, form: symbolic.Form) -> None:
    """Other values for the parameters are another robot."""
    spec, rng = spec_for("raven2_gold"), np.random.default_rng(3)
    found = symbolic.formulas(spec, what, lengths=True, form=form)
    values = {symbol.name: value * rng.uniform(0.5, 2.0) for symbol, value in found.parameters.items()}
    shares = rng.uniform(0.5, 2.0, 4)  # one for all moments of a link, so that it can exist
    values |= {name: shares[int(name[-1])] * found.parameters[sympy.Symbol(name)] for name in values if name[0] == "I"}

    def other(k: int, link: LinkSpec) -> LinkSpec:
        com = [values.get(f"c{axis}{k}", value) for axis, value in zip("xyz", link.com, strict=True)]
        inertia = [shares[k] * value for value in link.inertia]
        row = replace(link.placement, a=values.get(f"a{k}", link.placement.a), d=values.get(f"d{k}", link.placement.d))
        return replace(link, mass=values.get(f"m{k}", link.mass), com=com, inertia=inertia, placement=row)

    robot = replace(spec, links=tuple(other(k, link) for k, link in enumerate(spec.links, 1)))
    state = [rng.normal(0.0, 1.0, len(one.symbols)).tolist() for one in found.inputs]
    got = symbolic.function(found)(*state, list(values.values()))
    mine = ravengc.Robot(robot)
    g = ravengc.Gravity(*state[-1])
    expected = mine.gravity_torque(state[0], g) if what == "gravity" else mine.inverse_dynamics(*state[:3], g)
    np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-12)


def test_links_fixed_to_a_moving_one_are_part_of_it() -> None:
    hand = LinkSpec(
        name="hand", joint="fixed", placement=DhRow(a=0.2, alpha=0.3), parent="link2", mass=0.4, com=(0.1, 0, 0)
    )
    spec = replace(spec_for("rrbot"), links=(*spec_for("rrbot").links, hand))
    found = symbolic.formulas(spec)
    assert found.parameters[sympy.Symbol("m2")] == 1.4
    assert agrees(found)
    on_base = replace(hand, name="plate", parent=None)
    spec = replace(spec_for("rrbot"), links=(on_base, *spec_for("rrbot").links), tip="link2")
    assert lines(symbolic.formulas(spec)) == lines(symbolic.formulas(spec_for("rrbot")))


# The textbook


def test_rrbot_is_the_textbook() -> None:
    """Two links in a vertical plane: tau2 = -g m2 r2 sin(q1 + q2), x of frame 0 up, r the COM's distance."""
    found = symbolic.formulas(spec_for("rrbot"), gravity="level", lengths=True)
    assert lines(found) == [
        "tau1 = -g*m2*(a2 + cx2)*sin(q1 + q2) - g*(a1*m2 + m1*(a1 + cx1))*sin(q1)",
        "tau2 = -g*m2*(a2 + cx2)*sin(q1 + q2)",
    ]
    modified = symbolic.formulas(spec_for("rrbot_modified"), gravity="level", lengths=True)
    assert lines(modified) == [
        "tau1 = -cx2*g*m2*sin(q1 + q2) - g*(a2*m2 + cx1*m1)*sin(q1)",
        "tau2 = -cx2*g*m2*sin(q1 + q2)",
    ]


def test_rrbot_dynamics_are_the_textbook() -> None:
    """Inertia, Coriolis and centrifugal terms as every book has them: only cos(q2) and sin(q2) are left."""
    g, a1, cx2, cx1, m1, m2, i1, i2 = sympy.symbols("g a2 cx2 cx1 m1 m2 Izz1 Izz2")
    q1, q2, qd1, qd2, qdd1, qdd2 = sympy.symbols("q1 q2 qd1 qd2 qdd1 qdd2")
    found = symbolic.formulas(spec_for("rrbot_modified"), "inverse-dynamics", gravity="level", lengths=True)
    h, c = m2 * a1 * cx2 * sympy.sin(q2), m2 * a1 * cx2 * sympy.cos(q2)
    weight = -g * m2 * cx2 * sympy.sin(q1 + q2)
    inertia = i1 + i2 + m1 * cx1**2 + m2 * (a1**2 + cx2**2)
    tau2 = (i2 + m2 * cx2**2 + c) * qdd1 + (i2 + m2 * cx2**2) * qdd2 + h * qd1**2 + weight
    tau1 = (inertia + 2 * c) * qdd1 + (i2 + m2 * cx2**2 + c) * qdd2 - h * (2 * qd1 * qd2 + qd2**2)
    tau1 += weight - g * (m1 * cx1 + m2 * a1) * sympy.sin(q1)
    assert [sympy.expand(a - b) for a, b in zip(found.entries, (tau1, tau2), strict=True)] == [0, 0]


def test_rrbot_pose_is_the_textbook() -> None:
    found = symbolic.formulas(spec_for("rrbot"), "kinematics", lengths=True)
    assert lines(found)[2] == "T[1,4] = a1*sin(q1) + a2*sin(q1 + q2)"
    assert r"\cos(q_{1} + q_{2}) & -\sin(q_{1} + q_{2}) & 0" in symbolic.written(found, "latex")


def test_what_vanishes_on_paper_vanishes_here() -> None:
    """Vertical first axes carry nothing; and no coefficient is what rounding left of zero."""
    for name in ("dvrk_mtmr", "panda", "ur5", "ur10", "pa10"):
        assert symbolic.formulas(spec_for(name), gravity="level").entries[0] == 0
    for name in ("raven2_gold", "dvrk_ecm", "ur5", "pa10", "dvrk_mtml"):
        for entry in symbolic.formulas(spec_for(name), numbers=True, form="closed").entries:
            assert all(abs(float(number)) > 1e-6 for number in entry.atoms(sympy.Rational) - {0})


def test_coupled_joints_add_up_before_anything_is_written() -> None:
    """Three parallel joints at q, -q and q: the last link is at q, and the second one keeps its attitude."""
    row = DhRow(a=0.5)
    bars = tuple(
        LinkSpec(name=name, placement=row, mass=1.0, parent=parent)
        for name, parent in (("one", None), ("two", "one"), ("three", "two"))
    )
    coupling = CouplingSpec(coordinates=("pitch",), matrix=((1.0,), (-1.0,), (1.0,)), offset=(0.0, 0.0, 0.0))
    spec = RobotSpec(name="bars", convention="standard", links=bars, coupling=coupling)
    found = symbolic.formulas(spec, "kinematics")
    assert lines(found)[2] == "T[1,4] = cos(q1) + 0.5"
    assert agrees(found)


def test_right_angles_are_right_angles() -> None:
    for quarters in range(-5, 6):
        assert algebra.angle(quarters * pi / 2) == quarters * sympy.pi / 2
    assert algebra.angle(1.5708) == sympy.Rational(15708, 10000)
    assert algebra.cosine(6e-17) == 0.0
    assert algebra.cosine(0.5000000000000001) == 0.5
    assert algebra.cosine(0.7071067811865476) == 0.7071067811865476
    assert algebra.exact(0.9) - algebra.exact(0.45) - algebra.exact(0.45) == 0


def test_rounded_right_angles_are_taken_as_such_on_request() -> None:
    """The file of the Si arm has 1.570796327 and 3.14159625; the pitch bars keep the insertion axis upright."""
    spec = spec_for("dvrk_psm_si")
    found = symbolic.formulas(spec, gravity="level", right_angles=1e-5)
    assert agrees(found)
    assert lines(found)[-1] == "tau3 = -g*m7*cos(q1)*cos(q2 - 3e-06)"
    assert "# angles of rows within 1e-05 rad of right angles are right angles here" in symbolic.written(found)
    q, g = [0.3, 0.4, 0.1], [9.8]
    exact = symbolic.function(symbolic.formulas(spec, gravity="level"))(q, *g)
    np.testing.assert_allclose(symbolic.function(found)(q, *g), exact, atol=1e-5)
    assert found.spec != spec
    assert symbolic.formulas(spec).spec == spec


def test_only_parallel_axes_share_a_plane() -> None:
    spec = spec_for("ur5")
    plane = closed.planes(spec, mechanism.place(spec))
    q = mechanism.coordinates(spec)
    assert len({plane.of[symbol] for symbol in q[1:4]}) == 1
    assert len(set(plane.of.values())) == 4
    assert set(plane.shared) == {plane.of[q[1]]}


# Steps


@pytest.mark.parametrize("what", QUANTITIES)
def test_steps_are_different_and_used_more_than_once(what: symbolic.Quantity) -> None:
    found = symbolic.formulas(spec_for("panda"), what, form="steps")
    assert found.steps
    assert len(set(found.steps.values())) == len(found.steps)
    uses = dict.fromkeys(found.steps, 0)
    for expression in (*found.steps.values(), *found.entries):
        for part in sympy.preorder_traversal(expression):
            if part in uses:
                uses[part] += 1
            if part.is_Pow and part.args[0] in uses:
                uses[part.args[0]] += 1
    assert min(uses.values()) > 1


def test_a_negative_is_not_computed_again() -> None:
    x, y = sympy.symbols("x y")
    names = steps.Steps()
    first = names.name(x - y)
    assert names.name(y - x) == -first
    assert names.name(2 * x) == 2 * x
    assert len(names.defined) == 1


def test_a_closed_form_that_nobody_could_wait_for_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"form='closed' would have up to .* terms; choose 'steps' or 'auto'"):
        symbolic.formulas(spec_for("panda"), "inverse-dynamics", form="closed")
    assert symbolic.formulas(spec_for("panda"), "inverse-dynamics").steps


# Code


@pytest.mark.parametrize("what", QUANTITIES)
@pytest.mark.parametrize("name", ["dvrk_ecm_si", "panda"])
def test_c_compiles_and_agrees(name: str, what: symbolic.Quantity, tmp_path: Path) -> None:
    found = symbolic.formulas(spec_for(name), what, form="steps")
    values = list(found.parameters.values())
    compute = compiled(symbolic.written(found, "c"), function_name(found), found.shape, tmp_path)
    state = [np.random.default_rng(1).uniform(-2.0, 2.0, len(one.symbols)).tolist() for one in found.inputs]
    expected = symbolic.function(found)(*state)
    np.testing.assert_allclose(compute(*state, *([values] if values else [])), expected, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("options", [{"gravity": "level", "numbers": True}, {"gravity": (0.0, 0.0, -9.81)}])
def test_c_of_a_level_base(options: dict[str, Any], tmp_path: Path) -> None:
    """One number for gravity, or none; a robot without parameters takes none."""
    found = symbolic.formulas(spec_for("rrbot"), **options)
    source = symbolic.written(found, "c")
    compute = compiled(source, "rrbot_gravity", (2,), tmp_path)
    arguments = ([0.3, 0.5], 9.81) if "numbers" in options else ([0.3, 0.5], list(found.parameters.values()))
    np.testing.assert_allclose(compute(*arguments), [-7.080, -3.167], atol=5e-4)


def test_c_and_python_survive_any_name(tmp_path: Path) -> None:
    spec = replace(spec_for("rrbot"), name="7 of 9 */ #define int \\")
    found = symbolic.formulas(spec)
    assert function_name(found) == "robot_7_of_9_define_int_gravity"
    compiled(symbolic.written(found, "c"), function_name(found), (2,), tmp_path)
    names: dict[str, Any] = {}
    exec(symbolic.written(found, "python"), names)  # noqa: S102
    np.testing.assert_allclose(names[function_name(found)]([0.3, 0.5], [0.0, 0.0, -9.81]), [-7.080, -3.167], atol=5e-4)


def test_one_joint_is_a_vector_too(tmp_path: Path) -> None:
    one = replace(spec_for("rrbot"), links=spec_for("rrbot").links[:1])
    found = symbolic.formulas(one)
    assert agrees(found)
    compute = compiled(symbolic.written(found, "c"), "rrbot_gravity", (1,), tmp_path)
    got = compute([0.3], [1.0, 2.0, -9.0], list(found.parameters.values()))
    np.testing.assert_allclose(got, ravengc.Robot(one).gravity_torque([0.3], (1.0, 2.0, -9.0)))


@pytest.mark.parametrize("what", QUANTITIES)
@pytest.mark.parametrize("name", ["rrbot", "raven2_gold"])
def test_latex_closes_what_it_opens(name: str, what: symbolic.Quantity) -> None:
    text = symbolic.written(symbolic.formulas(spec_for(name), what), "latex")
    around = (r"\begingroup", r"\allowdisplaybreaks", r"\endgroup")
    body = "\n".join(line for line in text.splitlines() if not line.startswith("%") and line not in around)
    assert body.count("{") == body.count("}")
    assert body.isascii()
    assert re.findall(r"\\begin{(\w+\*?)}", body) == re.findall(r"\\end{(\w+\*?)}", body)
    for line in body.splitlines():
        assert line.count(r"\left(") == line.count(r"\right)")
        assert line.count("&") == 1 or "pmatrix" in body or "align*" in line
    assert "**" not in body
    assert "*" not in body.replace("align*", "")


def test_long_latex_may_break_across_pages() -> None:
    """An align of amsmath does not by itself, and would run off the page."""
    short, long = (
        symbolic.written(symbolic.formulas(spec_for(name), form="steps"), "latex") for name in ("rrbot", "panda")
    )
    assert "allowdisplaybreaks" not in short
    assert "\n\\begingroup\n\\allowdisplaybreaks\n\\begin{align*}\n" in long
    assert long.endswith("\\end{align*}\n\\endgroup\n")


def test_elements_that_are_not_in_the_torques_are_named() -> None:
    spec = mtm_with_special_terms()
    for what, named in (("gravity", True), ("kinematics", False)):
        text = symbolic.written(symbolic.formulas(spec, what, gravity="level"), "c")  # type: ignore[arg-type]
        assert ("not in tau, to be added" in text and "wrist spring" in text) == named


def test_text_lists_what_is_not_zero() -> None:
    text = symbolic.written(symbolic.formulas(spec_for("raven2_gold"), "regressor"))
    assert "# all other entries of Y (3x12) are 0" in text
    assert "Y[1,1] = " not in text or "Y[1,1] = 0" not in text
    assert max(map(len, text.splitlines())) <= 115


def test_as_data_is_what_was_found() -> None:
    data = symbolic.as_data(symbolic.formulas(spec_for("rrbot"), gravity="level"))
    assert data["entries"] == {
        "tau1": "-g*m2*(cx2 + 0.9)*sin(q1 + q2) - g*(m1*(cx1 + 0.9) + 0.9*m2)*sin(q1)",
        "tau2": "-g*m2*(cx2 + 0.9)*sin(q1 + q2)",
    }
    assert data["meanings"]["q1"] == "joint1, rad"
    assert data["parameters"] == {"m1": 1.0, "cx1": -0.45, "m2": 1.0, "cx2": -0.45}


# What is refused


def test_a_wrong_formula_is_seen() -> None:
    found = symbolic.formulas(spec_for("rrbot"))
    wrong = replace(found, entries=(found.entries[0], found.entries[1] * sympy.Rational(1000001, 1000000)))
    assert not symbolic.check(wrong).holds
    assert symbolic.check(found).holds


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"what": "torque"}, "what 'torque' is unknown: choose 'gravity'"),
        ({"frame": "hand"}, "frame 'hand' is unknown"),
        ({"gravity": "levle"}, "did you mean 'level'"),
        ({"gravity": (1.0, 2.0)}, "gravity must be 3 finite numbers"),
        ({"moving_base": True}, "moving_base is for inverse dynamics"),
        ({"right_angles": 0.2}, "right_angles is 0.2; expected an angle from 0 to 0.1 rad"),
        ({"form": "short"}, "form 'short' is unknown"),
        ({"numbers": 1}, "numbers is an int; expected a bool"),
        ({"on_progress": 3}, "on_progress is an int"),
    ],
)
def test_wrong_arguments_are_told(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=re.escape(message)):
        symbolic.formulas(spec_for("rrbot"), **options)


def test_without_sympy_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sympy", None)
    algebra.engine.cache_clear()
    try:
        with pytest.raises(MissingExtraError, match=re.escape("pip install 'ravengc[symbolic]'")):
            symbolic.formulas(spec_for("rrbot"))
    finally:
        algebra.engine.cache_clear()


def test_base_and_tool_are_in_it() -> None:
    turned = Pose(rotation=((0, -1, 0), (1, 0, 0), (0, 0, 1)), translation=(0.1, 0.2, 0.3))
    spec = replace(spec_for("rrbot"), base=turned, tool=Pose(translation=(0.0, 0.0, 0.5)))
    assert agrees(symbolic.formulas(spec, "jacobian"))
    assert lines(symbolic.formulas(spec, "kinematics"))[-2:] == ["T[3,4] = 0.9", "T[4,4] = 1"]
