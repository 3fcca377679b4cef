"""The bound control law: what it is built from, what it is bound to, and what it answers."""

from __future__ import annotations

import gc
import re
import weakref
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc
from ravengc import _core
from ravengc.control import CONTROLLER_STATES, EVENTS, LAWS, Controller, Drive, raven2_drive
from ravengc.errors import ArgumentError, ConfigError, LimitError

RAVEN, PANDA = ravengc.load("raven2_gold"), ravengc.load("panda")
Q = np.array((0.5, 1.5, 0.4))
LEVEL = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))


def drive(n: int) -> Drive:
    return Drive(np.full(n, 100.0), np.full(n, 5.0), np.zeros(n), "a test")


def raven(law: str = "pd+dg", **options: Any) -> Controller:
    """The RAVEN, a little away from where it should be."""
    controller = Controller(RAVEN, law, options.pop("drive", drive(3)), **options)
    controller.q[:] = Q
    controller.q_desired[:] = Q + 0.01
    return controller


def arrays(n: int = 3, **replaced: Any) -> dict[str, Any]:
    """What the core binds to."""
    names = ("q", "qd", "q_desired", "qd_desired", "out", "tau_pd", "tau_gravity")
    return {**{name: np.zeros(n) for name in names}, "gravity": LEVEL.copy(), **replaced}


def core(law: str = "pd+dg", **options: Any) -> _core.Controller:
    return _core.Controller(RAVEN, law, **{"kp": np.ones(3), "kd": np.ones(3), "ramp_s": 0.0, **options})


# What it is built from


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"tau_max": (1.0, -2.0, 3.0)}, LimitError, "tau_max of 'elbow' is -2.0; it should be zero or positive"),
        ({"tau_rate_max": 0.0}, LimitError, "tau_rate_max of 'shoulder' is 0.0; it should be positive"),
        ({"tau_rate_max": (1.0, 2.0)}, ArgumentError, r"tau_rate_max must be one number or 3, not \(1.0, 2.0\)"),
        ({"limits": ((0.0, 1.0, 0.0), 0.9)}, LimitError, r"limits \(upper\) of 'elbow' is 0.9; .* above the lower"),
        ({"limits": 5}, ArgumentError, "limits is 5; expected lower and upper limits, 'robot' or None"),
        ({"limits": "robots"}, ConfigError, "limits 'robots' is unknown: choose 'robot'; did you mean"),
        ({"jump": -1.0}, ConfigError, "jump of 'shoulder' is -1.0"),
        ({"jump": 4.0, "wrap": 6.0}, ConfigError, "jump of 'shoulder' is 4.0; .* at most half the modulus"),
        ({"wrap": 0.0}, ConfigError, "wrap of 'shoulder' is 0.0"),
        ({"wrap": np.nan, "feedback": "motor"}, ConfigError, r"wrap of motor 0 \(from 0\) is NaN"),
        ({"rate_hz": 0.0}, ConfigError, "rate_hz is 0.0; it should be a rate of 1 to 1e5"),
        ({"ramp_s": -1.0}, ConfigError, "ramp_s is -1.0"),
        ({"hold_s": np.inf}, ConfigError, "hold_s is inf"),
        ({"feedback": "motors"}, ConfigError, "feedback 'motors' is unknown: choose 'joint', 'motor'; did you mean"),
        ({"output": "motr"}, ConfigError, "output 'motr' is unknown"),
        ({"on_fault": "stop"}, ConfigError, "on_fault 'stop' is unknown: choose 'gravity', 'decay'"),
        ({"armed": 1}, ArgumentError, "armed is an int; expected a bool"),
        ({"accelerometer": LEVEL}, ArgumentError, "accelerometer is a ndarray; expected an Accelerometer"),
        (
            {"drive": Drive(np.array((1.0, -1.0, 1.0)), np.ones(3), np.ones(3), "")},
            ConfigError,
            "kp of 'elbow' is -1.0",
        ),
        ({"drive": Drive(np.ones(3), np.ones(2), np.ones(3), "")}, ArgumentError, "kd must be one number or 3"),
        ({"drive": Drive(np.ones(3), np.full(3, np.nan), np.ones(3), "")}, ConfigError, "kd of 'shoulder' is NaN"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_field_joint_and_value(
    options: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        raven(**options)


def test_gains_of_ones_own_are_enough_for_a_drive() -> None:
    own = Drive(np.full(3, 100.0), np.full(3, 5.0))
    assert own.rotor_inertia.tolist() == [0.0, 0.0, 0.0]
    assert own.source == "given"
    controllers = raven(drive=own), raven()
    for controller in controllers:
        controller.update()
    assert (controllers[0].tau == controllers[1].tau).all()
    with pytest.raises(ArgumentError, match="kp has dtype <U5; expected real numbers"):
        Drive("stiff", np.ones(3))  # type: ignore[arg-type]


def test_a_robot_without_transmission_has_no_motors() -> None:
    with pytest.raises(ConfigError, match="feedback is 'motor'; it should be at the joints, as the robot has no trans"):
        Controller(PANDA, "pd", drive(7), feedback="motor")
    with pytest.raises(ConfigError, match="output is 'motor'; it should be at the joints"):
        Controller(PANDA, "pd", drive(7), output="motor")


# What it is bound to


@pytest.mark.parametrize(
    ("replaced", "message"),
    [
        ({"q": [0.0, 0.0, 0.0]}, "q is a list; expected a float64 array"),
        ({"q": np.zeros(4)}, r"q has shape \(4,\)"),
        ({"out": np.zeros(3, dtype=np.float32)}, "out has dtype float32"),
        ({"gravity": np.zeros(2)}, r"gravity has shape \(2,\)"),
        ({"gravity": None}, "give either gravity or specific_force"),
        ({"specific_force": np.zeros(3)}, "give either gravity or specific_force"),
        ({"angular_velocity": np.zeros(3)}, "give both angular_velocity and angular_acceleration"),
        ({"q_desired": None}, r"q_desired is missing: the law 'pd\+dg' follows a target"),
    ],
)
def test_what_cannot_be_bound_is_refused(replaced: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        core().bind(**arrays(**replaced))


def test_outputs_have_memory_of_their_own() -> None:
    shared = np.zeros(3)
    for pair in (("out", "q"), ("out", "tau_pd"), ("tau_gravity", "qd_desired"), ("tau_pd", "gravity")):
        with pytest.raises(ArgumentError, match="shares memory"):
            core().bind(**arrays(**dict.fromkeys(pair, shared)))
    core().bind(**arrays(**dict.fromkeys(("q", "q_desired"), shared)))


def test_a_live_sensor_says_itself_how_the_base_turns() -> None:
    turning = {"angular_velocity": np.zeros(3), "angular_acceleration": np.zeros(3)}
    with pytest.raises(ArgumentError, match="the Accelerometer says how the base turns"):
        core("pd+bm").bind(**arrays(gravity=ravengc.Accelerometer(), **turning))


def test_an_array_that_changed_since_is_noticed() -> None:
    bound = arrays()
    step = core().bind(**bound)
    step()
    bound["tau_pd"].setflags(write=False)
    with pytest.raises(ArgumentError, match="bind again"):
        step()


def test_specific_force_is_gravity_turned_round() -> None:
    force, field = arrays(specific_force=-LEVEL), arrays()
    del force["gravity"]
    for bound in (force, field):
        law = core()
        law.arm()
        law.bind(**bound)()
    assert (force["out"] == field["out"]).all()
    assert field["out"] == pytest.approx(RAVEN.gravity_torque(np.zeros(3), LEVEL))


def test_gravity_alone_needs_no_target() -> None:
    q, out = Q.copy(), np.zeros(3)
    law = core("passive")
    law.arm()
    law.bind(q=q, out=out, gravity=LEVEL.copy())()
    assert (out == RAVEN.gravity_torque(Q, LEVEL)).all()


def test_a_cycle_and_what_it_holds_are_collected_together() -> None:
    class Array(np.ndarray):
        """One that can hold the cycle that holds it."""

        step: object

    out = np.zeros(3).view(Array)
    out.step = core().bind(**arrays(out=out))
    watch = weakref.ref(out)
    del out
    gc.collect()
    assert watch() is None


# What it answers


def test_every_law_of_the_core_is_a_law_here() -> None:
    for law in LAWS:
        core(law)
    with pytest.raises(
        ConfigError, match=re.escape("law is 'pd+xx'; choose 'pd', 'pd+sg', 'pd+dg', 'pd+bm' or 'passive'")
    ):
        core("pd+xx")


@pytest.mark.parametrize("law", ["pd+dg", "pd+bm"])
def test_gravity_from_a_live_sensor_in_the_same_call(law: str) -> None:
    chain = ravengc.Accelerometer(start_count=1, gravity_rate=1e6)
    controller = raven(law, accelerometer=chain)
    controller.update()
    assert controller.tau_gravity == pytest.approx(RAVEN.gravity_torque(Q, LEVEL), rel=1e-12)
    assert controller.state == "armed"
    assert chain.counters["no_sensor"] == 0


def test_an_arm_is_not_armed_on_a_strict_sensor_that_says_nothing() -> None:
    controller = raven(accelerometer=ravengc.Accelerometer(policy="strict"))
    controller.update()
    assert (controller.state, controller.seen, controller.tau.any()) == ("disarmed", ("waiting",), False)


def test_arming_is_bumpless() -> None:
    controller = raven(ramp_s=0.1, tau_rate_max=1e3, armed=False)
    controller.update()
    assert (controller.state, controller.tau.any()) == ("disarmed", False)
    controller.arm()
    taus = []
    for _ in range(200):
        controller.update()
        taus.append(controller.tau.copy())
    assert not taus[0].any()
    assert np.abs(np.diff(taus, axis=0)).max() <= 1.0 + 1e-12
    assert controller.state == "armed"
    assert controller.tau == pytest.approx(100.0 * 0.01 + controller.tau_gravity)


def test_a_fault_is_latched_until_it_is_acknowledged() -> None:
    controller = raven(hold_s=0.01)
    controller.update()
    controller.q[1] = np.nan
    for _ in range(11):
        controller.update()
    assert (controller.state, controller.seen) == ("fault", ("absent", "fault"))
    assert controller.tau == pytest.approx(RAVEN.gravity_torque(Q, LEVEL))
    controller.q[1] = Q[1]
    controller.update()
    assert (controller.state, controller.seen, controller.since) == ("fault", (), ("absent", "fault"))
    assert controller.counters["absent"] == 11
    assert controller.counters["cycles"] == 13
    assert controller.counters.keys() - {"cycles"} == set(EVENTS)
    controller.acknowledge()
    assert controller.status == 0
    controller.update()
    assert controller.state == "armed"
    controller.disarm()
    controller.update()
    assert (controller.state, controller.tau.any()) == ("disarmed", False)


def test_status_words_have_the_bits_of_the_events() -> None:
    controller = raven(limits="robot", tau_max=1e-3)
    controller.q_desired[:] = 9.0
    controller.update()
    bits = {name: 1 << bit for bit, name in enumerate(EVENTS)}
    seen = bits["target_limit"] | bits["torque_limit"]
    assert controller.status == seen | seen << 32
    assert all(EVENTS.values())
    assert controller.state in CONTROLLER_STATES


def test_first_differences_stand_in_for_velocities() -> None:
    controller = raven("pd", differentiate=True, rate_hz=500.0)
    controller.qd[:] = np.nan
    controller.update()
    controller.q += 0.001
    controller.update()
    assert controller.tau_pd == pytest.approx(np.full(3, 100.0 * 0.009 - 5.0 * 0.5))
    controller.skip(4)
    controller.q += 0.001
    controller.update()
    assert controller.tau_pd == pytest.approx(np.full(3, 100.0 * 0.008 - 5.0 * 0.1))
    with pytest.raises(ArgumentError, match="updates is -1"):
        controller.skip(-1)


def test_the_published_motor_gains_at_the_motors_are_those_at_the_joints_but_for_the_coupling() -> None:
    """Kp at the motors is C^-T Kp C^-1 at the joints; the published joint gains are its diagonal, nearly."""
    transmission = RAVEN.spec.transmission
    assert transmission is not None
    C = np.array(transmission.joint_per_motor)
    at_motors = Drive(np.array((0.3, 0.3, 0.15)) / 12.25, np.zeros(3), np.zeros(3), "at the motors")
    controller = raven("pd", drive=at_motors, feedback="motor", output="joint")
    controller.q[:] = RAVEN.motor_positions(Q)
    controller.update()
    stiffness = np.linalg.inv(C).T @ np.diag(at_motors.kp) @ np.linalg.inv(C)
    assert controller.tau == pytest.approx(stiffness @ np.full(3, 0.01), rel=1e-9)
    assert np.diag(stiffness) == pytest.approx(raven2_drive().kp, rel=0.03)


anything = st.floats(width=64) | st.floats(-4.0, 4.0)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_whatever_comes_in_what_goes_out_is_finite_and_within_limits(data: st.DataObject) -> None:
    law = data.draw(st.sampled_from(sorted(LAWS)))
    options = {"tau_max": 20.0, "tau_rate_max": 2e3, "limits": "robot", "jump": 0.5, "wrap": 6.3, "ramp_s": 0.005}
    controller = raven(law, **options, on_fault=data.draw(st.sampled_from(("gravity", "decay"))), hold_s=0.003)
    inputs = [controller.q, controller.qd, controller.q_desired, controller.qd_desired, controller.gravity]
    inputs += [controller.angular_velocity, controller.angular_acceleration]
    for _ in range(30):
        array = data.draw(st.sampled_from(range(len(inputs))))
        inputs[array][data.draw(st.integers(0, 2))] = data.draw(anything)
        before = controller.tau.copy()
        controller.update()
        assert np.isfinite(controller.tau).all()
        assert np.isfinite(controller.tau_pd).all()
        assert np.isfinite(controller.tau_gravity).all()
        assert (np.abs(controller.tau) <= 20.0).all()
        assert (np.abs(controller.tau - before) <= 2.0 * (1.0 + 1e-15)).all()
        if data.draw(st.booleans()):
            controller.acknowledge()
