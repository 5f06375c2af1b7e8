#!/usr/bin/env python3
"""One and two replicas behind HAProxy on one machine: throughput, a rolling restart, a replica killed, a replica that stalls.

    cargo build --release && python3 tests/soak/replicas.py target/release/scallopd

It needs Linux, haproxy and wrk (apt-get install haproxy wrk), openssl for the rows with TLS, and Python's standard library. The proxy
runs with deploy/haproxy.cfg as it stands; variables set its ports. The program ends everything that it started.

Throughput: wrk asks for single heights, each on one of 32 kept connections, and for batches of 1000, directly, through the proxy to one
replica, and through it to two. If the program runs as root and can create control groups, each replica gets --cores-each of a core, so that
replicas, proxy and wrk do not compete; else they share the cores, and two replicas are no faster than one. "us" are processor time a
request, of all replicas and of the proxy, which depend little on other work on the machine.

Failures: requests at fixed times, whether or not earlier ones were answered. A client repeats a request as docs/integration.md asks: on
a broken connection and the proxy's 502 at once, then after growing pauses, on 429 and 503 after Retry-After. "repeated by the client" is
what a client without repetition would have lost, "lost" what had no answer after five attempts; "repeated by the proxy" is what the proxy
counts. The program ends with 1 where a request is lost, or where a single calculation is lost to a client that does not repeat.
"""

import argparse
import asyncio
import collections
import contextlib
import dataclasses
import http.client
import json
import multiprocessing
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIGURATION = ROOT / "deploy" / "haproxy.cfg"
TICKS_A_SECOND = os.sysconf("SC_CLK_TCK")
CUTTER = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}
HEIGHT = {"cutter": CUTTER, "contact": {"slope_deg": 40, "feed_angle_deg": 30}, "step_over_mm": 0.687, "feed_per_tooth_mm": 0.3}
BACKENDS = ("single", "long")
# Each kind of request is sent by a process of its own. The proxy holds whole single requests and can repeat them, but not batches of this size.
SINGLE, SHORT, LONG = "single", "batch of 1000", "batch of 50 000, envelope"
STALL_S = 8
KILLS = 6
ATTEMPTS = 5
# An attempt is given up after this time, longer than the server's own 60 s.
PATIENCE_S = 70


def request_of(kind):
    """Path and body."""
    if kind == SINGLE:
        return "/v1/scallop-height", json.dumps(HEIGHT).encode()
    count, model = (1000, "analytic") if kind == SHORT else (50_000, "envelope")
    contacts = [{"slope_deg": 5 + index * 37 % 80, "feed_angle_deg": index * 61 % 360} for index in range(count)]
    shared = {name: value for name, value in HEIGHT.items() if name != "contact"} | {"model": model}
    return "/v1/scallop-height/batch", json.dumps({**shared, "contacts": contacts}).encode()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def cpu_s(pid):
    """Processor time of a process so far, by all its threads."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_A_SECOND


def wait_until(condition, what, seconds=30):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"{what} did not come within {seconds} s")
        time.sleep(0.02)


class Share:
    """A control group that limits its processes to a part of a core; without a folder if the system does not permit one."""

    # The system takes no quota under 1 ms.
    PERIOD_US = 20_000

    def __init__(self, name, cores):
        quota = int(cores * self.PERIOD_US)
        if pathlib.Path("/sys/fs/cgroup/cgroup.controllers").exists():
            self.folder, limits = pathlib.Path("/sys/fs/cgroup") / name, {"cpu.max": f"{quota} {self.PERIOD_US}"}
        else:
            self.folder, limits = pathlib.Path("/sys/fs/cgroup/cpu") / name, {"cpu.cfs_period_us": self.PERIOD_US, "cpu.cfs_quota_us": quota}
        try:
            self.folder.mkdir()
            for file, value in limits.items():
                (self.folder / file).write_text(str(value))
        except OSError as error:
            print(f"no limit of processors: {error}", file=sys.stderr)
            self.close()
            self.folder = None

    def close(self):
        if self.folder:
            # The group is busy until the system has removed its processes.
            for _ in range(100):
                if not self.folder.exists():
                    return
                with contextlib.suppress(OSError):
                    self.folder.rmdir()
                time.sleep(0.05)


class Replica:
    """One server, started again on the same port."""

    def __init__(self, program, number, drain_delay_s, cores=None):
        self.program, self.drain_delay_s, self.port, self.process = program, drain_delay_s, free_port(), None
        self.share = Share(f"scallopd-replicas-{os.getpid()}-{number}", cores) if cores else None

    def start(self):
        # The shell joins the group before it becomes the server, which sets its number of threads by it.
        command = [self.program, "--listen", f"127.0.0.1:{self.port}", "--drain-delay-s", str(self.drain_delay_s), "--log-format", "json"]
        if self.share and self.share.folder:
            command = ["sh", "-c", f'echo $$ > {self.share.folder}/cgroup.procs && exec "$@"', "sh", *command]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        wait_until(self.is_ready, "a replica")

    def is_ready(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=1)
        try:
            connection.request("GET", "/readyz")
            return connection.getresponse().status == 200
        except OSError:
            return False
        finally:
            connection.close()

    def restart(self):
        """Restarts like a rolling update: SIGTERM, the drain, a new process."""
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        if code != 0:
            sys.exit(f"a replica ended with {code} after SIGTERM")
        self.start()

    def close(self):
        if self.process and self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.kill()
            self.process.wait()
        if self.share:
            self.share.close()


class Proxy:
    """HAProxy with the configuration for operators."""

    def __init__(self, haproxy, replicas, folder, certificate=None):
        self.port, self.control = free_port(), folder / f"proxy-{len(list(folder.iterdir()))}.sock"
        variables = {
            "SCALLOPD_PROXY_BIND": f"127.0.0.1:{self.port}",
            "SCALLOPD_PROXY_SOCKET": str(self.control),
            **{f"SCALLOPD_REPLICA_{number}": f"127.0.0.1:{replica.port}" for number, replica in enumerate(replicas, start=1)},
        }
        if certificate:
            variables["SCALLOPD_CERTIFICATE"] = str(certificate)
        self.process = subprocess.Popen([haproxy, "-db", "-f", CONFIGURATION], env={**os.environ, **variables}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(self.control.exists, "the proxy")

    def tell(self, command):
        with socket.socket(socket.AF_UNIX) as stream:
            stream.connect(str(self.control))
            stream.sendall(command.encode() + b"\n")
            stream.shutdown(socket.SHUT_WR)
            return b"".join(iter(lambda: stream.recv(1 << 16), b"")).decode()

    def servers(self):
        """The counters of the proxy, by (backend, server)."""
        head, *lines = self.tell("show stat").removeprefix("# ").strip().splitlines()
        rows = [dict(zip(head.split(","), line.split(","))) for line in lines]
        return {(row["pxname"], row["svname"]): row for row in rows if row["pxname"] in BACKENDS}

    def use(self, count):
        """Sends requests to the first `count` replicas."""
        for backend in BACKENDS:
            for number in (1, 2):
                self.tell(f"set server {backend}/replica-{number} state {'ready' if number <= count else 'maint'}")
        self.wait_for(count)

    def wait_for(self, count):
        """Waits until `count` replicas get requests of all kinds."""
        wait_until(lambda: sum(row["status"].startswith("UP") for (_, name), row in self.servers().items() if name.startswith("replica")) == count * len(BACKENDS), f"{count} replicas at the proxy")

    def repeated(self):
        """Requests that the proxy has sent again, to the same replica or to another, by backend."""
        servers = self.servers()
        return {backend: int(servers[backend, "BACKEND"]["wretr"]) + int(servers[backend, "BACKEND"]["wredis"]) for backend in BACKENDS}

    def close(self):
        self.process.kill()
        self.process.wait()


@dataclasses.dataclass
class Counts:
    """The outcomes of a client's requests."""

    sent: int = 0
    at_once: int = 0
    repeated: int = 0
    lost: int = 0
    longest_s: float = 0.0
    reasons: collections.Counter = dataclasses.field(default_factory=collections.Counter)


class Client:
    """Requests at fixed times over as many connections as are busy at once."""

    def __init__(self, port, kind):
        path, body = request_of(kind)
        self.message = f"POST {path} HTTP/1.1\r\nhost: replicas\r\ncontent-type: application/json\r\ncontent-length: {len(body)}\r\n\r\n".encode() + body
        self.port, self.idle, self.counts = port, [], Counts()

    async def run(self, rate, is_over):
        """Sends until `is_over`, then waits for the answers."""
        began, tasks = time.monotonic(), set()
        while not is_over():
            task = asyncio.create_task(self.ask())
            tasks.add(task)
            task.add_done_callback(tasks.discard)
            self.counts.sent += 1
            await asyncio.sleep(max(0.0, began + self.counts.sent / rate - time.monotonic()))
        await asyncio.gather(*tasks)
        for _, writer in self.idle:
            writer.close()
        return self.counts

    async def ask(self):
        began = time.monotonic()
        for attempt in range(ATTEMPTS):
            # At once after the first attempt, then 0.1, 0.2, 0.4 s.
            pause = 0.0 if attempt == 0 else 0.05 * 2**attempt
            try:
                status, retry_after = await asyncio.wait_for(self.exchange(), PATIENCE_S)
                if status == 200:
                    self.counts.at_once += attempt == 0
                    self.counts.repeated += attempt > 0
                    self.counts.longest_s = max(self.counts.longest_s, time.monotonic() - began)
                    return
                self.counts.reasons[str(status)] += 1
                if status not in (429, 502, 503):
                    break
                # The proxy's own 503 has no Retry-After.
                pause = retry_after if retry_after is not None else pause
            except (OSError, EOFError, asyncio.TimeoutError) as error:
                self.counts.reasons[type(error).__name__] += 1
            await asyncio.sleep(pause)
        self.counts.lost += 1

    async def exchange(self):
        """Status and Retry-After of one attempt."""
        reader, writer = self.idle.pop() if self.idle else await asyncio.open_connection("127.0.0.1", self.port, limit=1 << 20)
        try:
            writer.write(self.message)
            await writer.drain()
            head = (await reader.readuntil(b"\r\n\r\n")).lower()
            length = re.search(rb"\r\ncontent-length: (\d+)", head)
            if length:
                await reader.readexactly(int(length[1]))
            elif b"\r\ntransfer-encoding: chunked" in head:
                while size := int(await reader.readline(), 16):
                    await reader.readexactly(size + 2)
                await reader.readline()
        except BaseException:
            writer.close()
            raise
        if b"\r\nconnection: close" in head or not (length or b"chunked" in head):
            writer.close()
        else:
            self.idle.append((reader, writer))
        retry_after = re.search(rb"\r\nretry-after: (\d+)", head)
        return int(head[9:12]), int(retry_after[1]) if retry_after else None


def send(port, kind, rate, over, results):
    """The process of one kind of request."""
    results.put((kind, asyncio.run(Client(port, kind).run(rate, over.is_set))))


def under_load(proxy, rates, disturb):
    """Runs `disturb` while requests of all kinds are sent: returns the clients' outcomes by kind, and the proxy's repetitions by backend."""
    over, results = multiprocessing.Event(), multiprocessing.Queue()
    before = proxy.repeated()
    senders = [multiprocessing.Process(target=send, args=(proxy.port, kind, rate, over, results), daemon=True) for kind, rate in rates.items()]
    for sender in senders:
        sender.start()
    try:
        time.sleep(2)
        disturb()
        time.sleep(2)
        over.set()
        counts = dict(results.get(timeout=PATIENCE_S * ATTEMPTS) for _ in senders)
    finally:
        over.set()
        for sender in senders:
            sender.join(5)
            sender.kill()
    after = proxy.repeated()
    return counts, {backend: after[backend] - before[backend] for backend in BACKENDS}


def restart_all(proxy, replicas):
    for replica in replicas:
        replica.restart()
        proxy.wait_for(2)


def kill_in_turns(proxy, replicas):
    for killed in (replicas * KILLS)[:KILLS]:
        killed.process.kill()
        killed.process.wait()
        time.sleep(2)
        killed.start()
        proxy.wait_for(2)


def stall_one(proxy, replicas):
    replicas[0].process.send_signal(signal.SIGSTOP)
    time.sleep(STALL_S)
    replicas[0].process.send_signal(signal.SIGCONT)
    proxy.wait_for(2)


DISTURBANCES = {
    "nothing": lambda proxy, replicas: time.sleep(5),
    "rolling restart": restart_all,
    f"one killed, {KILLS} times": kill_in_turns,
    f"one stalls for {STALL_S} s": stall_one,
}


def failures(options, haproxy, folder):
    rates = {SINGLE: options.rate, SHORT: options.batch_rate, LONG: options.batch_rate / 5}
    print("| while two replicas serve | requests | a second | sent | answered at once | repeated by the proxy | repeated by the client | lost | longest wait, ms |")
    print("|---|---|---|---|---|---|---|---|---|")
    faults = []
    for name, disturb in DISTURBANCES.items():
        with contextlib.ExitStack() as stack:
            replicas = [stack.enter_context(contextlib.closing(Replica(options.program, number, options.drain_delay_s))) for number in (1, 2)]
            for replica in replicas:
                replica.start()
            proxy = stack.enter_context(contextlib.closing(Proxy(haproxy, replicas, folder)))
            proxy.wait_for(2)
            counts, by_proxy = under_load(proxy, rates, lambda: disturb(proxy, replicas))
        for kind, rate in rates.items():
            seen = counts[kind]
            # Both kinds of batches share a backend: its repetitions stand with the first.
            proxied = by_proxy["single"] if kind == SINGLE else by_proxy["long"] if kind == SHORT else "(above)"
            reasons = ", ".join(f"{count} x {reason}" for reason, count in seen.reasons.items())
            repeated = f"{seen.repeated} ({reasons})" if reasons else str(seen.repeated)
            print(f"| {name} | {kind} | {rate:g} | {seen.sent} | {seen.at_once} | {proxied} | {repeated} | {seen.lost} | {seen.longest_s * 1e3:.0f} |", flush=True)
            if seen.lost:
                faults.append(f"{name}: {seen.lost} of {kind} lost")
            if kind == SINGLE and seen.repeated:
                faults.append(f"{name}: {seen.repeated} single calculations reached a client as failures")
    return faults


def wrk_run(wrk, url, kind, seconds, connections, is_kept=True):
    path, body = request_of(kind)
    with tempfile.NamedTemporaryFile("w", suffix=".lua") as script:
        close = "" if is_kept else 'wrk.headers["connection"] = "close"\n'
        script.write(f'wrk.method = "POST"\nwrk.headers["content-type"] = "application/json"\n{close}wrk.body = [==[{body.decode()}]==]\n')
        script.flush()
        command = [wrk, "--threads", "1", "--connections", str(connections), "--duration", f"{seconds}s", "--latency", "--script", script.name, url + path]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    if "Non-2xx" in text:
        sys.exit(f"{url} failed under load:\n{text}")
    value, unit = re.search(r"50%\s+([\d.]+)(us|ms|s)\b", text).groups()
    return int(re.search(r"(\d+) requests in", text)[1]), float(re.search(r"Requests/sec:\s+([\d.]+)", text)[1]), float(value) * {"us": 1e-3, "ms": 1.0, "s": 1e3}[unit]


def certificate(folder):
    """A certificate signed by itself, with its key."""
    key, signed = folder / "key.pem", folder / "signed.pem"
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj", "/CN=localhost", "-keyout", key, "-out", signed]
    subprocess.run(command, check=True, capture_output=True)
    both = folder / "certificate.pem"
    both.write_text(signed.read_text() + key.read_text())
    return both


def throughput(options, haproxy, wrk, folder):
    with contextlib.ExitStack() as stack:
        replicas = [stack.enter_context(contextlib.closing(Replica(options.program, number, 0, options.cores_each))) for number in (1, 2)]
        for replica in replicas:
            replica.start()
        proxies = {"proxy": stack.enter_context(contextlib.closing(Proxy(haproxy, replicas, folder)))}
        if shutil.which("openssl"):
            proxies["proxy with TLS"] = stack.enter_context(contextlib.closing(Proxy(haproxy, replicas, folder, certificate(folder))))
        limited = all(replica.share and replica.share.folder for replica in replicas)
        print(f"each replica has {options.cores_each:g} of a core" if limited else "replicas, proxy and wrk share the cores")
        print("| requests | way | connections | replicas | a second | of one | p50, ms | us of replicas | us of the proxy |")
        print("|---|---|---|---|---|---|---|---|---|")
        rows = [(kind, way, count, True) for kind in (SINGLE, SHORT) for way in ("direct", *proxies) for count in (1, 2) if way != "direct" or count == 1]
        rows += [(SINGLE, way, 1, False) for way in ("direct", *proxies)]
        first = {}
        for kind, way, count, is_kept in rows:
            proxy = proxies.get(way)
            url = f"http://127.0.0.1:{replicas[0].port}" if proxy is None else f"{'https' if 'TLS' in way else 'http'}://127.0.0.1:{proxy.port}"
            if proxy:
                proxy.use(count)
            runs = []
            for _ in range(options.rounds):
                wrk_run(wrk, url, kind, 1, 4, is_kept)
                before = sum(cpu_s(replica.process.pid) for replica in replicas), cpu_s(proxy.process.pid) if proxy else 0.0
                answered, rate, p50 = wrk_run(wrk, url, kind, options.seconds, 32 if kind == SINGLE else 8, is_kept)
                after = sum(cpu_s(replica.process.pid) for replica in replicas), cpu_s(proxy.process.pid) if proxy else 0.0
                runs.append((rate, p50, *(1e6 * (end - start) / answered for start, end in zip(before, after))))
            rate, p50, ours, proxied = (sorted(figures)[len(runs) // 2] for figures in zip(*runs))
            first.setdefault((kind, way, is_kept), rate)
            ratio = f"{rate / first[kind, way, is_kept]:.2f}" if count > 1 else ""
            kept = "kept" if is_kept else "one a request"
            print(f"| {kind} | {way} | {kept} | {count} | {rate:.0f} | {ratio} | {p50:.2f} | {ours:.1f} | {f'{proxied:.1f}' if proxy else ''} |", flush=True)


def need(program, package):
    found = shutil.which(program) or shutil.which(program, path="/usr/sbin:/usr/local/sbin")
    if found is None:
        sys.exit(f"{program} is missing: apt-get install {package}")
    return found


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", help="the server's executable")
    arguments.add_argument("--only", choices=("throughput", "failures"))
    arguments.add_argument("--seconds", type=int, default=3, help="length of a run of wrk")
    arguments.add_argument("--rounds", type=int, default=3, help="runs of wrk a row; the median counts")
    arguments.add_argument("--cores-each", type=float, default=0.1, help="of a core for each replica while throughput is measured; 0 for no limit")
    arguments.add_argument("--rate", type=float, default=400, help="single requests a second while replicas fail")
    arguments.add_argument("--batch-rate", type=float, default=10, help="batches of 1000 a second, and a fifth of it of 50 000")
    arguments.add_argument("--drain-delay-s", type=int, default=5, help="after SIGTERM; the default is that of the manifests")
    options = arguments.parse_args()
    haproxy = need("haproxy", "haproxy")
    # SIGTERM raises an exception, so that everything that was started is ended.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    faults = []
    with tempfile.TemporaryDirectory() as name:
        if options.only != "failures":
            throughput(options, haproxy, need("wrk", "wrk"), pathlib.Path(name))
        if options.only != "throughput":
            faults = failures(options, haproxy, pathlib.Path(name))
    print("\n".join(faults) or "no fault")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
