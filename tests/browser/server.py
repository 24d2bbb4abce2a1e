"""The page of `gravical live` behind a server that plays scenes in place of the program."""

import json
import pathlib
import queue
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

PAGE = pathlib.Path(__file__).resolve().parents[2] / "crates/gravical-cli/src/cmd/live/page"
TOKEN = "0123456789abcdef"
TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
          "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")
REPORT = "<!doctype html><title>Report</title><h1>Calibration report</h1>"


class Session:
    """What has been said so far, and who listens."""

    def __init__(self):
        self.lock = threading.Lock()
        self.play([])

    def play(self, events):
        with self.lock:
            self.events = list(events)
            self.listeners = []
            self.commands = []
            self.refuse = None
            self.react = None
            self.down = False

    def hang_up(self, down):
        """Ends all streams, and refuses new ones while it is down."""
        with self.lock:
            self.down = down
            for listener in self.listeners:
                listener.put(None)
            self.listeners = []

    def say(self, event):
        with self.lock:
            self.events.append(event)
            for listener in self.listeners:
                listener.put(event)

    def listen(self):
        with self.lock:
            listener = queue.Queue()
            self.listeners.append(listener)
            return list(self.events), listener

    def take(self, command):
        self.commands.append(command)
        if self.react:
            self.react(command)


def serve(session):
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, *_):
            pass

        def answer(self, status, kind, body, policy=POLICY):
            data = body.encode()
            self.send_response(status)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(data)))
            self.send_header("Cache-Control", "no-store")
            if policy:
                self.send_header("Content-Security-Policy", policy)
            self.end_headers()
            self.wfile.write(data)

        def allowed(self):
            if parse_qs(urlsplit(self.path).query).get("token") == [TOKEN]:
                return True
            self.answer(403, "text/plain", "token")
            return False

        def do_GET(self):
            if not self.allowed():
                return
            name = urlsplit(self.path).path.lstrip("/") or "page.html"
            if name == "events":
                return self.stream()
            if name == "report":
                return self.answer(200, "text/html", REPORT, policy=None)
            file = PAGE / name
            if file.parent != PAGE or not file.is_file():
                return self.answer(404, "text/plain", name)
            text = file.read_text()
            self.answer(200, TYPES[file.suffix], text.replace("{token}", TOKEN) if file.suffix == ".html" else text)

        def stream(self):
            if session.down:
                return self.answer(503, "text/plain", "down")
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Cache-Control", "no-store")
            self.send_header("Connection", "close")
            self.end_headers()
            events, listener = session.listen()
            self.close_connection = True
            try:
                self.wfile.write(b": begin\n\n")
                for event in events:
                    self.wfile.write(f"data: {json.dumps(event)}\n\n".encode())
                self.wfile.flush()
                while True:
                    try:
                        event = listener.get(timeout=1)
                        if event is None:
                            return
                        self.wfile.write(f"data: {json.dumps(event)}\n\n".encode())
                    except queue.Empty:
                        self.wfile.write(b": there\n\n")
                    self.wfile.flush()
            except OSError:
                pass

        def do_POST(self):
            if not self.allowed():
                return
            command = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            session.take(command)
            if session.refuse:
                return self.answer(400, "application/json", json.dumps({"error": session.refuse}))
            self.send_response(204)
            self.end_headers()

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server, f"http://127.0.0.1:{server.server_port}/?token={TOKEN}"
