"""Sends and reads objects of the classes that datamodel-code-generator generates from the OpenAPI document.

Usage: check_models.py OPENAPI_JSON BASE_URL, with the generated module `scallopd_models` on the path.
"""

import json
import sys
from pathlib import Path
from typing import Any, get_args

import httpx
import scallopd_models as models
from pydantic import MISSING, BaseModel

CUTTER = models.Cutter(models.ToroidalCutter(type="toroidal", diameter_mm=10, corner_radius_mm=2, teeth=4))
CONTACT = models.Contact(models.AngleContact(slope_deg=40, feed_angle_deg=30))


def post(base_url: str, path: str, request: BaseModel) -> httpx.Response:
    content = request.model_dump_json(by_alias=True)
    return httpx.post(f"{base_url}{path}", content=content, headers={"content-type": "application/json"})


def calls(base_url: str) -> None:
    """Typed calls, an answer with null, and a typed problem."""
    height = models.ScallopHeightRequest(cutter=CUTTER, contact=CONTACT, step_over_mm=0.687, feed_per_tooth_mm=0.3)
    answer = models.ScallopHeightAnswer.model_validate_json(post(base_url, "/v1/scallop-height", height).content)
    assert abs(answer.scallop_height_mm - 0.01305) < 1e-4, answer

    tapered = models.Cutter(models.TaperedBallCutter(type="tapered_ball", diameter_mm=2, taper_deg=5, shank_diameter_mm=6))
    height = models.ScallopHeightRequest(cutter=tapered, contact=CONTACT, step_over_mm=0.1)
    assert post(base_url, "/v1/scallop-height", height).status_code == 200

    contacts = models.Contacts1([models.AngleContactWithStepOver(slope_deg=slope, feed_angle_deg=90) for slope in (20, 0)])
    batch = models.MaxFeedBatchRequest(cutter=CUTTER, contacts=contacts, scallop_tolerance_mm=0.012, step_over_mm=0.4)
    columns = models.MaxFeedBatchAnswer.model_validate_json(post(base_url, "/v1/max-feed/batch", batch).content)
    assert columns.feed_rate_mm_min is MISSING and columns.feed_per_tooth_mm is not MISSING, columns
    assert len(columns.feed_per_tooth_mm) == 2 and columns.feed_per_tooth_mm[1] is None, columns

    feed = models.MaxFeedRequest(cutter=CUTTER, contact=CONTACT, scallop_tolerance_mm=0.013, step_over_mm=0.987)
    problem = models.UnprocessableProblem.model_validate_json(post(base_url, "/v1/max-feed", feed).content).root
    assert isinstance(problem, models.ToleranceExceededProblem), problem
    assert abs(problem.max_step_over_mm - 0.783) < 1e-3, problem


def upload(base_url: str, document: Any) -> None:
    """A form of a file and generated parameters."""
    form = document["paths"]["/v1/cutter-recommendation/upload"]["post"]["requestBody"]["content"]["multipart/form-data"]["example"]
    parameters = models.RecommendationParameters.model_validate(form["parameters"])
    files: Any = {
        "surface": ("surface.csv", form["surface"]),
        "parameters": (None, parameters.model_dump_json(by_alias=True), "application/json"),
    }
    response = httpx.post(f"{base_url}/v1/cutter-recommendation/upload", files=files)
    answer = models.RecommendationAnswer.model_validate_json(response.content)
    assert answer.recommended.name == "T10", answer


def optional_is_not_nullable() -> None:
    """A member that may be absent is distinguished from one that may be null."""
    fields = models.ScallopHeightRequest.model_fields
    assert MISSING in get_args(fields["feed_per_tooth_mm"].annotation) and type(None) not in get_args(
        fields["feed_per_tooth_mm"].annotation
    )
    try:
        models.ScallopHeightRequest.model_validate({"cutter": CUTTER, "contact": CONTACT, "step_over_mm": None})
    except ValueError:
        pass
    else:
        raise AssertionError("null stands for an absent step-over")
    nullable = models.ScallopHeightAnswer.model_fields["effective_radius_mm"]
    assert nullable.is_required() and type(None) in get_args(nullable.annotation), nullable


def round_trips(document: Any) -> int:
    """Every example of a request or an answer, read and written again, is the same."""
    count = 0
    for methods in document["paths"].values():
        for operation in methods.values():
            contents = [operation.get("requestBody", {}).get("content", {}), operation["responses"]["200"]["content"]]
            for content in (content.get("application/json", {}) for content in contents):
                if "example" in content and "$ref" in content["schema"]:
                    model: type[BaseModel] = getattr(models, content["schema"]["$ref"].rsplit("/", 1)[1])
                    written = model.model_validate(content["example"]).model_dump(mode="json", by_alias=True)
                    assert written == content["example"], f"{model.__name__}: {written} for {content['example']}"
                    count += 1
    return count


def main(path: str, base_url: str) -> None:
    document = json.loads(Path(path).read_text())
    calls(base_url)
    upload(base_url, document)
    optional_is_not_nullable()
    print(f"datamodel-code-generator: typed calls, a typed problem, an upload and {round_trips(document)} examples")


if __name__ == "__main__":
    main(*sys.argv[1:])
