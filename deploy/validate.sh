#!/bin/sh
# Checks the deployment files without deploying them: manifests against the Kubernetes schemas, the compose file against its own, alert
# rules and dashboard as far as possible without Prometheus, and the Dockerfile. A test of the service checks the names of metrics.
# The Python tools go into a virtual environment under target/. promtool and docker are used
# where they are; checks that were skipped are listed at the end.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
tools=target/deploy-tools
if [ ! -x "$tools/bin/hadolint" ]; then
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet --disable-pip-version-check -r deploy/validate-requirements.txt
fi
left_out=

say() { printf '== %s\n' "$*"; }

for overlay in development production; do
    say "kubernetes overlay $overlay"
    rendered="target/kubernetes-$overlay.yaml"
    kubectl kustomize "deploy/kubernetes/overlays/$overlay" > "$rendered"
    "$tools/bin/kubernetes-validate" --strict "$rendered"
done

say "Dockerfile"
"$tools/bin/hadolint" Dockerfile

say "compose file, Prometheus, Grafana"
"$tools/bin/check-jsonschema" --builtin-schema vendor.compose-spec deploy/compose.yaml
"$tools/bin/python" deploy/validate.py

say "the simulated autoscaler's rule"
"$tools/bin/python" -m unittest discover --quiet --start-directory deploy

if command -v haproxy > /dev/null; then
    say "proxy"
    SCALLOPD_PROXY_SOCKET="$root/target/haproxy.sock" haproxy -c -q -f deploy/haproxy.cfg
else
    left_out="$left_out haproxy (its own reading of deploy/haproxy.cfg)"
fi

if command -v promtool > /dev/null; then
    promtool check config deploy/prometheus/prometheus.yaml
    promtool check rules deploy/prometheus/alerts.yaml
else
    left_out="$left_out promtool (syntax of the rules' expressions)"
fi
if docker compose version > /dev/null 2>&1; then
    GRAFANA_PASSWORD=check docker compose --file deploy/compose.yaml config --quiet
else
    left_out="$left_out docker-compose (its own reading of the compose file)"
fi
[ -z "$left_out" ] || say "not here, left out:$left_out"
say "all valid"
