"""The player in a real browser: pages as files, without a network, by keyboard, on phones, and pixels read back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from made_up_run import SCENE, recorded
from page_reader import PageReader

from games.rebuilt import REBUILT
from simcore import Match
from simcore.match.runner import play_auto
from simcore.show.page import write_page
from simcore.show.scene import LevelLook, scene_of
from simcore.telemetry.recording import Recording

READY = "window.simcore && simcore.run && simcore.run.groups.robots.n > 0"
# Middle and heading of what has one color in a view from above, by its pixels
SEEN = """((data, width, height, wanted) => {
  let n = 0, x = 0, y = 0;
  for (let k = 0; k < width * height; k++) {
    const [r, g, b] = [data[4 * k], data[4 * k + 1], data[4 * k + 2]];
    if (wanted(r, g, b)) { n++; x += k % width; y += Math.floor(k / width); }
  }
  return [n, x / n + 0.5, y / n + 0.5];
})"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    recording = Recording()
    played = play_auto(REBUILT, "depot", seconds=8.0, sinks=[recording])
    played.match.close()
    path = tmp_path_factory.mktemp("page") / "run.html"
    write_page(path, recording, scene_of(played.match), title="<b>my run</b>")
    return path, recording


def opened(browser, path, *, size=(1366, 768), query=""):
    page = browser("about:blank")
    page.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
    page.call("Page.navigate", url=path.as_uri() + query)
    page.wait_for(READY)
    return page


def complaints(page) -> list[str]:
    """Return the errors of scripts, without the warning that reading pixels back is slow."""
    page.evaluate("1")
    return [error for error in page.errors if "ReadPixels" not in error]


@pytest.mark.slow
def test_the_page_seeks_by_keyboard_and_click_makes_no_requests_and_fits_one_screen(browser, run) -> None:
    path, _ = run
    page = opened(browser, path, query="#t=2.5")
    assert path.stat().st_size < 330_000
    assert page.evaluate("document.querySelector('output').textContent") == "2.50 s"
    assert page.evaluate("document.querySelector('h1').textContent") == "<b>my run</b>", "a text"
    said = []
    for key in ("End", "ArrowLeft", "Home", "ArrowRight"):
        page.evaluate(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))")
        said.append(page.evaluate("document.querySelector('output').textContent"))
    assert said == ["8.00 s", "7.90 s", "0.02 s", "0.12 s"]
    first, x, y = page.evaluate(
        "(() => { const time = simcore.run.meta.events.find((event) => event[1] === 'hit')[0];"
        " const box = simcore.line.canvas.getBoundingClientRect();"
        " return [time, box.left + simcore.line.x(time), box.top + 28]; })()"
    )
    for off, wanted in ((2.0, first), (-60.0, None)):
        for kind in ("mousePressed", "mouseReleased"):
            page.call("Input.dispatchMouseEvent", type=kind, x=x + off, y=y, button="left", clickCount=1)
        now = page.evaluate("simcore.now")
        if wanted is None:  # away from marks: the time at that place, on the same scale as the marks
            seconds = page.evaluate("(simcore.run.end - simcore.run.start) / (simcore.line.width - 2)")
            assert now == pytest.approx(first + off * seconds, abs=1.5 * seconds + 0.01)
        else:
            assert now == pytest.approx(wanted), "a click near a mark goes to its moment"
    low = page.evaluate("document.querySelector('.bar').getBoundingClientRect().bottom")
    assert low <= 768, "field and time line are on the first screen of a school's laptop"
    page.evaluate("simcore.jump(3.0); simcore.play()")
    page.wait_for("simcore.now > 4.0")
    page.evaluate("simcore.stop()")
    assert page.requests == [path.as_uri()] and complaints(page) == []
    spent = page.evaluate(
        "(() => { const begun = performance.now(); for (let k = 0; k < 20; k++) simcore.show(k / 3);"
        " return (performance.now() - begun) / 20; })()"
    )
    assert spent < 300.0, f"a seek takes {spent:.0f} ms of a busy computer"


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 900])
def test_a_page_does_not_overflow_on_narrow_screens(browser, run, width) -> None:
    page = opened(browser, run[0], size=(width, 844))
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert complaints(page) == []


@pytest.mark.slow
def test_the_top_view_and_the_3d_view_agree_with_telemetry(browser, run) -> None:
    """The middle of the blue bumpers, found by its pixels, agrees to a centimeter in both views at twenty instants."""
    path, recording = run
    page = opened(browser, path, size=(1400, 800))
    times, poses = recording.poses("Sim/Robot/Pose3d")
    page.evaluate("simcore.setView('solid'); simcore.setCamera('above'); 1")
    draw = f"""(() => {{
      const p = simcore, s = p.solid, gl = s.renderer.getContext(), T = THREE;
      s.eye.fov = 3; s.eye.far = 2000; s.eye.updateProjectionMatrix();  // hardly any perspective
      s.scene.traverse((node) => {{ if (node.isMesh || node.isLineSegments) node.visible = false; }});
      const paint = new T.MeshBasicMaterial({{ color: 0xff00ff }}), group = s.robots[0].group;
      group.traverse((node) => {{ node.visible = true; }});
      s.robots[0].parts.forEach((part) => {{ part.traverse((node) => {{ node.visible = false; }}); }});
      group.children.forEach((node) => {{ if (node.isMesh) node.material = paint; }});
      s.scene.background = null; s.scene.fog = null;
      const t = p.top, fill = t.paint;
      t.resize(900, 900, 1);
      p.run.meta.robots[0].own_ink = '#ff00ff';
      t.floor.width = 1;  // no ground
      const plan = (time, isDrawn) => {{  // of the robot's rectangle, or of its arrow
        t.paint = (look, trace) => {{ if (look.fill === '#ff00ff' && isDrawn(look)) fill.call(t, look, trace); }};
        const {{ place }} = p.run.robot(0, time);
        t.scale = 600;  // pixels a meter, around the robot
        t.at = [450 - t.scale * place[0], 450 + t.scale * place[1]];
        t.draw(time);
        const {{ width, height }} = t.canvas, data = t.pen.getImageData(0, 0, width, height).data;
        const [, x, y] = {SEEN}(data, width, height, (r, g, b) => r > 200 && g < 60 && b > 200);
        return [(x - t.at[0]) / t.scale, (t.at[1] - y) / t.scale];
      }};
      window.look = (time) => {{
        p.now = time;
        s.draw(time);
        s.robots[0].parts.forEach((part) => {{ part.visible = false; }});
        for (const name of Object.keys(s.strokes)) s.stroke(name, []);
        s.renderer.render(s.scene, s.eye);
        const w = s.canvas.width, h = s.canvas.height, data = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, data);
        const [n, x, y] = {SEEN}(data, w, h, (r, g, b) => r > 200 && g < 60 && b > 200);
        const at = new T.Vector3(2 * x / w - 1, 2 * y / h - 1, 0.5).unproject(s.eye).sub(s.eye.position);
        const far = s.eye.position.z / -at.z, seen = s.eye.position.clone().addScaledVector(at, far);
        const center = plan(time, (look) => look.wide === 0.03), tip = plan(time, (look) => look.wide === 0.01);
        return [n, seen.x, seen.y, ...center, Math.atan2(tip[1] - center[1], tip[0] - center[0]) * 180 / Math.PI,
          ...p.run.robot(0, time).place, ...p.run.robot(0, time).quat];
      }};
    }})()"""
    page.evaluate(draw)
    moved = []
    for time in np.linspace(0.3, 7.9, 20):
        row = min(int(np.searchsorted(times, time)), len(times) - 1)
        pose = poses[row]
        n, x, y, top_x, top_y, degrees, *solid = page.evaluate(f"look({times[row]})")
        assert n > 100, "the robot is seen"
        assert (top_x, top_y) == pytest.approx(pose[:2], abs=0.01)
        yaw = 2.0 * math.atan2(pose[6], pose[3])
        assert (degrees - math.degrees(yaw) + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1.0)
        assert solid[:3] == pytest.approx(pose[:3], abs=0.001)
        assert np.abs(np.dot(solid[3:], pose[[4, 5, 6, 3]])) == pytest.approx(1.0, abs=1e-6)
        cos, sin = math.cos(yaw), math.sin(yaw)
        moved.append((cos * (x - pose[0]) + sin * (y - pose[1]), cos * (y - pose[1]) - sin * (x - pose[0])))
    assert np.std(moved, axis=0).max() < 0.01, "the same spot of the robot at all instants, to the centimeter"


@pytest.mark.slow
@pytest.mark.parametrize("camera", ["follow", "behind"])
def test_a_following_camera_stays_between_the_walls_and_shows_the_robot(browser, run, camera) -> None:
    page = opened(browser, run[0])
    page.evaluate(f"simcore.setView('solid'); simcore.setCamera('{camera}'); 1")
    length, width = REBUILT.field.size
    for time in np.linspace(0.1, 7.9, 20):
        x, y, z, u, v = page.evaluate(
            f"(() => {{ simcore.show({time}); const s = simcore.solid, at = s.robots[0].group.position.clone();"
            " at.project(s.eye); return [...s.eye.position, at.x, at.y]; })()"
        )
        assert 0.2 < x < length - 0.2 and 0.2 < y < width - 0.2 and 0.5 < z < 6.0
        assert abs(u) < 0.5 and abs(v) < 0.75, "the robot is in the middle of the picture"
    assert page.evaluate("simcore.solid.cut.uCut.value") == 1, "what stands between is seen through"


@pytest.mark.slow
def test_points_rise_where_they_are_scored_and_only_while_the_page_plays(browser, run) -> None:
    path, recording = run
    page = opened(browser, path)
    times, points = recording.series("Sim/Score/Blue")
    row = int(np.nonzero(np.diff(points) > 0)[0][0]) + 1
    first, rise = float(times[row]), int(points[row] - points[row - 1])
    page.evaluate(
        "window.risen = []; simcore.solid.score = (text, side, place) => risen.push([text, side, ...place]); 1"
    )
    page.evaluate(f"simcore.show({first - 0.3}); simcore.show({first + 5.0}); 1")
    assert page.evaluate("risen") == [], "who jumps sees no points"
    page.evaluate(f"for (let t = {first - 0.5}; t < {first + 0.6}; t += 0.02) simcore.show(t); 1")
    text, side, x, y, _ = page.evaluate("risen")[0]
    assert (text, side) == (f"+{rise}", "blue")
    hub = next(goal.center for goal in scene_goals() if goal.alliance == "blue")
    assert math.hypot(x - hub[0], y - hub[1]) < 1.0, "in the hub"


def scene_goals():
    with Match(REBUILT) as match:
        return scene_of(match).goals


@pytest.mark.slow
def test_the_score_board_shows_the_values_in_the_log(browser, run) -> None:
    """The test reads both scores, the clock and the period at twenty times, as a reader sees them over the picture."""
    path, recording = run
    page = opened(browser, path)
    for time in np.linspace(0.1, 7.9, 20):
        row = int(np.searchsorted(recording.times, time, side="right")) - 1
        one = next(snapshot for k, snapshot in enumerate(recording.snapshots()) if k == row)
        left = math.ceil(one.doubles["Sim/Match/TimeLeft"] - 1e-6)
        page.evaluate(f"simcore.show({recording.times[row]}); 1")
        seen = page.evaluate("[...document.querySelectorAll('.score :is(i, b, span)')].map((node) => node.textContent)")
        blue, red = (str(one.integers[f"Sim/Score/{side}"]) for side in ("Blue", "Red"))
        assert seen == [blue, f"{left // 60}:{left % 60:02d}", one.strings["Sim/Match/Period"], red]


def test_the_page_and_its_reader_agree_on_every_piece(browser, run) -> None:
    path, _ = run
    page, reader = opened(browser, path), PageReader(path)
    for time in reader.group("pieces")[0][::40]:
        seen = page.evaluate(
            f"(() => {{ const found = []; simcore.run.eachPiece({time + 1e-7}, (row, x, y, z, state) =>"
            " found.push([x, y, z, state])); return found; })()"
        )
        assert np.array(seen) == pytest.approx(reader.pieces(time), abs=2e-3)


@pytest.mark.slow
def test_the_field_the_legend_the_heat_map_and_the_boards_show_the_recorded_data(browser, tmp_path) -> None:
    """Names are shown as texts, places with a piece are marked, and the key counts shots."""
    levels = [
        LevelLook(name="BlueTop", alliance="blue", label="Top", places=("A", "B"), is_single=True, middle=(2.0, 1.5)),
        LevelLook(name="BlueTray", alliance="blue", label="Tray", places=("",), middle=(2.0, 1.5)),
        LevelLook(name="Shelf", label="Shelf", places=("",), middle=(5.5, 1.5)),
    ]
    recording, counts = Recording(), {"BlueTop": (0, 1), "BlueTray": (3,), "Shelf": (1,)}
    for tick, one in enumerate(recorded().snapshots()):
        now = {f"Sim/Places/{name}": np.array(row) * (tick > 25) for name, row in counts.items()}
        recording.write(replace(one, integer_arrays={**one.integer_arrays, **now}))
    path = tmp_path / "places.html"
    write_page(path, recording, replace(SCENE, levels=levels))
    page = opened(browser, path)
    texts = "(selector) => [...document.querySelectorAll(selector)].map((node) => node.textContent)"
    read = lambda selector: page.evaluate(f"({texts})({selector!r})")  # noqa: E731
    hovered = page.evaluate(
        "(() => { const { canvas, at, scale } = simcore.top, box = canvas.getBoundingClientRect();"
        " const k = box.width / canvas.width;"
        " const x = box.left + k * (at[0] + 0.2 * scale), y = box.top + k * (at[1] - 0.2 * scale);"
        " const event = { clientX: x, clientY: y };"
        " canvas.dispatchEvent(new PointerEvent('pointermove', event)); return canvas.title; })()"
    )
    assert hovered == "box <1>"
    assert ["hit (1)", "miss (1)"] == [words.strip() for words in read(".key span") if "(" in words]
    assert read(".places figcaption") == ["Placed for blue", "Placed"]
    page.evaluate(
        "simcore.setView('top'); { const { top } = simcore, { words } = top; window.written = [];"
        " top.words = (...all) => { written.push(all[3]); words.apply(top, all); }; } 1"
    )
    page.evaluate("simcore.show(0.2); 1")
    assert read(".cell.full") == [] and page.evaluate("written") == ["Top", "0", "Tray", "0", "Shelf", "0"]
    page.evaluate("written.length = 0; simcore.show(0.9); 1")
    assert read(".cell.full") == ["Top B", "Tray3", "Shelf1"]
    assert page.evaluate("written") == ["Top", "1", "Tray", "3", "Shelf", "1"]
    page.evaluate("document.querySelector('.key input').click()")
    counts = page.evaluate("simcore.top.heat.map((cell) => cell[2])")
    assert sum(counts) == len(recording.times), "a robot is once somewhere at a time"
    assert complaints(page) == []


@pytest.mark.slow
@pytest.mark.parametrize("view", ["solid", "top"])
def test_save_picture_saves_a_png_of_the_view_with_the_board(browser, run, view) -> None:
    page = opened(browser, run[0], size=(1200, 800), query="#t=6")
    page.evaluate(f"simcore.setView('{view}'); 1")
    page.evaluate(
        """HTMLAnchorElement.prototype.click = function () { window.file = this.download; };
        URL.createObjectURL = (blob) => {
          createImageBitmap(blob).then((image) => {
            const { width, height } = image, context = new OffscreenCanvas(width, height).getContext('2d');
            context.drawImage(image, 0, 0);
            const { data } = context.getImageData(0, 0, width, height), rows = { white: [], fuel: [] };
            for (let k = 0; k < data.length; k += 4) {
              const y = Math.floor(k / 4 / width), [r, g, b] = data.subarray(k, k + 3);
              if (Math.min(r, g, b) > 220) rows.white.push(y);
              if (r > 180 && g > 140 && b < 90) rows.fuel.push(y);
            }
            const count = (low, high) => rows.white.filter((y) => y >= low && y < high).length;
            window.saved = [blob.type, width, height, count(690, 720), count(20, 60), rows.fuel.length];
          });
          return '';
        }; 1"""
    )
    page.click("Save picture")
    page.wait_for("window.saved")
    kind, width, height, title, board, fuel = page.evaluate("saved")
    assert (page.evaluate("file"), kind, width, height) == ("run_6.00s.png", "image/png", 1280, 720)
    assert title > 300 and board > 150 and fuel > 4000, "title, score board, and 504 balls"
    assert page.evaluate("simcore.solid.canvas.width === simcore.solid.home.clientWidth"), "as large as before"
    assert {url.partition(":")[0] for url in page.requests[1:]} <= {"data"} and complaints(page) == []
