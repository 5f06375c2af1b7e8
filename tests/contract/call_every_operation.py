"""Calls every operation once with the generated Python client, sending the document's examples and expecting their answers.

Usage: call_every_operation.py OPENAPI_JSON BASE_URL, with the generated package `scallopd_client` on the path.
"""

import importlib
import json
import math
import sys
from pathlib import Path

from scallopd_client import Client


def alike(expected, found, place=""):
    """Fails unless the JSON values agree, numbers to 1e-9 relative: another machine's sine may differ in the last digits."""
    if isinstance(expected, dict):
        assert expected.keys() == found.keys(), f"{place}: {sorted(expected)} expected, found {sorted(found)}"
        for key in expected:
            alike(expected[key], found[key], f"{place}/{key}")
    elif isinstance(expected, list):
        assert len(expected) == len(found), f"{place}: {len(expected)} items expected, found {len(found)}"
        for index, (one, other) in enumerate(zip(expected, found)):
            alike(one, other, f"{place}/{index}")
    elif isinstance(expected, float):
        assert math.isclose(expected, found, rel_tol=1e-9, abs_tol=1e-12), f"{place}: {expected} expected, found {found}"
    else:
        assert expected == found, f"{place}: {expected!r} expected, found {found!r}"


def body_class(module):
    """The class of the request that the generated module takes."""
    return module.sync_detailed.__annotations__["body"]


def body_of(operation, module):
    """The example request as the generated client takes it."""
    content = operation["requestBody"]["content"]
    models = importlib.import_module("scallopd_client.models")
    model = getattr(models, str(body_class(module)).split(".")[-1].strip("'>"))
    if "multipart/form-data" in content:
        form = content["multipart/form-data"]["example"]
        return model.from_dict({name: part.encode() if isinstance(part, str) else part for name, part in form.items()})
    return model.from_dict(content["application/json"]["example"])


def main(document, base_url):
    client = Client(base_url=base_url)
    called = 0
    for path, methods in json.loads(Path(document).read_text())["paths"].items():
        for operation in methods.values():
            if "parameters" in operation:
                # The client's functions want enumerations for words; the document's examples are the words themselves.
                examples = {parameter["name"]: parameter["example"] for parameter in operation["parameters"] if "example" in parameter}
                query = {name: ",".join(map(str, value)) if isinstance(value, list) else value for name, value in examples.items()}
                response = client.get_httpx_client().get(path, params=query)
                assert response.status_code == 200, f"GET {path}: {response.status_code} {response.content!r}"
                alike(operation["responses"]["200"]["content"]["application/json"]["example"], response.json(), path)
                called += 1
                continue
            module = importlib.import_module(f"scallopd_client.api.{operation['tags'][0]}.{operation['operationId']}")
            arguments = {"body": body_of(operation, module)} if "requestBody" in operation else {}
            response = module.sync_detailed(client=client, **arguments)
            assert response.status_code == 200, f"{path}: {response.status_code} {response.content!r}"
            expected = operation["responses"]["200"]["content"].get("application/json", {}).get("example")
            if expected is not None:
                alike(expected, json.loads(response.content), path)
                # The client's answer, written as JSON again, equals the answer.
                alike(expected, response.parsed.to_dict(), f"{path} as parsed")
            called += 1
    refused(client)
    print(f"{called} operations called, and a problem read")


def refused(client):
    """A problem is read with its figure."""
    models = importlib.import_module("scallopd_client.models")
    request = models.MaxFeedRequest(
        cutter=models.BallEndCutter(type_=models.BallEndCutterType.BALL_END, diameter_mm=10),
        contact=models.AngleContact(slope_deg=40, feed_angle_deg=30),
        scallop_tolerance_mm=0.01,
        step_over_mm=0.8,
    )
    problem = importlib.import_module("scallopd_client.api.calculations.max_feed").sync(client=client, body=request)
    assert problem.type_ == "tolerance-exceeded", problem
    # sqrt(8 R h) to the leading order.
    assert math.isclose(problem.max_step_over_mm, math.sqrt(8 * 5 * 0.01), rel_tol=1e-3), problem


if __name__ == "__main__":
    main(*sys.argv[1:])
