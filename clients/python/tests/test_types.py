"""The typed dictionaries against the program's OpenAPI document, so that a member added there is not forgotten here."""

from __future__ import annotations

import json
import unittest
import urllib.request
from typing import Any, Dict, Set

from scallopd import objects
from servers import ServiceCase

# What a method's own parameters send, beside the typed dictionary of the others.
CONTACT = {"cutter", "contact"}
TOLERANCE = {"cutter", "contact", "scallop_tolerance_mm"}
BATCH = {"cutter", "contacts"}
TOLERANCE_BATCH = {"cutter", "contacts", "scallop_tolerance_mm"}
OPERATIONS: Dict[str, Any] = {
    "scallop-height": (CONTACT, objects.HeightParameters, objects.ScallopHeight),
    "max-feed": (TOLERANCE, objects.FeedParameters, objects.MaxFeed),
    "step-over": (TOLERANCE, objects.StepOverParameters, objects.StepOver),
    "cutting-parameters": (TOLERANCE, objects.CuttingLimits, objects.CuttingParameters),
    "scallop-height/batch": (BATCH, objects.HeightBatchParameters, objects.HeightColumns),
    "max-feed/batch": (TOLERANCE_BATCH, objects.FeedBatchParameters, objects.FeedColumns),
    "step-over/batch": (TOLERANCE_BATCH, objects.StepOverBatchParameters, objects.HeightColumns),
    "cutting-parameters/batch": (TOLERANCE_BATCH, objects.CuttingBatchLimits, objects.CuttingColumns),
    "critical-slope": (
        {"toroidal", "ball_end", "scallop_height_mm", "machine"},
        objects.CriticalSlopeParameters,
        objects.CriticalSlope,
    ),
    "cutter-recommendation": (
        {"surface", "cutters", "scallop_height_mm", "machine"},
        objects.RecommendationParameters,
        objects.Recommendation,
    ),
}


class Types(ServiceCase):
    """Members of requests and answers."""

    def members(self, schema: Dict[str, Any]) -> Set[str]:
        """The names of a schema's properties, those of its parts and alternatives included."""
        while "$ref" in schema:
            schema = self.document["components"]["schemas"][schema["$ref"].rsplit("/", 1)[1]]
        found = set(schema.get("properties", {}))
        for part in schema.get("allOf", []) + schema.get("oneOf", []) + schema.get("anyOf", []):
            found |= self.members(part)
        return found

    def test_the_types_know_every_member_of_requests_and_answers(self) -> None:
        with urllib.request.urlopen(f"{self.service.url}/openapi.json") as answer:
            self.document = json.load(answer)
        checked = 0
        for operation, (own, request, answered) in OPERATIONS.items():
            description = self.document["paths"].get(f"/v1/{operation}", {}).get("post")
            # A program that compares exactly two cutters has other members, which this package does not offer.
            if description is None or (operation == "cutter-recommendation" and not self.service.offers("cutters")):
                continue
            checked += 1
            with self.subTest(operation):
                body = description["requestBody"]["content"]["application/json"]["schema"]
                self.assertEqual(self.members(body) - own - set(request.__annotations__), set())
                result = description["responses"]["200"]["content"]["application/json"]["schema"]
                self.assertEqual(self.members(result) - set(answered.__annotations__), set())
        self.assertGreater(checked, 5)


if __name__ == "__main__":
    unittest.main()
