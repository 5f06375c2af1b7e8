"""Checks that no schema covers: the files of Prometheus and Grafana, the references between the parts, and the image's build context."""

import json
import pathlib
import re
import sys

import yaml

DEPLOY = pathlib.Path(__file__).parent
faults = []


def check(condition, fault):
    if not condition:
        faults.append(fault)


def load(path):
    return yaml.safe_load((DEPLOY / path).read_text())


def balanced(expression):
    """Whether brackets are balanced outside quoted strings, which can be checked without a parser of PromQL."""
    open_ones = []
    for character in re.sub(r'"(\\.|[^"\\])*"', '""', expression):
        if character in "([{":
            open_ones.append(character)
        elif character in ")]}" and (not open_ones or open_ones.pop() + character not in ("()", "[]", "{}")):
            return False
    return not open_ones and expression.count('"') % 2 == 0


def check_alerts():
    names = set()
    for group in load("prometheus/alerts.yaml")["groups"]:
        for rule in group["rules"]:
            name = rule["alert"]
            check(name not in names, f"alert {name} is there twice")
            names.add(name)
            check(set(rule) <= {"alert", "expr", "for", "labels", "annotations"}, f"alert {name} has fields that Prometheus does not know")
            check(balanced(rule["expr"]), f"alert {name}: brackets or quotes are left open")
            check(re.fullmatch(r"\d+[smh]", rule.get("for", "0s")), f"alert {name}: {rule.get('for')} is no duration")
            check(rule["labels"].get("severity") in ("warning", "critical"), f"alert {name} has no severity")
            check({"summary", "description"} <= set(rule["annotations"]), f"alert {name} does not say what to do")


def check_prometheus():
    config = load("prometheus/prometheus.yaml")
    for file in config["rule_files"]:
        check((DEPLOY / "prometheus" / file).is_file(), f"the rule file {file} is not there")
    compose = load("compose.yaml")["services"]
    for job in config["scrape_configs"]:
        for target in (target for group in job["static_configs"] for target in group["targets"]):
            check(target.split(":")[0] in compose, f"Prometheus scrapes {target}, which compose.yaml does not start")


def check_compose():
    for name, service in load("compose.yaml")["services"].items():
        for volume in service.get("volumes", []):
            source = volume.split(":")[0]
            check(not source.startswith("./") or (DEPLOY / source).exists(), f"{name} mounts {source}, which is not there")


def check_dashboard():
    dashboard = json.loads((DEPLOY / "grafana/dashboards/scallopd.json").read_text())
    panels = dashboard["panels"]
    check(len({panel["id"] for panel in panels}) == len(panels), "two panels have one id")
    cells = set()
    for panel in panels:
        place = panel["gridPos"]
        covered = {(x, y) for x in range(place["x"], place["x"] + place["w"]) for y in range(place["y"], place["y"] + place["h"])}
        check(place["x"] + place["w"] <= 24, f"panel {panel['title']} leaves the grid")
        check(not covered & cells, f"panel {panel['title']} lies on another")
        cells |= covered
        for target in panel["targets"]:
            check(balanced(target["expr"]), f"panel {panel['title']}: brackets or quotes are left open")
    variables = {variable["name"] for variable in dashboard["templating"]["list"]} | {"__rate_interval", "__all"}
    used = set(re.findall(r"\$\{?(\w+)", json.dumps(dashboard)))
    check(used <= variables, f"the dashboard uses {used - variables}, which it does not define")
    datasource = load("grafana/provisioning/datasources/prometheus.yaml")["datasources"][0]["uid"]
    check(any(variable["current"].get("value") == datasource for variable in dashboard["templating"]["list"]), "the data source is another")


def check_build_context():
    """Every file that a build has read is in the image's build context. Cargo lists the files beside the program."""
    root = DEPLOY.parent
    lists = [path for path in (root / "target").glob("*/scallopd.d") if path.is_file()]
    if not lists:
        print("no build is here whose files could be compared with .dockerignore")
    ignored = [line for line in (root / ".dockerignore").read_text().splitlines() if line and not line.startswith("#")]
    for path in lists:
        names = re.split(r"(?<!\\) ", path.read_text().partition(": ")[2].strip())
        for name in (pathlib.Path(name) for name in names):
            if name.is_relative_to(root):
                relative = name.relative_to(root)
                check(is_in_context(relative, ignored), f"the build reads {relative}, which .dockerignore leaves out")


def is_in_context(path, ignored):
    """Whether the lines of .dockerignore leave a file in: the last that names it or a folder of it decides."""
    within = True
    for line in ignored:
        pattern = pathlib.PurePath(line.removeprefix("!"))
        if str(pattern) == "*" or pattern == path or pattern in path.parents:
            within = line.startswith("!")
    return within


for part in (check_alerts, check_prometheus, check_compose, check_dashboard, check_build_context):
    part()
print("\n".join(faults) or "Prometheus, Grafana, compose files and the build context agree")
sys.exit(bool(faults))
