"""The client's methods and typed dictionaries against the program's OpenAPI document, so that an operation or a member added there
is not forgotten here."""

from __future__ import annotations

import inspect
import json
import typing
import unittest
import urllib.request
from typing import Any, Dict, Set

import scallopd
from scallopd import calculations, objects, planning
from servers import ServiceCase

OTHER_NAMES = {
    "cutter_recommendation": "recommend",
    "cutter_recommendation_upload": "recommend_file",
    "path_check": "check_path",
    "path_check_upload": "check_path_file",
}
"""The methods that do not have their operation's name."""


def hints(method: Any) -> Dict[str, Any]:
    """The types of a method's parameters and of its answer, under `return`."""
    # `Unpack` is known to type checkers only; `Union[X]` is X.
    return typing.get_type_hints(method, localns={"Unpack": typing.Union})


def keys(dictionary: Any) -> Set[str]:
    """The keys of a typed dictionary, those of its bases included."""
    return set(dictionary.__required_keys__ | dictionary.__optional_keys__)


def parameters(method: Any) -> Set[str]:
    """The names of a method's parameters, those in the dictionary of `**parameters` included."""
    found = set()
    for name, parameter in inspect.signature(method).parameters.items():
        found |= keys(hints(method)[name]) if parameter.kind is parameter.VAR_KEYWORD else {name}
    return found


class Operations(ServiceCase):
    """Operations of the document, and members of their requests and answers."""

    document: Dict[str, Any]
    operations: Dict[str, Dict[str, Any]]
    """By the client's methods."""

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        with urllib.request.urlopen(f"{cls.service.url}/openapi.json") as answer:
            cls.document = json.load(answer)
        cls.operations = {}
        for path, item in cls.document["paths"].items():
            if path.startswith("/v1/"):
                # GET beside POST is the same operation, with its parameters in the query.
                operation = item.get("post") or item["get"]
                name = operation["operationId"]
                cls.operations[OTHER_NAMES.get(name, name)] = operation

    def resolved(self, schema: Dict[str, Any]) -> Dict[str, Any]:
        while "$ref" in schema:
            schema = self.document["components"]["schemas"][schema["$ref"].rsplit("/", 1)[1]]
        return schema

    def members(self, schema: Dict[str, Any]) -> Set[str]:
        """The names of a schema's properties, those of its parts and alternatives included."""
        schema = self.resolved(schema)
        found = set(schema.get("properties", {}))
        for part in schema.get("allOf", []) + schema.get("oneOf", []) + schema.get("anyOf", []):
            found |= self.members(part)
        return found

    def request_members(self, operation: Dict[str, Any]) -> Set[str]:
        if "requestBody" not in operation:
            return set()
        content = operation["requestBody"]["content"]
        if "application/json" in content:
            return self.members(content["application/json"]["schema"])
        form = self.resolved(content["multipart/form-data"]["schema"])
        return self.members(form["properties"]["parameters"])

    def test_each_operation_has_a_method_and_each_method_an_operation(self) -> None:
        methods = {name for area in scallopd.Client.__bases__ for name in vars(area) if not name.startswith("_")}
        self.assertEqual(set(self.operations), methods)

    def test_the_parameters_know_every_member_of_requests(self) -> None:
        for name, operation in self.operations.items():
            with self.subTest(name):
                self.assertEqual(self.request_members(operation) - parameters(getattr(scallopd.Client, name)), set())

    def test_the_types_know_every_member_of_answers(self) -> None:
        for name, operation in self.operations.items():
            with self.subTest(name):
                answer = operation["responses"]["200"]["content"]["application/json"]["schema"]
                returned = hints(getattr(scallopd.Client, name))["return"]
                if typing.get_origin(returned) is list:
                    # The method returns the list that is the answer's only member.
                    (returned,) = typing.get_args(returned)
                    (member,) = self.resolved(answer)["properties"].values()
                    answer = member["items"]
                self.assertEqual(self.members(answer) - keys(returned), set())


class Names(unittest.TestCase):
    """What the package offers."""

    def test_every_public_class_is_offered(self) -> None:
        for module in (calculations, planning, objects):
            for name, value in vars(module).items():
                # `Warning` would hide the built-in exception.
                if getattr(value, "__module__", None) == module.__name__ and not name.startswith("_") and name != "Warning":
                    self.assertIs(getattr(scallopd, name, None), value, f"{name} is missing in __all__ of {module.__name__}")

    def test_no_two_modules_offer_the_same_name(self) -> None:
        self.assertEqual(len(scallopd.__all__), len(set(scallopd.__all__)))


if __name__ == "__main__":
    unittest.main()
