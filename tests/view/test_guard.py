"""The view answers its own page and nobody else: foreign hosts and sites, crowds, slow readers."""

from __future__ import annotations

import contextlib
import http.client
import http.server
import json
import socket
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from simcore.show.view_guard import MOST_VIEWERS, ViewGuard
from simcore.show.view_page import ViewPage

from simcore.errors import OutputError
from simcore.show.view_models import ViewModels
from simcore.telemetry.snapshot import Snapshot

viser = pytest.importorskip("viser", reason="the extra 'view' is not installed")
connect = pytest.importorskip("websockets.sync.client").connect
InvalidStatus = pytest.importorskip("websockets.exceptions").InvalidStatus

LINK = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
PROTOCOL = f"viser-v{viser.__version__}"


def refused(guard: ViewGuard, port: int = 8080, **headers: str) -> str:
    """The sentence with which a request is refused, empty if it is answered."""
    given = {name.replace("_", "-").lower(): value for name, value in headers.items()}
    ask = SimpleNamespace(get_all=lambda key: [given[key.lower()]] if key.lower() in given else [])
    answer = guard.refusal(ask, port)
    return "" if answer is None else answer[1]


@pytest.mark.parametrize(
    ("host", "other_site", "answered"),
    [
        ("127.0.0.1:8080", {}, True),
        ("localhost:8080", {"Origin": "http://localhost:8080"}, True),
        ("LocalHost:8080", {"Origin": "http://localhost:8080"}, True),
        ("[::1]:8080", {}, True),
        ("127.0.0.1:8080", {**LINK, "Sec_Fetch_Site": "cross-site"}, True),
        ("127.0.0.1:8080", {**LINK, "Sec_Fetch_Site": "same-site", "Sec_Fetch_Dest": "iframe"}, False),
        ("127.0.0.1:8080", {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"}, False),
        ("127.0.0.1:8080", {"Origin": "http://localhost:8080"}, False),
        ("127.0.0.1:8080", {"Origin": "https://127.0.0.1:8080"}, False),
        ("127.0.0.1:8080", {"Origin": "http://127.0.0.1:8081"}, False),
        ("127.0.0.1:8080", {"Origin": "http://127.0.0.1:8080.evil.example"}, False),
        ("127.0.0.1:8080", {"Origin": "null"}, False),
        ("127.0.0.1:8081", {}, False),
        ("127.0.0.1", {}, False),
        ("evil.example:8080", {"Origin": "http://evil.example:8080"}, False),  # DNS rebinding
        ("192.168.0.7:8080", {}, False),
        ("localhost.evil.example:8080", {}, False),
        ("", {}, False),
    ],
)  # fmt: skip
def test_only_its_own_host_and_origin_are_answered(host, other_site, answered) -> None:
    assert (refused(ViewGuard("127.0.0.1"), Host=host, **other_site) == "") == answered


def test_a_view_for_other_computers_answers_numeric_addresses_and_its_own_names() -> None:
    guard = ViewGuard("0.0.0.0")
    own = socket.gethostname()
    for host in ("192.168.0.7:8080", "[fe80::1]:8080", f"{own}:8080", f"{own}.local:8080", "127.0.0.1:8080"):
        assert refused(guard, Host=host, Origin=f"http://{host}") == ""
    assert "Host evil.example:8080" in refused(guard, Host="evil.example:8080", Origin="http://evil.example:8080")
    assert "Origin http://evil.example" in refused(guard, Host="192.168.0.7:8080", Origin="http://evil.example")


def test_a_viser_that_cannot_be_guarded_is_not_served(monkeypatch) -> None:
    """As a new version might be, that starts its server in another way."""
    monkeypatch.setattr(ViewGuard, "guarding", lambda self: contextlib.nullcontext())
    with pytest.raises(OutputError, match=r"cannot be kept from answering websites.* pip install 'viser=="):
        ViewPage(ViewModels())


class _Rate(threading.Thread):
    """Ticks of an endless run a second; each builds and shows a snapshot with 400 pieces that moved."""

    def __init__(self, page: ViewPage) -> None:
        super().__init__(daemon=True)
        self._page, self.ticks, self._ends = page, 0, False
        self.worst = 0.0

    def run(self) -> None:
        rows = np.zeros((400, 7))
        rows[:, 3], step = 1.0, np.array((0.001, 0, 0, 0, 0, 0, 0))
        while not self._ends:
            start = time.perf_counter()
            rows = rows + step
            arrays = {"Sim/GamePieces/Ball": rows}
            self._page.show(Snapshot(time=0.02 * self.ticks, tick=self.ticks, pose_arrays=arrays))
            self.ticks += 1
            self.worst = max(self.worst, time.perf_counter() - start)
            time.sleep(0.02)

    def measure(self, seconds: float) -> float:
        before, self.worst = self.ticks, 0.0
        time.sleep(seconds)
        return (self.ticks - before) / seconds

    def end(self) -> None:
        self._ends = True
        self.join()


def test_a_crowd_a_slow_reader_and_rubbish_do_not_stop_a_run() -> None:
    """200 connections: so many as may look are served, the others told why not; one reads nothing at all."""
    with ViewPage(ViewModels()) as page:
        port = int(page.url.rpartition(":")[2])
        rate = _Rate(page)
        rate.start()
        alone = rate.measure(1.0)
        socket_url, options = f"ws://127.0.0.1:{port}", {"subprotocols": [PROTOCOL], "max_size": None}
        slow = connect(socket_url, origin=page.url, max_queue=1, **options)  # never reads: its buffers fill up
        viewers, answers = [slow], []
        for _ in range(199):
            try:
                viewers.append(connect(socket_url, origin=page.url, max_queue=1, **options))
            except InvalidStatus as error:
                answers.append((error.response.status_code, error.response.body.decode()))
        rubbish = [socket.create_connection(("127.0.0.1", port)) for _ in range(20)]
        for number, one in enumerate(rubbish):
            one.sendall(bytes([number]) * 5000 if number % 2 else b"GET / HTTP/1.1\r\n")
        crowded = rate.measure(2.0)
        assert len(viewers) == MOST_VIEWERS and len(answers) == 200 - MOST_VIEWERS
        assert set(answers) == {(503, f"{MOST_VIEWERS} pages look at this view, no more can; close one\n")}
        assert crowded > 0.25 * alone and rate.worst < 1.0, (alone, crowded, rate.worst)
        buffer = page.server._websock_server._broadcast_buffer
        assert len(buffer.message_from_id) < 500, "what was not read is not kept: the newest of each thing is"
        for one in (*(viewer.socket for viewer in viewers[1:]), *rubbish):
            one.close()
        end = time.monotonic() + 10.0
        while True:  # places are free again
            try:
                connect(socket_url, origin=page.url, **options).close()
                break
            except InvalidStatus:
                assert time.monotonic() < end
                time.sleep(0.1)
        rate.end()
        slow.socket.close()


def test_a_raw_client_that_forges_its_host_is_refused() -> None:
    with ViewPage(ViewModels()) as page:
        port = int(page.url.rpartition(":")[2])
        for host, origin, status in (
            ("evil.example", None, 403),
            (f"evil.example:{port}", f"http://evil.example:{port}", 403),
            (f"127.0.0.1:{port}", "http://evil.example", 403),
            (f"127.0.0.1:{port}", page.url, 200),
        ):
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
            connection.request("GET", "/", headers={"Host": host, **({"Origin": origin} if origin else {})})
            answer = connection.getresponse()
            assert answer.status == status and (status == 200) == (b"<html" in answer.read(300))
            assert answer.getheader("X-Frame-Options") == "DENY"
            connection.close()
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
            with pytest.raises(InvalidStatus) as caught:
                connect(
                    f"ws://127.0.0.1:{port}", subprotocols=[PROTOCOL], additional_headers=headers,
                    user_agent_header=None,
                )  # fmt: skip
            assert caught.value.response.status_code == 403


_FOREIGN = """<!doctype html><title>elsewhere</title><body>waiting<script>
const port = %d, found = {};
const socket = (name, host) => new Promise(done => {
  const s = new WebSocket(`ws://${host}:${port}/`, ["%s"]);
  s.onmessage = () => { found[name] = "READ"; done(); };
  s.onopen = () => { s.send(new Uint8Array([0])); found[name] = "open"; setTimeout(done, 1000); };
  s.onerror = () => { found[name] = "refused"; done(); };
});
const get = (name, mode) => fetch(`http://127.0.0.1:${port}/`, {mode})
  .then(r => r.text()).then(t => { found[name] = t.length ? "READ" : "nothing"; }, () => { found[name] = "refused"; });
const frame = document.createElement("iframe");
frame.src = `http://127.0.0.1:${port}/`;
document.body.append(frame);
const asked = [["socket", "127.0.0.1"], ["rebound", "rebound.test"]].map(a => socket(...a));
Promise.all([...asked, get("cors", "cors"), get("opaque", "no-cors")])
  .then(() => { try { found.frame = frame.contentDocument ? "READ" : "closed"; } catch { found.frame = "closed"; }
                document.title = JSON.stringify(found); });
</script>"""


@pytest.mark.slow
def test_a_foreign_page_can_neither_read_nor_command_the_view(browser) -> None:
    """A page of another port in a real browser, by sockets, requests and a frame; also under DNS rebinding."""
    with ViewPage(ViewModels()) as page:
        port = int(page.url.rpartition(":")[2])
        text = (_FOREIGN % (port, PROTOCOL)).encode()

        class Elsewhere(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(text)

            def log_message(self, *_: object) -> None:
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as site:
            threading.Thread(target=site.serve_forever, daemon=True).start()
            url = f"http://127.0.0.1:{site.server_address[1]}/"
            visitor = browser(url)
            end = time.monotonic() + 30.0
            while not (title := visitor.evaluate("document.title")).startswith("{"):
                assert time.monotonic() < end, title
                time.sleep(0.1)
            visitor.call("Page.navigate", url=f"http://rebound.test:{port}/")
            visitor.wait_for_text("this is not the address of the view: Host rebound.test")
            site.shutdown()
    found = json.loads(title)
    assert found.pop("frame") == "closed"
    assert found == {"socket": "refused", "rebound": "refused", "cors": "refused", "opaque": "refused"}
    assert not page.has_viewers
