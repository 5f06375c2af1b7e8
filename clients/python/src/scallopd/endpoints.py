"""What the classes with the client's methods have in common: requests to the endpoints of one server."""

from __future__ import annotations

from typing import Any, Dict, Mapping, Sequence, Tuple, Union

from .multipart import File, Form, Source
from .transport import JsonBody, Transport


class Endpoints:
    """Base class of the classes whose methods call one area's endpoints."""

    _transport: Transport

    def _get(self, endpoint: str) -> Any:
        return self._transport.call("GET", f"/v1/{endpoint}")

    def _post(self, endpoint: str, body: Mapping[str, Any]) -> Any:
        return self._transport.call("POST", f"/v1/{endpoint}", JsonBody(_without_none(body)))

    def _upload(self, endpoint: str, parameters: Mapping[str, Any], files: Sequence[Tuple[str, Union[Source, File]]]) -> Any:
        """Sends a form of `parameters` and of `files`, each with the name of its part."""
        parts = [(part, file if isinstance(file, File) else File(file)) for part, file in files]
        return self._transport.call("POST", f"/v1/{endpoint}", Form(_without_none(parameters), parts))


def _without_none(body: Mapping[str, Any]) -> Dict[str, Any]:
    return {name: value for name, value in body.items() if value is not None}
