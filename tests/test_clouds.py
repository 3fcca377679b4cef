"""Clouds of points from files: what was written comes back, flaws are mended and said, what is no cloud is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ravengc.errors import ArgumentError, ConfigError, ParseError, RavenGCError
from ravengc.targets import Cloud, read_cloud
from ravengc.targets.normals import NEIGHBOURS, _clusters, _nearest

KINDS = {"float": "f4", "double": "f8", "short": "i2", "int": "i4"}
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def dome(count: int = 200, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points of the upper part of a sphere of 80 mm about (0.4, 0, 0.2), m, and its normals."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.5, 1.0, count)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    normals = np.column_stack((np.sqrt(1.0 - z * z) * np.cos(angle), np.sqrt(1.0 - z * z) * np.sin(angle), z))
    return np.array((0.4, 0.0, 0.2)) + 0.08 * normals, normals


def ply(
    rows: np.ndarray, *, form: str = "binary_little_endian", kind: str = "double", names: str = "x y z nx ny nz",
    before: str = "", behind: bytes = b"", comment: str = "", data_before: bytes = b"",
) -> bytes:  # fmt: skip
    properties = "".join(f"property {kind} {name}\n" for name in names.split()[: rows.shape[1]])
    header = f"ply\nformat {form} 1.0\n{comment}{before}element vertex {len(rows)}\n{properties}end_header\n"
    if form == "ascii":
        body = "".join(" ".join(f"{value:.17g}" for value in row) + "\n" for row in rows).encode()
    else:
        body = rows.astype(ORDERS[form] + KINDS[kind]).tobytes()
    return header.encode() + data_before + body + behind


def read(folder: Path, data: bytes | str, name: str = "cloud.ply", **options: Any) -> Cloud:
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_cloud(path, **options)


def refused(folder: Path, data: bytes | str, name: str = "cloud.csv", **options: Any) -> ParseError:
    with pytest.raises(ParseError) as caught:
        read(folder, data, name, **options)
    return caught.value


def csv(rows: np.ndarray, header: str = "x,y,z,nx,ny,nz", mark: str = ",") -> str:
    lines = [mark.join(f"{value:.17g}" for value in row) for row in rows]
    return "\n".join([header.replace(",", mark), *lines]) + "\n"


# What was written comes back


@quick
@given(
    form=st.sampled_from(["ascii", *ORDERS]), kind=st.sampled_from(["float", "double"]), seed=st.integers(0, 99),
    extra=st.booleans(), has_normals=st.booleans(),
)  # fmt: skip
def test_a_ply_comes_back(tmp_path: Path, form: str, kind: str, seed: int, extra: bool, has_normals: bool) -> None:
    points, normals = dome(30, seed)
    rows, names = (np.hstack((points, normals)), "x y z nx ny nz") if has_normals else (points, "x y z")
    before, data_before = "", b""
    if extra:
        rows, names = np.hstack((np.ones((30, 1)), rows)), f"quality {names}"
        before = "element camera 2\nproperty float a\nproperty uchar b\n"
        data_before = b"1 2\n1 2\n" if form == "ascii" else bytes(10)
    data = ply(rows, form=form, kind=kind, names=names, before=before, data_before=data_before, behind=b"\x03\0\0")
    cloud = read(tmp_path, data)
    tolerance = 1e-6 if kind == "float" and form != "ascii" else 1e-15
    np.testing.assert_allclose(cloud.points, points, atol=tolerance)
    if has_normals:
        np.testing.assert_allclose(cloud.normals, normals, atol=tolerance)


@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
def test_a_header_may_end_its_lines_in_any_way_and_name_lists_of_nothing(tmp_path: Path, end: bytes) -> None:
    """The vertices hold newlines, which must not be taken for the header's."""
    rows = np.hstack(dome(30))
    data = ply(rows, before="element face 0\nproperty list uchar int vertex_indices\n")
    header, _, vertices = data.partition(b"end_header\n")
    assert b"\n" in vertices
    cloud = read(tmp_path, header.replace(b"\n", end) + b"end_header" + end + vertices)
    np.testing.assert_array_equal(cloud.points, rows[:, :3])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", csv(np.hstack(dome()))),
        ("a.csv", csv(np.hstack(dome()), mark=";")),
        ("a.csv", csv(np.hstack(dome()), mark=";").replace(".", ",")),
        ("a.txt", csv(np.hstack(dome()), mark="\t")),
        ("a.txt", csv(np.hstack(dome())[:, [3, 4, 5, 0, 1, 2]], "normal_x,Normal Y,n.z,pos_x,Y,point z")),
        ("a.xyz", csv(np.hstack(dome()), "# from a scanner", mark=" ")),
        ("a.xyz", csv(np.hstack(dome()), "// x,y,z,nx,ny,nz", mark=" ").replace(",", " ")),
        ("a.xyz", csv(np.hstack(dome()), "% x,y,z,nx,ny,nz", mark=" ").replace(",", " ")),
        ("a.pts", csv(np.hstack(dome()), "200", mark=" ")),
        ("a.xyz", csv(np.hstack((dome()[0], np.full((200, 3), 128.0), dome()[1])), "# rgb between", mark=" ")),
        ("a.csv", csv(1e3 * np.hstack(dome()), "x [mm],y [mm],z [mm],nx,ny,nz")),
        ("a.csv", csv(1e3 * np.hstack(dome()), "x_mm,y_mm,z_mm,nx,ny,nz").replace("\n", "\r\n")),
        ("a.csv", csv(1e2 * np.hstack(dome()), "# units: centimetres\nx,y,z,nx,ny,nz")),
        ("a.csv", csv(1e3 * np.hstack(dome()), "# units are in mm\nx,y,z,nx,ny,nz")),
        ("a.csv", csv(1e3 * np.hstack(dome()))),
        ("a.csv", "\n".join(f'"{line}"'.replace(",", '","') for line in csv(np.hstack(dome())).split()) + "\n"),
    ],
)  # fmt: skip
def test_every_way_to_write_a_table_gives_the_same_cloud(tmp_path: Path, name: str, text: str) -> None:
    cloud = read(tmp_path, text, name)
    points, normals = dome()
    np.testing.assert_allclose(cloud.points, points, atol=1e-12)
    np.testing.assert_allclose(cloud.normals, normals, atol=1e-12)


@pytest.mark.parametrize(("unit", "factor"), [("m", 1.0), ("cm", 100.0), ("mm", 1000.0)])
def test_units_are_taken_from_the_file_the_caller_or_the_size_and_said(
    tmp_path: Path, unit: str, factor: float
) -> None:
    points, normals = dome()
    rows = np.hstack((factor * points, normals))
    for cloud in (
        read(tmp_path, ply(rows), units=unit),
        read(tmp_path, ply(rows, comment=f"comment units: {unit}\n")),
        read(tmp_path, ply(rows, comment=f"comment written in units of {unit}\n"), units=unit),
    ):
        np.testing.assert_allclose(cloud.points, points, atol=1e-12)
        assert not cloud.notes
    if unit != "cm":
        guessed = read(tmp_path, ply(rows))
        np.testing.assert_allclose(guessed.points, points, atol=1e-12)
        assert f"lengths are taken as {unit}: the cloud is 0.198 m across" in guessed.notes[0]
    else:
        with pytest.raises(ConfigError, match=r"cloud's diagonal measures .*units m, cm or mm"):
            read(tmp_path, ply(0.5 * rows))
    with pytest.raises(ConfigError, match="the file says"):
        read(tmp_path, ply(rows, comment=f"comment units {unit}\n"), units="mm" if unit == "m" else "m")


def test_units_that_are_not_read_and_points_far_from_the_rest_are_refused(tmp_path: Path) -> None:
    points, normals = dome()
    for unit in ("inches", "feet", "µm"):
        with pytest.raises(ConfigError, match=f"is in {unit}, as the file says; expected m, cm or mm"):
            read(tmp_path, f"# units: {unit}\n" + csv(np.hstack((points, normals))), "a.csv")
    points[7] = (0.0, 1e6, 0.0)
    with pytest.raises(ConfigError, match="measures 1000 m, taken as mm; remove what is far from the rest"):
        read(tmp_path, ply(np.hstack((points, normals))))
    assert len(read(tmp_path, ply(np.hstack((points, normals))), units="mm")) == 200


# Flaws


def test_flaws_are_mended_and_said(tmp_path: Path) -> None:
    points, normals = dome()
    rows = np.hstack((points, normals))
    rows[3, 0], rows[4, 2], rows[5, 1] = np.nan, np.inf, -1e12
    rows[10, 3:], rows[11, 3:], rows[12, 3:] = 0.0, np.nan, (3e-9, 0.0, 0.0)
    rows[20:30, 3:] *= 7.0
    rows = np.vstack((rows, rows[40:45]))
    cloud = read(tmp_path, ply(rows))
    assert len(cloud) == 197
    np.testing.assert_allclose(np.linalg.norm(cloud.normals, axis=1), 1.0)
    assert (
        np.degrees(np.arccos((cloud.normals * np.delete(normals, (3, 4, 5), axis=0)).sum(axis=1).clip(-1, 1))).max()
        < 12.0
    )
    assert cloud.notes[1:] == (
        "3 points without three finite coordinates are left out",
        "5 points repeating another are left out",
        "3 of 197 normals are missing or zero: estimated from the nearest points, turned as those around them",
    )


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        ({(4, 1): np.nan}, 6, "missing, not finite"),
        ({(7, 3): 0.0, (7, 4): 0.0, (7, 5): 0.0}, 9, "no normal"),
        ({(9, k): dome()[0][2, k] for k in range(3)}, 11, "the same point as one before"),
    ],
)
def test_strict_refuses_flaws_with_their_line(tmp_path: Path, change: dict, line: int, words: str) -> None:
    rows = np.hstack(dome())
    for place, value in change.items():
        rows[place] = value
    error = refused(tmp_path, csv(rows), strict=True, units="m")
    assert error.line == line
    assert words in str(error)
    error = refused(tmp_path, ply(rows), "a.ply", strict=True, units="m")
    assert error.line is None
    assert f"point {line - 1}: " in str(error)


def test_normals_of_a_plane_are_found_exactly_and_those_of_a_sphere_nearly(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    flat = np.column_stack((rng.uniform(0.3, 0.5, (300, 2)), np.full(300, 0.1)))
    cloud = read(tmp_path, ply(flat), facing=(0.0, 0.0, -2.0))
    np.testing.assert_allclose(cloud.normals, np.tile((0.0, 0.0, -1.0), (300, 1)), atol=1e-7)
    assert "no normals: estimated from the nearest points, turned towards (0, 0, -2)" in cloud.notes[-1]
    points, normals = dome(2000)
    found = read(tmp_path, ply(points)).normals
    angles = np.degrees(np.arccos((found * normals).sum(axis=1).clip(-1.0, 1.0)))
    assert np.quantile(angles, 0.95) < 5.0
    assert angles.max() < 25.0


def test_the_neighbours_are_the_nearest_ones_whatever_the_cloud() -> None:
    rng = np.random.default_rng(2)
    for cloud in (
        dome(3000)[0],
        rng.standard_normal((2000, 3)),
        np.vstack((dome(900)[0], 1e3 * rng.normal(size=(9, 3)))),
    ):
        support = cloud[:: 1 + len(cloud) // 1500]
        for rows in _clusters(cloud, np.arange(len(cloud))):
            away = np.linalg.norm(cloud[rows][:, None] - support[None], axis=2)
            found = np.sort(np.take_along_axis(away, _nearest(cloud[rows], support), axis=1), axis=1)
            np.testing.assert_allclose(found, np.sort(away, axis=1)[:, :NEIGHBOURS], rtol=1e-6, atol=1e-9)
        everyone = np.sort(np.concatenate(list(_clusters(cloud, np.arange(len(cloud))))))
        np.testing.assert_array_equal(everyone, np.arange(len(cloud)))


def test_more_points_than_normals_are_estimated_from_have_normals(tmp_path: Path) -> None:
    points, normals = dome(60_000)
    found = read(tmp_path, ply(points)).normals
    assert np.degrees(np.arccos((found * normals).sum(axis=1).clip(-1.0, 1.0))).max() < 15.0


def test_a_point_alone_and_points_on_a_line_need_normals(tmp_path: Path) -> None:
    alone = read(tmp_path, "0.5 0 0.3 0 0 2\n", "one.xyz")
    assert alone.points.tolist() == [[0.5, 0.0, 0.3]]
    assert alone.normals.tolist() == [[0.0, 0.0, 1.0]]
    assert "0.583 m from the origin" in alone.notes[0]
    error = refused(tmp_path, "x,y,z\n0.5,0,0.3\n")
    assert error.line == 2
    assert "give it nx, ny, nz" in str(error)
    straight = "x y z\n" + "".join(f"{0.01 * i} 0 0.3\n" for i in range(50))
    assert "off a line" in str(refused(tmp_path, straight, "line.xyz"))


# What is none


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("", "empty"),
        ("\n\n# nothing\n", "no row of numbers"),
        ("x,y\n1,2\n", "no column z"),
        ("1 2\n", "2 numbers in a row"),
        ("x,y,z\n0,0,0\n1,0\n", "a.csv:3: 2 cells; expected 3"),
        ("x,y,z\n0,0,0\n1,0,1_0\n", "a.csv:3:3: '1_0' is not a number"),
        ("x,y,z\n0,0,0\n1,0,up\n", "a.csv:3:3: 'up' is not a number"),
        ("x,y,z\n0,0\n", "a.csv:2: 2 cells; expected 3"),
        ("x,y,z,X\n0,0,0,0\n", "two columns for x"),
        ("x_mm,y_mm,z_m\n0,0,0\n", "different units"),
        ("x [inch],y [inch],z [inch]\n0,0,0\n", "column 'x [inch]' is in 'inch'; expected one of 'm', 'cm', 'mm'"),
        ('"0,5","0,3","0,2"\n' * 3, "a.csv:1:1: '\"0' has a quote without its second; numbers with a decimal"),
        ("0 0.5 0 0.3\n1 0.5 0.1 0.3\n2 0.4 0 0.3\n3 0.4 0.1 0.3\n", "a.csv:1: the first column counts the rows"),
        ("x,y,z\n0,0,\x1b[2J\n", r"a.csv:2:3: '\x1b[2J' is not a number"),
        ("x,y,z\nnan,0,0\ninf,0,0\n", "no point with three finite coordinates"),
        (b"x,y,z\n0,0,\xff\n", "a.csv:2: byte 0xff is not UTF-8 text"),
        (b"ply\n", "no line 'end_header'"),
        (b"ply\nend_header\n", "no line 'format'"),
        (b"ply\nformat ascii 1.0\nend_header\n", "no element 'vertex' (elements: none)"),
        (b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
         "0 vertices"),
        (b"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", ":3: '-1' elements; expected a whole number"),
        (b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n", "expected a whole number up to"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "a vertex has no y, z"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty flaot x\nend_header\n0\n", "did you mean 'float'?"),
        (b"ply\nformat acsii 1.0\nelement vertex 1\nend_header\n", "a.csv:2: 'format acsii 1.0' in the header"),
        (b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "a.csv:3: 'property float x' in the header"),
        (ply(dome()[0], form="ascii").replace(b"element vertex 200", b"element vertex 201"), "200 of the 201 vertices"),
        (ply(dome()[0], form="ascii")[:-30], "a.csv:207"),
        (ply(dome()[0])[:-1], "cut off: 199 of the 200 vertices that its header promises (24 bytes each)"),
        (ply(dome()[0]).replace(b"float z", b"float x"), "property twice"),
        (ply(dome()[0]).replace(b"property double x\n", b"property double x\nproperty list int int f\n"), "or a list"),
        (ply(dome()[0], before="element face 1\nproperty list uchar int v\n"), "stand before the vertices"),
    ],
)  # fmt: skip
def test_what_is_no_cloud_is_refused_and_said_why(tmp_path: Path, data: bytes | str, words: str) -> None:
    text = data if isinstance(data, bytes) else data.encode()
    if "twice" in words:
        text = text.replace(b"property double z", b"property double x\nproperty double z")
    assert words in str(refused(tmp_path, text, "a.csv"))


def test_paths_that_lead_nowhere(tmp_path: Path) -> None:
    (tmp_path / "liver.ply").write_bytes(ply(dome()[0]))
    with pytest.raises(ParseError, match=r"No such file or directory; did you mean 'liver\.ply'"):
        read_cloud(tmp_path / "lver.ply")
    with pytest.raises(ParseError, match="cannot be read"):
        read_cloud(tmp_path)
    with pytest.raises(ParseError, match="cannot be read"):
        read_cloud("a\0b")
    with pytest.raises(ConfigError, match=r"bundled cloud 'orgen' is unknown.*did you mean 'organ'"):
        read_cloud("example:orgen")
    with pytest.raises(ArgumentError, match="facing is"):
        read_cloud("example:organ", facing=(0, 0, 0))
    with pytest.raises(ConfigError, match="units 'inch' is unknown"):
        read_cloud("example:organ", units="inch")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_a_sentence(tmp_path: Path, data: st.DataObject) -> None:
    form = data.draw(st.sampled_from(["ascii", *ORDERS, "csv"]))
    rows = np.hstack(dome(20))
    whole = bytearray(csv(rows).encode() if form == "csv" else ply(rows, form=form, kind="float"))
    for _ in range(data.draw(st.integers(0, 3))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(whole)))
    found = read_or_complaint(tmp_path, bytes(whole[:cut]))
    if isinstance(found, str):
        assert 10 < len(found) < 500
    else:
        assert np.isfinite(found.points).all()
        np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0)


def read_or_complaint(folder: Path, data: bytes) -> Cloud | str:
    try:
        return read(folder, data)
    except RavenGCError as error:
        return str(error)


# Many points, placed


def test_a_million_points_are_thinned_evenly(tmp_path: Path) -> None:
    points, normals = dome(1_000_000)
    cloud = read(tmp_path, ply(np.hstack((points, normals)), kind="float"), most=500)
    assert 250 < len(cloud) <= 500
    assert f"{len(cloud)} of " in cloud.notes[-1]
    apart = np.linalg.norm(cloud.points[:, None] - cloud.points[None], axis=2)
    apart[np.diag_indices(len(apart))] = np.inf
    nearest = apart.min(axis=1)
    assert nearest.min() > 0.2 * nearest.mean()
    away = np.linalg.norm(points[::1000, None] - cloud.points[None], axis=2).min(axis=1)
    assert away.max() < 2.5 * nearest.mean()


@quick
@given(count=st.integers(1, 60), most=st.integers(1, 60), seed=st.integers(0, 9))
def test_thinning_keeps_points_of_the_cloud_and_no_more_than_asked(count: int, most: int, seed: int) -> None:
    cloud = Cloud(*dome(count, seed), "dome")
    thinned = cloud.thinned(most)
    assert 1 <= len(thinned) <= most
    assert {tuple(point) for point in thinned.points} <= {tuple(point) for point in cloud.points}
    assert len(cloud.thinned(count)) == count


@quick
@given(turn=st.tuples(*[st.floats(-180.0, 180.0)] * 3), at=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
def test_placing_is_rigid(turn: tuple[float, float, float], at: tuple[float, float, float]) -> None:
    cloud = Cloud(*dome(20), "dome")
    placed = cloud.placed(at, turn)
    np.testing.assert_allclose(placed.placed(at).middle, at, atol=1e-12)
    for before, after in ((cloud.points, placed.points), (cloud.normals, placed.normals)):
        apart = [np.linalg.norm(rows[:, None] - rows[None], axis=2) for rows in (before, after)]
        np.testing.assert_allclose(*apart, atol=1e-12)
    mean = placed.faced((0.0, 3.0, 0.0)).normals.mean(axis=0)
    np.testing.assert_allclose(mean / np.linalg.norm(mean), (0.0, 1.0, 0.0), atol=1e-9)


def test_the_bundled_cloud_is_what_its_program_writes() -> None:
    import importlib.util

    path = Path(__file__).parents[1] / "examples" / "organ_phantom.py"
    spec = importlib.util.spec_from_file_location("organ_phantom", path)
    assert spec
    assert spec.loader
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    points, normals = program.surface()
    cloud = read_cloud("example:organ").faced((0.0, 0.0, 1.0))
    assert len(cloud) == 3980
    assert len(cloud.notes) == 3
    height = np.ptp(points[:, 2]) / 1000.0
    assert abs(np.ptp(cloud.points[:, 2]) - height) < 0.02
    assert (cloud.normals[:, 2] > 0.2).all()
    assert (normals[:, 2] > 0.2).all()
