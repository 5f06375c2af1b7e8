#!/usr/bin/env python3
"""Hostile requests, each against its own server, and the resources that they take.

    cargo build --release && python3 tests/soak/attacks.py target/release/scallopd

For each attack it prints the peak memory, the processor time, the longest times of probes, single calculations and short batches of
other clients meanwhile, and the statuses that the attacker got. It fails where the peak exceeds 1 GiB, where another client waits
longer than 150 ms or is refused other than by a 503 with Retry-After, or where a status is unexpected.
`--only NAME` runs one attack. It needs Linux and Python's standard library.
"""

import argparse
import collections
import gzip
import io
import json
import math
import multiprocessing
import os
import pathlib
import platform
import re
import resource
import socket
import struct
import subprocess
import sys
import threading
import time
import zipfile

MOST_MIB = 1024
LONGEST_MS = 150
CUTTER = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}
HEIGHT = {"cutter": CUTTER, "contact": {"slope_deg": 40, "feed_angle_deg": 30}, "step_over_mm": 0.687, "feed_per_tooth_mm": 0.1}
SHORT_BATCH = {"cutter": CUTTER, "step_over_mm": 0.5, "contacts": [{"slope_deg": 5 + i, "feed_angle_deg": 30} for i in range(50)]}
JOB = {
    "cutters": [{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, {"type": "ball_end", "diameter_mm": 10}],
    "scallop_height_mm": 0.01,
    "machine": {"preset": "five_axis_vmc"},
}
SLOPE = {"mesh": {"points": [[0, 0, 0], [90, 0, 9], [0, 90, 0], [90, 90, 9]], "triangles": [[0, 1, 2], [1, 3, 2]]}}
UPLOAD = "/v1/cutter-recommendation/upload"
BOUNDARY = "edge"


def head(path, length=None, media_type="application/json", encoding=None, method="POST", accept=None):
    lines = [f"{method} {path} HTTP/1.1", "host: attack"]
    if accept:
        lines.append(f"accept-encoding: {accept}")
    if length is not None:
        lines += [f"content-type: {media_type}", f"content-length: {length}"]
    if encoding:
        lines.append(f"content-encoding: {encoding}")
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def post(path, value, compressed=False, accept=None):
    body = value if isinstance(value, bytes) else json.dumps(value).encode()
    body = gzip.compress(body, 6) if compressed else body
    return head(path, len(body), encoding="gzip" if compressed else None, accept=accept) + body


def form(parts, compressed=True, path=UPLOAD):
    """An upload of parts given as (name, file name, bytes)."""
    body = b"".join(
        f'--{BOUNDARY}\r\ncontent-disposition: form-data; name="{name}"; filename="{file}"\r\n\r\n'.encode() + data + b"\r\n"
        for name, file, data in parts
    )
    body += f"--{BOUNDARY}--\r\n".encode()
    body = gzip.compress(body, 6) if compressed else body
    return head(path, len(body), f"multipart/form-data; boundary={BOUNDARY}", "gzip" if compressed else None) + body


def surface(name, data):
    return form([("parameters", "p.json", json.dumps(JOB).encode()), ("surface", name, data)])


def connect(address, timeout=120):
    stream = socket.create_connection(address, timeout=timeout)
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return stream


def read_answer(stream):
    """The status and the length of an answer, read to its end."""
    answer = b""
    while b"\r\n\r\n" not in answer:
        data = stream.recv(1 << 16)
        if not data:
            return "closed", 0, False
        answer += data
    first, rest = answer.split(b"\r\n\r\n", 1)
    length = re.search(rb"\r\ncontent-length: (\d+)", first.lower())
    got = len(rest)
    while length and got < int(length[1]):
        data = stream.recv(1 << 18)
        if not data:
            break
        got += len(data)
    return int(first[9:12]), got, b"\r\nretry-after:" in first.lower()


def exchange(address, message, timeout=120):
    """Sends a request on a new connection; returns the status, or the fate of the connection."""
    try:
        with connect(address, timeout) as stream:
            try:
                stream.sendall(message)
            except OSError:
                pass
            return status_of(stream)
    except OSError as error:
        return type(error).__name__


def status_of(stream):
    """The status of an answer; a 503 must state when to come again."""
    status, _, retry = read_answer(stream)
    return "503 without Retry-After" if status == 503 and not retry else status


def side_by_side(count, run):
    """The results of `run(index)` in as many threads."""
    results = [None] * count

    def work(index):
        results[index] = run(index)

    threads = [threading.Thread(target=work, args=(index,), daemon=True) for index in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


# The attacks. Each takes the server's address and returns what the attacker got.


def part_flood(address, parts=4_000_000):
    return [exchange(address, flood_of_parts(parts))]


def two_part_floods(address):
    message = flood_of_parts(12_000_000)
    return side_by_side(2, lambda _: exchange(address, message))


def flood_of_parts(parts):
    body = gzip.compress(b"".join([b"--edge\r\n\r\n\r\n" * parts, b"--edge--\r\n"]), 6)
    return head(UPLOAD, len(body), "multipart/form-data; boundary=edge", "gzip") + body


def member_flood(address, contacts=4096):
    contact = {f"m{i}": 0 for i in range(256)}
    return [exchange(address, post("/v1/scallop-height/batch", {**SHORT_BATCH, "contacts": [contact] * contacts}, True))]


def large_member_flood(address):
    return member_flood(address, 20_000)


def vertex_flood():
    count = 20_000_000
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    data = header.encode() + bytes(12 * count) + struct.pack("<Biii", 3, 0, 1, 2)
    return surface("part.ply", data)


def vertex_flood_ply(address, copies=1):
    message = vertex_flood()
    return side_by_side(copies, lambda _: exchange(address, message))


def trickled_vertex_floods(address):
    """Four floods of vertices whose last bytes come at 200 bytes a second."""
    message = vertex_flood()

    def trickle(_):
        try:
            with connect(address) as stream:
                try:
                    stream.sendall(message[:-2000])
                    for start in range(len(message) - 2000, len(message), 20):
                        stream.sendall(message[start : start + 20])
                        time.sleep(0.1)
                except OSError:
                    # The answer may have come before.
                    pass
                return status_of(stream)
        except OSError as error:
            return type(error).__name__

    return side_by_side(4, trickle)


def vertex_flood_obj(address):
    return [exchange(address, surface("part.obj", b"v 0 0 0\n" * 20_000_000 + b"f 1 2 3\n"))]


def four_vertex_floods(address):
    return vertex_flood_ply(address, 4)


def binary_stl(side, apart=0.0):
    """Two facets for each of side x side cells of waves over 100 x 100 mm; with `apart` no two share a corner."""
    step = 100 / side
    facet = struct.Struct("<12x9f2x").pack
    columns = [(i * step, i * step + step * (1 - apart)) for i in range(side)]
    heights = [tuple(6 * math.sin(0.1 * x) for x in column) for column in columns]
    parts = [bytes(80), struct.pack("<I", 2 * side * side)]
    for low, high in columns:
        from_low, from_high = math.cos(0.12 * low), math.cos(0.12 * high)
        for (left, right), (on_left, on_right) in zip(columns, heights):
            a, b = (left, low, on_left * from_low), (right, low, on_right * from_low)
            c, d = (right, high, on_right * from_high), (left, high, on_left * from_high)
            parts.append(facet(*a, *b, *c))
            parts.append(facet(*(a if not apart else (left, low + step * apart, a[2])), *c, *d))
    return b"".join(parts)


def plain_upload(data, name="part.stl", **changed):
    job = json.dumps({**JOB, **changed}).encode()
    return form([("parameters", "p.json", job), ("surface", name, data)], compressed=False)


def until_answered(address, message, attempts=300):
    """The statuses of a request that is repeated a second after each 503. The last one must be 200."""
    statuses = []
    while len(statuses) < attempts:
        statuses.append(exchange(address, message, 600))
        if statuses[-1] != 503:
            return statuses
        time.sleep(1)
    return [*statuses, "given up"]


def uploads(address, count, message):
    return [status for statuses in side_by_side(count, lambda _: until_answered(address, message)) for status in statuses]


def beside_recommendations(address, count, message):
    """Uploads beside four clients that want recommendations from JSON; all repeat until they are answered."""
    recommendations = lambda _: uploads(address, 4, post("/v1/cutter-recommendation", {**JOB, "surface": SLOPE, "include": ["map", "passes"]}))
    got = side_by_side(2, lambda index: recommendations(index) if index else uploads(address, count, message))
    return [status for statuses in got for status in statuses]


def sixteen_uploads(address):
    return beside_recommendations(address, 16, plain_upload(binary_stl(1000), directions_deg=[0]))


def sixty_four_uploads(address):
    return beside_recommendations(address, 64, plain_upload(binary_stl(447), directions_deg=[0]))


def separate_facets(address):
    return uploads(address, 4, plain_upload(binary_stl(499, apart=0.01), directions_deg=[0], include=["map", "passes"]))


def ordinary_batches(address):
    """Four clients with the longest batches that are taken."""
    return uploads(address, 4, post("/v1/scallop-height/batch", {**columns(250_000), "significant_digits": 6}, True))


def columns(contacts):
    """A batch of as many contacts, with rounded columns."""
    contacts = {"slope_deg": [5 + i % 60 for i in range(contacts)], "feed_angle_deg": [i % 180 for i in range(contacts)]}
    return {"cutter": CUTTER, "step_over_mm": 0.5, "feed_per_tooth_mm": 0.1, "contacts": contacts}


def compressed_answers(address):
    """Two clients that want the longest answers compressed, as Python's requests does by default, four times each."""
    message = post("/v1/scallop-height/batch", columns(250_000), accept="gzip, deflate")
    return [status for _ in range(4) for status in uploads(address, 2, message)]


def mixed_jobs(address):
    """24 clients that want plans of 12,000 facets with map and passes, and 52 batches of 100,000 contacts."""
    plan = plain_upload(binary_stl(77), include=["map", "passes"])
    batch = post("/v1/scallop-height/batch", columns(100_000))
    got = side_by_side(2, lambda index: uploads(address, *((24, plan), (52, batch))[index]))
    return [status for statuses in got for status in statuses]


def many_planes(address):
    """Two hundred cutters with up to 50,000 planes each over two facets, of sixteen clients."""
    cutters = [{"type": "ball_end", "diameter_mm": 0.85 + 0.0001 * i} for i in range(200)]
    message = post("/v1/cutter-recommendation", {**JOB, "cutters": cutters, "scallop_height_mm": 1e-6, "surface": SLOPE, "include": ["passes"]})
    return side_by_side(16, lambda _: exchange(address, message))


def comb(address):
    """Two thousand strips side by side, each a run of its own in every plane."""
    points, triangles = [], []
    for strip in range(2000):
        x, first = 0.2 * strip, 4 * strip
        points += [[x, 0, 0.1 * x], [x + 0.05, 0, 0.1 * x], [x, 90, 9], [x + 0.05, 90, 9]]
        triangles += [[first, first + 1, first + 2], [first + 1, first + 3, first + 2]]
    job = {**JOB, "cutters": [{"type": "ball_end", "diameter_mm": 0.1}], "scallop_height_mm": 1e-5, "directions_deg": [0]}
    message = post("/v1/cutter-recommendation", {**job, "surface": {"mesh": {"points": points, "triangles": triangles}}})
    return side_by_side(4, lambda _: exchange(address, message))


def fine_patches(address):
    net = [[[x, y, (x * y) % 7] for x in (0, 20, 40, 60)] for y in (0, 20, 40, 60)]
    message = post("/v1/cutter-recommendation", {**JOB, "directions_deg": [0], "surface": {"bezier": {"control_points": net}, "samples": 1000}})
    return side_by_side(16, lambda _: exchange(address, message))


def circles(address):
    """Checks of paths in short programs, in files and in JSON, whose arcs become 770,000 chords each."""
    program = "G21 G90\nG0 X75 Y50 Z20\nG1 Z10 F1000\n" + "G2 I-25 J0\n" * 690
    job = {"cutter": CUTTER, "machine": JOB["machine"], "scallop_tolerance_mm": 0.01}
    parts = [("parameters", "p.json", json.dumps(job).encode()), ("surface", "part.stl", binary_stl(40)), ("path", "path.nc", program.encode())]
    file = form(parts, compressed=False, path="/v1/path-check/upload")
    text = post("/v1/path-check", {**job, "surface": SLOPE, "path": {"program": program}})
    return side_by_side(16, lambda index: exchange(address, (file, text)[index % 2]))


def large_json_mesh(address):
    """Sixty MB of points and triangles in the shortest notation."""
    body = json.dumps({**JOB, "directions_deg": [0]})[:-1].encode() + b',"surface":{"mesh":{"points":[[0,0,0],[9,0,0],[0,9,0]'
    body += b",[1,1,1]" * 3_500_000 + b'],"triangles":[[0,1,2]' + b",[0,1,2]" * 4_000_000 + b"]}}}"
    return side_by_side(4, lambda _: exchange(address, post("/v1/cutter-recommendation", body)))


def not_finite(address):
    body = b'{"contacts":[' + b"NaN," * (16 << 20) + b"NaN]}"
    return side_by_side(4, lambda _: exchange(address, post("/v1/max-feed/batch", body[: 64 << 20] if len(body) > 64 << 20 else body, True)))


def large_bodies_left(address):
    """Clients that send 64 MB of points and close the connection while they are read."""
    body = json.dumps(JOB)[:-1].encode() + b',"surface":{"points":[[0,0,0]' + b",[1,2,3]" * 8_000_000 + b"]}}"
    message = post("/v1/cutter-recommendation", body)
    for _ in range(8):
        stream = connect(address)
        stream.sendall(message)
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        stream.close()
    return ["left"] * 8


def package_upload():
    """A 3MF file with as many vertices as are read, and twice as many triangles."""
    vertices = b"".join(b'<vertex x="%d" y="%d" z="1"/>' % (i % 100, i // 100) for i in range(10_000)) * 399
    triangles = b"".join(b'<triangle v1="%d" v2="%d" v3="%d"/>' % (i, i + 1, i + 100) for i in range(9_800)) * 400
    model = (
        b'<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        b'<object id="1" type="model"><mesh><vertices>' + vertices + b"</vertices><triangles>" + triangles + triangles
        + b'</triangles></mesh></object></resources><build><item objectid="1"/></build></model>'
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        archive.writestr("3D/3dmodel.model", model)
    return plain_upload(file.getvalue(), "part.3mf", directions_deg=[0])


def package(address):
    return uploads(address, 2, package_upload())


def expensive_batch(contacts):
    """Contacts for which the search of the exact cutter's step-over takes longest of those known: about a millisecond each."""
    contact = {"slope_deg": 0.001, "feed_angle_deg": 0, "surface_radius_mm": 1}
    cutter = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 0.01}
    batch = {"cutter": cutter, "model": "envelope", "runout": {"radial_mm": 0.02, "axial_mm": 0.02}, "scallop_tolerance_mm": 0.02}
    return post("/v1/step-over/batch", {**batch, "feed_per_tooth_mm": 0.3, "contacts": [contact] * contacts}, True)


def expensive_contacts(address):
    return [exchange(address, expensive_batch(4096))]


def expensive_batches_left(address):
    """Clients that abandon expensive batches: the processor must be idle soon after."""
    message = expensive_batch(250_000)
    for _ in range(16):
        stream = connect(address)
        stream.sendall(message)
        time.sleep(0.05)
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        stream.close()
    time.sleep(3)
    return ["left"] * 16


def expensive_batches(address):
    message = expensive_batch(250_000)
    return side_by_side(4, lambda _: exchange(address, message))


def unread_answers(address):
    contacts = [{"slope_deg": 5 + i % 60, "feed_angle_deg": i % 180} for i in range(250_000)]
    message = post("/v1/max-feed/batch", {"cutter": CUTTER, "step_over_mm": 0.5, "scallop_tolerance_mm": 0.02, "contacts": contacts}, True)

    def leave_unread(_):
        try:
            with connect(address) as stream:
                stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                stream.sendall(message)
                first = stream.recv(12)
                time.sleep(10)
                return int(first[9:12]) if first else "closed"
        except OSError as error:
            return type(error).__name__

    return side_by_side(24, leave_unread)


def unfinished_heads(address):
    streams = []
    for _ in range(2150):
        stream = connect(address)
        try:
            stream.sendall(b"GET /livez HTTP/1.1\r\nhost: attack\r\nx: " + b"x" * 415_000)
        except OSError:
            pass
        streams.append(stream)
    time.sleep(2)
    results = []
    for stream in streams:
        stream.settimeout(0.2)
        try:
            results.append(read_answer(stream)[0])
        except OSError as error:
            results.append(type(error).__name__)
        stream.close()
    return results


def heads_without_bodies(address):
    streams = [connect(address) for _ in range(64)]
    for stream in streams:
        stream.sendall(head("/v1/max-feed/batch", 1_000_000))
    results = [read_answer(stream)[0] for stream in streams]
    for stream in streams:
        stream.close()
    return results


def trickled_bodies(address):
    streams = [connect(address) for _ in range(64)]
    for stream in streams:
        stream.sendall(head("/v1/max-feed/batch", 1_000_000))
    for _ in range(100):
        for stream in streams:
            try:
                stream.sendall(b" " * 110)
            except OSError:
                pass
        time.sleep(0.1)
    for stream in streams:
        stream.close()
    return ["left"] * len(streams)


def one_byte_chunks(address):
    message = b"POST /v1/max-feed/batch HTTP/1.1\r\nhost: attack\r\ncontent-type: application/json\r\ntransfer-encoding: chunked\r\n\r\n"
    return [exchange(address, message + b"1\r\n \r\n" * (16 << 20) + b"0\r\n\r\n")]


def idle_connections(address):
    streams = [connect(address) for _ in range(4000)]
    time.sleep(8)
    for stream in streams:
        stream.close()
    return ["idle"] * len(streams)


def full_budget(address):
    """As many connections as may be open, and beside them all that fills the memory budget."""
    parts = [separate_facets, unread_answers, four_vertex_floods, many_planes]
    idle = [connect(address) for _ in range(3900)]
    got = side_by_side(len(parts), lambda index: parts[index](address))
    for stream in idle:
        stream.close()
    return [status for statuses in got for status in statuses]


ATTACKS = {
    "4 million empty parts": (part_flood, {400}),
    "two of 12 million": (two_part_floods, {400}),
    "4096 contacts of 256 unknown members": (member_flood, {200, 422}),
    "20,000 of them": (large_member_flood, {200, 413, 422}),
    "PLY of 2e7 vertices": (vertex_flood_ply, {408, 413}),
    "OBJ of 2e7 vertices": (vertex_flood_obj, {408, 413}),
    "four PLY of 2e7 vertices": (four_vertex_floods, {408, 413, 503}),
    "four PLY that trickle": (trickled_vertex_floods, {408, 413, 503, "ConnectionResetError"}),
    "4096 expensive contacts": (expensive_contacts, {200, 408}),
    "4 x 250,000 expensive contacts": (expensive_batches, {200, 408, 503}),
    "16 x 250,000, client leaves": (expensive_batches_left, {"left"}),
    "24 batches, answers unread": (unread_answers, {200, 408, 503}),
    "2150 heads of 415 KB": (unfinished_heads, {431, "closed", "ConnectionResetError", "TimeoutError"}),
    "64 heads without bodies": (heads_without_bodies, {408, 503}),
    "64 bodies at 1.1 kB/s": (trickled_bodies, {"left"}),
    "16 MiB in one-byte chunks": (one_byte_chunks, {400, 408}),
    "4000 idle connections": (idle_connections, {"idle"}),
    "3900 idle connections beside a full budget": (full_budget, {200, 408, 413, 503}),
    "4 ordinary batches of 250,000": (ordinary_batches, {200, 503}),
    "2 clients, 250,000 contacts, answers compressed": (compressed_answers, {200, 503}),
    "24 plans beside 52 batches of 100,000": (mixed_jobs, {200, 503}),
    "16 uploads of 100 MB": (sixteen_uploads, {200, 503}),
    "64 uploads of 20 MB": (sixty_four_uploads, {200, 503}),
    "4 x 498,000 facets apart, map and passes": (separate_facets, {200, 503}),
    "16 x 200 cutters of 50,000 planes": (many_planes, {200, 408, 422, 503}),
    "4 combs of 2000 strips": (comb, {200, 408, 422, 503}),
    "16 patches of a million samples": (fine_patches, {200, 408, 503}),
    "16 paths of 690 circles": (circles, {200, 503}),
    "4 JSON meshes of 60 MB": (large_json_mesh, {200, 408, 413, 422, 503}),
    "4 x 64 MiB of NaN": (not_finite, {400, 408, 413, 503}),
    "8 x 64 MB of points, client leaves": (large_bodies_left, {"left"}),
    "2 packages of 4 million vertices": (package, {200, 503}),
}


# Work that must be answered; the others have 5 s.
USUAL_TIMEOUT = {full_budget, ordinary_batches, compressed_answers, mixed_jobs, sixteen_uploads, sixty_four_uploads, separate_facets, circles, package}


class Server:
    def __init__(self, program, **settings):
        environment = {
            **os.environ,
            "SCALLOPD_LISTEN": "127.0.0.1:0",
            "SCALLOPD_LOG_LEVEL": "info",
            "SCALLOPD_REQUEST_TIMEOUT_S": "5",
            "SCALLOPD_CLIENT_TIMEOUT_S": "15",
            **settings,
        }
        self.process = subprocess.Popen([program], env=environment, stdout=subprocess.PIPE)
        host, port = json.loads(self.process.stdout.readline())["address"].rsplit(":", 1)
        self.address = (host, int(port))
        self.drain = subprocess.Popen(["cat"], stdin=self.process.stdout, stdout=subprocess.DEVNULL)

    def peak_mib(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024

    def cpu_s(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self):
        self.process.terminate()
        code = self.process.wait(60)
        self.drain.wait()
        return code


def observe(address, over, results):
    """Sends the requests of another client, on new connections, and reports the longest time and the statuses of each."""
    requests = {"livez": head("/livez", method="GET"), "single": post("/v1/scallop-height", HEIGHT), "batch": post("/v1/scallop-height/batch", SHORT_BATCH)}
    longest = dict.fromkeys(requests, 0.0)
    statuses = collections.Counter()
    while not over.is_set():
        for name, message in requests.items():
            began = time.monotonic()
            try:
                with connect(address, 30) as stream:
                    stream.sendall(message)
                    status, _, retry = read_answer(stream)
            except OSError as error:
                status, retry = type(error).__name__, False
            longest[name] = max(longest[name], 1000 * (time.monotonic() - began))
            statuses[name, status, retry] += 1
        time.sleep(0.02)
    results.put((longest, statuses))


def run(program, name):
    attack, _ = ATTACKS[name]
    settings = {"SCALLOPD_REQUEST_TIMEOUT_S": "60"} if attack in USUAL_TIMEOUT else {}
    server = Server(program, **settings)
    try:
        return measure(server, name)
    finally:
        if server.process.poll() is None:
            server.process.kill()


def measure(server, name):
    """Prints the row of an attack, and returns its faults."""
    attack, expected = ATTACKS[name]
    over, results = multiprocessing.Event(), multiprocessing.Queue()
    observer = multiprocessing.Process(target=observe, args=(server.address, over, results), daemon=True)
    observer.start()
    time.sleep(0.3)
    began = time.monotonic()
    got = collections.Counter(attack(server.address))
    took = time.monotonic() - began
    cpu = server.cpu_s()
    time.sleep(1)
    still = server.cpu_s() - cpu
    over.set()
    longest, statuses = results.get(timeout=60)
    observer.join()
    peak = server.peak_mib()
    code = server.stop()
    print(
        f"| {name} | {peak:.0f} | {cpu:.1f} | {took:.1f} | {longest['livez']:.0f} | {longest['single']:.0f} | {longest['batch']:.0f} | "
        + ", ".join(f"{count} x {status}" for status, count in got.items()) + " |",
        flush=True,
    )
    faults = []
    if peak > MOST_MIB:
        faults.append(f"{peak:.0f} MiB exceed {MOST_MIB}")
    if not set(got) <= expected:
        faults.append(f"the attacker got {dict(got)}, not {expected}")
    faults += [f"{other} took {ms:.0f} ms" for other, ms in longest.items() if ms > LONGEST_MS]
    faults += [f"{count} x {other}: {status}" for (other, status, retry), count in statuses.items() if status != 200 and not (status == 503 and retry)]
    shed = sum(count for (_, status, _), count in statuses.items() if status == 503)
    if shed:
        print(f"  ({shed} of {sum(statuses.values())} requests of others were shed)")
    if still > 0.5:
        faults.append(f"{still:.1f} s of processor time in the second after the attack")
    if code != 0:
        faults.append(f"the server ended with {code}")
    return [f"{name}: {fault}" for fault in faults]


def run_safely(program, name):
    """A failure of one row does not keep the others from being measured."""
    try:
        return run(program, name)
    except Exception as error:
        return [f"{name}: not measured: {type(error).__name__}: {error}"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", help="the server's executable")
    arguments.add_argument("--only", action="append", choices=ATTACKS, help="one attack; may be repeated")
    given = arguments.parse_args()
    before = os.getloadavg()[0]
    files = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(files, 20_000) if files > 0 else 20_000, files))
    print("| attack | peak, MiB | processor time, s | took, s | longest /livez, ms | single, ms | short batch, ms | the attacker got |")
    print("|---|---|---|---|---|---|---|---|")
    faults = [fault for name in given.only or ATTACKS for fault in run_safely(given.program, name)]
    print(f"\n{platform.machine()}, {os.cpu_count()} processors, {time.strftime('%Y-%m-%d')}; load average before {before:.1f}, after {os.getloadavg()[0]:.1f}")
    print("\n".join(faults) or "no fault")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
