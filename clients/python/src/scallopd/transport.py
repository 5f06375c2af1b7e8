"""HTTP for the client: kept-alive connections, deadlines and repeated attempts. Every request of the service is a pure function of
its body, so that a request whose answer was lost can be sent again without harm."""

from __future__ import annotations

import http.client
import io
import json
import socket
import ssl
import time
from collections import deque
from email.utils import parsedate_to_datetime
from typing import Any, Deque, Dict, Iterator, Mapping, Optional, Protocol, Tuple
from urllib.parse import urlsplit

from .errors import ConnectionLost, InvalidAnswer, Timeout, problem_from

FIRST_PAUSE_S = 0.05
LONGEST_PAUSE_S = 1.0
REPEATED_STATUSES = (429, 502, 503)
"""The statuses of the service at its limit, and 502 of a proxy whose connection to a replica broke."""


class Body(Protocol):
    """A request's body, written in pieces."""

    content_type: str
    replayable: bool
    """Whether `chunks` can be called again."""

    def length(self) -> Optional[int]:
        """The number of bytes, where it is known before they are sent. Called once, before `chunks`."""

    def chunks(self) -> Iterator[bytes]:
        """The bytes, from the beginning."""


class JsonBody:
    """A JSON document."""

    content_type = "application/json"
    replayable = True

    def __init__(self, document: Any) -> None:
        self._bytes = json.dumps(document, default=_plain, separators=(",", ":")).encode()

    def length(self) -> Optional[int]:
        return len(self._bytes)

    def chunks(self) -> Iterator[bytes]:
        yield self._bytes


def _plain(value: Any) -> Any:
    """Converts values that `json` does not support: numpy arrays and scalars and `array.array` by `tolist`, other buffers,
    mappings, iterables."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    try:
        return memoryview(value).tolist()
    except TypeError:
        pass
    try:
        return list(value)
    except TypeError:
        raise TypeError(f"{type(value).__name__} has no JSON form") from None


class _BodyError(Exception):
    """Reading the body's source failed. Distinguishes its `OSError` from those of the connection."""

    def __init__(self, cause: OSError) -> None:
        super().__init__(str(cause))
        self.cause = cause


def _chunks_of(body: Body) -> Iterator[bytes]:
    chunks = body.chunks()
    while True:
        try:
            chunk = next(chunks, None)
        except OSError as error:
            raise _BodyError(error) from error
        if chunk is None:
            return
        yield chunk


class _DeadlineReader(io.RawIOBase):
    """Reads a socket until a moment, however many pieces arrive before it. The socket's own time-out restarts with each piece."""

    def __init__(self, sock: socket.socket) -> None:
        super().__init__()
        self._sock = sock
        self._file = sock.makefile("rb", buffering=0)
        self.until = time.monotonic()

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> Optional[int]:
        self._sock.settimeout(_seconds_to(self.until))
        return self._file.readinto(buffer)

    def close(self) -> None:
        self._file.close()
        super().close()


class _DeadlineSocket:
    """The part of a socket that `http.client.HTTPResponse` uses."""

    def __init__(self, sock: socket.socket, until: float) -> None:
        self._reader = _DeadlineReader(sock)
        self._reader.until = until

    def makefile(self, _mode: str) -> io.BufferedReader:
        return io.BufferedReader(self._reader)


def _seconds_to(moment: float) -> float:
    """The time left. Zero would make the socket non-blocking, so an expired deadline raises here."""
    left = moment - time.monotonic()
    if left <= 0:
        raise socket.timeout("timed out")
    return left


class Transport:
    """Sends requests to one server. Threads may share it: each call under way uses a connection of its own."""

    def __init__(
        self, base_url: str, timeout: float, retry_for: float, headers: Mapping[str, str], context: Optional[ssl.SSLContext]
    ) -> None:
        parts = urlsplit(base_url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"the base URL is http:// or https:// with a host, not {base_url!r}")
        self._base_url = base_url.rstrip("/")
        self._host = parts.hostname
        self._port = parts.port
        self._prefix = parts.path.rstrip("/")
        self._context = (context or ssl.create_default_context()) if parts.scheme == "https" else None
        self._timeout = timeout
        self._retry_for = retry_for
        self._headers = {"accept": "application/json", "user-agent": "scallopd-python", **headers}
        self._idle: Deque[http.client.HTTPConnection] = deque()

    def close(self) -> None:
        """Closes the idle connections."""
        while self._idle:
            self._idle.pop().close()

    def __del__(self) -> None:
        # Sockets that are only dropped raise ResourceWarning. An `__init__` that failed has left no idle connections.
        if hasattr(self, "_idle"):
            self.close()

    def call(self, method: str, path: str, body: Optional[Body] = None) -> Any:
        """The answer's JSON; a problem is raised.

        Repeats the request on 429, 502 and 503 and where the connection breaks, until the pauses before the attempts add up to `retry_for`.
        """
        length = None if body is None else body.length()
        repeatable = body is None or body.replayable
        left = self._retry_for
        pause = FIRST_PAUSE_S
        while True:
            # A body that can be sent only once must not meet a connection that the server may have closed meanwhile.
            idle = self._take_idle() if repeatable else None
            try:
                status, headers, content = self._exchange(idle or self._connection(), method, path, body, length)
            except _BodyError as error:
                raise error.cause from None
            except socket.timeout:
                raise Timeout(f"{method} {self._base_url}{path}: no answer within {self._timeout:g} s") from None
            except (OSError, http.client.HTTPException) as error:
                if idle is not None:
                    continue  # A stale connection is no failure: the next idle one, then a new one, is tried at once.
                wait = pause
                if not repeatable or wait > left:
                    raise ConnectionLost(f"{method} {self._base_url}{path}: {error or type(error).__name__}") from error
            else:
                retry_after = _retry_after_s(headers.get("retry-after"))
                if status < 400:
                    return _json_of(content, path)
                wait = pause if retry_after is None else retry_after
                if status not in REPEATED_STATUSES or not repeatable or wait > left:
                    raise self._problem(status, headers, content, path, retry_after)
            time.sleep(wait)
            left -= wait
            pause = min(2 * pause, LONGEST_PAUSE_S)

    def _take_idle(self) -> Optional[http.client.HTTPConnection]:
        try:
            return self._idle.pop()
        except IndexError:
            return None

    def _connection(self) -> http.client.HTTPConnection:
        if self._context is not None:
            return http.client.HTTPSConnection(self._host, self._port, timeout=self._timeout, context=self._context)
        return http.client.HTTPConnection(self._host, self._port, timeout=self._timeout)

    def _exchange(
        self, connection: http.client.HTTPConnection, method: str, path: str, body: Optional[Body], length: Optional[int]
    ) -> Tuple[int, Mapping[str, str], bytes]:
        """One request and its answer. The connection is kept for the next call where that is possible, otherwise closed."""
        keep = False
        try:
            try:
                until = self._send(connection, method, path, body, length)
            except (BrokenPipeError, ConnectionResetError):
                # A server that refuses a body answers before it has read all of it, then closes.
                if connection.sock is None or body is None:
                    raise
                until = time.monotonic() + self._timeout

            def response_to(sock: Any, *args: Any, **options: Any) -> http.client.HTTPResponse:
                watched: Any = _DeadlineSocket(sock, until)
                return http.client.HTTPResponse(watched, *args, **options)

            connection.response_class = response_to  # type: ignore[assignment]
            with connection.getresponse() as response:
                content = response.read()
                keep = not response.will_close
                headers = {name.lower(): value for name, value in response.getheaders()}
                return response.status, headers, content
        finally:
            if keep:
                self._idle.append(connection)
            else:
                connection.close()

    def _send(self, connection: http.client.HTTPConnection, method: str, path: str, body: Optional[Body], length: Optional[int]) -> float:
        """Sends the request and returns the moment by which the answer must be complete: for a body of many chunks the time-out
        starts anew with each, since a large upload may take longer than any calculation."""
        until = time.monotonic() + self._timeout
        if connection.sock is None:
            connection.connect()
        connection.sock.settimeout(_seconds_to(until))
        connection.putrequest(method, self._prefix + path, skip_accept_encoding=True)
        for name, value in self._headers.items():
            connection.putheader(name, value)
        if body is None:
            connection.endheaders()
            return until
        connection.putheader("content-type", body.content_type)
        if length is None:
            connection.putheader("transfer-encoding", "chunked")
        else:
            connection.putheader("content-length", str(length))
        connection.endheaders()
        for index, chunk in enumerate(_chunks_of(body)):
            if index > 0:
                until = time.monotonic() + self._timeout
            connection.sock.settimeout(_seconds_to(until))
            connection.send(chunk if length is not None else b"%x\r\n%b\r\n" % (len(chunk), chunk))
        if length is None:
            connection.send(b"0\r\n\r\n")
        return until

    def _problem(self, status: int, headers: Mapping[str, str], content: bytes, path: str, retry_after: Optional[float]) -> Exception:
        if headers.get("content-type", "").startswith("application/problem+json"):
            return problem_from(_json_of(content, path), retry_after)
        text = content[:200].decode("utf-8", "replace")
        return InvalidAnswer(f"{self._base_url}{path}: status {status}, not the service's answer: {text!r}")


def _retry_after_s(value: Optional[str]) -> Optional[float]:
    """Seconds of a `Retry-After`, which holds a number or a date (RFC 9110, section 10.2.3); None where it holds neither."""
    if value is None:
        return None
    if value.strip().isdigit():
        return float(value)
    try:
        return max(0.0, parsedate_to_datetime(value).timestamp() - time.time())
    except (TypeError, ValueError):
        return None


def _json_of(content: bytes, path: str) -> Dict[str, Any]:
    try:
        document = json.loads(content)
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise InvalidAnswer(f"{path}: the answer is no JSON object: {content[:200]!r}")
    return document
