"""The picture, the page and the view of a run over a moving surface, from a run whose numbers are known."""

from __future__ import annotations

import re
import subprocess
import sys
from html.parser import HTMLParser
from typing import TYPE_CHECKING

import numpy as np
import pytest

from ravengc.errors import ConfigError, MissingExtraError
from ravengc.reports import track_view
from ravengc.reports.track_figures import flattened, hold_errors
from ravengc.reports.track_numbers import ROWS, cell, means
from ravengc.reports.track_report import Report, report_html, write_report
from ravengc.reports.track_view import frame_rows, write_view
from track_scenes import ROBOT, small_run

if TYPE_CHECKING:
    from pathlib import Path

VOID = {"meta", "img", "br", "hr", "link", "input"}


class Checker(HTMLParser):
    """Collects what an HTML document refers to, and fails where its tags do not match."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.refers: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.refers += [value or "" for name, value in attrs if name in {"src", "href"}]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        while self.open.pop() != tag:
            assert self.open or tag == "html", tag

    def handle_data(self, data: str) -> None:
        self.text += data


def report(**changes: object) -> Report:
    runs = {"resolved": small_run(), "naive": small_run(method="naive", error_m=1.2e-3)}
    given = {
        "title": "A <title> & more",
        "summaries": {name: [run.summary()] for name, run in runs.items()},
        "runs": runs,
        "picture": b"\x89PNG",
        "command": "ravengc track --surface 'a b.ply'",
        "notes": ["lengths are taken as mm"],
        "links": {"3-D": "view.html"},
    }
    return Report(**(given | changes))  # type: ignore[arg-type]


def test_the_page_is_one_file_with_the_numbers(tmp_path: Path) -> None:
    write_report(tmp_path / "report.html", report())
    page = Checker()
    page.feed((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert not page.open
    assert page.refers == ["view.html", "data:image/png;base64,iVBORw=="]
    for expected in (
        "A <title> & more",
        "coverage, %",
        "70.0",
        "1.200",
        "6 points were not covered",
        "2 hold tests",
        "lengths are taken as mm",
        "closing_gain_per_s",
        "unreachable",
    ):
        assert expected in page.text


def test_the_page_of_several_seeds_says_so() -> None:
    run = small_run()
    page = report_html(report(summaries={"resolved": [run.summary()] * 3}, runs={"resolved": run}))
    assert "Means of 3 seeds" in page


def test_means_are_means_and_violations_are_added_up() -> None:
    a, b = small_run(error_m=2e-4).summary(), small_run(error_m=4e-4).summary()
    a["limit_violations"] = {"position": 2, "velocity": 1}
    found = means([a, b])
    assert found["hold_rms_m"] == pytest.approx(3e-4)
    assert found["limit_violations"] == 3.0
    assert np.isnan(means([small_run(holds=0).summary()])["hold_rms_m"])
    texts = {row.key: cell(row, found) for row in ROWS}
    assert texts["coverage"] == "70.0"
    assert texts["hold_rms_m"] == "0.300"
    assert cell(next(row for row in ROWS if row.key == "hold_rms_m"), means([small_run(holds=0).summary()])) == "–"


def test_hold_errors_leave_out_the_way_there() -> None:
    run = small_run(holds=2)
    errors = hold_errors(run)
    assert len(errors) == 2 * 100
    np.testing.assert_allclose(errors, 3e-4)
    assert len(hold_errors(small_run(holds=0))) == 0


def test_the_flat_map_of_a_plane_keeps_distances() -> None:
    rng = np.random.default_rng(0)
    across = np.linalg.qr(rng.standard_normal((3, 3)))[0][:, :2]
    points = rng.standard_normal((30, 2)) @ across.T
    flat = flattened(points) / 1e3
    np.testing.assert_allclose(
        np.linalg.norm(flat[:, None] - flat[None], axis=2), np.linalg.norm(points[:, None] - points[None], axis=2)
    )
    assert flattened(np.zeros((1, 3))).shape == (1, 2)


@pytest.mark.parametrize("case", ["two", "one", "without holds", "one point", "nothing reached"])
def test_every_run_can_be_drawn(tmp_path: Path, case: str) -> None:
    pytest.importorskip("matplotlib")
    from ravengc.reports.figures import save_figure
    from ravengc.reports.track_figures import draw_track

    runs = {"resolved": small_run()}
    if case == "two":
        runs["naive"] = small_run(method="naive", error_m=1e-3)
    elif case == "without holds":
        runs = {"resolved": small_run(holds=0)}
    elif case == "one point":
        runs = {"resolved": small_run(1)}
    elif case == "nothing reached":
        for name in ("error_max_m", "start_s", "reached_s", "time_s"):
            getattr(runs["resolved"].visits, name)[:] = np.nan
        runs["resolved"].visits.outcome[:] = "unreachable"
    save_figure(draw_track(runs, "LIVER-500"), tmp_path / "track.svg")
    assert (tmp_path / "track.svg").stat().st_size > 5000


def test_frames_are_rows_in_order_no_faster_than_the_eye() -> None:
    run = small_run()
    rows = frame_rows(run)
    assert rows[0] == 0
    assert rows[-1] == len(run.trace.stamps) - 1
    assert (np.diff(rows) > 0).all()
    assert np.diff(run.trace.stamps[rows]).min() > 0.02
    assert len(frame_rows(run)) <= track_view.MOST_FRAMES


def test_links_turn_the_z_axis_into_their_direction() -> None:
    for direction in ((0, 0, 1.0), (0, 0, -1.0), (1.0, 0, 0), (0.6, 0.0, -0.8)):
        w, x, y, z = track_view._along(np.array(direction))
        assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
        turned = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        np.testing.assert_allclose(turned, direction, atol=1e-12)


def test_points_take_the_colour_of_their_outcome_when_their_visit_is_over() -> None:
    run = small_run()
    before, after = (track_view._colours(run, now) for now in (-1.0, 1e9))
    assert (before == track_view.WAITING).all()
    changed = (after != before).any(axis=1)
    assert changed.sum() == 18  # those that were not set out for keep theirs
    first = run.visits.point[0]
    assert (track_view._colours(run, 0.25)[first] != track_view.WAITING).any()


def test_without_viser_the_command_to_install_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'ravengc\[view\]'"):
        write_view(tmp_path / "view.html", small_run(), ROBOT)
    with pytest.raises(MissingExtraError):
        track_view.check_view(tmp_path / "view.html")
    with pytest.raises(ConfigError, match=r"ending in \.html"):
        track_view.check_view(tmp_path / "view.png")
    assert not list(tmp_path.iterdir())


def test_the_view_is_one_file(tmp_path: Path) -> None:
    """In a process of its own: viser and what it brings warn of things that are not ours."""
    pytest.importorskip("viser")
    program = (
        "from pathlib import Path; from track_scenes import ROBOT, small_run; "
        "from ravengc.reports.track_view import write_view; write_view(Path('view.html'), small_run(8), ROBOT)"
    )
    here = [str(path) for path in sys.path]
    done = subprocess.run(  # noqa: S603 -- our own
        [sys.executable, "-c", f"import sys; sys.path[:0] = {here!r}; {program}"],
        cwd=tmp_path, check=True, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.stdout == ""
    page = (tmp_path / "view.html").read_text(encoding="utf-8")
    assert "__VISER_EMBED_DATA__" in page
    assert not re.search(r"<(?:script|link)[^>]+(?:src|href)=\"https?:", page)
