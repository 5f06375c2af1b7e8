"""Tests inside FreeCAD: `freecadcmd test_freecad.py`, which `run` beside this file starts."""

import importlib
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import traceback
import unittest
from pathlib import Path as FilePath

import FreeCAD
import Part
import Path

HERE = FilePath(os.environ["SCALLOPD_CLIENTS"]) / "freecad"
sys.path[:0] = [str(HERE), str(HERE.parent / "python/src"), str(HERE.parent / "tests")]

import finish_milling as milling
import scallopd
from scallopd import ranking
from servers import RecordingServer, Service

Vector = FreeCAD.Vector
BALL = {"name": "B10", "type": "ball_end", "diameter_mm": 10, "teeth": 2, "spindle_speed_rpm": 12000, "max_feed_per_tooth_mm": 0.15}
TORUS = {"name": "T10", "type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4, "spindle_speed_rpm": 10000}


def convex_cylinder():
    """The upper half of a cylinder of radius 30 along X."""
    return [Part.makeCylinder(30, 40, Vector(0, 0, 0), Vector(1, 0, 0)).Faces[0]]


def trough():
    """A trough of radius 15 along Y in a block; its face is reversed against its surface."""
    block = Part.makeBox(40, 40, 20).cut(Part.makeCylinder(15, 40, Vector(20, 0, 20), Vector(0, 1, 0)))
    return [face for face in block.Faces if isinstance(face.Surface, Part.Cylinder)]


def free_form():
    """A B-spline with curvature and twist everywhere."""
    points = [[Vector(10 * x, 10 * y, 0.4 * (x - 2) ** 2 + 0.7 * x * y - 0.5 * y * y + 0.1 * x**3) for y in range(5)] for x in range(5)]
    surface = Part.BSplineSurface()
    surface.interpolate(points)
    return [surface.toShape()]


def tip_at(contact, normal, cutter):
    """The tip of a cutter that touches a surface there."""
    radius = cutter["diameter_mm"] / 2
    corner = cutter.get("corner_radius_mm", radius)
    level = Vector(normal.x, normal.y, 0)
    ring = level.normalize() * (radius - corner) if level.Length > 0 else Vector()
    return contact + normal * corner + ring - Vector(0, 0, corner)


def answer(request):
    """A recommendation in the service's form, with three runs on the cylinder: a link joins the first two, a lift the others."""
    if request.path.endswith("/max-feed/batch"):
        return feeds(request)
    body = request.json()
    cutter = body["cutters"][0]
    tips, moves, starts = [], [], []
    for number, y in enumerate((-1.0, -0.5, 10.0)):
        along = [0.0, 10.0, 20.0, 30.0]
        for x in along if number % 2 == 0 else reversed(along):
            normal = Vector(0, y, math.sqrt(30**2 - y * y)).normalize()
            tip = tip_at(normal * 30 + Vector(x, 0, 0), normal, cutter)
            is_first = len(starts) == number
            if is_first:
                lift = [] if number == 1 else [[tip.x, tip.y, 35.0], [tip.x, tip.y, tip.z + 1]]
                before = [[*tips[-1][:2], 35.0]] if number == 2 else []
                tips, moves = tips + before + lift, moves + ["rapid"] * len(before + lift)
                starts.append(len(tips) if starts else 0)
            tips.append([tip.x, tip.y, tip.z])
            moves.append("link" if is_first else "cut")
    tips.append([*tips[-1][:2], 35.0])
    moves.append("rapid")
    rates = [1000.0 + 100 * index for index in range(len(tips))]
    spread = {"min": 0.4, "median": 0.5, "max": 0.6}
    plan = {"type": cutter["type"], "direction_deg": 0.0, "machining_time_s": 12.5, "passes": 3, "step_over_xy_mm": spread}
    plan = {**plan, "cutter": 0, "name": cutter["name"], "feed_rate_mm_min": 2500.0, "uncut_share": 0.001}
    other = {**plan, "cutter": 1, "name": body["cutters"][-1]["name"], "machining_time_s": 20.0}
    ranked = [plan] if len(body["cutters"]) == 1 else [plan, other]
    document = {
        "method": "surface",
        "model": "envelope",
        "recommended": {"cutter": 0, "name": cutter["name"], "direction_deg": 0.0, "machining_time_s": 12.5, "feed_rate_mm_min": 2500.0},
        "candidates": ranked,
        "not_ranked": [{"cutter": 2, "name": "B60", "code": "cannot-reach", "detail": "12 % of the area stays uncut", "uncut_share": 0.12}],
        "surface": {"bounds_mm": {"min": [0, -30, 0], "max": [40, 30, 30]}},
        "passes": {
            "run_starts": starts,
            "operation": [0] * len(starts),
            "move": moves,
            "tip_mm": tips,
            "feed_rate_mm_min": rates,
            "contact_mm": [None] * len(tips),
        },
        "confidence": {"level": "high", "reasons": []},
        "warnings": [{"code": "steep-area", "detail": "3 % of the area is steeper than 85 deg"}],
    }
    return 200, {}, document


def feeds(request):
    count = len(request.json()["contacts"]["normal"])
    rates = [1200.0 + 60 * index for index in range(count)]
    rates[1] = None
    failure = {"index": 1, "pointer": "/contacts/1", "code": "gouging", "detail": "the cutter does not fit"}
    return 200, {}, {"model": "envelope", "feed_rate_mm_min": rates, "failures": [failure], "summary": {}, "warnings": []}


def off_the_cutter(point, cutter):
    """The distance of a point, given from the tip, from the bottom of a ball-end or toroidal cutter."""
    corner = cutter.get("corner_radius_mm", cutter["diameter_mm"] / 2)
    beside = max(math.hypot(point.x, point.y) - (cutter["diameter_mm"] / 2 - corner), 0.0)
    return abs(math.hypot(beside, point.z - corner) - corner)


class Cutters(unittest.TestCase):
    """Cutters from the tools of a job."""

    def test_the_finishing_cutters_of_a_job_are_found_with_their_speeds(self):
        document = FreeCAD.newDocument()
        self.addCleanup(FreeCAD.closeDocument, document.Name)
        part = document.addObject("Part::Feature", "Part")
        part.Shape = Part.makeBox(10, 10, 10)
        document.recompute()
        job = path_module("PathJob", "Path.Main.Job").Create("Job", [part], None)
        bits, controllers = path_module("PathToolBit", "Path.Tool.Bit"), path_module("PathToolController", "Path.Tool.Controller")
        for name, shape in (("Ball", "ballend"), ("Bull", "bullnose"), ("Drill", "drill")):
            tool = bits.Factory.Create(name, bits.findToolShape(f"{shape}.fcstd"))
            tool.Diameter = 8
            if name == "Bull":
                tool.FlatRadius, tool.Flutes, tool.Chipload = 2.5, 4, 0.08
            controller = controllers.Create(name, tool=tool, toolNumber=2)
            controller.SpindleSpeed = 9000 if name == "Bull" else 0
            job.Proxy.addToolController(controller)
        found = {cutter["name"]: cutter for cutter in milling.cutters("job")}
        self.assertEqual(found["Ball"], {"name": "Ball", "type": "ball_end", "diameter_mm": 8, "flute_length_mm": 40})
        bull = {"type": "toroidal", "corner_radius_mm": 1.5, "teeth": 4, "spindle_speed_rpm": 9000, "max_feed_per_tooth_mm": 0.08}
        self.assertEqual(found["Bull"], {"name": "Bull", "diameter_mm": 8, "flute_length_mm": 40, **bull})
        self.assertNotIn("Drill", found)
        # The job's own default tool.
        self.assertEqual([cutter["type"] for cutter in found.values()].count("flat_end"), 1)


def path_module(old, new):
    """A module of the Path workbench, by its name in 0.20 or later."""
    try:
        return importlib.import_module(f"PathScripts.{old}")
    except ImportError:
        return importlib.import_module(new)


class Curvature(unittest.TestCase):
    """The kernel's curvature in the service's signs: convex positive, across to the left of the feed seen from outside."""

    def at(self, faces, point, feed):
        face, u, v, _ = milling.nearest_on(faces, point)
        normal, values, directions = milling.contact_frame(face, u, v)
        return milling.curvature_along(normal, values, directions, feed)

    def assert_curvature(self, found, along, across, twist):
        expected = {"along_per_mm": along, "across_per_mm": across, "twist_per_mm": twist}
        for name, value in expected.items():
            self.assertAlmostEqual(found[name], value, places=9, msg=name)

    def test_a_cylinder_is_convex_around_it(self):
        faces, top = convex_cylinder(), Vector(20, 0, 31)
        self.assert_curvature(self.at(faces, top, Vector(0, 1, 0)), 1 / 30, 0, 0)
        self.assert_curvature(self.at(faces, top, Vector(2, 0, 0)), 0, 1 / 30, 0)
        # At the top w = -y^2/60 and y = (x + t)/sqrt(2) along and across the feed: k_FT = 1/60.
        self.assert_curvature(self.at(faces, top, Vector(1, 1, 0)), 1 / 60, 1 / 60, 1 / 60)
        self.assert_curvature(self.at(faces, top, Vector(1, -1, 0.4)), 1 / 60, 1 / 60, -1 / 60)

    def test_a_trough_is_concave_across_it(self):
        faces, bottom = trough(), Vector(20, 20, 6)
        self.assertEqual(faces[0].Orientation, "Reversed")
        self.assert_curvature(self.at(faces, bottom, Vector(1, 0, 0)), -1 / 15, 0, 0)
        self.assert_curvature(self.at(faces, bottom, Vector(0, 1, 0)), 0, -1 / 15, 0)

    def test_a_face_of_an_open_shell_may_point_down(self):
        faces = [face.reversed() for face in convex_cylinder()]
        self.assert_curvature(self.at(faces, Vector(20, 0, 31), Vector(0, 1, 0)), 1 / 30, 0, 0)

    def test_spheres_and_planes_have_the_same_curvature_in_all_directions(self):
        sphere = Part.makeSphere(12)
        sphere.Placement = FreeCAD.Placement(Vector(5, 6, 7), FreeCAD.Rotation(Vector(1, 1, 0), 40))
        self.assert_curvature(self.at(sphere.Faces, Vector(9, 8, 22), Vector(1, 0.3, 0)), 1 / 12, 1 / 12, 0)
        self.assert_curvature(self.at([Part.makePlane(10, 10)], Vector(4, 4, 1), Vector(1, 0.3, 0)), 0, 0, 0)

    def test_a_free_form_surface_falls_from_its_tangent_plane_as_its_curvature_says(self):
        faces = free_form()
        for x, y in ((12, 14), (22, 31), (31, 9)):
            face, u, v, _ = milling.nearest_on(faces, Vector(x, y, 3))
            contact = face.valueAt(u, v)
            frame = milling.contact_frame(face, u, v)
            for angle in (0.2, 1.1, 2.5):
                feed = Vector(math.cos(angle), math.sin(angle), 0)
                k = milling.curvature_along(*frame, feed)
                f = (feed - frame[0] * feed.dot(frame[0])).normalize()
                t = frame[0].cross(f)
                # Third order enters with the step; the mean of the two senses removes it.
                for side in (f, t, (f + t).normalize(), (f - t).normalize()):
                    drops, predictions = [], []
                    for step in (0.3, -0.3):
                        other = face.Surface.parameter(contact + side * step)
                        across = face.valueAt(*other) - contact
                        a, b = across.dot(f), across.dot(t)
                        drops.append(across.dot(frame[0]))
                        predictions.append(-0.5 * (k["along_per_mm"] * a * a + 2 * k["twist_per_mm"] * a * b + k["across_per_mm"] * b * b))
                    self.assertAlmostEqual(sum(drops) / 2, sum(predictions) / 2, delta=2e-5)

    def test_a_feed_along_the_normal_has_no_curvature(self):
        self.assertIsNone(self.at(convex_cylinder(), Vector(20, 0, 31), Vector(0, 0, -1)))


class Contacts(unittest.TestCase):
    """Contacts from the tip's positions."""

    def test_the_contact_of_ball_toroidal_and_flat_cutters_is_found_from_the_tip(self):
        met = 0
        flat = {"type": "flat_end", "diameter_mm": 10, "corner_radius_mm": 0}
        for faces in (convex_cylinder(), free_form(), Part.makeSphere(40).Faces):
            for cutter in (BALL, TORUS, flat):
                for x, y in ((12, 14), (17, -11), (21, 6)):
                    nearest = milling.nearest_on(faces, Vector(x, y, 41))
                    if nearest is None:
                        continue
                    face, u, v, _ = nearest
                    contact, normal = face.valueAt(u, v), milling.contact_frame(face, u, v)[0]
                    found = milling.contact_of(faces, tip_at(contact, normal, cutter), cutter, 0.01)
                    self.assertIsNotNone(found)
                    self.assertLess(found[0].valueAt(found[1], found[2]).distanceToPoint(contact), 1e-4)
                    met += 1
        self.assertGreaterEqual(met, 20)

    def test_a_tip_off_the_faces_has_no_contact(self):
        self.assertIsNone(milling.contact_of(convex_cylinder(), Vector(20, 0, 31), BALL, 0.05))
        self.assertIsNone(milling.contact_of(convex_cylinder(), Vector(60, 0, 30), BALL, 0.05))


class Passes(unittest.TestCase):
    """The recommendation's passes as a path; the server answers with a fixture in the service's form."""

    def setUp(self):
        self.document = FreeCAD.newDocument()
        self.addCleanup(FreeCAD.closeDocument, self.document.Name)
        self.server = RecordingServer(answer)
        self.addCleanup(self.server.__exit__)
        self.client = scallopd.Client(self.server.url)
        self.addCleanup(self.client.close)

    def test_faces_are_sent_as_a_mesh_that_follows_them(self):
        milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        body = self.server.received[0].json()
        self.assertEqual(body["include"], ["passes"])
        mesh = body["surface"]["mesh"]
        outward = 0
        for corners in mesh["triangles"]:
            a, b, c = (Vector(*mesh["points"][corner]) for corner in corners)
            middle = (a + b + c) / 3
            self.assertLess(abs(math.hypot(middle.y, middle.z) - 30), 0.01 / 4 + 1e-9)
            outward += (b - a).cross(c - a).dot(Vector(0, middle.y, middle.z)) > 0
        self.assertEqual(outward, len(mesh["triangles"]))

    def test_the_path_is_the_answers_move_by_move(self):
        recommendation = milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        feature = milling.add_path(milling.path_of(recommendation, 10000), "Finish")
        names = [command.Name for command in feature.Path.Commands]
        # Spindle, up and over; down to the first run; the second is linked; up, over and down to the third; up.
        self.assertEqual(names, ["M3", "G0", "G0", "G0"] + 8 * ["G1"] + 3 * ["G0"] + 4 * ["G1"] + ["G0"])
        passes = recommendation["passes"]
        columns = zip(passes["move"][1:], passes["tip_mm"][1:], passes["feed_rate_mm_min"][1:])
        for (move, tip, rate), command in zip(columns, feature.Path.Commands[3:]):
            self.assertEqual(command.Name, "G0" if move == "rapid" else "G1")
            for axis, value in zip("XYZ", tip):
                self.assertAlmostEqual(command.Parameters[axis], value, places=6)
            if move != "rapid":
                self.assertAlmostEqual(60 * command.Parameters["F"], rate, places=6)

    def test_the_path_begins_with_the_tool_and_plunges_slowly(self):
        recommendation = milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        commands = milling.path_of(recommendation, 10000, 7, 100).Commands
        self.assertEqual([(command.Name, command.Parameters) for command in commands[:2]], [("M6", {"T": 7}), ("M3", {"S": 10000})])
        tips = recommendation["passes"]["tip_mm"]
        plunges = [
            60 * command.Parameters["F"]
            for before, tip, command in zip(tips, tips[1:], commands[4:])
            if command.Name == "G1" and milling.is_plunge(before, tip)
        ]
        self.assertTrue(plunges)
        self.assertTrue(all(abs(rate - 100) < 1e-6 for rate in plunges))
        others = [60 * command.Parameters["F"] for command in commands if command.Name == "G1"]
        self.assertEqual(sum(rate > 100 for rate in others), len(others) - len(plunges))

    def test_the_post_processor_writes_millimetres_per_minute(self):
        recommendation = milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        feature = milling.add_path(milling.path_of(recommendation, 10000), "Finish")
        with tempfile.TemporaryDirectory() as folder:
            file = FilePath(folder) / "finish.ngc"
            milling.gcode(feature, str(file))
            lines = file.read_text().splitlines()
        self.assertIn("M3 S10000", " ".join(lines).replace("S10000.0", "S10000"))
        moves = [line for line in lines if line.startswith("G1 ")]
        self.assertEqual(len(moves), 12)
        self.assertIn("F1200.000", moves[0])

    def test_another_cutter_than_the_fastest_is_planned_on_request(self):
        request = (self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        recommendation = milling.recommend(*request)
        self.assertIs(milling.choose(*request, recommendation, 0), recommendation)
        other = milling.choose(*request, recommendation, 1)
        self.assertEqual(self.server.received[-1].json()["cutters"], [BALL])
        self.assertEqual(other["recommended"]["name"], "B10")

    def test_the_ranking_is_a_table(self):
        recommendation = milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        lines = ranking.text(recommendation).splitlines()
        self.assertRegex(lines[1], r"^T10 +0\.0 +12\.5 +3 +0\.500 +2500 +0\.10$")
        self.assertRegex(lines[3], r"^B60 +12 % of the area stays uncut$")
        self.assertIn("warning: 3 % of the area is steeper than 85 deg", lines)

    def test_the_dialog_returns_the_chosen_cutter(self):
        from PySide import QtCore, QtGui

        application = QtGui.QApplication.instance() or QtGui.QApplication([])
        recommendation = milling.recommend(self.client, convex_cylinder(), [TORUS, BALL], 0.01, "five_axis_vmc")
        for row, button, expected in ((1, "accept", 1), (0, "accept", 0), (2, "accept", None), (1, "reject", None)):

            def act(row=row, button=button):
                dialog = application.activeModalWidget()
                dialog.findChild(QtGui.QTableWidget).selectRow(row)
                getattr(dialog, button)()

            QtCore.QTimer.singleShot(0, act)
            self.assertEqual(milling.ranking_dialog(recommendation), expected)


class Feeds(unittest.TestCase):
    """Feeds for an existing path."""

    def path(self, faces):
        """Rapid moves, then a ball-end cutter around the cylinder and along it."""
        commands = [Path.Command("G0", {"Z": 50}), Path.Command("G0", {"X": 10, "Y": -10})]
        for degrees in (-15, -10, -5, 0, 5):
            angle = math.radians(degrees)
            centre = Vector(10, 35 * math.sin(angle), 35 * math.cos(angle))
            commands.append(Path.Command("G1", {"X": centre.x, "Y": centre.y, "Z": centre.z - 5, "F": 5}))
        commands.append(Path.Command("G1", {"X": 20}))
        commands.append(Path.Command("G1", {"Z": 50}))
        return Path.Path(commands)

    def test_contacts_carry_normal_feed_and_curvature(self):
        faces = convex_cylinder()
        moves, columns = milling.contacts_of_path(self.path(faces), faces, BALL)
        self.assertEqual(moves, [2, 3, 4, 5, 6, 7])
        for index, degrees in enumerate((-15, -10, -5, 0, 5, 5)):
            angle = math.radians(degrees)
            self.assertLess(columns["normal"][index].distanceToPoint(Vector(0, math.sin(angle), math.cos(angle))), 1e-6)
        curvature = columns["surface_curvature"]
        for index in (1, 2, 3, 4):
            self.assertAlmostEqual(curvature["along_per_mm"][index], 1 / 30, places=9)
        self.assertAlmostEqual(curvature["across_per_mm"][5], 1 / 30, places=9)

    def test_feeds_replace_those_of_the_path_and_failures_keep_theirs(self):
        with RecordingServer(answer) as server, scallopd.Client(server.url) as client:
            faces = convex_cylinder()
            path, changed, failures = milling.path_with_feeds(client, self.path(faces), faces, BALL, 0.01, step_over_mm=0.4)
            body = server.received[0].json()
        self.assertEqual(body["model"], "envelope")
        self.assertEqual(body["cutter"], {"type": "ball_end", "diameter_mm": 10, "teeth": 2})
        self.assertEqual((body["spindle_speed_rpm"], body["max_feed_per_tooth_mm"]), (12000, 0.15))
        self.assertEqual(len(body["contacts"]["normal"]), 6)
        self.assertEqual((changed, [failure["move"] for failure in failures]), (5, [3]))
        rates = [round(60 * command.Parameters.get("F", 0)) for command in path.Commands]
        # Contacts get 1200, none, 1320, 1380, ...; each move the smaller of its ends'.
        self.assertEqual(rates, [0, 0, 1200, 300, 1320, 1320, 1380, 1440, 0])
        self.assertEqual(path.Commands[7].Parameters["X"], 20)


class PluginExample(unittest.TestCase):
    """The example of README.md, which must stay short."""

    def test_the_example_makes_a_path_and_gcode_in_under_30_lines(self):
        readme = (HERE / "README.md").read_text()
        example = readme.split("```python\n", 1)[1].split("```", 1)[0]
        lines = len([line for line in example.splitlines() if line.strip()])
        self.assertLess(lines, 30)
        self.assertIn(f"G-code in {lines} lines", readme)
        document = FreeCAD.newDocument()
        self.addCleanup(FreeCAD.closeDocument, document.Name)
        document.addObject("Part::Feature", "Part").Shape = Part.makeCylinder(30, 40, Vector(0, 0, 0), Vector(1, 0, 0))
        with RecordingServer(answer) as server, tempfile.TemporaryDirectory() as folder:
            here = os.getcwd()
            os.chdir(folder)
            try:
                exec(example.replace("http://127.0.0.1:8080", server.url), {})
                self.assertIn("G1 X", FilePath("finish.ngc").read_text())
            finally:
                os.chdir(here)
        self.assertEqual(len(document.getObject("Finish").Path.Commands), 20)


class Macros(unittest.TestCase):
    """The macro files, run as FreeCAD runs them."""

    def run_macro(self, name, server, **changes):
        settings = json.loads((HERE / "finish_milling.json").read_text())
        settings.update({"server": server, "faces": ["Part.Face1"], **changes})
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump(settings, file)
            file.flush()
            os.environ["SCALLOPD_SETTINGS"] = file.name
            try:
                exec(compile((HERE / name).read_text(), name, "exec"), {"__name__": "__main__"})
            finally:
                del os.environ["SCALLOPD_SETTINGS"]

    def setUp(self):
        self.document = FreeCAD.newDocument()
        self.addCleanup(FreeCAD.closeDocument, self.document.Name)
        self.document.addObject("Part::Feature", "Part").Shape = Part.makeCylinder(30, 40, Vector(0, 0, 0), Vector(1, 0, 0))

    def test_selected_faces_become_a_path_and_gcode(self):
        with RecordingServer(answer) as server, tempfile.TemporaryDirectory() as folder:
            file = FilePath(folder) / "finish.ngc"
            self.run_macro("FinishFaces.FCMacro", server.url, gcode_file=str(file))
            self.assertEqual(len(self.document.getObject("Finish").Path.Commands), 21)
            self.assertIn("G1 X10", file.read_text())

    def test_the_command_line_of_the_readme(self):
        with RecordingServer(answer) as server, tempfile.TemporaryDirectory() as folder:
            settings = json.loads((HERE / "finish_milling.json").read_text())
            settings.update({"server": server.url, "faces": ["Part.Face1"], "gcode_file": f"{folder}/finish.ngc"})
            (FilePath(folder) / "mine.json").write_text(json.dumps(settings))
            self.document.recompute()
            self.document.saveAs(f"{folder}/part.FCStd")
            readme = (HERE / "README.md").read_text()
            command = re.search(r"^SCALLOPD_SETTINGS=\S+ (freecadcmd .* part.FCStd .*)$", readme, re.MULTILINE)[1]
            command = command.replace("part.FCStd", f"{folder}/part.FCStd").replace("clients/", f"{HERE.parent}/").split()
            environment = {**os.environ, "SCALLOPD_SETTINGS": f"{folder}/mine.json"}
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, env=environment)
            self.assertIn("Finish: 21 commands", done.stdout + done.stderr)
            self.assertIn("G1 X10", (FilePath(folder) / "finish.ngc").read_text())

    def test_an_existing_path_becomes_one_with_feeds(self):
        path = Feeds().path(None)
        milling.add_path(path, "Old")
        feeds = {**json.loads((HERE / "finish_milling.json").read_text())["feeds"], "path": "Old"}
        with RecordingServer(answer) as server:
            self.run_macro("FeedsForPath.FCMacro", server.url, feeds=feeds)
            body = server.received[0].json()
        self.assertEqual(body["cutter"], {"type": "ball_end", "diameter_mm": 10, "teeth": 2})
        self.assertEqual(body["spindle_speed_rpm"], 12000)
        found = self.document.getObject("OldFeeds").Path.Commands
        self.assertEqual(round(60 * found[2].Parameters["F"]), 1200)

    def test_a_path_is_checked_and_gets_the_feeds_of_its_points(self):
        def check(_request):
            lines = [1, 2, 3, 4, 5, 6, 7, 8, 9]
            rates = [None, None, 1000.0, 1100.0, 1200.0, 1300.0, 1400.0, 1500.0, None]
            feeds = {"line": lines, "feed_rate_mm_min": rates, "machining_time_s": 3.0}
            places = [{"code": "gouge", "point_mm": [1, 2, 3], "line": 4}]
            left = {"p50": 0.001, "p99": 0.01}
            cut = {"depth_mm": 0.1, "rapid_depth_mm": 0}
            body = {
                "residual_mm": left,
                "gouge": cut,
                "reachable_over_tolerance_share": 0.1,
                "machining_time_s": 4.0,
                "places": places,
                "feeds": feeds,
            }
            return 200, {}, body

        milling.add_path(Feeds().path(None), "Existing")
        feeds = {**json.loads((HERE / "finish_milling.json").read_text())["feeds"], "path": "Existing"}
        with RecordingServer(check) as server:
            self.run_macro("CheckPath.FCMacro", server.url, feeds=feeds)
            body = server.received[0].json()
        self.assertEqual(body["include"], ["places", "feeds"])
        self.assertEqual(body["path"]["program"].count("\n"), 8)
        self.assertTrue(body["avoid"]["mesh"]["triangles"])
        found = self.document.getObject("ExistingChecked").Path.Commands
        self.assertEqual(round(60 * found[2].Parameters["F"]), 1000)

    def test_names_that_the_document_does_not_have_are_reported_and_not_raised(self):
        with RecordingServer(answer) as server:
            self.run_macro("FinishFaces.FCMacro", server.url, faces=["Part.Face9", "Nothing.Face1", "Part"])
            self.run_macro("FeedsForPath.FCMacro", server.url)
            self.assertEqual(server.received, [])

    def test_a_cutter_that_is_not_in_the_settings_is_reported_and_not_raised(self):
        milling.add_path(Feeds().path(None), "Old")
        feeds = {**json.loads((HERE / "finish_milling.json").read_text())["feeds"], "path": "Old", "cutter": "T99"}
        with RecordingServer(answer) as server:
            self.run_macro("FeedsForPath.FCMacro", server.url, feeds=feeds)
            self.assertEqual(server.received, [])
        self.assertIsNone(self.document.getObject("OldFeeds"))

    def test_a_server_that_is_away_is_reported_and_not_raised(self):
        original = scallopd.Client.__init__.__kwdefaults__["retry_for"]
        scallopd.Client.__init__.__kwdefaults__["retry_for"] = 0
        try:
            self.run_macro("FinishFaces.FCMacro", "http://127.0.0.1:1")
        finally:
            scallopd.Client.__init__.__kwdefaults__["retry_for"] = original
        self.assertIsNone(self.document.getObject("Finish"))


FIGURE = re.compile(r"-?[0-9][0-9.]*")


def words_of(line):
    """A line without its figures."""
    return FIGURE.sub("#", re.sub(r" +", " ", line)).strip()


class AgainstTheProgram(unittest.TestCase):
    """The real program, where it has passes and curvature."""

    @classmethod
    def setUpClass(cls):
        cls.service = Service()
        cls.addClassCleanup(cls.service.kill)
        if not cls.service.offers("run_starts", "twist_per_mm"):
            raise unittest.SkipTest("the program under test has no passes or no curvature")
        cls.client = scallopd.Client(cls.service.url)
        cls.addClassCleanup(cls.client.close)

    def test_the_transcript_of_the_readme(self):
        """The README's figures are today's; with SCALLOPD_WRITE_DOCS=1 they are written. Runs with one program are equal to the byte."""
        readme = (HERE / "README.md").read_text()
        commands, shown, moves = re.findall(r"```(?:sh|text)\n(.*?)```", readme, re.DOTALL)[:3]
        with tempfile.TemporaryDirectory() as folder:
            (FilePath(folder) / "clients").symlink_to(HERE.parent)
            commands = commands.replace("> mine.json", f"| sed 's#http://127.0.0.1:8080#{self.service.url}#' > mine.json")
            done = subprocess.run(
                ["sh", "-ec", commands], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120
            )
            gcode = (FilePath(folder) / "finish.ngc").read_text().replace(" \n", "\n")
        found, found_moves = self.like(shown, done.stdout + done.stderr), self.like(moves, gcode)
        if os.environ.get("SCALLOPD_WRITE_DOCS"):
            (HERE / "README.md").write_text(readme.replace(shown, found).replace(moves, found_moves))
            return
        for one, other in ((shown, found), (moves, found_moves)):
            figures = [[float(figure) for figure in FIGURE.findall(text)] for text in (one, other)]
            for printed, value in zip(*figures):
                # Another processor or another version of the kernel moves the last digits.
                self.assertLessEqual(abs(printed - value), 0.01 + 0.01 * abs(value), f"SCALLOPD_WRITE_DOCS=1 renews it:\n{other}")

    def like(self, shown, output):
        """The lines of the output that have the words of the shown ones, in their order."""
        lines = {}
        for line in output.splitlines():
            lines.setdefault(words_of(line), []).append(line.rstrip())
        for line in shown.splitlines():
            self.assertIn(words_of(line), lines, output)
        return "".join(lines[words_of(line)].pop(0) + "\n" for line in shown.splitlines())

    def test_the_passes_touch_the_faces(self):
        faces = free_form()
        for cutter in (TORUS, BALL):
            with self.subTest(cutter["name"]):
                # The torus does not fit into all of the surface.
                recommendation = milling.recommend(self.client, faces, [cutter], 0.01, "five_axis_vmc", max_uncut_share=1)
                passes = recommendation["passes"]
                columns = zip(passes["tip_mm"], passes["contact_mm"], passes["normal"])
                touching = [(Vector(*tip), Vector(*contact), Vector(*normal)) for tip, contact, normal in columns if contact is not None]
                found = 0
                for tip, contact, normal in touching[:: max(1, len(touching) // 200)]:
                    self.assertLess(off_the_cutter(contact - tip, cutter), 1e-9)
                    nearest = milling.nearest_on(faces, contact)
                    # Near the edge the nearest point of the untrimmed surface can lie outside the face.
                    if nearest is not None:
                        # The mesh keeps within a quarter of the scallop height. A facet that deviates by e from curvature k turns the
                        # normal by up to sqrt(2 e k): 0.9 deg at the 0.05 per mm that this surface reaches.
                        self.assertLess(nearest[3], 0.0025)
                        self.assertLess(math.degrees(normal.getAngle(milling.upward_normal(*nearest[:3]))), 1)
                    found += milling.contact_of(faces, tip, cutter, 0.01) is not None
                # At edges between facets a contact is up to 0.01 mm off the faces, and where the torus does not fit it has none.
                self.assertGreater(found, 150)
                path = milling.path_of(recommendation, cutter["spindle_speed_rpm"])
                self.assertEqual(
                    sum(command.Name == "G1" for command in path.Commands), len(passes["move"]) - passes["move"].count("rapid")
                )

    def test_a_plan_of_several_operations_changes_its_tools(self):
        """A cone on a plate: round the cone by waterlines, the plate to and fro."""
        part = Part.makeBox(40, 40, 5).fuse(Part.makeCone(14, 4, 12, Vector(20, 20, 5)))
        faces = [face for face in part.Faces if milling.upward_normal(face, *face.Surface.parameter(face.CenterOfMass)).z > 0.1]
        cutters = [TORUS, {**BALL, "name": "B6", "diameter_mm": 6}]
        options = {"operations": {"max": 3}, "max_uncut_share": 0.1}
        recommendation = milling.recommend(self.client, faces, cutters, 0.05, "five_axis_vmc", **options)
        operations = recommendation["plan"]["operations"]
        self.assertGreater(len(operations), 1)
        numbers = [4 + cutter for cutter in milling.cutters_of_operations(recommendation)]
        commands = milling.path_of(recommendation, tools=[(number, 8000 + number) for number in numbers]).Commands
        changes = [command.Parameters["T"] for command in commands if command.Name == "M6"]
        self.assertEqual(changes, [number for before, number in zip([None, *numbers], numbers) if number != before])
        self.assertEqual(len(changes), 1 + recommendation["plan"]["tool_changes"])
        # Each operation begins at the clearance height, where the one before has ended.
        passes = recommendation["passes"]
        starts = milling.operation_starts(passes)
        clearance = max(tip[2] for tip in passes["tip_mm"])
        self.assertEqual(len(starts), len(operations))
        for start in starts[1:]:
            for point in (start - 1, start):
                self.assertEqual((passes["move"][point], passes["tip_mm"][point][2]), ("rapid", clearance))
        cuts = [command for command in commands if command.Name == "G1"]
        self.assertEqual(len(cuts), len(passes["move"]) - passes["move"].count("rapid"))

    def test_the_curvature_of_the_passes_is_the_kernels(self):
        faces = free_form()
        passes = milling.recommend(self.client, faces, [BALL], 0.01, "five_axis_vmc")["passes"]
        found = passes["surface_curvature"]
        tips = [Vector(*tip) for tip in passes["tip_mm"]]
        pairs = {name: [] for name in found}
        for index in range(1, len(tips), 25):
            contact = passes["contact_mm"][index]
            nearest = contact and milling.nearest_on(faces, Vector(*contact))
            if index in passes["run_starts"] or not nearest:
                continue
            expected = milling.curvature_along(*milling.contact_frame(*nearest[:3]), tips[index] - tips[index - 1])
            for name, value in expected.items():
                pairs[name].append((value, found[name][index]))
        # The service estimates them from the mesh, which is coarse at the edges: the medians are compared.
        for name, values in pairs.items():
            size = statistics.median(abs(expected) for expected, _ in values)
            self.assertGreater(size, 0.002, name)
            self.assertLess(statistics.median(abs(value - expected) for expected, value in values), 0.25 * size, name)

    def test_feeds_of_a_planned_path_keep_its_tolerance(self):
        faces = convex_cylinder()
        path, changed, failures = milling.path_with_feeds(
            self.client, Feeds().path(faces), faces, BALL, 0.01, step_over_mm=0.4, max_feed_rate_mm_min=5000
        )
        self.assertEqual((changed, failures), (6, []))
        for command in path.Commands[2:8]:
            self.assertGreater(60 * command.Parameters["F"], 300)


# FreeCAD runs this file in a namespace that no module has, goes on to its own prompt after it and returns 0 whatever happened: the tests
# are collected by hand and the exit status is set here.
CASES = [Cutters, Curvature, Contacts, Passes, Feeds, PluginExample, Macros, AgainstTheProgram]
try:
    suite = unittest.TestSuite(unittest.defaultTestLoader.loadTestsFromTestCase(case) for case in CASES)
    status = 0 if unittest.TextTestRunner(sys.stdout, verbosity=2).run(suite).wasSuccessful() else 1
except BaseException:
    traceback.print_exc()
    status = 2
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)
