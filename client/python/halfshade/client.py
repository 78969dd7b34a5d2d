"""The client: connect, upload, render, query, batch."""

import concurrent.futures
import itertools
import pathlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import grpc
import numpy as np
from google.protobuf.message import Message

from halfshade.scene_files import SceneFiles, digest, read_scene_files
from halfshade.v1 import render_pb2, render_pb2_grpc, report_pb2, scene_pb2, scene_pb2_grpc

_CHUNK_BYTES = 1 << 20
_ATTEMPTS = 6  # of a call that is UNAVAILABLE: 6 s with pauses that double from 0.2 s
_RETRY_S = 60.0  # no further attempt after so long
_MAX_REPLY_BYTES = 6 << 20
_DTYPES = {render_pb2.ENCODING_RAW_F32: np.dtype("<f4"), render_pb2.ENCODING_RAW_F16: np.dtype("<f2")}


class HalfshadeError(Exception):
    """What the server answered: `code` (a grpc.StatusCode) and its words."""

    def __init__(self, code: grpc.StatusCode, message: str):
        super().__init__(f"{code.name}: {message}")
        self.code = code
        self.message = message


@dataclass(frozen=True)
class RenderResult:
    """Images by the lower-case name of their kind, and the server's report.

    images: read-only arrays (height, width, channels), row 0 on top, float32 or float16, of the wire's kinds:
      frame            4: linear r, g, b over the background, and coverage
      visibility       1 for each light, 0 to 1, 1 = lit
      soft_shadow_map  2, light_map_size a side: visibility, light_z (metres)
      depth            1: metres along the camera's axis, 0: nothing
      normal           3: unit, world axes
      albedo           3: linear
      object_id        1: node index + 1, 0: nothing
      position         3: metres, world
      penumbra_width   1 for each light: metres on the receiver
    report.outputs[i].pixel_sha256 is the SHA-256 of the i-th array's bytes.
    """

    images: dict[str, np.ndarray]
    report: report_pb2.RenderReport

    def __getitem__(self, kind: str) -> np.ndarray:
        return self.images[kind]


def _set_fields(message: Message, fields: Mapping[str, Any]) -> None:
    """Sets fields by their proto names: nested mappings, lists, and three numbers for a Vec3 or Rgb."""
    for name, value in fields.items():
        field = message.DESCRIPTOR.fields_by_name.get(name)
        if field is None:
            known = ", ".join(message.DESCRIPTOR.fields_by_name)
            raise ValueError(f"{message.DESCRIPTOR.name} has no field {name!r}; it has {known}")
        if field.message_type is None:
            if field.label == field.LABEL_REPEATED:
                getattr(message, name).extend(value)
            else:
                setattr(message, name, _enum_number(field, value) if field.enum_type else value)
        elif field.label == field.LABEL_REPEATED:
            for element in value:
                _set_message(getattr(message, name).add(), element)
        else:
            _set_message(getattr(message, name), value)


def _set_message(message: Message, value: Any) -> None:
    message.SetInParent()
    if isinstance(value, Message):
        message.CopyFrom(value)
    elif isinstance(value, Mapping):
        _set_fields(message, value)
    else:  # Vec3 x y z, Rgb r g b
        names = [field.name for field in message.DESCRIPTOR.fields]
        numbers = [float(number) for number in value]
        if len(names) != 3 or len(numbers) != 3:
            raise ValueError(f"{message.DESCRIPTOR.name}: {value!r} is neither its fields nor three numbers")
        _set_fields(message, dict(zip(names, numbers)))


def _enum_number(field: Any, value: Any) -> int:
    """"aces" -> TONE_MAP_ACES; numbers as they are."""
    if not isinstance(value, str):
        return value
    matches = [v for v in field.enum_type.values if v.name == value.upper() or v.name.endswith("_" + value.upper())]
    if len(matches) != 1:
        raise ValueError(f"{field.name}: {value!r} is none of {', '.join(v.name for v in field.enum_type.values)}")
    return matches[0].number


def make_request(
    scene: str, outputs: Sequence[str] = ("frame",), *, half: bool = False, **fields: Any
) -> render_pb2.RenderRequest:
    """A RenderRequest for arrays.

    scene: "scenes/<hex>", as Client.upload returns it. outputs: kinds, lower case, each once. half: float16 arrays.
    fields: the others of RenderRequest by name, nested ones as mappings, vectors as three numbers:
      width=640, camera={"look_at": {"eye": (0, 2, 5), "target": (0, 0, 0)}}, method={"shaft": {"rows": 16}}
    Raises ValueError for a name that is none; values are the server's to judge.
    """
    request = render_pb2.RenderRequest(scene=scene)
    encoding = render_pb2.ENCODING_RAW_F16 if half else render_pb2.ENCODING_RAW_F32
    kinds = render_pb2.OutputKind.DESCRIPTOR.values_by_name
    if len(set(outputs)) != len(outputs):
        raise ValueError(f"outputs: {outputs!r} has a kind twice")
    for kind in outputs:
        name = "OUTPUT_KIND_" + kind.upper()
        if name not in kinds or kinds[name].number == 0:
            known = [v.name.removeprefix("OUTPUT_KIND_").lower() for v in kinds.values() if v.number]
            raise ValueError(f"outputs: no kind {kind!r}; there are {', '.join(known)}")
        request.outputs.add(kind=kinds[name].number, encoding=encoding)
    if "outputs" in fields or "scene" in fields:
        raise ValueError("scene and outputs are the first two arguments")
    _set_fields(request, fields)
    return request


class Client:
    """Talks to one server; may be used by several threads.

    Calls that fail for now are made again: UNAVAILABLE up to 6 times within 6 s, RESOURCE_EXHAUSTED after the pause
    that the server asks for, both for a minute at most. Everything else raises HalfshadeError.
    """

    def __init__(self, address: str, timeout_s: float = 600.0):
        """address: "host:port" or "unix:path", without TLS. timeout_s: of each call."""
        self._timeout_s = timeout_s
        self._channel = grpc.insecure_channel(
            address,
            options=[
                ("grpc.max_receive_message_length", _MAX_REPLY_BYTES),
                ("grpc.enable_retries", 0),
                ("grpc.service_config_disable_resolution", 1),
                ("grpc.enable_http_proxy", 0),
                ("grpc.initial_reconnect_backoff_ms", 100),
                ("grpc.min_reconnect_backoff_ms", 1000),
                ("grpc.max_reconnect_backoff_ms", 1000),
            ],
        )
        self._scenes = scene_pb2_grpc.SceneServiceStub(self._channel)
        self._renders = render_pb2_grpc.RenderServiceStub(self._channel)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; calls under way are cancelled."""
        self._channel.close()

    def upload(self, path: str | pathlib.Path) -> str:
        """Uploads what the server lacks of a .glb or .gltf and makes the scene; its name, "scenes/<hex>".

        Raises OSError and SceneFileError for what cannot be read.
        """
        files = read_scene_files(path)
        blobs = {digest(data): data for data in (files.root, *files.files.values())}
        missing = self._call(
            lambda **call: self._scenes.FindMissingBlobs(
                scene_pb2.FindMissingBlobsRequest(digests=blobs), **call
            ).missing_digests,
            files.name,
        )
        for name in missing:
            self._call(lambda **call: self._scenes.UploadBlob(_chunks(name, blobs[name]), **call), files.name)
        return self._call(lambda **call: self._create(files, call), files.name)

    def describe(self, scene: str) -> scene_pb2.Scene:
        """What is in a scene: bounds, triangles, cameras, node_names in the file's order, warnings."""
        request = scene_pb2.GetSceneRequest(name=scene)
        return self._call(lambda **call: self._scenes.GetScene(request, **call).scene, scene)

    def render(
        self, scene: str, outputs: Sequence[str] = ("frame",), *, half: bool = False, **fields: Any
    ) -> RenderResult:
        """Renders; arguments as make_request, arrays as RenderResult."""
        return self.run(make_request(scene, outputs, half=half, **fields))

    def run(self, request: render_pb2.RenderRequest) -> RenderResult:
        """Renders a request whose outputs are all RAW_F32 or RAW_F16."""
        for i, output in enumerate(request.outputs):
            if output.encoding not in _DTYPES:
                raise ValueError(f"outputs[{i}].encoding: only RAW_F32 and RAW_F16 are arrays")
        return self._call(lambda **call: self._read_stream(request, call), request.scene)

    def query(
        self, scene: str, points: np.ndarray, normals: np.ndarray | None = None, **fields: Any
    ) -> np.ndarray:
        """Visibility of every light from points: float32 (n, lights), 1 = all of the light is seen.

        points: (n, 3), world metres. normals: (n, 3), unit; None: no horizon. fields: as of make_request (lights,
        method, seed, ...).
        """
        query = render_pb2.QueryVisibilityRequest(request=make_request(scene, (), **fields), points=_packed(points))
        if normals is not None:
            query.normals = _packed(normals)
        response = self._call(lambda **call: self._renders.QueryVisibility(query, **call), scene)
        return np.frombuffer(response.visibility, "<f4").reshape(len(points), -1)

    def batch(
        self, requests: Iterable[render_pb2.RenderRequest], jobs: int = 4
    ) -> Iterator[tuple[int, RenderResult | HalfshadeError]]:
        """Renders many, `jobs` at a time, and yields (index in requests, result) as each is finished.

        An item's failure is its own: the error is yielded in its place. `requests` may be endless: no more than `jobs`
        of them are taken ahead. Order them by scene and light: the server caches both.
        """
        if jobs < 1:
            raise ValueError(f"jobs: {jobs}; must be at least 1")
        numbered = enumerate(requests)
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            running: dict[concurrent.futures.Future, int] = {}
            while True:
                for index, request in itertools.islice(numbered, jobs - len(running)):
                    running[pool.submit(self._run_or_error, request)] = index
                if not running:
                    return
                done, _ = concurrent.futures.wait(running, return_when=concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    yield running.pop(future), future.result()

    def _run_or_error(self, request: render_pb2.RenderRequest) -> RenderResult | HalfshadeError:
        try:
            return self.run(request)
        except HalfshadeError as error:
            return error

    def _create(self, files: SceneFiles, call: dict[str, Any]) -> str:
        request = scene_pb2.CreateSceneRequest(
            root_digest=digest(files.root), files={uri: digest(data) for uri, data in files.files.items()}
        )
        return self._scenes.CreateScene(request, **call).scene.name

    def _read_stream(self, request: render_pb2.RenderRequest, call: dict[str, Any]) -> RenderResult:
        """Puts plan, headers, chunks and report together."""
        headers: list[render_pb2.OutputImage] = []
        data: list[bytearray] = []
        report = None
        for part in self._renders.RenderStream(render_pb2.RenderStreamRequest(request=request), **call):
            kind = part.WhichOneof("part")
            if kind == "header":
                headers.append(part.header)
                data.append(bytearray())
            elif kind == "chunk":
                data[-1] += part.chunk
            elif kind == "report":
                report = part.report
        if report is None:
            raise HalfshadeError(grpc.StatusCode.INTERNAL, "RenderStream: the server's stream has no report")
        images = {}
        for header, pixels in zip(headers, data):
            kind = render_pb2.OutputKind.Name(header.kind).removeprefix("OUTPUT_KIND_").lower()
            image = np.frombuffer(bytes(pixels), _DTYPES[header.encoding])
            images[kind] = image.reshape(header.height, header.width, header.channels)
        return RenderResult(images, report)

    def _call(self, attempt: Callable[..., Any], scene: str) -> Any:
        begin = time.monotonic()
        for i in itertools.count():
            try:
                return attempt(timeout=self._timeout_s, metadata=[("x-halfshade-scene", scene)])
            except grpc.RpcError as error:
                pause_s = _retry_pause_s(error, i)
                if pause_s is None or time.monotonic() - begin + pause_s > _RETRY_S:
                    raise HalfshadeError(error.code(), error.details()) from error
            time.sleep(pause_s)


def _retry_pause_s(error: grpc.RpcError, attempt: int) -> float | None:
    """Until the next attempt; None: there is none. The server's push-back where it sends one."""
    code = error.code()
    pushback = dict(error.trailing_metadata() or ()).get("grpc-retry-pushback-ms")
    is_unavailable = code == grpc.StatusCode.UNAVAILABLE
    if is_unavailable and attempt + 1 >= _ATTEMPTS:
        return None
    if pushback is not None and (is_unavailable or code == grpc.StatusCode.RESOURCE_EXHAUSTED):
        return int(pushback) / 1000 if pushback.isdigit() else None
    return 0.2 * 2**attempt if is_unavailable else None


def _chunks(name: str, data: bytes) -> Iterator[scene_pb2.UploadBlobRequest]:
    for offset in range(0, max(1, len(data)), _CHUNK_BYTES):
        yield scene_pb2.UploadBlobRequest(
            digest=name, size_bytes=len(data), offset_bytes=offset, data=data[offset : offset + _CHUNK_BYTES]
        )


def _packed(vectors: np.ndarray) -> bytes:
    array = np.asarray(vectors, "<f4")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"points and normals are (n, 3), not {array.shape}")
    return array.tobytes()


def connect(address: str, timeout_s: float = 600.0) -> Client:
    """A client of the server at "host:port" or "unix:path"; connects at the first call. timeout_s: of each call."""
    return Client(address, timeout_s)
