"""The Python client against the real server."""

import contextlib
import hashlib
import io
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

import grpc
import numpy as np

import halfshade
from halfshade.scene_files import read_scene_files

LIGHT = {"center": (0, 4, 0), "edge_u": (1, 0, 0), "edge_v": (0, 0, 1), "direction": (0, -1, 0), "radiance": (10, 10, 10)}
CAMERA = {"look_at": {"eye": (0, 4, 5), "target": (0, 0, 0), "fovy_deg": 50}}
# A full plate of 1 m, 1 m over a floor of 8 m.
QUADS = [(4.0, 0.0), (0.5, 1.0)]


class Server:
    def __init__(self):
        command = [os.environ["HALFSHADED_BINARY"], "--http", "off", "--listen", "127.0.0.1:0", "--log-level", "off"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.address = re.match(r"serving grpc=(\S+)", self.process.stdout.readline())[1]

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.stdout.close()
        return self.process.wait(60)


def write_gltf(folder):
    """scene.gltf with its buffer beside it."""
    positions, gltf = b"", {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [], "meshes": []}
    views, accessors = [], []
    for i, (half, y) in enumerate(QUADS):
        corners = [(-half, y, -half), (-half, y, half), (half, y, half), (half, y, -half)]
        triangles = np.array([corners[k] for k in (0, 1, 2, 0, 2, 3)], "<f4")
        views.append({"buffer": 0, "byteOffset": len(positions), "byteLength": triangles.nbytes})
        positions += triangles.tobytes()
        low, high = triangles.min(0).tolist(), triangles.max(0).tolist()
        accessors.append({"bufferView": i, "componentType": 5126, "count": 6, "type": "VEC3", "min": low, "max": high})
        gltf["meshes"].append({"primitives": [{"attributes": {"POSITION": i}}]})
        gltf["nodes"].append({"mesh": i, "name": ["floor", "plate"][i]})
    gltf |= {"bufferViews": views, "accessors": accessors}
    gltf["buffers"] = [{"uri": "data/a%20b.bin", "byteLength": len(positions)}]
    (folder / "data").mkdir()
    (folder / "data" / "a b.bin").write_bytes(positions)
    (folder / "scene.gltf").write_text(json.dumps(gltf))
    return folder / "scene.gltf"


class ClientTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name).resolve()
        cls.path = write_gltf(cls.folder)
        cls.client = halfshade.connect(cls.server.address)
        cls.scene = cls.client.upload(cls.path)

    @classmethod
    def tearDownClass(cls):
        cls.client.close()
        code = cls.server.stop()
        cls.temporary.cleanup()
        assert code == 0, code

    def command(self, *arguments):
        command = [os.environ["HALFSHADE_BINARY"], *arguments, "--server", self.server.address]
        return subprocess.run(command, cwd=self.folder, check=True, capture_output=True, text=True).stdout

    def test_arrays_have_the_digests_of_the_command(self):
        kinds = ("visibility", "frame", "depth", "normal", "albedo", "object_id", "position")
        result = self.client.render(
            self.scene, kinds, width=96, height=64, camera=CAMERA, lights=[LIGHT], method={"multi_map": {"k": 16}}
        )
        report = json.loads(self.command(
            "render", "scene.gltf", "--size", "96x64", "--camera", "eye=0,4,5 target=0,0,0 fovy=50",
            "--light", "center=0,4,0 edge_u=1,0,0 edge_v=0,0,1 direction=0,-1,0 radiance=10,10,10",
            "--method", "multi_map", "--set", "k=16", "--json", *(w for kind in kinds for w in ("-o", f"{kind}={kind}.f32"))
        ))
        self.assertEqual(list(result.images), list(kinds))
        for kind, told, by_command in zip(kinds, result.report.outputs, report["outputs"]):
            array = result[kind]
            self.assertEqual(array.dtype, np.float32)
            self.assertEqual(array.shape, (64, 96, told.channels))
            self.assertEqual(hashlib.sha256(array.tobytes()).hexdigest(), by_command["pixelSha256"], kind)
            self.assertEqual(told.pixel_sha256, by_command["pixelSha256"])
            self.assertEqual(array.tobytes(), (self.folder / f"{kind}.f32").read_bytes())

    def test_the_picture_is_of_the_scene(self):
        result = self.client.render(
            self.scene, ("depth", "position", "object_id", "visibility"), width=96, height=64, camera=CAMERA, lights=[LIGHT]
        )
        position, is_floor = result["position"], result["object_id"][..., 0] == 1
        self.assertLess(np.abs(position[is_floor][:, 1]).max(), 1e-5)
        forward = np.array([0, -4, -5]) / np.sqrt(41)
        depth = (position - [0, 4, 5]) @ forward
        np.testing.assert_allclose(result["depth"][is_floor][:, 0], depth[is_floor], rtol=1e-5)
        # Below the plate the light is hidden, 3 m beside it is not.
        visibility = result["visibility"][is_floor][:, 0]
        beside = np.abs(position[is_floor][:, [0, 2]]).max(1)
        self.assertEqual(visibility[beside > 3].min(), 1)
        self.assertEqual(visibility[beside < 0.3].max(initial=0), 0)

    def test_a_frame_without_shadows_differs_where_there_are_some(self):
        fields = {"width": 96, "height": 64, "camera": CAMERA, "lights": [LIGHT], "method": {"ray": {"rays": 64}}}
        shadowed = self.client.render(self.scene, ("frame", "visibility"), **fields)
        nodes = range(len(self.client.describe(self.scene).node_names))
        overrides = [{"index": i, "casts": False} for i in nodes]
        lit = self.client.render(self.scene, ("frame", "visibility"), node_overrides=overrides, **fields)
        is_lit = shadowed["visibility"][..., 0] == 1
        np.testing.assert_array_equal(lit["frame"][is_lit], shadowed["frame"][is_lit])
        self.assertGreater((~is_lit).sum(), 50)
        self.assertTrue((lit["frame"][~is_lit][:, :3] > shadowed["frame"][~is_lit][:, :3]).all())
        self.assertEqual(lit["visibility"].min(), 1)

    def test_half_floats(self):
        full = self.client.render(self.scene, ("visibility",), width=32, height=32, lights=[LIGHT], camera=CAMERA)
        half = self.client.render(self.scene, ("visibility",), half=True, width=32, height=32, lights=[LIGHT], camera=CAMERA)
        self.assertEqual(half["visibility"].dtype, np.float16)
        np.testing.assert_array_equal(half["visibility"], full["visibility"].astype(np.float16))

    def test_points_see_what_they_should(self):
        points = np.array([(0, 0.01, 0), (3, 0.01, 0), (0, 2, 0)])
        visibility = self.client.query(self.scene, points, lights=[LIGHT, LIGHT], method={"ray": {"rays": 64}})
        np.testing.assert_array_equal(visibility, [(0, 0), (1, 1), (1, 1)])
        down = np.tile([0, -1, 0], (3, 1))
        np.testing.assert_array_equal(self.client.query(self.scene, points, down, lights=[LIGHT]), [(0,), (0,), (0,)])

    def test_a_batch_yields_every_item_and_each_failure_in_its_place(self):
        widths = [16, 24, 9000, 32, 40, 48]
        requests = [halfshade.make_request(self.scene, ("depth",), width=w, height=16) for w in widths]
        results = dict(self.client.batch(requests, jobs=3))
        self.assertEqual(sorted(results), list(range(6)))
        self.assertEqual(results[2].code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertEqual(results[2].message, "width: 9000; must be 1 to 8192")
        for i in (0, 1, 3, 4, 5):
            self.assertEqual(results[i]["depth"].shape, (16, widths[i], 1))

    def test_a_batch_takes_no_more_ahead_than_it_renders(self):
        taken = []

        def endless():
            while True:
                taken.append(1)
                yield halfshade.make_request(self.scene, ("depth",), width=16, height=16)

        batch = self.client.batch(endless(), jobs=2)
        for _ in range(5):
            next(batch)
        batch.close()
        self.assertLessEqual(len(taken), 5 + 2)

    def test_errors_name_what_is_wrong(self):
        with self.assertRaisesRegex(halfshade.HalfshadeError, "NOT_FOUND: scenes/0000"):
            self.client.render("scenes/" + "0" * 64)
        with self.assertRaisesRegex(ValueError, "no field 'wide'"):
            self.client.render(self.scene, wide=3)
        with self.assertRaisesRegex(ValueError, "no kind 'shadow'; there are frame, visibility"):
            self.client.render(self.scene, ("shadow",))
        with self.assertRaisesRegex(ValueError, "Vec3: .* three numbers"):
            self.client.render(self.scene, lights=[{"center": (1, 2)}])
        with self.assertRaisesRegex(ValueError, "tone_map: 'filmic' is none of"):
            self.client.render(self.scene, shading={"tone_map": "filmic"})
        with self.assertRaisesRegex(ValueError, "jobs: 0"):
            next(self.client.batch([], jobs=0))
        with self.assertRaisesRegex(ValueError, r"\(n, 3\), not \(3,\)"):
            self.client.query(self.scene, (1, 2, 3))

    def test_a_server_that_is_gone_is_unavailable(self):
        with halfshade.connect("127.0.0.1:1", timeout_s=2) as client:
            with self.assertRaises(halfshade.HalfshadeError) as raised:
                client.render(self.scene)
        self.assertIn(raised.exception.code, (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.DEADLINE_EXCEEDED))

    def test_a_scenes_name_is_that_of_the_command(self):
        self.assertEqual(self.command("upload", "scene.gltf").strip(), self.scene)

    def test_reads_nothing_outside_the_scenes_folder(self):
        outside = self.folder.parent / f"{self.folder.name}-outside.bin"
        outside.write_bytes(b"secret")
        try:
            (self.folder / "link.bin").symlink_to(outside)
            for uri, message in [
                (f"../{outside.name}", "outside the scene's folder"),
                ("link.bin", "outside the scene's folder"),
                ("/etc/passwd", "outside the scene's folder"),
                ("%2e%2e/x", "outside the scene's folder"),
                ("file:///etc/passwd", "has a scheme"),
                ("data", "is not a regular file"),
                ("none.bin", "No such file"),
            ]:
                bad = self.folder / "bad.gltf"
                bad.write_text(json.dumps({"images": [{"uri": "data:,x"}, {"uri": uri}]}))
                with self.assertRaisesRegex(halfshade.SceneFileError, f"^/images/1/uri: .*{message}"):
                    read_scene_files(bad)
        finally:
            outside.unlink()

    def test_the_ten_lines_of_the_readme(self):
        subprocess.run([os.environ["MAKE_SCENE"], "colonnade", "scene.glb"], cwd=self.folder, check=True, capture_output=True)
        readme = pathlib.Path(os.environ["README"]).read_text()
        lines = re.findall(r"^    (.*)$", readme[readme.index("<!-- the ten lines") : readme.index("The digest is")], re.M)
        self.assertEqual(len(lines), 10)
        code = "\n".join(lines).replace("127.0.0.1:50051", self.server.address).replace("scene.glb", str(self.folder / "scene.glb"))
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, {})  # noqa: S102 (our own README)
        digest, method = printed.getvalue().splitlines()[1].split()
        report = json.loads(self.command(
            "render", "scene.glb", "--size", "320x180", "-o", "VISIBILITY=v.f32", "-o", "DEPTH=z.f32", "--json",
            "--light", "center=2,5,1 edge_u=1,0,0 edge_v=0,0,1 direction=0,-1,0"
        ))
        self.assertEqual(digest, report["outputs"][0]["pixelSha256"])
        self.assertEqual(method, report["method"])


if __name__ == "__main__":
    unittest.main()
