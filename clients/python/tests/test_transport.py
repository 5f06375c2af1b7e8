"""Connections: restarts, overload, time-outs and refused bodies."""

from __future__ import annotations

import io
import json
import math
import os
import socket
import tempfile
import threading
import time
import unittest
from email.parser import BytesParser
from email.utils import formatdate
from typing import Any, Callable, List

import scallopd
from servers import Received, RecordingServer, Reply, Service, SocketServer, read_request, response

BALL: scallopd.Cutter = {"type": "ball_end", "diameter_mm": 10}
CANDIDATE: scallopd.Candidate = {"type": "ball_end", "diameter_mm": 10}
SLOPE: scallopd.Contact = {"slope_deg": 40, "feed_angle_deg": 30}
HEIGHT_MM = 5 - math.sqrt(25 - 0.09)


def ask(client: scallopd.Client) -> float:
    return client.scallop_height(BALL, SLOPE, step_over_mm=0.6)["scallop_height_mm"]


def overloaded(status: int = 503) -> Any:
    return {"type": "overloaded", "title": "The server is busy", "status": status, "detail": "try again", "instance": "/", "errors": []}


class Restarts(unittest.TestCase):
    """The real program is killed under a running client."""

    def test_a_kill_and_restart_loses_no_call(self) -> None:
        service = Service()
        client = scallopd.Client(service.url, retry_for=20)
        answers: List[float] = []
        failures: List[BaseException] = []
        done = threading.Event()

        def work() -> None:
            try:
                while not done.is_set():
                    answers.append(ask(client))
            except BaseException as error:
                failures.append(error)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        try:
            for _ in range(3):
                answered = len(answers)
                time.sleep(0.15)
                service.kill()
                time.sleep(0.2)
                service = Service(port=service.port)
                end = time.monotonic() + 20
                while len(answers) < answered + 100 and time.monotonic() < end and not failures:
                    time.sleep(0.01)
                self.assertGreaterEqual(len(answers), answered + 100)
        finally:
            done.set()
            for thread in threads:
                thread.join()
            service.kill()
            client.close()
        self.assertEqual(failures, [])
        for answer in answers:
            self.assertAlmostEqual(answer, HEIGHT_MM, places=12)

    def test_a_server_that_stays_away_is_reported_after_the_stated_time(self) -> None:
        service = Service()
        client = scallopd.Client(service.url, retry_for=0.5)
        ask(client)
        service.kill()
        started = time.monotonic()
        with self.assertRaisesRegex(scallopd.ConnectionLost, "/v1/scallop-height.*refused"):
            ask(client)
        self.assertLess(time.monotonic() - started, 5)

    def test_a_connection_that_the_server_closed_while_idle_is_replaced_without_repeats_being_allowed(self) -> None:
        service = Service("--client-timeout-s", "1")
        self.addCleanup(service.kill)
        client = scallopd.Client(service.url, retry_for=0)
        ask(client)
        time.sleep(1.5)
        self.assertAlmostEqual(ask(client), HEIGHT_MM, places=12)

    def test_one_connection_serves_many_calls(self) -> None:
        def serve(connection: socket.socket, _: int) -> None:
            while read_request(connection) is not None:
                connection.sendall(response({"scallop_height_mm": 1}))

        with SocketServer(serve) as server, scallopd.Client(server.url) as client:
            for _ in range(20):
                ask(client)
            self.assertEqual(server.connections, 1)

    def test_an_answer_cut_off_in_the_middle_is_asked_for_again(self) -> None:
        def serve(connection: socket.socket, number: int) -> None:
            read_request(connection)
            whole = response({"scallop_height_mm": 1})
            connection.sendall(whole if number > 0 else whole[:-5])

        with SocketServer(serve) as server, scallopd.Client(server.url) as client:
            self.assertEqual(ask(client), 1)
            self.assertEqual(server.connections, 2)


class Overload(unittest.TestCase):
    """Answers 429, 502 and 503."""

    def after(self, refusals: int, refusal: Reply) -> Callable[[Received], Reply]:
        left = [refusals]

        def reply(_: Received) -> Reply:
            left[0] -= 1
            return refusal if left[0] >= 0 else (200, {}, {"scallop_height_mm": 1})

        return reply

    def test_the_client_waits_as_long_as_retry_after_says(self) -> None:
        for status in (429, 503):
            refusal: Reply = (status, {"retry-after": "1"}, overloaded(status))
            with RecordingServer(self.after(1, refusal)) as server:
                started = time.monotonic()
                self.assertEqual(ask(scallopd.Client(server.url)), 1)
                self.assertGreaterEqual(time.monotonic() - started, 1)

    def test_a_date_in_retry_after_is_understood(self) -> None:
        date = formatdate(time.time() + 2, usegmt=True)
        with RecordingServer(self.after(1, (503, {"retry-after": date}, overloaded()))) as server:
            started = time.monotonic()
            self.assertEqual(ask(scallopd.Client(server.url)), 1)
            # The date has whole seconds.
            self.assertGreaterEqual(time.monotonic() - started, 0.9)

    def test_without_retry_after_the_pauses_grow(self) -> None:
        with RecordingServer(self.after(3, (503, {}, overloaded()))) as server:
            started = time.monotonic()
            self.assertEqual(ask(scallopd.Client(server.url)), 1)
            self.assertGreaterEqual(time.monotonic() - started, 0.05 + 0.1 + 0.2)

    def test_a_proxy_that_lost_its_replica_is_asked_again(self) -> None:
        with RecordingServer(self.after(1, (502, {"content-type": "text/html"}, "no gateway"))) as server:
            self.assertEqual(ask(scallopd.Client(server.url)), 1)
            self.assertEqual(len(server.received), 2)

    def test_a_longer_wait_than_allowed_raises_the_problem_at_once(self) -> None:
        with RecordingServer(self.after(9, (503, {"retry-after": "3600"}, overloaded()))) as server:
            with self.assertRaises(scallopd.Problem) as raised:
                ask(scallopd.Client(server.url))
            self.assertEqual((raised.exception.status, raised.exception.retry_after_s), (503, 3600))
            self.assertEqual(len(server.received), 1)

    def test_another_program_in_the_servers_place_is_named_as_such(self) -> None:
        with RecordingServer(lambda _: (404, {"content-type": "text/html"}, "nothing here")) as server:
            with self.assertRaisesRegex(scallopd.InvalidAnswer, "status 404"):
                ask(scallopd.Client(server.url))
        with RecordingServer(lambda _: (200, {}, ["not", "an", "object"])) as server:
            with self.assertRaises(scallopd.InvalidAnswer):
                ask(scallopd.Client(server.url))


class TimeOuts(unittest.TestCase):
    """Slow servers."""

    def raises_in_time(self, client: scallopd.Client) -> None:
        started = time.monotonic()
        with self.assertRaisesRegex(scallopd.Timeout, r"POST http://.*/v1/scallop-height: no answer within 0.3 s") as raised:
            ask(client)
        self.assertIsInstance(raised.exception, TimeoutError)
        # The server would take ten seconds and more.
        self.assertLess(time.monotonic() - started, 5)

    def test_a_silent_server_times_out_and_the_client_stays_usable(self) -> None:
        def serve(connection: socket.socket, number: int) -> None:
            read_request(connection)
            if number == 0:
                server.sleep(10)
            connection.sendall(response({"scallop_height_mm": 1}))

        with SocketServer(serve) as server:
            client = scallopd.Client(server.url, timeout=0.3)
            self.raises_in_time(client)
            self.assertEqual(ask(client), 1)

    def test_an_answer_that_trickles_in_times_out_as_a_whole(self) -> None:
        def serve(connection: socket.socket, _: int) -> None:
            read_request(connection)
            for byte in response({"scallop_height_mm": 1}):
                connection.sendall(bytes([byte]))
                server.sleep(0.1)

        with SocketServer(serve) as server:
            self.raises_in_time(scallopd.Client(server.url, timeout=0.3))

    def test_an_upload_may_take_longer_than_the_time_out_while_it_moves(self) -> None:
        class Slow(io.RawIOBase):
            left = 6

            def readable(self) -> bool:
                return True

            def readinto(self, buffer: Any) -> int:
                time.sleep(0.25)
                self.left -= 1
                buffer[:1] = b"0"
                return 1 if self.left >= 0 else 0

        with RecordingServer(lambda _: (200, {}, {"method": "surface"})) as server:
            client = scallopd.Client(server.url, timeout=1)
            answer = client.recommend_file(Slow(), [CANDIDATE], 0.01, "vmc")  # type: ignore[arg-type]
            self.assertEqual(answer["method"], "surface")
            self.assertIn(b"\r\n\r\n000000\r\n--", server.received[0].body)


class Refusals(unittest.TestCase):
    """Bodies that the real program does not take."""

    def test_a_body_over_the_limit_is_a_problem_and_no_broken_connection(self) -> None:
        service = Service("--max-upload", "100000")
        self.addCleanup(service.kill)
        client = scallopd.Client(service.url, retry_for=2)
        with self.assertRaises(scallopd.Problem) as raised:
            client.recommend_file(b"0 0 0\n" * 3_000_000, [CANDIDATE], 0.01, "vmc")
        self.assertEqual(raised.exception.status, 413)

    def test_a_missing_file_is_named_at_once(self) -> None:
        with self.assertRaises(FileNotFoundError):
            scallopd.Client("http://127.0.0.1:1").recommend_file("/does/not/exist.stl", [CANDIDATE], 0.01, "vmc")

    def test_a_url_without_a_host_is_refused(self) -> None:
        for url in ("127.0.0.1:8080", "ftp://host", "http://"):
            with self.assertRaises(ValueError):
                scallopd.Client(url)

    def test_a_base_url_may_have_a_path_and_headers_are_sent(self) -> None:
        with RecordingServer(lambda _: (200, {}, {"machines": []})) as server:
            client = scallopd.Client(server.url + "/milling/", headers={"authorization": "Bearer x"})
            self.assertEqual(client.machines(), [])
            self.assertEqual(server.received[0].path, "/milling/v1/machines")
            self.assertEqual(server.received[0].headers["authorization"], "Bearer x")


class Uploads(unittest.TestCase):
    """The form as a server sees it."""

    def received(self, surface: Any, **options: Any) -> Received:
        with RecordingServer(lambda _: (200, {}, {"method": "surface"})) as server:
            scallopd.Client(server.url).recommend_file(surface, [CANDIDATE], 0.01, "vmc", **options)
            return server.received[0]

    def parts(self, request: Received) -> Any:
        head = b"content-type: " + request.headers["content-type"].encode() + b"\r\n\r\n"
        parts: Any = BytesParser().parsebytes(head + request.body).get_payload()
        return {
            part.get_param("name", header="content-disposition"): (part.get_filename(), part.get_payload(decode=True)) for part in parts
        }

    def test_paths_bytes_and_open_files_arrive_alike(self) -> None:
        content = os.urandom(700_000).replace(b"\r", b"").replace(b"\n", b"")
        with tempfile.NamedTemporaryFile(suffix=".stl") as file:
            file.write(content)
            file.seek(0)
            name = os.path.basename(file.name)
            reading, writing = os.pipe()

            def feed() -> None:
                with os.fdopen(writing, "wb") as end:
                    end.write(content)

            feeder = threading.Thread(target=feed)
            feeder.start()
            with os.fdopen(reading, "rb") as pipe:
                cases = [(file.name, name), (file, name), (scallopd.File(content, "a.stl"), "a.stl"), (pipe, "file")]
                for source, expected in cases:
                    request = self.received(source)
                    self.assertEqual(self.parts(request)["surface"], (expected, content))
                    self.assertEqual("content-length" in request.headers, source is not pipe)
            feeder.join()

    def test_an_open_file_is_read_from_its_position(self) -> None:
        file = io.BytesIO(b"skip0 0 0")
        file.seek(4)
        self.assertEqual(self.parts(self.received(file))["surface"], ("file", b"0 0 0"))

    def test_parameters_and_libraries_are_parts(self) -> None:
        library = scallopd.File(b'{"data": []}', "a.json")
        parts = self.parts(self.received(b"0 0 0", libraries=[library], include=["passes"], model=None))
        self.assertEqual(parts["library"], ("a.json", b'{"data": []}'))
        expected = {"cutters": [CANDIDATE], "scallop_tolerance_mm": 0.01, "machine": {"preset": "vmc"}, "include": ["passes"]}
        self.assertEqual(json.loads(parts["parameters"][1]), expected)

    def test_a_file_name_cannot_break_the_form(self) -> None:
        request = self.received(scallopd.File(b"0 0 0", 'a"\r\n.stl'))
        self.assertIn(b'filename="a%22%0D%0A.stl"', request.body)

    def test_a_text_file_is_refused(self) -> None:
        with self.assertRaisesRegex(TypeError, "'rb'"):
            self.received(io.StringIO("0 0 0"))

    def test_an_upload_that_can_be_read_again_is_repeated_and_a_pipe_is_not(self) -> None:
        busy = [True]

        def reply(_: Received) -> Reply:
            refuse, busy[0] = busy[0], False
            return (503, {"retry-after": "0"}, overloaded()) if refuse else (200, {}, {"method": "surface"})

        with RecordingServer(reply) as server:
            client = scallopd.Client(server.url)
            client.recommend_file(io.BytesIO(b"0 0 0"), [CANDIDATE], 0.01, "vmc")
            self.assertEqual([b"0 0 0" in request.body for request in server.received], [True, True])
            busy[0] = True
            reading, writing = os.pipe()
            os.write(writing, b"0 0 0")
            os.close(writing)
            with os.fdopen(reading, "rb") as pipe, self.assertRaises(scallopd.Problem):
                client.recommend_file(pipe, [CANDIDATE], 0.01, "vmc")


if __name__ == "__main__":
    unittest.main()
