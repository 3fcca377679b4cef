"""The arguments of the reference by their names, so that what is wrong is said before the first matrix product."""

from __future__ import annotations

from functools import wraps
from inspect import signature
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from ravengc._convert import as_array, check_choice, check_type
from ravengc.errors import ArgumentError
from ravengc.messages import shown
from ravengc.spec import RobotSpec

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["checked"]

P = ParamSpec("P")
T = TypeVar("T")

OF_COORDINATES = ("q", "qd", "qdd", "tau")
IN_BASE_AXES = ("g", "f", "w", "dw", "v")


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Let a function of the reference raise ArgumentError for an argument of the wrong kind, shape or name.

    Its arguments are told by their names: ``spec``; ``q``, ``qd``, ``qdd``, ``tau`` (n,); ``g``, ``f``, ``w``, ``dw``,
    ``v`` (3,); ``payload``; ``frame``; ``axes``. None is as good as left out where it is the default.
    """
    names = signature(function)

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        given = names.bind(*args, **kwargs).arguments
        spec = given["spec"]
        check_type(spec, RobotSpec, "spec")
        for name, value in given.items():
            if value is not None or names.parameters[name].default is not None:
                _check(name, value, spec)
        return function(*args, **kwargs)

    return call


def _check(name: str, value: Any, spec: RobotSpec) -> None:
    if name in OF_COORDINATES:
        _check_shape(value, name, (len(spec.coordinate_names),))
    elif name in IN_BASE_AXES:
        _check_shape(value, name, (3,))
    elif name == "payload":
        _check_payload(value)
    elif name == "frame":
        check_choice(value, ("base", *(link.name for link in spec.links), "tool"), name, ArgumentError)
    elif name == "axes":
        check_choice(value, ("base", "frame"), name, ArgumentError)


def _check_shape(value: Any, name: str, shape: tuple[int, ...]) -> None:
    array = as_array(value, name, kinds="iufc")
    if array.shape != shape:
        raise ArgumentError(f"{name} has shape {array.shape}; expected {shape}")


def _check_payload(value: Any) -> None:
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ArgumentError(f"payload is {shown(value)}; expected a mass, a centre of mass and an inertia, or None")
    for name, entry, shape in zip(("mass", "com", "inertia"), value, ((), (3,), (6,)), strict=True):
        _check_shape(entry, f"payload: {name}", shape)
