#!/usr/bin/python3
"""`halfshade batch` against a loop of `halfshade render`: items a second, CPU time, and whether the pixels are the same.

    tests/stress/batch_throughput.py --build build/release [--items 1000] [--loop 36] [--jobs 4] [--contexts 1]

12 scenes made by rule; FRAME, VISIBILITY and DEPTH of 640 x 360 from cameras and lights at random. The loop renders every
(items / loop)-th item. Exits with 1 where a picture of the loop is not, bit for bit, the batch's.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

SCENES = [("S1", 1), ("S2", 1), ("S3", 1), ("S4", 1), ("S5", 1), ("S6", 1), ("S7", 1), ("S8", 1), ("plant", 1),
          ("colonnade", 1), ("S5", 2), ("S6", 2)]
OUTPUTS = [("FRAME", "PNG"), ("VISIBILITY", "PNG"), ("DEPTH", "EXR_FLOAT")]


def template(name, bounds_min, bounds_max):
    """Cameras and lights on hemispheres around the scene's middle."""
    middle = [(bounds_min[axis] + bounds_max[axis]) / 2 for axis in "xyz"]
    extent = max(bounds_max[axis] - bounds_min[axis] for axis in "xyz")
    eye = {"target": middle, "radius": [1.2 * extent, 1.8 * extent], "elevation_deg": [15, 60]}
    light = {"target": middle, "radius": [1.0 * extent, 1.5 * extent], "elevation_deg": [45, 90],
             "width_m": [0.05 * extent, 0.3 * extent], "height_m": [0.05 * extent, 0.3 * extent]}
    return {
        "id": name, "scene": f"{name}.glb", "width": 640, "height": 360,
        "camera": {"lookAt": {"eye": {"$hemisphere": eye}, "target": dict(zip("xyz", middle))}},
        "lights": [{"$light": light}],
        "outputs": [{"kind": f"OUTPUT_KIND_{kind}", "encoding": f"ENCODING_{encoding}"} for kind, encoding in OUTPUTS],
    }


class Measured:
    """Wall and CPU seconds of the programs run inside."""

    def __enter__(self):
        self.begin, self.usage = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        return self

    def __exit__(self, *_):
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.wall_s = time.monotonic() - self.begin
        self.cpu_s = usage.ru_utime + usage.ru_stime - self.usage.ru_utime - self.usage.ru_stime


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--build", required=True, type=pathlib.Path)
    flags.add_argument("--items", type=int, default=1000)
    flags.add_argument("--loop", type=int, default=36)
    flags.add_argument("--jobs", type=int, default=4)
    flags.add_argument("--contexts", type=int, default=1)
    flags = flags.parse_args()
    halfshade = flags.build.resolve() / "client/halfshade"
    make_scene = flags.build.resolve() / "tests/support/make_scene"
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)

        def run(*command):
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            if ran.returncode != 0:
                sys.exit(f"{' '.join(map(str, command))}: exit code {ran.returncode}\n{ran.stderr}")
            return ran.stdout

        lines = []
        for i, (kind, seed) in enumerate(SCENES):
            name = f"{kind}-{seed}"
            run(make_scene, kind, f"{name}.glb", "--seed", str(seed))
            scene = json.loads(run(halfshade, "scene", f"{name}.glb", "--json"))
            (folder / "template.json").write_text(json.dumps(template(name, scene["boundsMin"], scene["boundsMax"])))
            count = flags.items * (i + 1) // len(SCENES) - flags.items * i // len(SCENES)
            lines += run(halfshade, "sample", "template.json", "--count", str(count)).splitlines()
        (folder / "requests.jsonl").write_text("".join(line + "\n" for line in lines))

        with Measured() as batch:
            run(halfshade, "batch", "requests.jsonl", "-o", "out", "--jobs", str(flags.jobs), "--contexts", str(flags.contexts))
        manifest = {item["id"]: item for item in map(json.loads, (folder / "out/manifest.jsonl").read_text().splitlines())}
        assert len(manifest) == len(lines), (len(manifest), len(lines))

        differing = []
        picked = [lines[i * len(lines) // flags.loop] for i in range(flags.loop)]
        with Measured() as loop:
            for line in picked:
                request = json.loads(line)
                name = request.pop("id")
                (folder / "request.json").write_text(json.dumps(request))
                report = json.loads(run(halfshade, "render", "-", "--request", "request.json", "--json", "-o", "FRAME=f.png", "-o",
                                        "VISIBILITY=v.png", "-o", "DEPTH=d.exr"))
                alone = [output["pixelSha256"] for output in report["outputs"]]
                if alone != [output["pixelSha256"] for output in manifest[name]["outputs"]]:
                    differing.append(name)

        timings = [item["report"]["timing"] for item in manifest.values()]
        render_s = sum(timing["cpuMs"] for timing in timings) / 1e3
        encode_s = sum(timing["encodeMs"] + timing["digestMs"] for timing in timings) / 1e3
        items, rate, loop_rate = len(lines), len(lines) / batch.wall_s, len(picked) / loop.wall_s
        print(f"{items} items of {len(SCENES)} scenes, {flags.jobs} jobs, {flags.contexts} contexts; loop: {len(picked)} of them")
        print(f"batch  {rate:7.2f} items/s  {1e3 * batch.cpu_s / items:7.1f} CPU-ms an item")
        print(f"loop   {loop_rate:7.2f} items/s  {1e3 * loop.cpu_s / len(picked):7.1f} CPU-ms an item")
        print(f"batch / loop: {rate / loop_rate:.1f} times the items a second")
        print(f"reports: {1e3 * render_s / items:.1f} CPU-ms of drawing, {1e3 * encode_s / items:.1f} ms of encoding and digests an item;"
              f" the batch's CPU time is {batch.cpu_s / (render_s + encode_s):.2f} of their sum")
        print(f"{len(picked) - len(differing)} of {len(picked)} pictures of the loop are the batch's, bit for bit")
        return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
