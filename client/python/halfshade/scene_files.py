"""The files of a scene, read for an upload: the .glb or .gltf and what its buffers and images name.

Only regular files inside the scene's folder are read, links resolved first.
"""

import hashlib
import json
import pathlib
import re
import stat
import struct
import urllib.parse
from dataclasses import dataclass


class SceneFileError(ValueError):
    """A scene names what may not, or cannot, be read; the message starts with the JSON pointer."""


@dataclass(frozen=True)
class SceneFiles:
    """root and files (relative URI, percent-decoded -> bytes), and the name that their content gives the scene."""

    root: bytes
    files: dict[str, bytes]

    @property
    def name(self) -> str:
        """"scenes/<hex>"."""
        # Sorted by the URI's bytes.
        lines = [f"{digest(self.root)}\n"]
        lines += [f"{digest(self.files[uri])} {uri}\n" for uri in sorted(self.files, key=lambda uri: uri.encode())]
        return "scenes/" + digest("".join(lines).encode())


def digest(data: bytes) -> str:
    """Hex SHA-256."""
    return hashlib.sha256(data).hexdigest()


def _gltf_of(root: bytes) -> dict:
    """The JSON of a GLB (its first chunk) or of a .gltf; {} where it is broken: the server will say how."""
    text = root
    if root[:4] == b"glTF":
        if len(root) < 20 or root[16:20] != b"JSON":
            return {}
        text = root[20 : 20 + struct.unpack_from("<I", root, 12)[0]]
    try:
        gltf = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return gltf if isinstance(gltf, dict) else {}


def _read_in_folder(folder: pathlib.Path, uri: str, place: str) -> bytes:
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]*:", uri):
        raise SceneFileError(f"{place}: {uri[:200]!r}: has a scheme; only files in the scene's folder are read")
    name = urllib.parse.unquote(uri)
    try:
        path = (folder / name).resolve()
        if name.startswith("/") or not path.is_relative_to(folder):
            raise SceneFileError(f"{place}: {uri[:200]!r}: outside the scene's folder")
        if not stat.S_ISREG(path.stat().st_mode):
            raise SceneFileError(f"{place}: {uri[:200]!r}: is not a regular file")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, SceneFileError):
            raise
        raise SceneFileError(f"{place}: {uri[:200]!r}: {error}") from error


def read_scene_files(path: str | pathlib.Path) -> SceneFiles:
    """Raises OSError where `path` itself cannot be read, SceneFileError for what it names."""
    path = pathlib.Path(path)
    root = path.read_bytes()
    folder = path.parent.resolve()
    gltf = _gltf_of(root)
    files: dict[str, bytes] = {}
    for kind in ("buffers", "images"):
        entries = gltf.get(kind)
        for i, entry in enumerate(entries if isinstance(entries, list) else []):
            uri = entry.get("uri") if isinstance(entry, dict) else None
            if not isinstance(uri, str) or uri[:5].lower() == "data:":
                continue
            name = urllib.parse.unquote(uri)
            if name not in files:
                files[name] = _read_in_folder(folder, uri, f"/{kind}/{i}/uri")
    return SceneFiles(root, files)
