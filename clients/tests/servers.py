"""Servers for the clients' tests: the real program, and scripted servers for behaviour that the real one does not show on demand."""

from __future__ import annotations

import json
import os
import select
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.request
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

REPOSITORY = Path(__file__).resolve().parents[2]
STARTING_S = 20


def binary() -> str:
    """The scallopd program under test."""
    return os.environ.get("SCALLOPD_BINARY", str(REPOSITORY / "target/debug/scallopd"))


class Service:
    """The real program on a port of its own."""

    def __init__(self, *options: str, port: int = 0) -> None:
        self._log = tempfile.TemporaryFile()
        command = [binary(), "--listen", f"127.0.0.1:{port}", "--log-format", "json", *options]
        self._process = subprocess.Popen(command, stdout=self._log, stderr=subprocess.STDOUT)
        self.port = self._port()
        self.url = f"http://127.0.0.1:{self.port}"

    def _port(self) -> int:
        end = time.monotonic() + STARTING_S
        while time.monotonic() < end and self._process.poll() is None:
            for line in self._lines():
                if line.get("message") == "listening":
                    return int(line["address"].rsplit(":", 1)[1])
            time.sleep(0.02)
        self.kill()
        raise RuntimeError(f"the server did not start: {self._lines()}")

    def _lines(self) -> List[Dict[str, Any]]:
        # `pread` leaves the offset alone, which the child shares.
        text = os.pread(self._log.fileno(), 1 << 20, 0).decode()
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.startswith("{") and line.endswith("\n")]

    def offers(self, *names: str) -> bool:
        """Whether its OpenAPI document has all these names of paths or members."""
        with urllib.request.urlopen(f"{self.url}/openapi.json") as answer:
            document = answer.read().decode()
        return all(f'"{name}"' in document for name in names)

    def kill(self) -> None:
        """Ends the program at once, as a crash would."""
        self._process.kill()
        self._process.wait()
        self._log.close()


class ServiceCase(unittest.TestCase):
    """Tests against one running program."""

    service: Service

    @classmethod
    def setUpClass(cls) -> None:
        cls.service = Service()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.service.kill()


@dataclass
class Received:
    """A request that a `RecordingServer` received."""

    method: str
    path: str
    headers: Mapping[str, str]
    body: bytes

    def json(self) -> Any:
        return json.loads(self.body)


Reply = Tuple[int, Mapping[str, str], Any]


class RecordingServer:
    """Records requests and answers each with what `reply` makes of it: status, headers and a JSON document."""

    def __init__(self, reply: Callable[[Received], Reply]) -> None:
        self.received: List[Received] = []
        recording = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            # Headers and body leave as two pieces, which Nagle's algorithm would hold apart for 40 ms.
            disable_nagle_algorithm = True

            def do_POST(self) -> None:
                request = Received(self.command, self.path, {k.lower(): v for k, v in self.headers.items()}, self._body())
                recording.received.append(request)
                status, headers, document = reply(request)
                content = json.dumps(document).encode()
                self.send_response(status)
                kind = "application/json" if status < 400 else "application/problem+json"
                for name, value in {"content-type": kind, "content-length": str(len(content)), **headers}.items():
                    self.send_header(name, value)
                try:
                    self.end_headers()
                    self.wfile.write(content)
                except ConnectionError:
                    self.close_connection = True  # A client with a failed file has closed the connection.

            do_GET = do_POST

            def _body(self) -> bytes:
                if self.headers.get("transfer-encoding") != "chunked":
                    return self.rfile.read(int(self.headers.get("content-length", 0)))
                body = b""
                while size := int(self.rfile.readline(), 16):
                    body += self.rfile.read(size)
                    self.rfile.readline()
                self.rfile.readline()
                return body

            def log_message(self, format: str, *args: Any) -> None:
                pass

        class Server(ThreadingHTTPServer):
            daemon_threads = True

        self._server = Server(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}"
        threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True).start()

    def __enter__(self) -> RecordingServer:
        return self

    def __exit__(self, *_: Any) -> None:
        self._server.shutdown()
        self._server.server_close()


class SocketServer:
    """Hands each connection to `serve` with its number, counted from 0, in a thread."""

    def __init__(self, serve: Callable[[socket.socket, int], None]) -> None:
        self.connections = 0
        self._serve = serve
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._closing = threading.Event()
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while not self._closing.is_set():
            if not select.select([self._listener], [], [], 0.05)[0]:
                continue
            connection, _ = self._listener.accept()
            number, self.connections = self.connections, self.connections + 1
            threading.Thread(target=self._one, args=(connection, number), daemon=True).start()
        self._listener.close()

    def _one(self, connection: socket.socket, number: int) -> None:
        with connection:
            try:
                self._serve(connection, number)
            except OSError:
                pass  # The client closed first, which several tests are about.

    def sleep(self, seconds: float) -> None:
        """Waits, but not beyond the test."""
        self._closing.wait(seconds)

    def __enter__(self) -> SocketServer:
        return self

    def __exit__(self, *_: Any) -> None:
        self._closing.set()


def read_request(connection: socket.socket) -> Optional[bytes]:
    """The head and body of the next request; None at the connection's end."""
    data = b""
    while b"\r\n\r\n" not in data:
        piece = connection.recv(65536)
        if not piece:
            return None
        data += piece
    head, body = data.split(b"\r\n\r\n", 1)
    length = next((int(line.split(b":")[1]) for line in head.split(b"\r\n") if line.lower().startswith(b"content-length:")), 0)
    while len(body) < length:
        body += connection.recv(65536)
    return head + b"\r\n\r\n" + body


def response(document: Any, status: str = "200 OK", headers: str = "") -> bytes:
    """A complete answer."""
    content = json.dumps(document).encode()
    return f"HTTP/1.1 {status}\r\ncontent-type: application/json\r\ncontent-length: {len(content)}\r\n{headers}\r\n".encode() + content
