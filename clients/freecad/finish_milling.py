"""Finish milling in FreeCAD with scallopd: cutters ranked for selected faces, the passes of the chosen one as a Path object, and feeds
for an existing path. The macros beside this file use it; other macros and workbenches can import it.

Runs in FreeCAD 0.20 and later, with or without the GUI. Lengths are millimetres; Z is the tool axis.
"""

import importlib
import json
import math
import os

import FreeCAD
import Part
import Path
from scallopd import ranking

SECONDS_PER_MINUTE = 60.0
PASSES = ["passes"]


def settings():
    """The macros' settings: `finish_milling.json` beside this file, or the file that the variable SCALLOPD_SETTINGS names."""
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "finish_milling.json")
    with open(os.environ.get("SCALLOPD_SETTINGS", beside), encoding="utf-8") as file:
        chosen = json.load(file)
    # The older name of the tolerance.
    chosen.setdefault("scallop_tolerance_mm", chosen.get("scallop_height_mm"))
    return chosen


# Cutters

SHAPES = {"ballend": "ball_end", "bullnose": "toroidal", "torus": "toroidal", "endmill": "flat_end"}


def cutters(chosen):
    """The settings' `cutters`: a list of cutters as it is, or "job" for the cutters of the document's job."""
    return cutters_of_job() if chosen == "job" else chosen


def tool_number(settings, place, document=None):
    """The tool number of the cutter at a place: of the settings' `tool_numbers`, or of the job's tool controllers."""
    if settings["cutters"] == "job":
        return controllers_of_job(document)[place].ToolNumber
    return settings["tool_numbers"][place]


def cutter_named(chosen, name):
    """The cutter of that name among the settings' `cutters`."""
    known = {cutter["name"]: cutter for cutter in cutters(chosen)}
    if name not in known:
        raise LookupError(f"there is no cutter {name!r}; known are {', '.join(known)}")
    return known[name]


def cutters_of_job(document=None):
    """The ball-end, bull-nose and flat cutters among the tool controllers of the document's jobs, with the controllers' speeds."""
    return [cutter_of(controller) for controller in controllers_of_job(document)]


def controllers_of_job(document=None):
    """The tool controllers of `cutters_of_job`."""
    # The group is called Tools since 0.19.
    groups = [getattr(getattr(job, "Tools", None), "Group", []) for job in (document or FreeCAD.ActiveDocument).Objects]
    return [controller for group in groups for controller in group if cutter_of(controller) is not None]


def cutter_of(controller):
    """A tool controller's cutter; None for a drill, chamfer mill and the like."""
    tool = controller.Tool
    shape = (getattr(tool, "ShapeType", "") or getattr(tool, "ShapeName", "")).lower()
    kind = next((kind for name, kind in SHAPES.items() if shape.startswith(name)), None)
    if kind is None:
        return None
    diameter = millimetres(tool, "Diameter")
    cutter = {"name": controller.Label, "type": kind, "diameter_mm": diameter}
    if kind == "toroidal":
        corner = millimetres(tool, "CornerRadius") or millimetres(tool, "TorusRadius")
        # Until 0.21 a bull-nose tool states the radius of its flat.
        cutter["corner_radius_mm"] = corner or diameter / 2 - millimetres(tool, "FlatRadius")
    # Zero stands for a figure that was not entered.
    for name, value in (
        ("teeth", int(getattr(tool, "Flutes", 0))),
        ("spindle_speed_rpm", float(controller.SpindleSpeed)),
        ("max_feed_per_tooth_mm", millimetres(tool, "Chipload")),
        ("flute_length_mm", millimetres(tool, "CuttingEdgeHeight")),
    ):
        if value > 0:
            cutter[name] = value
    return cutter


def millimetres(tool, name):
    """A tool's length; 0 if it has none of that name."""
    value = getattr(tool, name, 0.0)
    return float(getattr(value, "Value", value))


# Faces


def selected_faces(names=()):
    """The faces selected in the GUI; without a GUI those of `names`, such as "Body.Face3"."""
    if FreeCAD.GuiUp:
        import FreeCADGui

        chosen = [sub for selection in FreeCADGui.Selection.getSelectionEx() for sub in selection.SubObjects]
    else:
        chosen = [face for face in map(face_named, names) if face is not None]
    return [shape for shape in chosen if isinstance(shape, Part.Face)]


def face_named(name):
    """The face of a name such as "Body.Face3" in the active document; None where there is none."""
    feature = FreeCAD.ActiveDocument and FreeCAD.ActiveDocument.getObject(name.partition(".")[0])
    faces = feature.Shape.Faces if hasattr(feature, "Shape") else []
    number = name.partition(".Face")[2]
    return faces[int(number) - 1] if number.isdigit() and 0 < int(number) <= len(faces) else None


def mesh_of(faces, deviation_mm):
    """The faces as a mesh in the form of a request, at most `deviation_mm` away from them."""
    # A shape keeps the mesh of its display; a copy without it is meshed with the requested deviation.
    points, triangles = Part.Compound(faces).copy(True, False).tessellate(deviation_mm)
    return {"points": points, "triangles": triangles}


# Recommendation


def faces_beside(faces, shapes):
    """The other faces of the shapes that the faces belong to: the cutter must not cut them."""
    whole = [shape.Faces for shape in shapes if any(own.isSame(face) for own in shape.Faces for face in faces)]
    return [own for of_shape in whole for own in of_shape if not any(own.isSame(face) for face in faces)]


def visible_shapes():
    """The shapes of the active document that are shown, those of hidden features left out."""
    features = FreeCAD.ActiveDocument.Objects if FreeCAD.ActiveDocument else []
    return [feature.Shape for feature in features if hasattr(feature, "Shape") and getattr(feature, "Visibility", True)]


def recommend(client, faces, cutters, scallop_tolerance_mm, machine, beside=(), **parameters):
    """The cutters ranked for the faces, with the passes of the fastest. The faces `beside` them are not cut."""
    # A deviation of a quarter of the scallop height keeps the mesh's error small beside the results.
    surface = {"mesh": mesh_of(faces, scallop_tolerance_mm / 4)}
    if beside:
        parameters["avoid"] = {"mesh": mesh_of(beside, scallop_tolerance_mm / 4)}
    return client.recommend(surface, cutters, scallop_tolerance_mm, machine, include=PASSES, **parameters)


def choose(client, faces, cutters, scallop_tolerance_mm, machine, recommendation, cutter, **parameters):
    """The recommendation with the passes of the cutter number `cutter`, which need not be the fastest."""
    if cutter == recommendation["recommended"]["cutter"]:
        return recommendation
    return recommend(client, faces, [cutters[cutter]], scallop_tolerance_mm, machine, **parameters)


def ask_for_cutter(recommendation):
    """Shows the ranking and returns the number of the chosen cutter, or None. Without a GUI prints it and returns the fastest."""
    if not FreeCAD.GuiUp:
        print(ranking.text(recommendation))
        return recommendation["recommended"]["cutter"]
    return ranking_dialog(recommendation)


def ranking_dialog(recommendation):
    """A dialog with the ranking as a table; the number of the chosen cutter, or None where it was cancelled."""
    from PySide import QtGui

    rows = ranking.rows(recommendation)
    ranked = len(recommendation["candidates"])
    dialog = QtGui.QDialog()
    dialog.setWindowTitle("Cutters for these faces")
    dialog.resize(760, 320)
    table = QtGui.QTableWidget(len(rows), len(ranking.HEADS), dialog)
    table.setHorizontalHeaderLabels(ranking.HEADS)
    table.setSelectionBehavior(QtGui.QAbstractItemView.SelectRows)
    table.setSelectionMode(QtGui.QAbstractItemView.SingleSelection)
    table.setEditTriggers(QtGui.QAbstractItemView.NoEditTriggers)
    for row, cells in enumerate(rows):
        for column, cell in enumerate(cells):
            table.setItem(row, column, QtGui.QTableWidgetItem(cell))
        if row >= ranked:
            table.setSpan(row, 1, 1, len(ranking.HEADS) - 1)
    table.resizeColumnsToContents()
    table.selectRow(0)
    notes = QtGui.QLabel("\n".join(ranking.notes(recommendation)), dialog)
    notes.setWordWrap(True)
    buttons = QtGui.QDialogButtonBox(QtGui.QDialogButtonBox.Ok | QtGui.QDialogButtonBox.Cancel, parent=dialog)
    buttons.accepted.connect(dialog.accept)
    buttons.rejected.connect(dialog.reject)
    layout = QtGui.QVBoxLayout(dialog)
    for widget in (table, notes, buttons):
        layout.addWidget(widget)
    if dialog.exec_() != QtGui.QDialog.Accepted or not 0 <= table.currentRow() < ranked:
        return None
    return recommendation["candidates"][table.currentRow()]["cutter"]


# Passes to a path


def path_of(recommendation, spindle_speed_rpm=None, tool_number=None, plunge_rate_mm_min=None, tools=None):
    """The passes of the recommended plan as a `Path.Path`: every link, lift and approach is among them.

    With `tool_number` the path begins with the change to that tool. `tools` has the number and the spindle speed of each operation's
    tool in place of both. With `plunge_rate_mm_min` the tool goes straight down at most at this rate, where it otherwise has the feed of
    the pass."""
    passes = recommendation["passes"]
    tools = tools or [(tool_number, spindle_speed_rpm)]
    begins = dict(zip(operation_starts(passes), tools))
    commands, tool, before = [], None, None
    for index, (move, tip, rate) in enumerate(zip(passes["move"], passes["tip_mm"], passes["feed_rate_mm_min"])):
        if index in begins:
            commands += [] if begins[index] == tool else change_to(*begins[index])
            tool = begins[index]
            # Up first: nobody knows where the tool is.
            commands += [Path.Command("G0", {"Z": tip[2]}), Path.Command("G0", {"X": tip[0], "Y": tip[1]})]
        elif move == "rapid":
            commands.append(rapid_to(tip))
        else:
            slow = plunge_rate_mm_min is not None and is_plunge(before, tip)
            commands.append(cut_to(tip, min(rate, plunge_rate_mm_min) if slow else rate))
        before = tip
    return Path.Path(commands)


def operation_starts(passes):
    """The first point of each operation, which is the start of its first run."""
    firsts = {}
    for start, operation in zip(passes["run_starts"], passes["operation"]):
        firsts.setdefault(operation, start)
    return sorted(firsts.values())


def change_to(number, spindle_speed_rpm):
    """The commands that change to a tool and start the spindle, each where it is stated."""
    change = [] if number is None else [Path.Command("M6", {"T": number})]
    return change + ([] if spindle_speed_rpm is None else [Path.Command("M3", {"S": spindle_speed_rpm})])


def cutters_of_operations(recommendation):
    """The cutter of each operation of the passes, by its number in the request."""
    operations = recommendation.get("plan", {}).get("operations") or [recommendation["recommended"]]
    return [operation["cutter"] for operation in operations]


def is_plunge(before, tip):
    """Whether a move goes straight down."""
    return tip[2] < before[2] and math.hypot(tip[0] - before[0], tip[1] - before[1]) < 1e-6


def rapid_to(tip):
    """A rapid move."""
    return Path.Command("G0", {"X": tip[0], "Y": tip[1], "Z": tip[2]})


def cut_to(tip, rate_mm_min):
    """A move at a feed rate. FreeCAD's paths hold millimetres per second; post-processors write millimetres per minute."""
    return Path.Command("G1", {"X": tip[0], "Y": tip[1], "Z": tip[2], "F": rate_mm_min / SECONDS_PER_MINUTE})


def add_path(path, name):
    """A Path object of the active document."""
    feature = FreeCAD.ActiveDocument.addObject("Path::Feature", name)
    feature.Path = path
    FreeCAD.ActiveDocument.recompute()
    return feature


def gcode(feature, file_name="-", post="linuxcnc"):
    """G-code of a Path object by one of FreeCAD's post-processors, also written to a file where one is named."""
    try:
        processor = importlib.import_module(f"Path.Post.scripts.{post}_post")  # FreeCAD 0.21 and later
    except ImportError:
        processor = importlib.import_module(f"PathScripts.post.{post}_post")
    return processor.export([feature], file_name, "--no-show-editor --no-header")


# Feeds for an existing path


def contact_frame(face, u, v):
    """Normal, upwards, and principal curvatures with their directions, convex positive.

    The kernel counts a curvature positive where the centre lies on the side of the surface's own normal. Where the face has the
    surface's orientation, that is outside the part; the service counts it positive where the centre lies inside the part.
    """
    surface, normal = face.Surface, face.normalAt(u, v)
    sign = -1.0 if normal.dot(surface.normal(u, v)) > 0 else 1.0
    if normal.z < 0:  # A face of an open shell may point down; the tool is above.
        normal, sign = -normal, -sign
    values = [sign * surface.curvature(u, v, kind) for kind in ("Max", "Min")]
    try:
        directions = surface.curvatureDirections(u, v)
    except Part.OCCError:  # At an umbilic every direction is principal.
        first = normal.cross(FreeCAD.Vector(1, 0, 0) if abs(normal.x) < 0.9 else FreeCAD.Vector(0, 1, 0)).normalize()
        directions = (first, normal.cross(first))
    return normal, values, directions


def curvature_along(normal, values, directions, feed):
    """Curvature in the axes of the feed: along F, across T = n x F, and the twist between them; None for a feed along the normal."""
    along = feed - normal * feed.dot(normal)
    if along.Length < 1e-9 * max(feed.Length, 1e-9):
        return None
    along.normalize()
    across = normal.cross(along)
    parts = [(value, direction.dot(along), direction.dot(across)) for value, direction in zip(values, directions)]
    return {
        "along_per_mm": sum(value * f * f for value, f, _ in parts),
        "across_per_mm": sum(value * t * t for value, _, t in parts),
        "twist_per_mm": sum(value * f * t for value, f, t in parts),
    }


def upward_normal(face, u, v):
    """The unit normal on the tool's side."""
    normal = face.normalAt(u, v)
    return -normal if normal.z < 0 else normal


def contact_of(faces, tip, cutter, gap_mm, start=None):
    """The contact of a cutter with its tip at `tip`: face, u and v; None if it is more than `gap_mm` off the faces.

    `start` is a contact nearby, such as that of the move before, where the search begins.
    """
    radius = cutter["diameter_mm"] / 2
    corner = {"ball_end": radius, "flat_end": 0.0}.get(cutter["type"], cutter.get("corner_radius_mm", 0.0))

    def miss(face, u, v):
        """The tip of a cutter that touches the face at (u, v), less the required tip."""
        normal = upward_normal(face, u, v)
        level = math.hypot(normal.x, normal.y)
        ring = FreeCAD.Vector() if level < 1e-9 else FreeCAD.Vector(normal.x, normal.y, 0) * ((radius - corner) / level)
        return face.valueAt(u, v) + normal * corner + ring - FreeCAD.Vector(0, 0, corner) - tip

    below = nearest_on(faces, tip + FreeCAD.Vector(0, 0, corner))
    for guess in (start, below and below[:3]):
        found = guess and solve_contact(miss, *guess)
        if found and found[0].isPartOfDomain(*found[1:]) and miss(*found).Length <= gap_mm:
            return found
    # On a floor the flat of the cutter touches, wherever its corner is.
    return below[:3] if below and abs(below[3] - corner) <= gap_mm else None


def solve_contact(miss, face, u, v):
    """The contact near (u, v) whose cutter has the right tip seen from above, by Newton's method; None where it does not converge."""
    first, last, low, high = face.Surface.bounds()
    here = miss(face, u, v)
    for _ in range(30):
        if math.hypot(here.x, here.y) < 1e-7:
            return face, u, v
        # Backwards at the upper ends of the parameters.
        step_u, step_v = 1e-6 if u + 1e-6 <= last else -1e-6, 1e-6 if v + 1e-6 <= high else -1e-6
        by_u, by_v = (miss(face, u + step_u, v) - here) * (1 / step_u), (miss(face, u, v + step_v) - here) * (1 / step_v)
        determinant = by_u.x * by_v.y - by_v.x * by_u.y
        if abs(determinant) < 1e-12:
            return None
        du, dv = (here.x * by_v.y - by_v.x * here.y) / determinant, (by_u.x * here.y - here.x * by_u.y) / determinant
        # Near a floor, the corner's position changes quickly with the normal, so a step that increases the miss is shortened.
        for share in (1, 0.5, 0.25, 0.125, 0.0625):
            next_u, next_v = min(max(u - share * du, first), last), min(max(v - share * dv, low), high)
            there = miss(face, next_u, next_v)
            if math.hypot(there.x, there.y) < math.hypot(here.x, here.y):
                break
        else:
            return None
        u, v, here = next_u, next_v, there
    return None


def nearest_on(faces, point):
    """Face, u, v and distance of the nearest point inside a face."""
    best = None
    for face in faces:
        u, v = face.Surface.parameter(point)
        if face.isPartOfDomain(u, v):
            distance = face.valueAt(u, v).distanceToPoint(point)
            if best is None or distance < best[3]:
                best = (face, u, v, distance)
    return best


def contacts_of_path(path, faces, cutter, gap_mm=0.05):
    """The straight cutting moves of a path that end in contact with the faces: their numbers in the path, and their contacts as columns."""
    moves, columns = [], {"normal": [], "feed": [], "surface_curvature": {"along_per_mm": [], "across_per_mm": [], "twist_per_mm": []}}
    position = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    contact = None
    for index, command in enumerate(path.Commands):
        before = FreeCAD.Vector(*(position[axis] for axis in "XYZ"))
        position.update({axis: command.Parameters[axis] for axis in "XYZ" if axis in command.Parameters})
        tip = FreeCAD.Vector(*(position[axis] for axis in "XYZ"))
        if command.Name not in ("G1", "G01") or (tip - before).Length < 1e-9:
            continue
        contact = contact_of(faces, tip, cutter, gap_mm, contact)
        if contact is None:
            continue
        normal, values, directions = contact_frame(*contact)
        curvature = curvature_along(normal, values, directions, tip - before)
        if curvature is None:
            continue
        moves.append(index)
        columns["normal"].append(normal)
        columns["feed"].append(tip - before)
        for name, value in curvature.items():
            columns["surface_curvature"][name].append(value)
    return moves, columns


def path_with_feeds(client, path, faces, cutter, scallop_tolerance_mm, **parameters):
    """The path with the largest feeds that keep the tolerance, the number of moves that got one, and the failures by move.

    `cutter` is one of those that are ranked; its spindle speed and largest feed per tooth count unless `parameters` state others.
    `parameters` are those of `Client.max_feed_batch`: a step-over, limits of the feed.

    Moves off the faces, moves along the normal and those without an answer keep their feed.
    """
    moves, columns = contacts_of_path(path, faces, cutter)
    if not moves:
        return path, 0, []
    shape = {name: cutter[name] for name in ("type", "diameter_mm", "corner_radius_mm", "teeth") if name in cutter}
    limits = {name: cutter[name] for name in ("spindle_speed_rpm", "max_feed_per_tooth_mm") if name in cutter}
    answer = client.max_feed_batch(shape, columns, scallop_tolerance_mm, **{"model": "envelope", **limits, **parameters})
    rates = dict(zip(moves, answer["feed_rate_mm_min"]))
    commands = path.Commands
    for move, rate in rates.items():
        if rate is not None:
            # The tolerance must hold at both ends of a move; where the move before ends off the faces, at this end.
            before = rates.get(move - 1)
            rate = rate if before is None else min(rate, before)
            commands[move] = Path.Command("G1", {**commands[move].Parameters, "F": rate / SECONDS_PER_MINUTE})
    # The service names the first thousand failures.
    failures = [{**failure, "move": moves[failure["index"]]} for failure in answer["failures"]]
    changed = sum(rate is not None for rate in rates.values())
    return Path.Path(commands), changed, failures


# The check of a path


def path_checked(client, path, faces, cutter, scallop_tolerance_mm, machine, beside=(), **parameters):
    """What the path leaves on the faces, and the path with the largest feeds that keep the scallop height with tooth marks. Cuts into the
    faces `beside` them are found too.

    The answer is that of `Client.check_path`; the `line` of a place is the number of the path's command, from 1. A cutter without
    teeth and spindle speed has no feeds: the path is then returned as it is.
    """
    surface = {"mesh": mesh_of(faces, scallop_tolerance_mm / 4)}
    if beside:
        parameters["avoid"] = {"mesh": mesh_of(beside, scallop_tolerance_mm / 4)}
    program = "\n".join(block_of(command) for command in path.Commands)
    has_teeth = {"teeth", "spindle_speed_rpm"} <= set(cutter)
    include = ["places", "feeds"] if has_teeth else ["places"]
    answer = client.check_path(surface, {"program": program}, cutter, scallop_tolerance_mm, machine, include=include, **parameters)
    if not has_teeth:
        return answer, path
    # The points of an arc's chords have one line; the least of their feeds holds for the command.
    rates = {}
    for line, rate in zip(answer["feeds"]["line"], answer["feeds"]["feed_rate_mm_min"]):
        if rate is not None:
            rates[line] = min(rate, rates.get(line, rate))
    commands = path.Commands
    for line, rate in rates.items():
        command = commands[line - 1]
        commands[line - 1] = Path.Command(command.Name, {**command.Parameters, "F": rate / SECONDS_PER_MINUTE})
    return answer, Path.Path(commands)


def block_of(command):
    """A command as a block of a program, in mm and minutes."""
    if command.Name.startswith("("):
        return command.Name
    words = [f"{name}{value * SECONDS_PER_MINUTE if name == 'F' else value:.6f}" for name, value in command.Parameters.items()]
    return " ".join([command.Name, *words])
