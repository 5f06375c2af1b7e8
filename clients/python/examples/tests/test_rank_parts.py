"""The Dask example on a local cluster: workers and services that die lose no part."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Dict, List

import distributed

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import rank_parts
from servers import Service, binary

PARTS = 6
COLUMNS = 40


def part(number: int) -> str:
    """A wavy slope as points, another one for each number."""
    lines = []
    for row in range(COLUMNS):
        for column in range(COLUMNS):
            x, y = 0.5 * column, 0.5 * row
            lines.append(f"{x},{y},{0.1 * y + 0.02 * number * ((column % 8) - 4) ** 2 / 16}")
    return "\n".join(lines)


LIBRARY = "name,type,diameter_mm,corner_radius_mm\nT10,toroidal,10,2\nB6,ball_end,6,\n"


class RankParts(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = Path(self._folder.name)
        self.parts, self.answers, self.library = self.folder / "parts", self.folder / "answers", self.folder / "library.csv"
        self.parts.mkdir()
        self.library.write_text(LIBRARY)
        for number in range(PARTS):
            (self.parts / f"part-{number:02}.csv").write_text(part(number))
        (self.parts / "broken.stl").write_text("this is no STL file")
        (self.parts / "notes.txt").write_text("no part")

    def cluster(self) -> distributed.Client:
        client = distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None)
        self.addCleanup(client.shutdown)
        return client

    def assert_complete(self, lines: List[Dict[str, Any]]) -> None:
        self.assertEqual(len(lines), PARTS + 1)
        refused = [line for line in lines if line["refused"]]
        self.assertEqual([line["part"] for line in refused], ["broken.stl"])
        self.assertTrue(all(line["cutter"] in ("T10", "B6") and line["machining_time_s"] > 0 for line in lines if not line["refused"]))
        # Nothing unfinished stays beside the answers.
        self.assertEqual(len(list(self.answers.iterdir())), PARTS + 1)

    def test_a_restarted_service_and_a_killed_worker_lose_no_part(self) -> None:
        client = self.cluster()
        services = [Service()]
        port = services[0].port

        def disturb() -> None:
            while len(list(self.answers.glob("*.json"))) < 2:
                time.sleep(0.01)
            services[0].kill()
            services.append(Service(port=port))
            pids = client.run(os.getpid)
            os.kill(next(iter(pids.values())), signal.SIGKILL)

        self.answers.mkdir()
        disturber = threading.Thread(target=disturb)
        disturber.start()
        lines = rank_parts.rank_all(client, self.parts, self.answers, self.library, f"http://127.0.0.1:{port}")
        disturber.join()
        self.assertEqual(len(services), 2)
        services[-1].kill()
        self.assert_complete(lines)

    def test_a_run_with_a_service_beside_each_worker_continues_where_it_stopped(self) -> None:
        client = self.cluster()
        client.register_plugin(rank_parts.ServiceBeside(binary()))
        first = self.parts / "part-00.csv"
        hidden = [path for path in self.parts.iterdir() if path != first]
        aside = self.folder / "aside"
        aside.mkdir()
        for path in hidden:
            path.rename(aside / path.name)
        self.assertEqual([line["part"] for line in rank_parts.rank_all(client, self.parts, self.answers, self.library)], ["part-00.csv"])
        written = (self.answers / "part-00.csv.json").stat().st_mtime_ns
        for path in aside.iterdir():
            path.rename(self.parts / path.name)
        # The services die; the workers start them again.
        client.run(kill_service)
        lines = rank_parts.rank_all(client, self.parts, self.answers, self.library)
        self.assertEqual((self.answers / "part-00.csv.json").stat().st_mtime_ns, written)
        self.assert_complete(lines)


def kill_service(dask_worker: distributed.Worker) -> None:
    process = dask_worker.plugins["scallopd"]._process
    process.kill()
    process.wait()


if __name__ == "__main__":
    unittest.main()
