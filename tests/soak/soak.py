#!/usr/bin/env python3
"""Soak test: all endpoints with valid and invalid requests, batches and uploads, from as many clients as fill the cores, for a minute.

    cargo build --release && python3 tests/soak/soak.py target/release/scallopd

It fails on an answer 5xx that is not a shed request's 503 with Retry-After, on a status that a request does not call for, on a
connection that the server breaks, and when memory in the last ten seconds exceeds that in the first ten (after a warm-up) by more
than a tenth and 8 MiB, which is the size of an allocator's caches. It needs Linux and Python's standard library.
"""

import argparse
import collections
import json
import math
import multiprocessing
import os
import pathlib
import random
import re
import socket
import struct
import subprocess
import sys
import time

CUTTER = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}
CONTACT = {"slope_deg": 40, "feed_angle_deg": 30}
SHAPES = {
    "cutters": [{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, {"type": "ball_end", "diameter_mm": 10}],
    "scallop_height_mm": 0.01,
    "machine": {"preset": "five_axis_vmc"},
}


def dome(rows):
    """Heights of a flat dome on a grid, in mm, one row after the other."""
    return [[float(x), float(y), 20 - ((x - rows / 2) ** 2 + (y - rows / 2) ** 2) / (4 * rows)] for y in range(rows) for x in range(rows)]


def binary_stl(rows):
    points = dome(rows)
    facets = bytearray()
    for y in range(rows - 1):
        for x in range(rows - 1):
            a, b, c, d = (points[i] for i in (y * rows + x, y * rows + x + 1, (y + 1) * rows + x, (y + 1) * rows + x + 1))
            for corners in ((a, b, c), (b, d, c)):
                facets += struct.pack("<12fH", 0, 0, 0, *corners[0], *corners[1], *corners[2], 0)
    return b"\0" * 80 + struct.pack("<I", len(facets) // 50) + bytes(facets)


def csv(rows):
    return "x,y,z\n".encode() + "".join(f"{x},{y},{z:.4f}\n" for x, y, z in dome(rows)).encode()


def request(method, path, body=b"", media_type="application/json"):
    head = f"{method} {path} HTTP/1.1\r\nhost: soak\r\n"
    if body:
        head += f"content-type: {media_type}\r\ncontent-length: {len(body)}\r\n"
    return (head + "\r\n").encode() + body


def post(path, value):
    return request("POST", path, json.dumps(value).encode())


def upload(file, name):
    boundary = "soak-boundary"
    parts = [
        f'--{boundary}\r\ncontent-disposition: form-data; name="parameters"\r\ncontent-type: application/json\r\n\r\n'.encode()
        + json.dumps(SHAPES).encode(),
        f'\r\n--{boundary}\r\ncontent-disposition: form-data; name="surface"; filename="{name}"\r\n\r\n'.encode() + file,
        f"\r\n--{boundary}--\r\n".encode(),
    ]
    return request("POST", "/v1/cutter-recommendation/upload", b"".join(parts), f"multipart/form-data; boundary={boundary}")


def mixture():
    """Requests as bytes: (weight, name, expected status, bytes)."""
    height = {"cutter": CUTTER, "contact": CONTACT, "step_over_mm": 0.687, "feed_per_tooth_mm": 0.1}
    feed = {"cutter": CUTTER, "contact": CONTACT, "step_over_mm": 0.5, "scallop_tolerance_mm": 0.02}
    step = {"cutter": CUTTER, "contact": CONTACT, "scallop_tolerance_mm": 0.02}
    contacts = [{"slope_deg": 5 + i % 60, "feed_angle_deg": i % 180} for i in range(2000)]
    toroidal, ball_end = ({name: value for name, value in cutter.items() if name != "type"} for cutter in SHAPES["cutters"])
    job = {"toroidal": toroidal, "ball_end": ball_end, "scallop_height_mm": SHAPES["scallop_height_mm"], "machine": SHAPES["machine"]}
    critical = {**job, "width_mm": 80, "height_mm": 40}
    surface = {"points": dome(30)}
    endless = post("/v1/scallop-height", {"cutter": "x" * 100_000})
    return [
        (20, "scallop-height", 200, post("/v1/scallop-height", height)),
        (10, "scallop-height, envelope", 200, post("/v1/scallop-height", {**height, "model": "envelope"})),
        (20, "max-feed", 200, post("/v1/max-feed", feed)),
        (10, "step-over", 200, post("/v1/step-over", step)),
        (5, "critical-slope", 200, post("/v1/critical-slope", critical)),
        (3, "machines", 200, request("GET", "/v1/machines")),
        (2, "scallop-height, batch", 200, post("/v1/scallop-height/batch", {k: v for k, v in height.items() if k != "contact"} | {"contacts": contacts})),
        (2, "step-over, batch", 200, post("/v1/step-over/batch", {k: v for k, v in step.items() if k != "contact"} | {"contacts": contacts})),
        (2, "recommendation", 200, post("/v1/cutter-recommendation", {**SHAPES, "surface": surface})),
        (1, "upload, STL", 200, upload(binary_stl(100), "dome.stl")),
        (1, "upload, CSV", 200, upload(csv(100), "dome.csv")),
        (1, "upload, not a surface", 400, upload(b"this is no surface\n" * 100, "poem.txt")),
        (3, "out of range", 422, post("/v1/scallop-height", {**height, "contact": {"slope_deg": 140, "feed_angle_deg": 0}})),
        (3, "tolerance exceeded", 422, post("/v1/max-feed", {**feed, "step_over_mm": 3, "scallop_tolerance_mm": 0.001})),
        (3, "not JSON", 400, request("POST", "/v1/max-feed", b"{\"cutter\": ")),
        (2, "too large", 413, endless),
        (2, "no such path", 404, request("GET", "/v1/nothing")),
        (2, "no such method", 405, request("DELETE", "/v1/max-feed")),
        (2, "no such type", 415, request("POST", "/v1/max-feed", b"x", "text/plain")),
        (1, "openapi", 200, request("GET", "/openapi.json")),
        (1, "metrics", 200, request("GET", "/metrics")),
        (1, "readyz", 200, request("GET", "/readyz")),
    ]


class Client:
    """One connection, opened again if the server announced its close."""

    def __init__(self, address):
        self.address = address
        self.stream = None

    def exchange(self, message):
        """Status, whether Retry-After is there."""
        if self.stream is None:
            self.stream = socket.create_connection(self.address, timeout=60)
            self.stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.stream.sendall(message)
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += self.receive()
        head, rest = answer.split(b"\r\n\r\n", 1)
        head = head.lower()
        length = re.search(rb"\r\ncontent-length: (\d+)", head)
        if length:
            left = int(length[1]) - len(rest)
            while left > 0:
                left -= len(self.receive())
        else:
            while not rest.endswith(b"0\r\n\r\n"):
                rest += self.receive()
        if b"\r\nconnection: close" in head:
            self.close()
        return int(head[9:12]), b"\r\nretry-after:" in head

    def receive(self):
        data = self.stream.recv(1 << 18)
        if not data:
            raise ConnectionError("the server ended the connection within an answer")
        return data

    def close(self):
        if self.stream is not None:
            self.stream.close()
            self.stream = None


def run_client(address, until, seed, results):
    chance = random.Random(seed)
    requests = mixture()
    weights = [weight for weight, *_ in requests]
    client = Client(address)
    counts = collections.Counter()
    while time.monotonic() < until:
        _, name, _, message = chance.choices(requests, weights)[0]
        try:
            status, retry = client.exchange(message)
            counts[name, status, retry] += 1
        except OSError as error:
            client.close()
            # A body that is refused unread may meet the closed connection before the answer is read.
            counts[name, "too large" if name == "too large" else f"broken: {error}", False] += 1
        if chance.random() < 0.01:
            client.close()
    results.put(counts)


def resident_mib(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024


def watch(pid, seconds):
    """Memory each half second, as (time, MiB)."""
    began = time.monotonic()
    samples = []
    while (elapsed := time.monotonic() - began) < seconds:
        samples.append((elapsed, resident_mib(pid)))
        time.sleep(0.5)
    return samples


def mean(values):
    return math.fsum(values) / len(values)


def judge(counts, samples, seconds):
    faults = []
    expected = {name: status for _, name, status, _ in mixture()}
    print(f"{'request':28}{'status':>12}{'count':>10}")
    for (name, status, retry), count in sorted(counts.items(), key=str):
        print(f"{name:28}{status:>12}{count:>10}")
        if status == 503 and retry or status in (expected[name], "too large"):
            continue
        faults.append(f"{count} x {name}: {status} instead of {expected[name]}")
    faults += [f"{name} was never asked" for name in expected.keys() - {name for name, *_ in counts}]
    first = mean([mib for at, mib in samples if at < 10])
    last = mean([mib for at, mib in samples if at >= seconds - 10])
    print(f"{sum(counts.values()) / seconds:.0f} requests a second; memory {first:.1f} MiB in the first ten seconds, {last:.1f} MiB in the last")
    if last > 1.1 * first + 8:
        faults.append(f"memory grew from {first:.1f} to {last:.1f} MiB")
    return faults


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", help="the server's executable")
    arguments.add_argument("--seconds", type=float, default=60)
    arguments.add_argument("--warm-up", type=float, default=5, help="seconds before memory is watched")
    arguments.add_argument("--clients", type=int, default=4 * (os.cpu_count() or 1))
    given = arguments.parse_args()

    environment = {**os.environ, "SCALLOPD_LISTEN": "127.0.0.1:0", "SCALLOPD_LOG_FORMAT": "json", "SCALLOPD_LOG_LEVEL": "info"}
    server = subprocess.Popen([given.program], env=environment, stdout=subprocess.PIPE)
    host, port = json.loads(server.stdout.readline())["address"].rsplit(":", 1)
    # The rest of the log is read and discarded; unread, it would block the server.
    drain = subprocess.Popen(["cat"], stdin=server.stdout, stdout=subprocess.DEVNULL)
    results = multiprocessing.Queue()
    until = time.monotonic() + given.warm_up + given.seconds
    clients = [multiprocessing.Process(target=run_client, args=((host, int(port)), until, seed, results)) for seed in range(given.clients)]
    for client in clients:
        client.start()
    try:
        time.sleep(given.warm_up)
        samples = watch(server.pid, given.seconds)
        counts = sum((results.get(timeout=120) for _ in clients), collections.Counter())
    finally:
        for client in clients:
            client.join(10)
        server.terminate()
        code = server.wait(60)
        drain.wait()
    faults = judge(counts, samples, given.seconds)
    if code != 0:
        faults.append(f"the server ended with {code}")
    print("\n".join(faults) or "no fault")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
