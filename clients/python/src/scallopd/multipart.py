"""A form of files (multipart/form-data, RFC 7578), written while it is sent."""

from __future__ import annotations

import io
import json
import os
import secrets
from typing import Any, BinaryIO, Iterator, List, Optional, Sequence, Tuple, Union

__all__ = ["File", "Source"]

Source = Union[str, os.PathLike[str], bytes, bytearray, memoryview, BinaryIO]
"""What a file is read from: a path (`str` or `PathLike`), bytes, or an open binary file."""

CHUNK_BYTES = 256 * 1024


class File:
    """A part that is a file."""

    def __init__(self, source: Source, name: Optional[str] = None) -> None:
        self._path: Optional[str] = None
        self._file: Optional[BinaryIO] = None
        self._start = 0
        given = name
        if isinstance(source, (bytes, bytearray, memoryview)):
            self._file = io.BytesIO(source)
        elif isinstance(source, (str, os.PathLike)):
            self._path = os.fspath(source)
            given = name or os.path.basename(self._path)
        elif hasattr(source, "read"):
            self._file = source
            own_name = getattr(source, "name", None)
            given = name or (os.path.basename(own_name) if isinstance(own_name, str) else None)
        else:
            raise TypeError(f"a file is a path, bytes or an open binary file, not {type(source).__name__}")
        self.name = given or "file"
        self.replayable = self._path is not None or (self._file is not None and self._file.seekable())
        if self._file is not None and self.replayable:
            self._start = self._file.tell()

    def length(self) -> Optional[int]:
        """The number of bytes from the file's position to its end; None if it is known only after reading."""
        if self._path is not None:
            return os.stat(self._path).st_size
        if not self.replayable or self._file is None:
            return None
        end = self._file.seek(0, os.SEEK_END)
        self._file.seek(self._start)
        return end - self._start

    def chunks(self, length: Optional[int]) -> Iterator[bytes]:
        """The bytes. `length` is the announced length: of a longer file only so many bytes are sent, a shorter one is an error."""
        if self._path is not None:
            with open(self._path, "rb") as file:
                yield from _read(file, length, self.name)
        elif self._file is not None:
            if self.replayable:
                self._file.seek(self._start)
            yield from _read(self._file, length, self.name)


def _read(file: BinaryIO, length: Optional[int], name: str) -> Iterator[bytes]:
    left = length
    while left is None or left > 0:
        chunk = file.read(CHUNK_BYTES if left is None else min(CHUNK_BYTES, left))
        if not isinstance(chunk, bytes):
            raise TypeError(f"{name} is open as text; open it with mode 'rb'")
        if not chunk:
            if left is not None:
                raise ValueError(f"{name} became shorter while it was sent")
            return
        if left is not None:
            left -= len(chunk)
        yield chunk


class Form:
    """The parts `parameters` (JSON) and any files, as the body of a request."""

    def __init__(self, parameters: Any, files: Sequence[Tuple[str, File]]) -> None:
        # 128 random bits do not occur in a file by chance.
        boundary = secrets.token_hex(16)
        self.content_type = f"multipart/form-data; boundary={boundary}"
        self.replayable = all(file.replayable for _, file in files)
        self._parameters = self._head(boundary, "parameters", None, "application/json") + json.dumps(parameters).encode()
        self._files: List[Tuple[bytes, File]] = [
            (b"\r\n" + self._head(boundary, part, file.name, "application/octet-stream"), file) for part, file in files
        ]
        self._sizes: List[Optional[int]] = [None] * len(files)
        self._end = f"\r\n--{boundary}--\r\n".encode()

    @staticmethod
    def _head(boundary: str, part: str, file_name: Optional[str], content_type: str) -> bytes:
        # Quotes and line ends in a file name are escaped as browsers do.
        escaped = (file_name or "").replace('"', "%22").replace("\r", "%0D").replace("\n", "%0A")
        file = "" if file_name is None else f'; filename="{escaped}"'
        return f'--{boundary}\r\ncontent-disposition: form-data; name="{part}"{file}\r\ncontent-type: {content_type}\r\n\r\n'.encode()

    def length(self) -> Optional[int]:
        sizes = [file.length() for _, file in self._files]
        known = [size for size in sizes if size is not None]
        if len(known) < len(sizes):
            self._sizes = [None] * len(sizes)
            return None
        self._sizes = sizes
        return len(self._parameters) + sum(len(head) for head, _ in self._files) + sum(known) + len(self._end)

    def chunks(self) -> Iterator[bytes]:
        yield self._parameters
        for (head, file), size in zip(self._files, self._sizes):
            yield head
            yield from file.chunks(size)
        yield self._end
