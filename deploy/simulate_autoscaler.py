#!/usr/bin/env python3
"""Simulates the autoscaler of the manifests on a step of load by the rules of its controller, without a cluster.

    python3 deploy/simulate_autoscaler.py                                # base and production, steps of 2, 5 and 10 times
    python3 deploy/simulate_autoscaler.py --pod-start-s 90               # where each new pod needs a new node

Read from the manifests: replicas, target, stabilisation windows and policies of the HorizontalPodAutoscaler, requests and limits of the
pod. From Kubernetes' controller (defaults of version 1.33): a sync each 15 s, a tolerance of 10 %, utilisation in whole per cent, and pods
whose first full window of metrics is not over count as idle when more are asked for. Metrics are means over 15 s, fetched each 15 s. The
phases of both clocks against the step are unknown: each row is the worst of nine pairs.

Requests are a stream of work that all ready pods share evenly, as behind a proxy that balances requests; a pod works at most with its
limit of processors. Requests that would wait longer than the service allows are shed (503) and repeated after Retry-After, five attempts in
all; "lost" are those shed five times. 1x is the load that keeps the least number of replicas at the target. The step lasts ten minutes. It
needs PyYAML.
"""

import argparse
import dataclasses
import itertools
import math
import pathlib

import yaml

KUBERNETES = pathlib.Path(__file__).parent / "kubernetes"
SYNC_S = 15.0
METRICS_WINDOW_S = 15.0
# From a scrape to the autoscaler: the kubelet's own statistics are some seconds old.
METRICS_AGE_S = 3.0
TOLERANCE = 0.1
TICK_S = 0.1
SETTLING_S = 120.0
STEP_S = 600.0
REST_S = 600.0
RETRY_AFTER_S = 1.0
ATTEMPTS = 5


# The controller's rule.


def desired_replicas(current, usages, unready, missing, request, target, tolerance=TOLERANCE):
    """Replicas for the `usages` of ready pods, in the unit of `request`; `unready` and `missing` are numbers of pods without one.

    GetResourceReplicas of Kubernetes' pkg/controller/podautoscaler/replica_calculator.go.
    """

    def ratio(values):
        # The controller counts in thousandths of a processor and whole per cent.
        return math.floor(100 * sum(values) / (request * len(values)) + 1e-9) / target

    def changes_little(value):
        return 1 - tolerance <= value <= 1 + tolerance

    usage_ratio = ratio(usages)
    rebalance = unready > 0 and usage_ratio > 1
    if not rebalance and not missing:
        return current if changes_little(usage_ratio) else math.ceil(usage_ratio * len(usages))
    # Pods without metrics count against the change: as fully used when fewer are wanted, as idle when more are.
    usages = usages + [request * max(1.0, target / 100) if usage_ratio < 1 else 0.0] * missing
    usages += [0.0] * (unready if rebalance else 0)
    new_ratio = ratio(usages)
    if changes_little(new_ratio) or (usage_ratio < 1) != (new_ratio < 1):
        return current
    replicas = math.ceil(new_ratio * len(usages))
    return current if (new_ratio < 1 < replicas / current) or (new_ratio > 1 > replicas / current) else replicas


DEFAULT_UP = [{"type": "Pods", "value": 4, "periodSeconds": 15}, {"type": "Percent", "value": 100, "periodSeconds": 15}]
DEFAULT_DOWN = [{"type": "Percent", "value": 100, "periodSeconds": 15}]


class Behaviour:
    """The limits on a desired number of replicas: stabilisation windows, then policies, then bounds."""

    def __init__(self, behaviour, least, most):
        self.least, self.most = least, most
        self.up = {"policies": DEFAULT_UP, "stabilizationWindowSeconds": 0, "selectPolicy": "Max", **behaviour.get("scaleUp", {})}
        self.down = {"policies": DEFAULT_DOWN, "stabilizationWindowSeconds": 300, "selectPolicy": "Max", **behaviour.get("scaleDown", {})}
        self.recommendations, self.events = [], []

    def next(self, now, current, desired):
        """The number of replicas from `now` on."""
        self.recommendations.append((now, desired))
        lowest, highest = (
            extreme([desired, *(number for at, number in self.recommendations if at > now - rules["stabilizationWindowSeconds"])])
            for extreme, rules in ((min, self.up), (max, self.down))
        )
        stable = min(max(current, lowest), highest)
        if stable > current:
            chosen = min(stable, max(self.limit(now, current, self.up, 1), current), self.most)
        elif stable < current:
            chosen = max(stable, min(self.limit(now, current, self.down, -1), current), self.least)
        else:
            chosen = current
        chosen = min(max(chosen, self.least), self.most)
        if chosen != current:
            self.events.append((now, chosen - current))
        return chosen

    def limit(self, now, current, rules, sign):
        """The limit of the policies on the number."""
        if rules["selectPolicy"] == "Disabled":
            return current
        limits = []
        for policy in rules["policies"]:
            start = current - sum(change for at, change in self.events if at > now - policy["periodSeconds"])
            if policy["type"] == "Pods":
                limits.append(start + sign * policy["value"])
            else:
                share = start * (1 + sign * policy["value"] / 100)
                # Both ways to the larger change; the margin is for shares that are whole numbers but for their last digit.
                limits.append(math.ceil(share - 1e-9) if sign > 0 else math.floor(share + 1e-9))
        furthest = rules["selectPolicy"] == "Max"
        return max(limits) if furthest == (sign > 0) else min(limits)


# The manifests.


@dataclasses.dataclass
class Manifest:
    """The parts of the manifests that the simulation uses."""

    name: str
    least: int
    most: int
    target: int
    behaviour: dict
    request_cores: float
    limit_cores: float


def cores(quantity):
    text = str(quantity)
    return float(text[:-1]) / 1000 if text.endswith("m") else float(text)


def patched(manifest, patches):
    """A manifest with those patches of a kustomization that name its kind: operations `replace` and `add` of RFC 6902."""
    for patch in patches:
        if patch["target"]["kind"] != manifest["kind"]:
            continue
        for operation in yaml.safe_load(patch["patch"]):
            *path, last = [part.replace("~1", "/").replace("~0", "~") for part in operation["path"].split("/")[1:]]
            place = manifest
            for part in path:
                place = place[int(part) if isinstance(place, list) else part]
            if last == "-":
                place.append(operation["value"])
            else:
                place[int(last) if isinstance(place, list) else last] = operation["value"]
    return manifest


def manifest_of(name):
    """The base, or an overlay of it."""
    base, patches = KUBERNETES / "base", []
    if name != "base":
        patches = yaml.safe_load((KUBERNETES / "overlays" / name / "kustomization.yaml").read_text())["patches"]
    autoscaler, deployment = (patched(yaml.safe_load((base / file).read_text()), patches) for file in ("horizontal-pod-autoscaler.yaml", "deployment.yaml"))
    spec = autoscaler["spec"]
    (metric,) = spec["metrics"]
    resources = deployment["spec"]["template"]["spec"]["containers"][0]["resources"]
    return Manifest(
        name, spec["minReplicas"], spec["maxReplicas"], metric["resource"]["target"]["averageUtilization"], spec.get("behavior", {}),
        cores(resources["requests"]["cpu"]), cores(resources["limits"]["cpu"]),
    )


# The simulation.


@dataclasses.dataclass
class Outcome:
    """The results of a step of load."""

    replicas: list = dataclasses.field(default_factory=list)
    arrived: float = 0.0
    shed: float = 0.0
    lost: float = 0.0
    last_shed_s: float = 0.0
    longest_wait_s: float = 0.0


class Pod:
    """A replica: when it is ready, and the processor time that it has used at each scrape."""

    def __init__(self, ready_at):
        self.ready_at, self.used_s, self.scrapes = ready_at, 0.0, []

    def usage(self):
        """Cores over the last window of metrics; none where that is not wholly after the pod got ready."""
        if len(self.scrapes) < 2 or self.scrapes[-2][0] < self.ready_at:
            return None
        (start, before), (end, after) = self.scrapes[-2:]
        return (after - before) / (end - start)


def simulate(manifest, factor, longest_wait_s, pod_start_s, sync_phase_s, scrape_phase_s):
    """One step of load, from 0 to STEP_S, in work (core seconds) per second."""
    usual = manifest.least * manifest.request_cores * manifest.target / 100
    behaviour = Behaviour(manifest.behaviour, manifest.least, manifest.most)
    pods = [Pod(-math.inf) for _ in range(manifest.least)]
    outcome, queue, published = Outcome([(0.0, manifest.least)]), 0.0, []
    # Shed work, by the tick of its repetition: amounts by the number of attempts so far.
    returning = {}
    ticks = range(round(-SETTLING_S / TICK_S), round((STEP_S + REST_S) / TICK_S))
    sync_every, scrape_every = round(SYNC_S / TICK_S), round(METRICS_WINDOW_S / TICK_S)
    for tick in ticks:
        now = tick * TICK_S
        arriving = [usual * (factor if 0 <= now < STEP_S else 1) * TICK_S, *returning.pop(tick, [0.0] * (ATTEMPTS - 1))]
        outcome.arrived += arriving[0] if 0 <= now < STEP_S else 0.0
        ready = [pod for pod in pods if pod.ready_at <= now]
        capacity = len(ready) * manifest.limit_cores
        offered = queue + sum(arriving)
        done = min(offered, capacity * TICK_S)
        queue = min(offered - done, capacity * longest_wait_s)
        outcome.longest_wait_s = max(outcome.longest_wait_s, queue / capacity)
        turned_away = offered - done - queue
        if turned_away > 1e-9:
            share = turned_away / sum(arriving)
            back = [amount * share for amount in arriving]
            outcome.lost += back[-1]
            outcome.shed += turned_away
            outcome.last_shed_s = now
            returning[tick + round(RETRY_AFTER_S / TICK_S)] = back[:-1]
        for pod in ready:
            pod.used_s += done / len(ready)
        if (tick - round(scrape_phase_s / TICK_S)) % scrape_every == 0:
            for pod in ready:
                pod.scrapes.append((now, pod.used_s))
            published.append((now + METRICS_AGE_S, [pod.usage() for pod in pods], list(pods)))
        if (tick - round(sync_phase_s / TICK_S)) % sync_every == 0:
            latest = [entry for entry in published if entry[0] <= now]
            if latest:
                known = dict(zip(map(id, latest[-1][2]), latest[-1][1]))
                usages = [known[id(pod)] for pod in pods if known.get(id(pod)) is not None]
                missing = sum(pod.ready_at <= now and len(pod.scrapes) < 2 for pod in pods if known.get(id(pod)) is None)
                if usages:
                    unready = len(pods) - len(usages) - missing
                    desired = desired_replicas(len(pods), usages, unready, missing, manifest.request_cores, manifest.target)
                    number = behaviour.next(now, len(pods), desired)
                    if number != len(pods):
                        outcome.replicas.append((now, number))
                    pods = pods[:number] + [Pod(now + pod_start_s) for _ in range(number - len(pods))]
    return outcome


def worst(outcomes):
    return max(outcomes, key=lambda outcome: (outcome.lost, outcome.shed, max(at for at, _ in outcome.replicas if at < STEP_S)))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--overlay", action="append", choices=("base", "production"), help="this one alone; may be repeated")
    arguments.add_argument("--step", action="append", type=float, help="times the usual load; may be repeated; default 2, 5 and 10")
    arguments.add_argument("--pod-start-s", type=float, default=5.0, help="from the decision until a pod gets requests, with its image on the node")
    arguments.add_argument(
        "--longest-wait-s", type=float, default=0.5,
        help="what the service lets a request wait before it sheds it: 0.5 for batches; 0.01 for single requests, of which 1024 are 20 us each on two cores",
    )
    options = arguments.parse_args()
    print("| manifests | step | replicas from the step on | last 503 after, s | shed attempts, of requests | lost, of requests | longest wait in the service, s |")
    print("|---|---|---|---|---|---|---|")
    for name in options.overlay or ("base", "production"):
        manifest = manifest_of(name)
        for factor in options.step or (2.0, 5.0, 10.0):
            phases = itertools.product((0.1, 5.1, 10.1), repeat=2)
            outcome = worst([simulate(manifest, factor, options.longest_wait_s, options.pod_start_s, *pair) for pair in phases])
            history = ", ".join(f"{number} at {at:.0f} s" if at else str(number) for at, number in outcome.replicas)
            shed, lost = (f"{amount / outcome.arrived:.1%}" for amount in (outcome.shed, outcome.lost))
            print(f"| {name} | {factor:g}x | {history} | {outcome.last_shed_s:.0f} | {shed} | {lost} | {outcome.longest_wait_s:.2g} |", flush=True)


if __name__ == "__main__":
    main()
