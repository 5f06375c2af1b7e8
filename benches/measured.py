"""Shared by the measurements with servers: builds, servers, their processor time and memory, the machine, tables. Standard library only."""

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "target" / "benches"
TICKS_A_SECOND = os.sysconf("SC_CLK_TCK")


def target() -> Path:
    """The folder of cargo's builds."""
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def build(*examples: str) -> list[Path]:
    """Builds the release server and the named examples; without names the baseline."""
    examples = examples or ("baseline",)
    named = [word for example in examples for word in ("--example", example)]
    subprocess.run(["cargo", "build", "--release", "--bin", "scallopd", *named], cwd=ROOT, check=True)
    release = target() / "release"
    return [release / "scallopd", *(release / "examples" / example for example in examples)]


def need(program: str, package: str) -> str:
    """The path of a program; exits with the way to install it where it is missing."""
    found = shutil.which(program)
    if found is None:
        sys.exit(f"{program} is missing: apt-get install {package}")
    return found


def environment(name: str) -> Path:
    """The interpreter of a virtual environment with `benches/NAME-requirements.txt`, created where it is missing or out of date."""
    home, wanted = RESULTS / f"venv-{name}", ROOT / "benches" / f"{name}-requirements.txt"
    python, made = home / "bin" / "python", home / "made-from"
    if not made.exists() or made.read_text() != wanted.read_text():
        subprocess.run([sys.executable, "-m", "venv", "--clear", home], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--requirement", wanted], check=True)
        made.write_text(wanted.read_text())
    return python


class Server:
    """A running server, with the system's figures of its process."""

    def __init__(self, name: str, process: subprocess.Popen, address: str):
        self.name, self.process, self.address = name, process, address

    def cpu_s(self) -> float:
        """Processor time used so far, by all its threads."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS_A_SECOND

    def peak_mb(self) -> float:
        """The peak memory of the process so far, in 10^6 bytes."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+) kB", status).group(1)) * 1024 / 1e6

    def post(self, path: str, body: bytes, content_type: str = "application/json") -> bytes:
        request = urllib.request.Request(f"http://{self.address}{path}", body, {"content-type": content_type})
        with urllib.request.urlopen(request, timeout=600) as answer:
            return answer.read()


@contextlib.contextmanager
def running(name: str, command: list, cores: str | None = None):
    """Starts a server, bound to `cores` where given, yields it with the address that it prints, and ends it. Its log is read and discarded."""
    pinned = ["taskset", "--cpu-list", cores] if cores else []
    with subprocess.Popen([*pinned, *map(str, command)], stdout=subprocess.PIPE, text=True) as process:
        try:
            line = process.stdout.readline()
            address = re.search(r"127\.0\.0\.1:\d+", line)
            if address is None:
                sys.exit(f"{name} did not start: {line!r}")
            # A process that discards the log: the cost of a log collector does not count for the server.
            with subprocess.Popen(["cat"], stdin=process.stdout, stdout=subprocess.DEVNULL) as reader:
                try:
                    yield Server(name, process, address.group())
                finally:
                    # Otherwise the reader of its log would be waited for without end.
                    process.terminate()
                process.wait(timeout=60)
                reader.wait(timeout=10)
        finally:
            process.kill()


def machine() -> dict:
    """The machine on which the numbers were measured."""
    model = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    memory = re.search(r"MemTotal:\s+(\d+)", Path("/proc/meminfo").read_text())
    revision = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    return {
        "processor": model.group(1) if model else "unknown",
        "cores": os.cpu_count(),
        "memory_gib": round(int(memory.group(1)) / 2**20, 1) if memory else None,
        "kernel": os.uname().release,
        "revision": revision.stdout.strip(),
        "load_before": round(os.getloadavg()[0], 2),
    }


def report(name: str, rows: list[dict], **more) -> None:
    """Prints the rows as a table and writes them, with the machine, as JSON."""
    if rows:
        heads = list(dict.fromkeys(head for row in rows for head in row))
        cells = [heads, *([shown(row.get(head)) for head in heads] for row in rows)]
        widths = [max(len(line[column]) for line in cells) for column in range(len(heads))]
        for line in cells:
            first, *rest = (cell.ljust(width) if column == 0 else cell.rjust(width) for column, (cell, width) in enumerate(zip(line, widths)))
            print("  ".join([first, *rest]))
    RESULTS.mkdir(parents=True, exist_ok=True)
    file = RESULTS / f"{name}.json"
    file.write_text(json.dumps({"machine": machine(), **more, "rows": rows}, indent=2) + "\n")
    print(f"written to {file}")


def shown(value) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return str(value)
