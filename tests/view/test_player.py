"""The player in a real browser: pages as files, without a network, by keyboard, on phones, and pixels read back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from made_up_run import SCENE, recorded
from page_reader import PageReader

from games.rebuilt import REBUILT
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
    """What went wrong in scripts; that a picture is read back slowly is none."""
    page.evaluate("1")
    return [error for error in page.errors if "ReadPixels" not in error]


@pytest.mark.slow
def test_a_file_plays_without_a_request_by_keyboard_and_its_first_screen_has_all(browser, run) -> None:
    path, _ = run
    page = opened(browser, path, query="#t=2.5")
    assert page.evaluate("document.querySelector('output').textContent") == "2.50 s"
    assert page.evaluate("document.querySelector('h1').textContent") == "<b>my run</b>", "a text"
    said = []
    for key in ("End", "ArrowLeft", "Home", "ArrowRight"):
        page.evaluate(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))")
        said.append(page.evaluate("document.querySelector('output').textContent"))
    assert said == ["8.00 s", "7.90 s", "0.02 s", "0.12 s"]
    page.evaluate("document.querySelector('.timeline .hit').click()")
    first = page.evaluate("simcore.run.meta.events.find((event) => event[1] === 'hit')[0]")
    assert page.evaluate("simcore.now") == pytest.approx(first)
    low = page.evaluate("document.querySelector('.timeline').getBoundingClientRect().bottom")
    assert low < 768, "field, slider and events are on the first screen of a school's laptop"
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
def test_nothing_overflows_on_narrow_screens(browser, run, width) -> None:
    page = opened(browser, run[0], size=(width, 844))
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert complaints(page) == []


@pytest.mark.slow
def test_from_above_and_solid_agree_with_telemetry(browser, run) -> None:
    """By pixels: the blue bumpers' middle in both views, within a pixel's part of a centimeter, at twenty instants."""
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
      s.scene.background = new T.Color(0);
      window.look = (time) => {{
        p.now = time;
        s.draw(time);
        s.robots[0].parts.forEach((part) => {{ part.visible = false; }});
        s.stroke('trails', []); s.stroke('previews', []); s.belief.visible = false;
        s.renderer.render(s.scene, s.eye);
        const w = s.canvas.width, h = s.canvas.height, data = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, data);
        const [n, x, y] = {SEEN}(data, w, h, (r, g, b) => r > 200 && g < 60 && b > 200);
        const at = new T.Vector3(2 * x / w - 1, 2 * y / h - 1, 0.5).unproject(s.eye).sub(s.eye.position);
        const far = s.eye.position.z / -at.z, seen = s.eye.position.clone().addScaledVector(at, far);
        p.top.draw(time);
        const words = p.top.robots[0].getAttribute('transform').match(/-?[\\d.]+/g).map(Number);
        return [n, seen.x, seen.y, words[0] / 100, (p.top.height - words[1]) / 100, -words[2],
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
def test_ground_key_heat_map_and_boards_are_drawn_of_data(browser, tmp_path) -> None:
    """Names are texts; a tag lies across its normal; a place is marked while a piece is in it; the key counts."""
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
    assert "box <1>" in read(".top title") and read(".top box") == []
    assert ["hit (1)", "miss (1)"] == [words.strip() for words in read(".key span") if "(" in words]
    assert read(".places figcaption") == ["Placed for blue", "Placed"]
    page.evaluate("simcore.show(0.2); 1")
    assert read(".cell.full") == [] and read(".counts [data-cell]") == ["Top0", "Tray0", "Shelf0"]
    page.evaluate("simcore.show(0.9); 1")
    assert read(".cell.full") == ["Top B", "Tray3", "Shelf1"] and read(".counts [data-cell]") == [
        "Top1",
        "Tray3",
        "Shelf1",
    ]
    page.evaluate("document.querySelector('.key input').click()")
    cells = page.evaluate(
        "[...document.querySelectorAll('[data-layer=heat] g[visibility=visible] rect')].map((node) => node.textContent)"
    )
    assert sum(int(words.split()[0]) for words in cells) == len(recording.times), "a robot is once somewhere at a time"
    assert complaints(page) == []


@pytest.mark.slow
@pytest.mark.parametrize("view", ["solid", "top"])
def test_save_picture_is_a_png_of_what_is_seen_under_the_board(browser, run, view) -> None:
    page = opened(browser, run[0], size=(1200, 800), query="#t=6")
    page.evaluate(f"simcore.setView('{view}'); 1")
    page.evaluate(
        """HTMLAnchorElement.prototype.click = function () { window.file = this.download; };
        URL.createObjectURL = (blob) => {
          createImageBitmap(blob).then((image) => {
            const { width, height } = image, context = new OffscreenCanvas(width, height).getContext('2d');
            context.drawImage(image, 0, 0);
            const { data } = context.getImageData(0, 0, width, height), rows = { ink: [], fuel: [] };
            for (let k = 0; k < data.length; k += 4) {
              const y = Math.floor(k / 4 / width), [r, g, b] = data.subarray(k, k + 3);
              if (Math.max(r, g, b) < 60) rows.ink.push(y);
              if (r > 200 && g > 160 && b < 80) rows.fuel.push(y);
            }
            const title = rows.ink.filter((y) => y < 60).length;
            window.saved = [blob.type, width, height, title, rows.fuel.length, Math.min(...rows.fuel)];
          });
          return '';
        }; 1"""
    )
    page.click("Save picture")
    page.wait_for("window.saved")
    kind, width, height, title, fuel, first = page.evaluate("saved")
    assert (page.evaluate("file"), kind, width) == ("run_6.00s.png", "image/png", 1600)
    assert 500 < height < 1500 and title > 500, "the title in dark letters"
    assert fuel > 4000 and first > 120, "504 balls of it, all below the board"
    assert {url.partition(":")[0] for url in page.requests[1:]} <= {"data"} and complaints(page) == []
