"""Recommendations against the real program."""

from __future__ import annotations

import math
from typing import Dict, List

import scallopd
from servers import ServiceCase

CUTTERS: List[scallopd.Candidate] = [
    {"name": "T10", "type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4, "spindle_speed_rpm": 10000},
    {"name": "B10", "type": "ball_end", "diameter_mm": 10, "teeth": 2, "spindle_speed_rpm": 12000},
]
LIBRARY = b"name,type,diameter_mm,corner_radius_mm\nfrom the library,ball end,8,\n"
# The top of a sphere of radius 100, 30 mm by 30 mm.
DOME = [[[x, y, math.sqrt(100**2 - x * x - y * y)] for x in range(-15, 16, 3)] for y in range(-15, 16, 3)]


class Recommendations(ServiceCase):
    def setUp(self) -> None:
        self.client = scallopd.Client(self.service.url)
        self.addCleanup(self.client.close)

    def test_a_mesh_is_finished_with_passes_point_by_point(self) -> None:
        points = [point for row in DOME for point in row]
        corners = [(11 * row + column, row, column) for row in range(10) for column in range(10)]
        triangles = [triangle for at, _, _ in corners for triangle in ([at, at + 1, at + 12], [at, at + 12, at + 11])]
        surface: scallopd.Surface = {"mesh": {"points": points, "triangles": triangles}}
        answer = self.client.recommend(surface, CUTTERS, 0.01, "five_axis_vmc", include=["passes"])
        self.assertEqual(len(answer["candidates"]), 2)
        passes = answer["passes"]
        count = len(passes["tip_mm"])
        self.assertGreater(count, 100)
        self.assertEqual({len(passes["contact_mm"]), len(passes["normal"]), len(passes["feed_rate_mm_min"])}, {count})
        plan = answer["candidates"][0]
        self.assertLess(plan["scallop_height_mm"]["max"], 0.0101)

    def test_a_file_is_ranked_with_the_cutters_of_a_library(self) -> None:
        text = "\n".join(f"{x} {y} {z}" for row in DOME for x, y, z in row).encode()
        answer = self.client.recommend_file(
            scallopd.File(text, "dome.xyz"),
            CUTTERS,
            0.01,
            {"preset": "vmc", "feed_rate_mm_min": 4000},
            libraries=[scallopd.File(LIBRARY, "tools.csv")],
        )
        names: Dict[str, int] = {plan["name"]: plan["cutter"] for plan in answer["candidates"]}
        self.assertEqual(sorted(names), ["B10", "T10", "from the library"])
        self.assertEqual(names["from the library"], 2)

    def test_the_machines_have_names_and_limits(self) -> None:
        machines = {machine["name"]: machine for machine in self.client.machines()}
        self.assertGreater(machines["five_axis_vmc"]["feed_rate_mm_min"], 0)
