"""Ranks the cutters of a library for every part of a folder, on a Dask cluster.

Each part is one task: a worker uploads the file to a service and writes the answer beside the others. A task whose worker dies
runs again on another worker, and a part whose answer is there already is left out, so that a run that was stopped continues.

Usage: rank_parts.py PARTS ANSWERS [--library FILE] [--scheduler ADDRESS] [--workers N] [--service URL | --program FILE]

With `--service`, all workers call one address, such as a proxy before several replicas. With `--program`, each worker starts
that program beside itself and calls it. Needs `pip install 'dask[distributed]' ./clients/python`.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, List, Optional

import distributed
import scallopd

MACHINE = "vmc"
SCALLOP_HEIGHT_MM = 0.01
FORMATS = {".stl", ".3mf", ".obj", ".ply", ".csv", ".xyz"}
MOST_ATTEMPTS = 10
"""The workers that may die with a part before it counts as the cause."""


class ServiceBeside(distributed.WorkerPlugin):
    """A service beside each worker, on a free port of the machine."""

    name = "scallopd"
    idempotent = True

    def __init__(self, program: str) -> None:
        self._program = program

    def setup(self, worker: distributed.Worker) -> None:
        self._log = tempfile.TemporaryFile()
        command = [self._program, "--listen", "127.0.0.1:0", "--log-format", "json"]
        self._process = subprocess.Popen(command, stdout=self._log, stderr=subprocess.STDOUT)
        self.url = f"http://{self._address()}"

    def teardown(self, worker: distributed.Worker) -> None:
        self._process.terminate()
        self._process.wait()

    def _address(self) -> str:
        end = time.monotonic() + 20
        while time.monotonic() < end and self._process.poll() is None:
            found = re.search(rb'"address":"([^"]+)"', os.pread(self._log.fileno(), 1 << 16, 0))
            if found:
                return found[1].decode()
            time.sleep(0.02)
        raise RuntimeError(f"{self._program} did not start")

    def running_url(self, worker: distributed.Worker) -> str:
        """The service's address; a service that died is started again."""
        if self._process.poll() is not None:
            self.setup(worker)
        return self.url


def rank(part: str, answers: str, library: Optional[str], service: Optional[str]) -> Dict[str, Any]:
    """Ranks the cutters for one part and stores the answer. Returns a line for the summary."""
    target = Path(answers) / f"{Path(part).name}.json"
    if service is None:
        worker = distributed.get_worker()
        service = worker.plugins["scallopd"].running_url(worker)
    # A service that restarts is waited for: the call is repeated, because it depends on its request alone.
    with scallopd.Client(service, retry_for=60) as client:
        try:
            answer: Dict[str, Any] = dict(
                client.recommend_file(
                    part,
                    [] if library else [{"name": "B6", "type": "ball_end", "diameter_mm": 6}],
                    SCALLOP_HEIGHT_MM,
                    MACHINE,
                    libraries=[library] if library else [],
                )
            )
        except scallopd.Problem as problem:
            # A part that is refused is an answer too: asking again would give the same.
            answer = {"refused": problem.members}
    # The answer appears whole or not at all, whatever happens to this worker.
    unfinished = target.with_name(f".{target.name}.{os.getpid()}")
    unfinished.write_text(json.dumps(answer))
    unfinished.replace(target)
    return summary(target)


def summary(target: Path) -> Dict[str, Any]:
    """The line of a part in the summary."""
    answer = json.loads(target.read_text())
    best = answer.get("recommended", {})
    return {
        "part": target.name[: -len(".json")],
        "cutter": best.get("name"),
        "machining_time_s": best.get("machining_time_s"),
        "refused": answer.get("refused", {}).get("detail"),
    }


def rank_all(
    client: distributed.Client, parts: Path, answers: Path, library: Optional[Path] = None, service: Optional[str] = None
) -> List[Dict[str, Any]]:
    """Ranks the cutters for all parts of a folder that have no answer yet. The lines are in the order of the names."""
    answers.mkdir(parents=True, exist_ok=True)
    files = sorted(path for path in parts.iterdir() if path.suffix.lower() in FORMATS)
    todo = [path for path in files if not (answers / f"{path.name}.json").exists()]
    # `pure=False`: the same part in another folder of answers is another task.
    tasks = [
        client.submit(
            rank, str(path.resolve()), str(answers.resolve()), str(library.resolve()) if library else None, service, retries=3, pure=False
        )
        for path in todo
    ]
    client.gather(tasks)
    return [summary(answers / f"{path.name}.json") for path in files]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("--library", type=Path, help="a tool library: Fusion, FreeCAD or CSV")
    parser.add_argument("--scheduler", help="a cluster's address; absent = workers on this machine")
    parser.add_argument("--workers", type=int, default=2, help="workers on this machine, each with one thread")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--service", help="one address for all workers")
    where.add_argument("--program", help="the program that each worker starts beside itself")
    options = parser.parse_args()
    distributed.dask.config.set({"distributed.scheduler.allowed-failures": MOST_ATTEMPTS})
    if options.scheduler:
        client = distributed.Client(options.scheduler)
    else:
        client = distributed.Client(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
    with client:
        if options.program:
            client.register_plugin(ServiceBeside(options.program))
        began = time.monotonic()
        lines = rank_all(client, options.parts, options.answers, options.library, options.service)
        for line in lines:
            print(json.dumps(line))
        print(f"{len(lines)} parts in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
