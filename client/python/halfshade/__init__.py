"""Soft shadows from area lights, from a Halfshade server into numpy arrays.

    import halfshade
    client = halfshade.connect("127.0.0.1:50051")
    scene = client.upload("scene.glb")
    result = client.render(scene, outputs=("visibility", "depth"), width=640, height=360)
    result["visibility"]  # float32, (360, 640, lights); row 0 on top, 1 = lit

World space is glTF's: metres, right-handed, y up. Fields are those of halfshade/v1/render.proto.
"""

from halfshade.client import Client, HalfshadeError, RenderResult, connect, make_request
from halfshade.scene_files import SceneFileError

__all__ = ["Client", "HalfshadeError", "RenderResult", "SceneFileError", "connect", "make_request"]
