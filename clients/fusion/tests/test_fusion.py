"""The script on files in the form that Fusion exports."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tempfile
import unittest
import zipfile
from email.parser import BytesParser
from pathlib import Path
from typing import Any, List

from servers import REPOSITORY, Received, RecordingServer, Reply, Service

SCRIPT = REPOSITORY / "clients/fusion/recommend_cutter.py"
LIBRARY = REPOSITORY / "clients/fusion/tests/data/library.json"
SURFACE = REPOSITORY / "examples/surface_2.stl"

ANSWER: Any = {
    "method": "surface",
    "model": "envelope",
    "recommended": {"cutter": 0, "name": "Ball 10 mm finish", "direction_deg": 0.0, "machining_time_s": 71.2},
    "candidates": [
        {
            "cutter": 0,
            "name": "Ball 10 mm finish",
            "type": "ball_end",
            "direction_deg": 12.5,
            "machining_time_s": 71.23,
            "passes": 74,
            "step_over_xy_mm": {"min": 0.5, "median": 0.61, "max": 0.63},
            "feed_rate_mm_min": 2880.0,
            "uncut_share": 0.0,
        }
    ],
    "not_ranked": [
        {"cutter": 2, "name": "Flat 8 mm", "code": "cannot-reach", "detail": "12 % of the area stays uncut", "uncut_share": 0.12}
    ],
    "confidence": {"level": "moderate", "reasons": [{"code": "close-race", "detail": "the lead is 1.2 %"}]},
    "warnings": [{"code": "tools-skipped", "detail": "1 tool is no finishing cutter: 1 drill"}],
}


def run(server: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(REPOSITORY / "clients/python/src")])
    command = [sys.executable, str(SCRIPT), "--server", server, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": paths})


class Script(unittest.TestCase):
    """The request that leaves the script, and what it prints."""

    def parts(self, request: Received) -> List[Any]:
        head = b"content-type: " + request.headers["content-type"].encode() + b"\r\n\r\n"
        payload: Any = BytesParser().parsebytes(head + request.body).get_payload()
        return [
            (part.get_param("name", header="content-disposition"), part.get_filename(), part.get_payload(decode=True)) for part in payload
        ]

    def test_surface_and_libraries_are_sent_as_they_are_and_the_ranking_is_printed(self) -> None:
        with tempfile.TemporaryDirectory() as folder, RecordingServer(lambda _: (200, {}, ANSWER)) as server:
            tools = Path(folder) / "library.tools"
            with zipfile.ZipFile(tools, "w") as archive:
                archive.write(LIBRARY, "tools.json")
            done = run(server.url, str(SURFACE), str(LIBRARY), str(tools), "--unit", "inch")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            parameters, surface, json_library, tools_library = self.parts(server.received[0])
            self.assertEqual(parameters[2], b'{"scallop_tolerance_mm": 0.01, "machine": {"preset": "vmc"}, "unit": "inch"}')
            self.assertEqual(surface, ("surface", "surface_2.stl", SURFACE.read_bytes()))
            self.assertEqual(json_library, ("library", "library.json", LIBRARY.read_bytes()))
            self.assertEqual(tools_library[:2], ("library", "library.tools"))
            self.assertEqual(zipfile.ZipFile(io.BytesIO(tools_library[2])).read("tools.json"), LIBRARY.read_bytes())
        self.assertEqual(
            done.stdout.splitlines(),
            [
                "cutter             direction deg  time s  passes  step-over mm  feed mm/min  uncut %",
                "Ball 10 mm finish  12.5           71.2    74      0.610         2880         0.00",
                "Flat 8 mm          12 % of the area stays uncut",
                "confidence: moderate",
                "  the lead is 1.2 %",
                "warning: 1 tool is no finishing cutter: 1 drill",
            ],
        )

    def test_a_problem_is_printed_and_the_exit_status_is_1(self) -> None:
        detail = "none of the 3 cutters can finish this surface"
        problem = {"type": "no-cutter-fits", "title": "No cutter fits", "status": 422, "detail": detail, "instance": "/"}
        reply: Reply = (422, {}, {**problem, "not_ranked": ANSWER["not_ranked"]})
        with RecordingServer(lambda _: reply) as server:
            done = run(server.url, str(SURFACE), str(LIBRARY))
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr, f"{detail}\n  Flat 8 mm: 12 % of the area stays uncut\n")
        done = run("http://127.0.0.1:1", "missing.stl", str(LIBRARY))
        self.assertEqual(done.returncode, 1)
        self.assertIn("missing.stl", done.stderr)


class AgainstTheProgram(unittest.TestCase):
    """The real program, where it reads tool libraries."""

    def test_the_cutters_of_both_forms_of_a_library_are_ranked(self) -> None:
        service = Service()
        self.addCleanup(service.kill)
        if not service.offers("cutters", "library"):
            self.skipTest("the program under test reads no tool libraries")
        with tempfile.TemporaryDirectory() as folder:
            tools = Path(folder) / "library.tools"
            with zipfile.ZipFile(tools, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.write(LIBRARY, "tools.json")
            for library in (LIBRARY, tools):
                done = run(service.url, str(SURFACE), str(library))
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                for name in ("Ball 10 mm finish", "Bull nose 5/8 in", "Flat 8 mm"):
                    self.assertIn(name, done.stdout)
                self.assertNotRegex(done.stdout, "(?m)^Drill")


if __name__ == "__main__":
    unittest.main()
