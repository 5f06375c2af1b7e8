"""Runs the examples of docs/integration.md and of the clients' READMEs, and compares what is shown below them."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, List, Tuple

import scallopd
from servers import REPOSITORY, ServiceCase

PAGE = REPOSITORY / "docs/integration.md"
PYTHON_README = REPOSITORY / "clients/python/README.md"
BASE = "http://127.0.0.1:8080"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def examples(page: Path, language: str) -> List[Tuple[str, str]]:
    """The blocks in a language, each with the block that follows it."""
    blocks: List[Tuple[str, str]] = BLOCK.findall(page.read_text(encoding="utf-8"))
    return [(text, blocks[index + 1][1]) for index, (kind, text) in enumerate(blocks) if kind == language]


def rounded(value: Any) -> Any:
    """Numbers with six significant digits."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, list):
        return [rounded(item) for item in value]
    return value


class IntegrationPage(ServiceCase):
    """Examples against the real program."""

    def ran(self, *command: str) -> str:
        environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "clients/python/src")}
        done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=120, env=environment)
        self.assertEqual((done.returncode, done.stderr), (0, ""), command)
        return done.stdout

    def here(self, text: str) -> str:
        self.assertIn(BASE, text)
        return text.replace(BASE, self.service.url)

    def assert_shown(self, shown: Any, answer: Any) -> None:
        """Every member that is shown has that value in the answer."""
        if isinstance(shown, dict):
            for name, value in shown.items():
                self.assert_shown(value, answer[name])
        else:
            self.assertEqual(shown, rounded(answer))

    def test_curl(self) -> None:
        found = examples(PAGE, "sh")
        self.assertEqual(len(found), 5)
        for command, shown in found:
            with self.subTest(command):
                if '"cutters"' in command and not self.service.offers("cutters"):
                    self.skipTest("the program under test compares no lists of cutters")
                self.assert_shown(json.loads(shown), json.loads(self.ran("bash", "-c", self.here(command))))

    def test_python(self) -> None:
        found = examples(PAGE, "python")
        self.assertEqual(len(found), 3)
        for text, shown in found:
            with self.subTest(text):
                self.assertEqual(self.ran(sys.executable, "-c", self.here(text)), shown)

    def test_the_readme_of_the_python_package(self) -> None:
        text = BLOCK.findall(PYTHON_README.read_text(encoding="utf-8"))[1][1]
        self.assertEqual(self.ran(sys.executable, "-c", self.here(text)), "11899 mm/min\nthe step-over must be under 0.783 mm\n")

    def test_javascript(self) -> None:
        if shutil.which("node") is None:
            self.skipTest("node is not installed")
        found = examples(PAGE, "javascript")
        self.assertEqual(len(found), 2)
        for text, shown in found:
            with self.subTest(text):
                self.assertEqual(self.ran("node", "--input-type=module", "--eval", self.here(text)), shown)

    def test_csharp(self) -> None:
        if shutil.which("mcs") is None or shutil.which("mono") is None:
            self.skipTest("Mono is not installed")
        found = examples(PAGE, "csharp")
        self.assertEqual(len(found), 2)
        for text, shown in found:
            with self.subTest(text), tempfile.TemporaryDirectory() as folder:
                source = Path(folder) / "Example.cs"
                source.write_text(self.here(text))
                program = str(source.with_suffix(".exe"))
                libraries = ("-r:System.Net.Http", "-r:System.Runtime.Serialization")
                self.ran("mcs", f"-out:{program}", *libraries, "-warnaserror", "-nowarn:0649", str(source))
                self.assertEqual(self.ran("mono", program), shown)

    def test_the_two_ways_to_state_a_curvature_agree(self) -> None:
        blocks = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
        fragments = [json.loads(text) for kind, text in blocks if kind == "json" and "surface_curvature" in text]
        self.assertEqual(len(fragments), 2)
        if not self.service.offers("twist_per_mm"):
            self.skipTest("the program under test has no curvature along the feed")
        client = scallopd.Client(self.service.url)
        cutter: scallopd.Cutter = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}
        contact: scallopd.Contact = {"slope_deg": 40, "feed_angle_deg": 20}
        heights = [client.scallop_height(cutter, contact, step_over_mm=0.5, model="envelope", **fragment) for fragment in fragments]
        self.assertAlmostEqual(heights[0]["scallop_height_mm"], heights[1]["scallop_height_mm"], places=12)

    def test_the_images_of_the_page_exist(self) -> None:
        for link in re.findall(r"\]\((?!http)([^)#]+)", PAGE.read_text(encoding="utf-8")):
            self.assertTrue((PAGE.parent / link).exists(), link)


if __name__ == "__main__":
    unittest.main()
