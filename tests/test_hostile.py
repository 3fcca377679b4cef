"""What nobody should do: the package answers with an error of its own, never with a crash, a hang or a traceback."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
import textwrap
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.errors import ArgumentError, ConfigError, ModelError, ParseError, RavenGCError
from ravengc.log import read_log, write_log
from ravengc.recordings import read_recording
from ravengc.reports.figures import save_figure
from ravengc.spec import CouplingSpec, DhRow, JointLimits, JointOrigin, LinkSpec, Pose, RobotSpec, TransmissionSpec

if TYPE_CHECKING:
    from collections.abc import Callable

PANDA = rg.load("panda").spec
LEVEL = rg.Gravity.level()
linux = pytest.mark.skipif(sys.platform != "linux", reason="pipes, limits and devices of Linux")


def script(code: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a process of its own: what it does to the interpreter stays there."""
    text = "import numpy as np, ravengc as rg\n" + textwrap.dedent(code)
    return subprocess.run(  # noqa: S603 -- this very interpreter
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=120, check=False
    )


# --- descriptions made by hand


def with_link(**changes: object) -> RobotSpec:
    return replace(PANDA, links=(replace(PANDA.links[0], **changes), *PANDA.links[1:]))


COUPLING = CouplingSpec(coordinates=tuple("abcdefg"), matrix=np.eye(7), offset=np.zeros(7))
TRANSMISSION = TransmissionSpec(motors=tuple("abcdefg"), joint_per_motor=np.eye(7), offset=np.zeros(7))
WRONG: list[tuple[Callable[[], object], str]] = [
    (lambda: 5, "robot: got 5, expected a RobotSpec"),
    (lambda: PANDA.links, "expected a RobotSpec"),
    (lambda: replace(PANDA, name=None), "robot: name: got None, expected a text"),
    (lambda: replace(PANDA, name="n" * 101), "at most 100 visible characters"),
    (lambda: replace(PANDA, links=None), "robot: links: got None, expected a tuple"),
    (lambda: replace(PANDA, links=(PANDA,)), "expected a LinkSpec"),
    (lambda: replace(PANDA, links=PANDA.links * 3), "has it already"),
    (lambda: replace(PANDA, base=np.eye(4)), "robot: base: got array"),
    (lambda: replace(PANDA, base=Pose(rotation=5)), "robot: base: rotation: got 5, expected a tuple"),
    (lambda: replace(PANDA, base=Pose(rotation=np.diag([1, 1, -1]))), "a mirror"),
    (lambda: replace(PANDA, tool=Pose(translation="abc")), "translation: got 'abc', expected a tuple"),
    (lambda: replace(PANDA, tip=7), "robot: tip: got 7, expected a text or None"),
    (lambda: replace(PANDA, description=1), "description: got 1, expected a text"),
    (lambda: replace(PANDA, coupling=(1, 2)), "expected a CouplingSpec or None"),
    (lambda: replace(PANDA, coupling=replace(COUPLING, matrix=[[1.0]])), "expected 7 rows of 7"),
    (lambda: replace(PANDA, coupling=replace(COUPLING, coordinates="abcdefg")), "expected a tuple"),
    (lambda: replace(PANDA, transmission=replace(TRANSMISSION, motors=list(range(7)))), "motors[0]: got 0"),
    (lambda: replace(PANDA, transmission=replace(TRANSMISSION, joint_per_motor=np.ones((7, 7)))), "has no inverse"),
    (lambda: with_link(joint="revolut"), "got 'revolut', expected one of"),
    (lambda: with_link(mass="1 kg"), "mass: got '1 kg', expected a number"),
    (lambda: with_link(mass=True), "mass: got True, expected a number"),
    (lambda: with_link(mass=0.0), "is 0 or not given"),
    (lambda: with_link(massless=1), "massless: got 1, expected true or false"),
    (lambda: with_link(com=np.zeros(2)), "com: got 2 numbers, expected 3"),
    (lambda: with_link(com=[0.0, np.nan, 0.0]), "com: got nan"),
    (lambda: with_link(inertia=None), "inertia: got None"),
    (lambda: with_link(placement=None), "placement: got None, expected a DhRow or a JointOrigin"),
    (lambda: with_link(placement=JointOrigin(axis=(1.0, 1.0, 0.0))), "expected a unit vector"),
    (lambda: with_link(limits={"lower": 0.0}), "expected a JointLimits"),
    (lambda: with_link(limits=JointLimits(lower="0 deg")), "lower: got '0 deg', expected a number or None"),
]


@pytest.mark.parametrize(("make", "words"), WRONG, ids=[words for _, words in WRONG])
def test_a_description_made_by_hand_is_checked(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(ModelError) as caught:
        rg.Robot(make())
    assert words in str(caught.value)


def test_arrays_and_lists_in_a_description_become_tuples() -> None:
    base = Pose(rotation=np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), translation=[0.0, 0.0, 1])
    link = LinkSpec(name="arm", placement=DhRow(), mass=1.0, com=np.array([0.1, 0.0, 0.0]), inertia=[0.1, 0, 0] * 2)
    spec = RobotSpec(name="arm", convention="standard", links=[replace(link, inertia=np.zeros(6))], base=base)
    assert isinstance(hash(spec), int)
    assert rg.from_toml(rg.Robot(spec).to_toml()).spec == spec


def test_the_description_of_a_robot_cannot_be_exchanged() -> None:
    with pytest.raises(AttributeError):
        rg.load("rrbot").spec = PANDA


# --- arguments


HUGE = 10**400


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda r: r.set_payload(1e300, (0, 0, 0)), "payload: mass: got 1e300, expected at most 1e9"),
        (lambda r: r.set_payload(1.0, (0, 0, 1e10)), "payload: com: got 1e10"),
        (lambda r: r.set_payload(1.0, (0, 0, 0), [1e300] * 6), "payload: inertia: got 1e300"),
        (lambda r: r.set_payload(np.nan, (0, 0, 0)), "mass is not finite"),
        (lambda r: r.set_base(np.eye(3), (1e300, 0, 0)), "base: translation: got 1e300"),
        (lambda r: r.set_tool(np.eye(3), (1e300, 0, 0)), "tool: translation: got 1e300"),
        (lambda r: r.set_payload(HUGE, (0, 0, 0)), "too large for a float64"),
        (lambda _: rg.Gravity(HUGE, 0, 0), "too large for a float64"),
        (lambda r: r.mass_matrix_batch([[0.0, 0.0]], threads=HUGE), "a whole number is beyond 64 bits"),
        (lambda r: r.forward_kinematics([0, 0], frame="link11"), "did you mean 'link1'? (there are base, link1"),
        (lambda r: r.forward_kinematics([0, 0], frame="\udcff"), "not valid Unicode"),
        (lambda r: r.jacobian([0, 0], axes="x" * 10**6), "expected 'base' or 'frame'"),
        (lambda r: r.mass_matrix_batch([0.0, 0.0]), "q has shape (2,); expected (samples, 2)"),
        (lambda r: r.gravity_torque(np.ma.masked_array([0.0, 1.0], mask=[0, 1]), LEVEL), "q has masked entries"),
        (lambda r: r.gravity_torque([HUGE, 0], LEVEL), "q has dtype object"),
    ],
)
def test_what_no_argument_can_be_is_refused(call: Callable[[rg.Robot], object], words: str) -> None:
    with pytest.raises(RavenGCError) as caught:
        call(rg.load("rrbot"))
    assert words in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_longer_float_beyond_float64_is_infinite_without_a_warning() -> None:
    tau = rg.load("rrbot").gravity_torque(np.array(["1e4000", 0], dtype=np.longdouble), LEVEL)
    assert np.isnan(tau).all() or np.finfo(np.longdouble).max < 1e4000


def test_batches_take_nested_lists() -> None:
    robot, q = rg.load("rrbot"), [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]
    gravity = [[0.0, 0.0, -9.8], [1.0, 0.0, -9.8], [0.0, 1.0, -9.8]]
    tau = [robot.gravity_torque(*each) for each in zip(q, gravity, strict=True)]
    np.testing.assert_allclose(robot.gravity_torque_batch(q, gravity), tau, rtol=1e-12)
    base = np.hstack((-np.array(gravity), np.zeros((3, 6)))).tolist()
    np.testing.assert_allclose(
        robot.inverse_dynamics_batch(q, np.zeros((3, 2)), np.zeros((3, 2)), base), tau, rtol=1e-12
    )


@pytest.mark.parametrize(
    "value",
    [
        LEVEL,
        rg.SpecificForce.level(),
        rg.BaseMotion(specific_force=(1.0, 2.0, 3.0), angular_velocity=(4, 5, 6), angular_acceleration=(7, 8, 9)),
        rg.Mounting([[0, -1, 0], [1, 0, 0], [0, 0, 1]], (0.1, 0.2, 0.3)),
    ],
    ids=lambda value: type(value).__name__,
)
def test_values_survive_copies_and_pickles(value: object) -> None:
    for again in (copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))):  # noqa: S301 -- our own
        assert again == value
        assert repr(again) == repr(value)


# --- the interpreter


@linux
def test_a_result_without_room_is_a_memory_error() -> None:
    done = script("""
        import resource
        q = np.zeros((2_000_000, 7))
        resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))
        try:
            rg.load("panda").gravity_regressor_batch(q, rg.Gravity.level())
        except MemoryError as error:
            print("refused", error)
    """)
    assert done.stdout.startswith("refused Unable to allocate")
    assert (done.returncode, done.stderr) == (0, "")


@linux
def test_bound_cycles_outlive_the_interpreter_and_forks() -> None:
    done = script("""
        import atexit, os, threading
        robot = rg.load("panda")
        robot.cycle = robot.bind(q=np.zeros(7), gravity=np.zeros(3), out=np.zeros(7))
        robot.mass_matrix_batch(np.zeros((2000, 7)), threads=2)
        child = os.fork()
        if child == 0:
            robot.cycle()
            robot.mass_matrix_batch(np.zeros((2000, 7)), threads=2)
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        def for_ever():
            while True:
                robot.cycle()
                robot.mass_matrix_batch(np.zeros((2000, 7)), threads=2)
        threading.Thread(target=for_ever, daemon=True).start()
        atexit.register(robot.cycle)
    """)
    assert (done.returncode, done.stderr) == (0, "")


# --- files


@linux
@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("arm.toml", rg.from_toml),
        ("arm.toml", rg.load),
        ("arm.urdf", rg.from_urdf),
        ("run.npz", read_log),
        ("run.csv", read_log),
        ("run.npz", read_recording),
        ("run.csv", read_recording),
        ("run.db3", read_recording),
    ],
)
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path, name: str, read: Callable[[Path], object]) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(ParseError, match="a pipe or a device"):
        read(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "no such file"),
        ("a\0b.csv", "no such file"),
        ("~nobody-of-this-name/run.csv", "no such file"),
        ("loop.csv", "a link to nowhere: loop.csv"),
        ("gone.csv", "a link to nowhere: elsewhere.csv"),
        ("folder", r"a folder without metadata\.yaml"),
        ("n" * 300 + ".csv", "cannot be read"),
    ],
)
def test_paths_to_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, problem: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("loop.csv").symlink_to("loop.csv")
    Path("gone.csv").symlink_to("elsewhere.csv")
    Path("folder").mkdir()
    with pytest.raises(ParseError, match=problem):
        read_recording(name)


def header(text: str) -> bytes:
    """An ``.npy`` file with this header and no data."""
    line = f"{text}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(line).to_bytes(2, "little") + line


class Trap:
    """A pickle that would leave a file behind."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.mark,)


MEMBERS: dict[str, Callable[[Path], bytes]] = {
    "a pickle": lambda mark: pickle.dumps(Trap(mark)),
    "objects": lambda mark: header("{'descr': '|O', 'fortran_order': False, 'shape': (1,)}") + pickle.dumps(Trap(mark)),
    "nothing": lambda _: b"",
    "code": lambda mark: header(f"__import__('pathlib').Path({str(mark)!r}).touch()"),
    "half a header": lambda _: header("{'descr': '<f8'"),
    "a deep header": lambda _: header("[" * 5000),
    "a shape beyond memory": lambda _: header("{'descr': '<f8', 'fortran_order': False, 'shape': (10**17,)}"),
    "a large shape": lambda _: header("{'descr': '<f8', 'fortran_order': False, 'shape': (100000000000000,)}"),
}


@pytest.mark.parametrize("kind", MEMBERS)
@pytest.mark.parametrize("read", [read_recording, read_log])
def test_hostile_archives_are_refused_and_nothing_in_them_runs(
    tmp_path: Path, read: Callable[[Path], object], kind: str
) -> None:
    path, mark = tmp_path / "run.npz", tmp_path / "mark"
    np.savez(tmp_path / "t.npz", t=np.arange(3.0))
    with zipfile.ZipFile(path, "w") as archive, zipfile.ZipFile(tmp_path / "t.npz") as good:
        archive.writestr("t.npy", good.read("t.npy"))
        archive.writestr("q.npy", MEMBERS[kind](mark))
    with pytest.raises(RavenGCError, match=r"run\.npz"):
        read(path)
    assert not mark.exists()


@pytest.mark.parametrize("read", [read_recording, read_log])
@pytest.mark.parametrize(("place", "value"), [((6, 8), 1), ((8, 10), 99)], ids=["encrypted", "unknown compression"])
def test_archives_that_cannot_be_unpacked_are_refused(
    tmp_path: Path, read: Callable[[Path], object], place: tuple[int, int], value: int
) -> None:
    """Flags and compression stand at these places of a member's own header and of its entry in the directory."""
    path = tmp_path / "run.npz"
    np.savez(path, t=np.arange(3.0), q=np.zeros((3, 2)))
    data = bytearray(path.read_bytes())
    for mark, at in zip((b"PK\x03\x04", b"PK\x01\x02"), place, strict=True):
        start = -1
        while (start := data.find(mark, start + 1)) >= 0:
            data[start + at] = value
    path.write_bytes(data)
    with pytest.raises(ParseError, match=r"run\.npz"):
        read(path)


@pytest.mark.parametrize(
    "name", ["_" * 10**6, "(" * 10**5, "(" + " " * 10**6 + "x", "a" + " " * 10**6 + "b", "/" * 10**6, "q" + "1" * 5000]
)
def test_long_column_names_take_no_time(tmp_path: Path, name: str) -> None:
    path = tmp_path / "run.csv"
    path.write_text(f"t,q1,{name}\n0,1,2\n")
    recording = read_recording(path)
    assert recording.joints == 1
    assert recording.notes[0].startswith("columns not used: ")
    assert len(recording.notes[0]) < 120


def test_large_tables_in_a_robot_file_take_little_time() -> None:
    arm = 'format = 1\nname = "arm"\nconvention = "frames"\n[[link]]\nname = "arm"\nmass = 1\n'
    for line in (f"com = [{'1.0,' * 10**5}]", f"rotation = [{'[1],' * 10**5}]"):
        with pytest.raises(ConfigError, match=r"expected (3 numbers|at most 64 rows)"):
            rg.from_toml(arm + line)


@pytest.mark.parametrize("text", ["{arm}", "\ufeff{arm}"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_text_with_a_mark_or_other_line_ends_is_read(text: str, end: str) -> None:
    arm = 'format = 1\nname = "arm"\nconvention = "frames"\n[[link]]\nname = "arm"\nmass = 1\n'
    assert rg.from_toml(text.format(arm=arm).replace("\n", end)).name == "arm"
    with pytest.raises(ParseError, match="not valid TOML"):
        rg.from_toml(arm.replace("\n", "\r"))


def draw(path: Path) -> None:
    figure = pytest.importorskip("matplotlib.figure").Figure()
    save_figure(figure, path)


WRITERS: dict[str, Callable[[Path], object]] = {
    ".toml": lambda path: rg.load("rrbot").to_toml(path),
    ".npz": lambda path: write_log(path, {"t": np.zeros(1)}, {}),
    ".png": draw,
}


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize(
    ("name", "problem"), [("file/x", "'.*file' is not a folder"), ("folder", "Is a directory"), ("a\0b", "null")]
)
def test_places_that_cannot_be_written_are_named(tmp_path: Path, suffix: str, name: str, problem: str) -> None:
    (tmp_path / "file").write_text("in the way")
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(ConfigError, match=f"cannot be written: .*{problem}"):
        WRITERS[suffix](tmp_path / f"{name}{suffix}")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", f"folder{suffix}"]


def test_no_robot_is_written_over_the_root_folder() -> None:
    with pytest.raises(ConfigError, match="it is a folder"):
        rg.load("rrbot").to_toml("/")


def test_argument_errors_are_argument_errors() -> None:
    """Objects of another kind, for the functions that take the package's own."""
    from ravengc.control import Controller, raven2_drive
    from ravengc.recordings import fit_to_robot
    from ravengc.replay import replay

    recording = read_recording("example:panda")
    for call in (
        lambda: replay(PANDA, recording),
        lambda: replay(rg.load("panda"), "example:panda"),
        lambda: fit_to_robot(recording, rg.load("panda")),
        lambda: Controller(PANDA, "pd", raven2_drive()),
        lambda: Controller(rg.load("raven2_gold"), "pd", 5.0),
    ):
        with pytest.raises(ArgumentError, match="; expected a "):
            call()
