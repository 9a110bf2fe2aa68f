"""The container level of glTF: JSON, buffers, accessors, image bytes."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.decoders import DecoderError, MissingDecoderError, decoded_meshopt
from ssdo_gl.scene.files import contained_file, read_file
from ssdo_gl.scene.numbers import LARGEST_NUMBER, finite
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import shown

Json = dict[str, Any]

_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
# Accessors without data are all zeros; so many numbers in a file fill 256 MiB.
_MAX_ZEROS = 1 << 25
_INDEX_TYPES = (5121, 5123, 5125)
# What compressed buffer views of a file may hold: bytes, 1 GiB.
MAX_UNPACKED = 1 << 30
_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
# Of all morph targets that are kept: 512 MiB.
_MAX_MORPHS = 1 << 27


class GltfError(ValueError):
    """What is wrong with a file, without its name."""


class Document:
    """A parsed glTF file whose buffers are loaded on demand."""

    def __init__(self, path: Path, document: Json, binary: bytes | None) -> None:
        self.path, self.json = path, document
        self._binary = binary
        self._buffers: dict[int, bytes] = {}
        self._zeros = self._morphs = self._unpacked_size = 0
        self._unpacked: dict[int, bytes] = {}
        # Accessors that a compressed mesh stands for.
        self.decoded: dict[int, NDArray[Any]] = {}

    @classmethod
    def load(cls, path: Path, where: str) -> Document:
        """Read a .glb or .gltf file."""
        data = read_file(path, where)
        text, binary = data, None
        if data[:4] == b"glTF":
            text, binary = _split_glb(data)
        elif path.suffix.lower() == ".glb":
            raise GltfError("not a GLB file: it does not start with 'glTF'")
        try:
            document = json.loads(text.decode("utf-8-sig"))
        except UnicodeDecodeError as error:
            raise GltfError(f"not valid glTF: byte {error.start} is not UTF-8 text") from None
        except json.JSONDecodeError as error:
            raise GltfError(
                f"not valid glTF: line {error.lineno}, column {error.colno}: {error.msg}"
            ) from None
        except ValueError:  # Python reads at most 4300 digits
            raise GltfError("not valid glTF: a number has too many digits") from None
        except RecursionError:
            raise GltfError("not valid glTF: nested too deeply") from None
        # glTF 1.0 may leave the asset out; its lists are objects.
        is_first = isinstance(document, dict) and isinstance(document.get("meshes"), dict)
        if not isinstance(document, dict) or not ("asset" in document or is_first):
            raise GltfError("not valid glTF: no 'asset' in it")
        asset = document.get("asset", {"version": "1.0"})
        if not isinstance(asset, dict):
            raise GltfError(
                f'not valid glTF: asset is {shown(asset)}: expected {{"version": "2.0"}}'
            )
        version = str(asset.get("version", ""))
        if not version.startswith("2."):
            raise GltfError(f"glTF version {shown(version)}: expected 2.0; convert it first")
        return cls(path, document, binary)

    def entry(self, kind: str, index: object) -> Json:
        """Return an element of one of the document's lists, e.g. of ``nodes``."""
        entries = self.json.get(kind, [])
        # A Python list would take -1 for its last element, and True for its second.
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(entries):
            raise GltfError(f"refers to {kind} {shown(index)}, but there are {len(entries)}")
        entry = entries[index]
        if not isinstance(entry, dict):
            raise GltfError(f"{kind} {index} is not an object")
        return entry

    def buffer(self, index: int) -> bytes:
        """Return the bytes of a buffer: embedded, inline or in a file beside."""
        if index not in self._buffers:
            entry = self.entry("buffers", index)
            # The binary chunk is the first buffer; others without a uri stand in for
            # what is compressed.
            data = self._binary if index == 0 else None
            data = self._uri(entry["uri"]) if "uri" in entry else data
            if data is None:
                raise GltfError(f"buffer {index} has neither a uri nor a binary chunk")
            if len(data) < int(entry["byteLength"]):
                raise GltfError(
                    f"buffer {index} is truncated: {len(data)} of {entry['byteLength']} bytes"
                )
            self._buffers[index] = data
        return self._buffers[index]

    def view(self, index: int) -> tuple[bytes, int, int]:
        """Return buffer, offset and length of a buffer view, within the buffer."""
        view = self.entry("bufferViews", index)
        packed = compressed(view)
        if packed is not None:
            if index not in self._unpacked:
                self._unpacked[index] = self._unpack(index, packed)
            return self._unpacked[index], 0, len(self._unpacked[index])
        return self._part(view, f"buffer view {index}")

    def _part(self, part: Json, where: str) -> tuple[bytes, int, int]:
        data = self.buffer(part["buffer"])
        start, length = int(part.get("byteOffset", 0)), int(part["byteLength"])
        if start < 0 or length < 0 or start + length > len(data):
            raise GltfError(f"{where} reaches beyond its buffer")
        return data, start, length

    def _unpack(self, index: int, packed: Json) -> bytes:
        """Return the bytes of a buffer view of EXT_meshopt_compression."""
        where = f"buffer view {index}"
        data, start, length = self._part(packed, where)
        count, size = int(packed["count"]), int(packed["byteStride"])
        self._unpacked_size += max(count, 0) * max(size, 0)
        if count < 1 or not 1 <= size <= 256 or self._unpacked_size > MAX_UNPACKED:
            raise GltfError(
                f"{where} has {count} elements of {size} bytes: "
                f"at most {MAX_UNPACKED} bytes in all are unpacked"
            )
        mode, filter_name = str(packed["mode"]), str(packed.get("filter", "NONE"))
        part = data[start : start + length]
        try:
            return decoded_meshopt(part, count, size, mode, filter_name)
        except MissingDecoderError as error:
            raise GltfError(f"{where}: EXT_meshopt_compression {error}") from None
        except DecoderError as error:
            raise GltfError(f"{where}: not valid meshopt compression: {error}") from None

    def accessor(self, index: int, widths: tuple[int, ...]) -> FloatArray:
        """Return an accessor as (count, width) float64, normalised integers as 0..1.

        Parameters
        ----------
        widths : tuple of int
            How many numbers an element may have.
        """
        accessor = self.entry("accessors", index)
        values = self.raw_accessor(index, widths).astype(np.float64)
        kind = _DTYPES[accessor["componentType"]][1:]
        if accessor.get("normalized", False) and kind[0] in "iu":
            # Signed values map their most negative number below -1; the format clamps it.
            values = np.maximum(values / float(np.iinfo(kind).max), -1.0)
        return values

    def count_morphs(self, count: int) -> None:
        """Refuse morph targets of more numbers than the memory should hold."""
        self._morphs += count
        if self._morphs > _MAX_MORPHS:
            raise GltfError(f"morph targets of more than {_MAX_MORPHS} numbers in all")

    def index_accessor(self, index: int) -> NDArray[np.int64]:
        """Return an accessor of whole numbers, shape (count,)."""
        if self.entry("accessors", index)["componentType"] not in _INDEX_TYPES:
            raise GltfError(f"accessor {index}: indices must be unsigned integers")
        return self.raw_accessor(index, (1,))[:, 0].astype(np.int64)

    def raw_accessor(self, index: int, widths: tuple[int, ...]) -> NDArray[Any]:
        """Return an accessor as (count, width) of its own component type."""
        accessor = self.entry("accessors", index)
        dtype = np.dtype(_DTYPES[accessor["componentType"]])
        width, count = _WIDTHS[accessor["type"]], int(accessor["count"])
        if width not in widths:
            raise GltfError(
                f"accessor {index}: {accessor['type']} of {width} numbers, "
                f"expected {' or '.join(map(str, widths))}"
            )
        offset = int(accessor.get("byteOffset", 0))
        if index in self.decoded:
            values = self.decoded[index]
            if values.shape != (count, width):
                raise GltfError(
                    f"accessor {index}: {count} elements of {width} numbers, but its mesh "
                    f"holds {len(values)} of {values.shape[1]}"
                )
            values = values.astype(dtype)
        elif "bufferView" in accessor:
            values = self._elements(accessor["bufferView"], offset, dtype, count, width)
        else:
            self._zeros += count * width
            if count < 0 or self._zeros > _MAX_ZEROS:
                raise GltfError(
                    f"accessor {index} asks for {count} elements without data: "
                    f"at most {_MAX_ZEROS} zeros in all are made"
                )
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], dtype)
        return values

    def _elements(
        self, view_index: int, offset: int, dtype: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        data, start, length = self.view(view_index)
        packed = dtype.itemsize * width
        stride = int(self.entry("bufferViews", view_index).get("byteStride", packed))
        needed = offset + (stride * (count - 1) + packed if count > 0 else 0)
        if offset < 0 or count < 0 or stride < packed or needed > length:
            raise GltfError(f"an accessor reaches beyond buffer view {view_index}")
        return np.ndarray((count, width), dtype, data, start + offset, (stride, dtype.itemsize))

    def _with_sparse(
        self, values: NDArray[Any], sparse: Json, dtype: np.dtype[Any]
    ) -> NDArray[Any]:
        count = int(sparse["count"])
        rows, replaced = sparse["indices"], sparse["values"]
        index = self._elements(
            rows["bufferView"],
            int(rows.get("byteOffset", 0)),
            np.dtype(_DTYPES[rows["componentType"]]),
            count,
            1,
        )[:, 0]
        if count and int(index.max()) >= len(values):
            raise GltfError(f"a sparse accessor replaces element {index.max()} of {len(values)}")
        result = values.copy()
        result[index] = self._elements(
            replaced["bufferView"],
            int(replaced.get("byteOffset", 0)),
            dtype,
            count,
            values.shape[1],
        )
        return result

    def image(self, index: int) -> bytes:
        """Return the encoded bytes of an image."""
        image = self.entry("images", index)
        if "bufferView" in image:
            data, start, length = self.view(image["bufferView"])
            return data[start : start + length]
        return self._uri(image["uri"])

    def _uri(self, uri: str) -> bytes:
        if not isinstance(uri, str):
            raise GltfError("a uri is not a text")
        if uri[:5].lower() == "data:":
            return _data_of(uri)
        where = f"{self.path.name}: uri"
        try:
            path = contained_file(self.path, unquote(uri), where)
        except SceneError:
            # Exporters forget to escape a % of the name itself.
            if "%" not in uri:
                raise
            path = contained_file(self.path, uri, where)
        return read_file(path, path.name)


def compressed(view: Json) -> Json | None:
    """Return how a buffer view is compressed, if it is."""
    extensions = view.get("extensions", {})
    return next((extensions[name] for name in _MESHOPT if name in extensions), None)


def _data_of(uri: str) -> bytes:
    """Return the bytes of a data: uri, with or without base64."""
    head, comma, body = uri.partition(",")
    if not comma:
        raise GltfError("a data: uri has no comma")
    data = unquote_to_bytes(body)
    if not head.lower().rstrip().endswith(";base64"):
        return data
    # White space and missing padding change nothing; both alphabets are in use.
    packed = b"".join(data.split()).rstrip(b"=").translate(bytes.maketrans(b"-_", b"+/"))
    try:
        return base64.b64decode(packed + b"=" * (-len(packed) % 4), validate=True)
    except binascii.Error:
        raise GltfError("a data: uri is not valid base64") from None


def numbers(data: Json, key: str, default: Sequence[float], where: str) -> FloatArray:
    """Return as many finite numbers under `key` as `default` has."""
    value = data.get(key, default)
    if isinstance(value, (list, tuple)) and len(value) == len(default):
        found = [number for number in map(finite, value) if number is not None]
        if len(found) == len(default):
            return np.array(found)
    raise GltfError(
        f"{where}: {key} = {shown(value)}: expected {len(default)} numbers up to {LARGEST_NUMBER:g}"
    )


def number(data: Json, key: str, default: float, where: str) -> float:
    """Return the finite number under `key`."""
    value = data.get(key, default)
    found = finite(value)
    if found is None:
        raise GltfError(
            f"{where}: {key} = {shown(value)}: expected a number up to {LARGEST_NUMBER:g}"
        )
    return found


def _split_glb(data: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON text and the binary chunk of a GLB container."""
    if len(data) < 20:
        raise GltfError(f"truncated GLB: {len(data)} bytes are less than its header")
    _, version, length = struct.unpack_from("<III", data)
    if version != 2:
        raise GltfError(f"GLB version {version}: expected 2")
    if length > len(data):
        raise GltfError(f"truncated GLB: its header says {length} bytes, there are {len(data)}")
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        if start + 8 + size > length:
            raise GltfError("truncated GLB: a chunk reaches beyond the end")
        chunks.setdefault(kind, data[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON_CHUNK not in chunks:
        raise GltfError("not valid GLB: no JSON chunk")
    return chunks[_JSON_CHUNK].rstrip(b"\0 "), chunks.get(_BINARY_CHUNK)
