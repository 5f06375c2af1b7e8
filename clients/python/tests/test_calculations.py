"""The calculations against the real program."""

from __future__ import annotations

import array
import concurrent.futures
import math
import unittest
from typing import Any, List

import scallopd
from servers import REPOSITORY, ServiceCase

TORUS: scallopd.Cutter = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}
BALL: scallopd.Cutter = {"type": "ball_end", "diameter_mm": 10}
OBLIQUE: scallopd.Contact = {"slope_deg": 40, "feed_angle_deg": 30}

try:
    import numpy
except ImportError:
    numpy = None  # type: ignore[assignment]


class Calculations(ServiceCase):
    """Single calculations, batches and problems."""

    def setUp(self) -> None:
        self.client = scallopd.Client(self.service.url)
        self.addCleanup(self.client.close)

    def test_a_ball_end_cutter_leaves_the_height_of_its_circle(self) -> None:
        answer = self.client.scallop_height(BALL, OBLIQUE, step_over_mm=0.6)
        self.assertAlmostEqual(answer["scallop_height_mm"], 5 - math.sqrt(25 - 0.09), places=12)
        self.assertEqual(answer["model"], "analytic")

    def test_the_largest_feed_and_step_over_leave_the_tolerance(self) -> None:
        feed = self.client.max_feed(TORUS, OBLIQUE, 0.013, step_over_mm=0.687, spindle_speed_rpm=10000)
        height = self.client.scallop_height(TORUS, OBLIQUE, step_over_mm=0.687, feed_per_tooth_mm=feed["feed_per_tooth_mm"])
        self.assertAlmostEqual(height["scallop_height_mm"], 0.013, places=12)
        self.assertAlmostEqual(feed["feed_rate_mm_min"], feed["feed_per_tooth_mm"] * 4 * 10000, places=6)
        step = self.client.step_over(TORUS, OBLIQUE, 0.013, feed_per_tooth_mm=feed["feed_per_tooth_mm"])
        self.assertAlmostEqual(step["step_over_mm"], 0.687, places=9)

    def test_a_parameter_that_is_none_is_not_sent(self) -> None:
        parameters: Any = {"runout": None, "model": None}
        answer = self.client.scallop_height(BALL, OBLIQUE, step_over_mm=0.6, **parameters)
        self.assertEqual(answer, self.client.scallop_height(BALL, OBLIQUE, step_over_mm=0.6))

    def test_a_batch_from_any_sequence_equals_the_single_calculations(self) -> None:
        normals: List[Any] = [(-0.64, 0, 0.77), [-0.1, 0.2, 1], array.array("d", [0, -0.5, 1])]
        feeds: List[Any] = [(1, 0, 0.84), [1, 0, 0], memoryview(array.array("f", [0, 1, 0.5]))]
        if numpy is not None:
            normals.append(numpy.array([-0.5, 0, 1]))
            feeds.append(numpy.array([1, 0, 0], dtype=numpy.float32))
        rows: List[scallopd.BatchContact] = [{"normal": normal, "feed": feed} for normal, feed in zip(normals, feeds)]
        answer = self.client.scallop_height_batch(TORUS, rows, step_over_mm=0.5)
        self.assertEqual(answer["failures"], [])
        for index, (normal, feed) in enumerate(zip(normals, feeds)):
            single = self.client.scallop_height(TORUS, {"normal": normal, "feed": feed}, step_over_mm=0.5)
            self.assertEqual(answer["scallop_height_mm"][index], single["scallop_height_mm"])

    def test_a_batch_whose_contacts_all_fail_raises_or_is_returned_by_choice(self) -> None:
        wide: scallopd.BatchContact = {"slope_deg": 40, "feed_angle_deg": 0, "step_over_mm": 30}
        with self.assertRaises(scallopd.Problem):
            self.client.scallop_height_batch(BALL, [wide, wide])
        with scallopd.Client(self.service.url, return_failed_batches=True) as client:
            answer = client.scallop_height_batch(BALL, [wide, wide])
            self.assertEqual(answer["scallop_height_mm"], [None, None])
            self.assertEqual([failure["index"] for failure in answer["failures"]], [0, 1])
            # A request with a fault of its own has no answer to return.
            with self.assertRaises(scallopd.Problem):
                client.scallop_height_batch({"type": "ball_end", "diameter_mm": -1}, [wide])

    def test_help_lists_the_parameters(self) -> None:
        self.assertIn("step_over_mm: float", scallopd.Client.max_feed.__doc__ or "")
        self.assertIn("method: Literal", scallopd.Client.recommend.__doc__ or "")
        cargo = (REPOSITORY / "Cargo.toml").read_text(encoding="utf-8")
        self.assertIn(f'version = "{scallopd.__version__}"', cargo)

    def test_a_batch_names_the_contact_without_an_answer(self) -> None:
        rows: List[scallopd.BatchContact] = [{"slope_deg": 40, "feed_angle_deg": 0}, {"slope_deg": 0, "feed_angle_deg": 0}]
        answer = self.client.max_feed_batch(TORUS, rows, 0.013, step_over_mm=0.5)
        self.assertIsNone(answer["feed_per_tooth_mm"][1])
        self.assertEqual([(failure["index"], failure["code"]) for failure in answer["failures"]], [(1, "flat-floor")])
        columns = self.client.step_over_batch(TORUS, rows, 0.013, model="envelope")
        self.assertEqual(len(columns["step_over_mm"]), 2)

    def test_the_critical_slope_of_the_published_rectangle(self) -> None:
        answer = self.client.critical_slope(
            {"diameter_mm": 10, "corner_radius_mm": 2}, {"diameter_mm": 10}, 0.01, "five_axis_vmc", width_mm=56, height_mm=28, slope_deg=60
        )
        self.assertAlmostEqual(answer["critical_slope_deg"], 33.8, delta=0.1)
        self.assertIn("five_axis_vmc", [machine["name"] for machine in self.client.machines()])

    def test_a_problem_carries_every_fault_with_its_place(self) -> None:
        cutter: Any = {"type": "toroidal", "diameter_mm": -10, "corner_radius_mm": 2}
        contact: Any = {"slope_deg": 100, "feed_angle_deg": 0}
        with self.assertRaises(scallopd.Problem) as raised:
            self.client.scallop_height(cutter, contact, step_over_mm=0.5)
        problem = raised.exception
        self.assertEqual((problem.type, problem.status, problem.instance), ("invalid-request", 422, "/v1/scallop-height"))
        self.assertEqual({fault.pointer for fault in problem.errors}, {"/cutter/diameter_mm", "/contact/slope_deg"})
        self.assertTrue(all(fault.code and fault.detail for fault in problem.errors))
        self.assertTrue(problem.request_id)
        self.assertIn("/contact/slope_deg", str(problem))

    def test_a_single_fault_is_named_with_its_place(self) -> None:
        contact: scallopd.Contact = {"slope_deg": 100, "feed_angle_deg": 0}
        with self.assertRaisesRegex(scallopd.Problem, r"^422 invalid-request: /contact/slope_deg: must be from 0 to 90"):
            self.client.step_over(TORUS, contact, 0.01)

    def test_an_exceeded_tolerance_has_its_figures_as_attributes(self) -> None:
        with self.assertRaises(scallopd.ToleranceExceeded) as raised:
            self.client.max_feed(TORUS, OBLIQUE, 0.013, step_over_mm=0.987)
        self.assertGreater(raised.exception.step_over_height_mm, 0.013)
        self.assertLess(raised.exception.max_step_over_mm, 0.987)
        self.client.max_feed(TORUS, OBLIQUE, 0.013, step_over_mm=0.99 * raised.exception.max_step_over_mm)

    def test_threads_share_a_client(self) -> None:
        def height(step_over_mm: float) -> float:
            return self.client.scallop_height(BALL, OBLIQUE, step_over_mm=step_over_mm)["scallop_height_mm"]

        steps = [0.1 + 0.001 * index for index in range(400)]
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            for step, found in zip(steps, pool.map(height, steps)):
                self.assertAlmostEqual(found, 5 - math.sqrt(25 - step * step / 4), places=12)


class NewerCalculations(ServiceCase):
    """Columns of contacts, curvature and cutting parameters, where the program under test has them."""

    def setUp(self) -> None:
        if not self.service.offers("/v1/cutting-parameters", "twist_per_mm"):
            self.skipTest("the program under test has no cutting parameters or no curvature")
        self.client = scallopd.Client(self.service.url)
        self.addCleanup(self.client.close)

    def test_columns_and_rows_have_the_same_answer(self) -> None:
        slopes = array.array("d", [10, 20, 30])
        columns: scallopd.ContactColumns = {
            "slope_deg": slopes,
            "feed_angle_deg": (0, 45, 90),
            "step_over_mm": [0.3, None, 0.5],
            "surface_curvature": {"along_per_mm": [0.01, 0, None], "across_per_mm": [0, 0.01, 0], "twist_per_mm": [0.0, 0.0, 0.001]},
        }
        rows: List[scallopd.BatchContact] = [
            {"slope_deg": 10, "feed_angle_deg": 0, "step_over_mm": 0.3, "surface_curvature": {"along_per_mm": 0.01}},
            {"slope_deg": 20, "feed_angle_deg": 45, "surface_curvature": {"across_per_mm": 0.01}},
            {"slope_deg": 30, "feed_angle_deg": 90, "step_over_mm": 0.5, "surface_curvature": {"twist_per_mm": 0.001}},
        ]
        by_columns = self.client.scallop_height_batch(TORUS, columns, step_over_mm=0.4, model="envelope")
        by_rows = self.client.scallop_height_batch(TORUS, rows, step_over_mm=0.4, model="envelope")
        self.assertEqual(by_columns["scallop_height_mm"], by_rows["scallop_height_mm"])

    def test_the_fastest_parameters_of_a_ball_end_cutter(self) -> None:
        # model.md: s = f_z = sqrt(2 (2 R t - t^2)) without limits on either.
        cutter: scallopd.Cutter = {**BALL, "teeth": 2}
        answer = self.client.cutting_parameters(cutter, OBLIQUE, 0.01, spindle_speed_rpm=10000, model="envelope")
        self.assertAlmostEqual(answer["step_over_mm"], 0.44699, places=3)
        self.assertAlmostEqual(answer["feed_per_tooth_mm"], 0.44699, places=3)
        batch = self.client.cutting_parameters_batch(
            cutter, [{"slope_deg": 40, "feed_angle_deg": 30}], 0.01, spindle_speed_rpm=10000, model="envelope"
        )
        self.assertAlmostEqual(batch["area_rate_mm2_min"][0] or 0, answer["area_rate_mm2_min"], places=6)


if __name__ == "__main__":
    unittest.main()
