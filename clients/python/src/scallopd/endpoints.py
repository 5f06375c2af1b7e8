"""What the classes with the client's methods have in common: requests to the endpoints of one server."""

from __future__ import annotations

import inspect
import re
import sys
from typing import Any, Dict, Mapping, Sequence, Tuple, Type, TypeVar, Union

from .errors import Problem
from .multipart import File, Form, Source
from .transport import JsonBody, Transport


class Endpoints:
    """Base class of the classes whose methods call one area's endpoints."""

    _transport: Transport
    _returns_failed_batches: bool

    def _get(self, endpoint: str) -> Any:
        return self._transport.call("GET", f"/v1/{endpoint}")

    def _post(self, endpoint: str, body: Mapping[str, Any]) -> Any:
        return self._transport.call("POST", f"/v1/{endpoint}", JsonBody(_without_none(body)))

    def _post_batch(self, endpoint: str, body: Mapping[str, Any]) -> Any:
        """Sends a batch. If all its contacts failed, the problem has the answer, which is returned by choice."""
        try:
            return self._post(endpoint, body)
        except Problem as problem:
            if self._returns_failed_batches and "answer" in problem.members:
                return problem.members["answer"]
            raise

    def _upload(self, endpoint: str, parameters: Mapping[str, Any], files: Sequence[Tuple[str, Union[Source, File]]]) -> Any:
        """Sends a form of `parameters` and of `files`, each with the name of its part."""
        parts = [(part, file if isinstance(file, File) else File(file)) for part, file in files]
        return self._transport.call("POST", f"/v1/{endpoint}", Form(_without_none(parameters), parts))


def _without_none(body: Mapping[str, Any]) -> Dict[str, Any]:
    return {name: value for name, value in body.items() if value is not None}


Class = TypeVar("Class", bound=Type[Endpoints])


def parameters_in_help(endpoints: Class) -> Class:
    """Adds to the text of each method the parameters that its `TypedDict` has, because `help` does not show them."""
    known = vars(sys.modules[endpoints.__module__])
    for method in vars(endpoints).values():
        if not inspect.isfunction(method):
            continue
        for annotation in method.__annotations__.values():
            unpacked = re.fullmatch(r"Unpack\[(\w+)\]", str(annotation))
            if unpacked:
                members = known[unpacked[1]].__annotations__
                lines = [f"    {name}: {_type_name(kind)}" for name, kind in members.items()]
                method.__doc__ = "\n".join(
                    [f"{method.__doc__}", "", "Further parameters, all optional unless the service needs them:", *lines]
                )
    return endpoints


def _type_name(kind: Any) -> str:
    """The name of a type as written in the source; a `TypedDict` stores it as a forward reference."""
    return str(getattr(kind, "__forward_arg__", getattr(kind, "__name__", kind)))
