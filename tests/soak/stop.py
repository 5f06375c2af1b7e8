#!/usr/bin/env python3
"""SIGTERM under load, ten times: each request is answered completely, or its connection is refused.

    cargo build --release && python3 tests/soak/stop.py target/release/scallopd

Clients send the soak's mixture, half of them on a new connection for each request and half on connections that they keep. After the signal,
a client continues until a connection is refused. On a connection kept from before, a client may meet the server's close where it has
received no byte of the answer; it sends that request again on a new connection, as HTTP clients do (RFC 9112, section 9.3.1). Any other
answer that is missing or cut off counts as lost. It needs Linux and Python's standard library.
"""

import argparse
import collections
import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time

import soak


class Counting(soak.Client):
    """A client that records whether its connection is new and whether a part of the answer has arrived."""

    def exchange(self, message):
        self.is_new, self.received = self.stream is None, False
        return super().exchange(message)

    def receive(self):
        data = super().receive()
        self.received = True
        return data


def run_client(address, keeps, seed, results):
    chance = random.Random(seed)
    # A body that is refused unread may meet the closed connection before the answer is read.
    requests = [entry for entry in soak.mixture() if entry[1] != "too large"]
    weights = [weight for weight, *_ in requests]
    client, counts = Counting(address), collections.Counter()
    while True:
        _, name, _, message = chance.choices(requests, weights)[0]
        try:
            status, _ = client.exchange(message)
            counts["answered" if status != 503 or name == "readyz" else "shed"] += 1
        except ConnectionRefusedError:
            break
        except OSError as error:
            client.close()
            again = not client.is_new and not client.received
            counts["sent again" if again else f"lost: {name}: {error}"] += 1
        if not keeps:
            client.close()
    results.put(counts)


def stop(program, clients, seconds):
    settings = {"SCALLOPD_LISTEN": "127.0.0.1:0", "SCALLOPD_LOG_FORMAT": "json", "SCALLOPD_LOG_LEVEL": "info", "SCALLOPD_DRAIN_DELAY_S": "1"}
    server = subprocess.Popen([program], env={**os.environ, **settings}, stdout=subprocess.PIPE)
    host, port = json.loads(server.stdout.readline())["address"].rsplit(":", 1)
    drain = subprocess.Popen(["cat"], stdin=server.stdout, stdout=subprocess.DEVNULL)
    results = multiprocessing.Queue()
    running = [multiprocessing.Process(target=run_client, args=((host, int(port)), index % 2 == 0, index, results)) for index in range(clients)]
    for client in running:
        client.start()
    time.sleep(seconds)
    server.send_signal(signal.SIGTERM)
    began = time.monotonic()
    code = server.wait(90)
    took = time.monotonic() - began
    counts = sum((results.get(timeout=90) for _ in running), collections.Counter())
    for client in running:
        client.join(10)
    drain.wait()
    return code, took, counts


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", help="the server's executable")
    arguments.add_argument("--times", type=int, default=10)
    arguments.add_argument("--clients", type=int, default=16)
    arguments.add_argument("--seconds", type=float, default=3, help="load before each stop")
    given = arguments.parse_args()
    faults = []
    for number in range(given.times):
        code, took, counts = stop(given.program, given.clients, given.seconds)
        lost = {name: count for name, count in counts.items() if name.startswith("lost")}
        print(f"stop {number + 1}: exit code {code} after {took:.1f} s; " + ", ".join(f"{count} {name}" for name, count in sorted(counts.items())), flush=True)
        faults += [f"stop {number + 1}: {count} x {name}" for name, count in lost.items()]
        if code != 0:
            faults.append(f"stop {number + 1}: exit code {code}")
    print("\n".join(faults) or "no request was lost")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
