#!/usr/bin/env python3
"""The processor time that a server spends on a request after its client has left, for the largest requests that are accepted.

    cargo build --release && python3 tests/soak/leave.py target/release/scallopd

For each kind of request it measures how long the whole request takes, then repeats the request and leaves at random moments of that
time: by a reset of the connection, or by closing it. It prints the median and the largest processor time of all threads after the
client has left, and fails where the largest exceeds `--most-ms`. `--only KIND` measures one kind. It needs Linux and Python's standard library.
"""

import argparse
import os
import random
import select
import socket
import struct
import sys
import time

import attacks

CUTTERS = [{"type": "toroidal", "diameter_mm": 4 + 0.1 * i, "corner_radius_mm": 1} for i in range(200)]


def json_points(count):
    """Points of waves in random order."""
    chance = random.Random(1)
    points = [(100 * chance.random(), 100 * chance.random()) for _ in range(count)]
    text = ",".join(f"[{x:.3f},{y:.3f},{5 + x / 20 - y / 30:.3f}]" for x, y in points)
    return json_surface('{"points":[' + text + "]}")


def json_surface(surface, **changed):
    body = attacks.json.dumps({**attacks.JOB, **changed})[:-1] + ',"surface":' + surface + "}"
    return attacks.post("/v1/cutter-recommendation", body.encode())


def json_mesh():
    """A grid of a quarter of a million points with as many facets as are held."""
    side = 500
    points = ",".join(f"[{x / 5},{y / 5},{(x * x + y * y) / 25000:.4f}]" for y in range(side) for x in range(side))
    cells = ((y * side + x, y * side + x + 1, (y + 1) * side + x) for y in range(side - 1) for x in range(side - 1))
    triangles = ",".join(f"[{a},{b},{c}],[{b},{c + 1},{c}]" for a, b, c in cells)
    return json_surface('{"mesh":{"points":[' + points + '],"triangles":[' + triangles + "]}}", include=["map", "passes"])


def large_json_mesh():
    """Sixty MB of points and triangles in the shortest notation."""
    points, triangles = ",".join(["[1,1,1]"] * 3_500_000), ",".join(["[0,1,2]"] * 4_000_000)
    return json_surface('{"mesh":{"points":[[0,0,0],[9,0,0],[0,9,0],' + points + '],"triangles":[[0,1,2],' + triangles + "]}}")


def patch():
    net = [[[x, y, (x * y) % 7] for x in (0, 20, 40, 60)] for y in (0, 20, 40, 60)]
    return json_surface(attacks.json.dumps({"bezier": {"control_points": net}, "samples": 1000}))


def text_file():
    """A scan of three million points in lines of text."""
    lines = "".join(f"{x / 17.32:.4f},{y / 17.32:.4f},{5 + x * y / 1e6:.4f}\n" for y in range(1732) for x in range(1732))
    return attacks.plain_upload(lines.encode(), "scan.csv")


def library():
    """As many tools in JSON as a library file holds, in a zip, beside a small surface."""
    tool = {
        "type": "ball end mill", "unit": "millimeters", "description": "B", "geometry": {"DC": 6.0, "NOF": 2, "LCF": 20.0},
        "start-values": {"presets": [{"name": "finish", "n": 12000, "f_z": 0.05}]}, "holder": {"segments": [{"height": 1.5}] * 80},
    }
    tools = attacks.json.dumps({"data": [tool] * 9_999}).encode()
    packed = attacks.io.BytesIO()
    with attacks.zipfile.ZipFile(packed, "w", attacks.zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("mills.json", tools)
    parts = [("library", "mills.zip", packed.getvalue()), ("library", "mills.json", tools[:1 << 24])]
    return attacks.form([*parts, ("parameters", "p.json", attacks.json.dumps({**attacks.JOB, "cutters": []}).encode())], compressed=False)


def many_cutters(**changed):
    """Two hundred cutters on fifty thousand facets."""
    return attacks.plain_upload(attacks.binary_stl(160), cutters=CUTTERS, **changed)


def batch(model, in_columns):
    """A quarter of a million different contacts as rows or as columns."""
    chance = random.Random(2)
    slopes, feeds = ([round(most * chance.random(), 6) for _ in range(250_000)] for most in (80, 360))
    rows = [{"slope_deg": 5 + slope, "feed_angle_deg": feed} for slope, feed in zip(slopes, feeds)]
    contacts = {"slope_deg": [row["slope_deg"] for row in rows], "feed_angle_deg": feeds} if in_columns else rows
    shared = {"cutter": attacks.CUTTER, "model": model, "step_over_mm": 0.5, "feed_per_tooth_mm": 0.1}
    return attacks.post("/v1/scallop-height/batch", {**shared, "contacts": contacts})


KINDS = {
    "JSON, 250,000 points": lambda: json_points(250_000),
    "JSON, 2,500,000 points": lambda: json_points(2_500_000),
    "JSON, mesh of 498,000 facets, map and passes": json_mesh,
    "JSON, mesh of 60 MB": large_json_mesh,
    "JSON, patch of a million samples": patch,
    "STL, 498,000 facets apart, map and passes": lambda: attacks.plain_upload(attacks.binary_stl(499, apart=0.01), include=["map", "passes"]),
    "STL, 2,000,000 facets": lambda: attacks.plain_upload(attacks.binary_stl(1000)),
    "CSV, 3,000,000 points": text_file,
    "3MF, 4,000,000 vertices": attacks.package_upload,
    "tool libraries of 16 MB": library,
    "200 cutters": many_cutters,
    "200 cutters, method rectangle": lambda: many_cutters(method="rectangle"),
    "batch of 250,000 rows": lambda: batch("analytic", False),
    "batch of 250,000 rows, envelope": lambda: batch("envelope", False),
    "batch of 250,000 contacts as columns, envelope": lambda: batch("envelope", True),
    "batch of 250,000 expensive contacts": lambda: attacks.expensive_batch(250_000),
}

# A longer request is not awaited; clients leave within this time.
LONGEST_S = 20


def processor_time(server):
    """The processor time of all threads, in s, to a nanosecond: the kernel's number for the clock of another process."""
    return time.clock_gettime((~server.process.pid << 3) | 2)


def idle_rate(server):
    """The processor time that the server takes in a second at rest."""
    began = processor_time(server)
    time.sleep(1)
    return processor_time(server) - began


def until_idle(server, longest=20):
    """Waits until the server takes no processor time, and returns the time at the end and the processor time."""
    deadline = time.monotonic() + longest
    last, quiet = processor_time(server), 0
    while quiet < 4 and time.monotonic() < deadline:
        time.sleep(0.02)
        now = processor_time(server)
        quiet, last = quiet + 1 if now - last < 0.001 else 0, now
    return time.monotonic(), last


def begin(server, message, seconds):
    """Sends for so long; returns the connection, and whether the answer has come."""
    stream = attacks.connect(server.address)
    stream.setblocking(False)
    deadline, sent, view = time.monotonic() + seconds, 0, memoryview(message)
    while (left := deadline - time.monotonic()) > 0:
        readable, writable, _ = select.select([stream], [stream] if sent < len(message) else [], [], left)
        if readable:
            return stream, True
        if writable:
            sent += stream.send(view[sent : sent + (1 << 18)])
    return stream, False


def leave(server, stream, way, idle):
    """The processor time after the client has left, in ms, without that of an idle server."""
    before, began = processor_time(server), time.monotonic()
    if way == "reset":
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    stream.close()
    ended, after = until_idle(server)
    return 1000 * max(0.0, after - before - idle * (ended - began))


def duration(server, message):
    """The time from the first byte to the answer, and its status."""
    began = time.monotonic()
    stream, is_answered = begin(server, message, LONGEST_S)
    took = time.monotonic() - began
    if not is_answered:
        stream.close()
        until_idle(server)
        return took, "not awaited"
    stream.setblocking(True)
    status = attacks.read_answer(stream)[0]
    stream.close()
    until_idle(server)
    return took, status


def measure(program, kind, ways, count):
    """Prints the rows of a kind, and returns the largest time."""
    message = KINDS[kind]()
    server = attacks.Server(program, SCALLOPD_REQUEST_TIMEOUT_S="300")
    worst = 0.0
    try:
        took, status = duration(server, message)
        idle = idle_rate(server)
        for way in ways:
            chance, found = random.Random(kind), []
            while len(found) < count:
                moment = took * chance.random()
                stream, is_answered = begin(server, message, moment)
                if is_answered:
                    stream.close()
                    until_idle(server)
                    took *= 0.97
                    continue
                found.append((leave(server, stream, way, idle), moment))
            found.sort()
            (most, at), median = found[-1], found[len(found) // 2][0]
            worst = max(worst, most)
            print(f"| {kind} | {len(message) / 1e6:.1f} | {took:.2f} | {status} | {way} | {median:.0f} | {most:.0f} | {at:.2f} |", flush=True)
    finally:
        server.stop()
    return worst


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", help="the server's executable")
    arguments.add_argument("--only", action="append", choices=KINDS, help="one kind; may be repeated")
    arguments.add_argument("--way", action="append", choices=["reset", "close"], help="one way of leaving")
    arguments.add_argument("--count", type=int, default=50, help="requests of each kind and way")
    arguments.add_argument("--most-ms", type=float, default=50)
    given = arguments.parse_args()
    print("| request | MB | whole, s | status | the client leaves by | median, ms | largest, ms | left after, s |")
    print("|---|---|---|---|---|---|---|---|")
    worst = max(measure(given.program, kind, given.way or ["reset", "close"], given.count) for kind in given.only or KINDS)
    print(f"\n{os.cpu_count()} processors, {time.strftime('%Y-%m-%d')}; load average {os.getloadavg()[0]:.1f}")
    sys.exit(worst > given.most_ms)


if __name__ == "__main__":
    main()
