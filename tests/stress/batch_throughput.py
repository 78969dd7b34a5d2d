#!/usr/bin/python3
"""`halfshade batch` against a loop of `halfshade render`; then the same batch under kill -9.

    tests/stress/batch_throughput.py --build build/release [--items 1000] [--loop 36] [--jobs 4] [--kills 10]

12 scenes made by rule; FRAME, VISIBILITY and DEPTH of 640 x 360 from cameras and lights at random. Prints items a second and CPU
time of both, and what drawing and encoding cost in a batch that does one thing at a time. The loop renders every (items / loop)-th
item. Then client and server, in turn, are killed --kills times, at random instants (seeded).

Exits with 1 where a picture of the loop is not, bit for bit, the batch's; where the killed batch, resumed, is not the unbroken one;
or where an item that the manifest had at a kill was rendered again.
"""

import argparse
import json
import pathlib
import random
import resource
import subprocess
import sys
import tempfile
import time

SCENES = [("S1", 1), ("S2", 1), ("S3", 1), ("S4", 1), ("S5", 1), ("S6", 1), ("S7", 1), ("S8", 1), ("plant", 1),
          ("colonnade", 1), ("S5", 2), ("S6", 2)]
OUTPUTS = [("FRAME", "PNG", "png"), ("VISIBILITY", "PNG", "png"), ("DEPTH", "EXR_FLOAT", "exr")]


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
        "outputs": [{"kind": f"OUTPUT_KIND_{kind}", "encoding": f"ENCODING_{encoding}"} for kind, encoding, _ in OUTPUTS],
    }


class Measured:
    """Wall and CPU seconds of the programs run, and ended, inside."""

    def __enter__(self):
        self.begin, self.usage = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        return self

    def __exit__(self, *_):
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.wall_s = time.monotonic() - self.begin
        self.cpu_s = usage.ru_utime + usage.ru_stime - self.usage.ru_utime - self.usage.ru_stime


class Bench:
    def __init__(self, build, folder):
        self.halfshade = build / "client/halfshade"
        self.halfshaded = build / "server/halfshaded"
        self.make_scene = build / "tests/support/make_scene"
        self.folder = folder

    def run(self, *command):
        ran = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if ran.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))}: exit code {ran.returncode}\n{ran.stderr}")
        return ran.stdout

    def write(self, name, lines):
        (self.folder / name).write_text("".join(line + "\n" for line in lines))

    def lines(self, items):
        lines = []
        for i, (kind, seed) in enumerate(SCENES):
            name = f"{kind}-{seed}"
            self.run(self.make_scene, kind, f"{name}.glb", "--seed", str(seed))
            scene = json.loads(self.run(self.halfshade, "scene", f"{name}.glb", "--json"))
            self.write("template.json", [json.dumps(template(name, scene["boundsMin"], scene["boundsMax"]))])
            count = items * (i + 1) // len(SCENES) - items * i // len(SCENES)
            lines += self.run(self.halfshade, "sample", "template.json", "--count", str(count)).splitlines()
        return lines

    def manifest(self, out):
        """id -> item; a line whose end is on its way is none."""
        try:
            text = (self.folder / out / "manifest.jsonl").read_text()
        except FileNotFoundError:
            return {}
        items = map(json.loads, text[:text.rfind("\n") + 1].splitlines())
        return {item["id"]: item for item in items}

    def render_alone(self, line):
        """The digests that `halfshade render` has for an item."""
        request = json.loads(line)
        del request["id"]
        self.write("request.json", [json.dumps(request)])
        files = [argument for kind, _, extension in OUTPUTS for argument in ("-o", f"{kind}=alone.{kind}.{extension}")]
        report = json.loads(self.run(self.halfshade, "render", "-", "--request", "request.json", "--json", *files))
        return [output["pixelSha256"] for output in report["outputs"]]

    def start_server(self, address):
        server = subprocess.Popen([self.halfshaded, "--listen", address, "--http", "off", "--log-level", "off"],
                                  stdout=subprocess.PIPE, text=True)
        return server, server.stdout.readline().split("grpc=")[1].split()[0]

    def start_batch(self, address, jobs):
        return subprocess.Popen([self.halfshade, "batch", "requests.jsonl", "-o", "killed", "--jobs", str(jobs), "--resume",
                                 "--server", address], cwd=self.folder, stderr=subprocess.DEVNULL)

    def killed(self, items, jobs, kills):
        """Runs the batch with `kills` kills; how many items of a manifest were rendered again."""
        def written(name):
            return [(self.folder / "killed" / file["name"]).stat().st_mtime_ns for file in seen[name]["files"]]

        instant = random.Random(20250202)
        server, address = self.start_server("127.0.0.1:0")
        batch = self.start_batch(address, jobs)
        seen, times = {}, {}
        for kill in range(kills):
            enough = items * (kill + 1) // (kills + 2)
            while batch.poll() is None and len(self.manifest("killed")) < enough:
                time.sleep(0.02)
            time.sleep(instant.uniform(0, 0.05))
            if batch.poll() is not None:
                sys.exit(f"kill {kill}: the batch has ended, with code {batch.returncode}")
            process = server if kill % 2 else batch
            process.kill()
            process.wait()
            seen = self.manifest("killed")
            times = {name: times.get(name) or written(name) for name in seen}
            if kill % 2:
                server, _ = self.start_server(address)
            else:
                batch = self.start_batch(address, jobs)
        if batch.wait() != 0:
            sys.exit(f"the batch ended with code {batch.returncode}")
        server.terminate()
        server.wait()
        return sum(written(name) != time_ns for name, time_ns in times.items())


def digests(manifest):
    return {name: [output["pixelSha256"] for output in item["outputs"]] for name, item in manifest.items()}


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--build", required=True, type=pathlib.Path)
    flags.add_argument("--items", type=int, default=1000)
    flags.add_argument("--loop", type=int, default=36)
    flags.add_argument("--jobs", type=int, default=4)
    flags.add_argument("--kills", type=int, default=10)
    flags = flags.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        bench = Bench(flags.build.resolve(), pathlib.Path(temporary))
        lines = bench.lines(flags.items)
        bench.write("requests.jsonl", lines)
        with Measured() as batch:
            bench.run(bench.halfshade, "batch", "requests.jsonl", "-o", "out", "--jobs", str(flags.jobs))
        whole = digests(bench.manifest("out"))
        picked = [lines[i * len(lines) // flags.loop] for i in range(flags.loop)]
        with Measured() as loop:
            alone = {json.loads(line)["id"]: bench.render_alone(line) for line in picked}
        # One at a time: the process's CPU time while it draws is the drawing's alone.
        bench.run(bench.halfshade, "batch", "requests.jsonl", "-o", "apart", "--jobs", "1")
        timings = [item["report"]["timing"] for item in bench.manifest("apart").values()]
        draw_ms = sum(timing["cpuMs"] for timing in timings) / len(timings)
        encode_ms = sum(timing["encodeMs"] + timing["digestMs"] for timing in timings) / len(timings)

        differing = sum(whole.get(name) != pixels for name, pixels in alone.items())
        rate, loop_rate, cpu_ms = len(lines) / batch.wall_s, len(picked) / loop.wall_s, 1e3 * batch.cpu_s / len(lines)
        print(f"{len(whole)} of {len(lines)} items of {len(SCENES)} scenes, {flags.jobs} jobs; loop: {len(picked)} of them")
        print(f"batch  {rate:7.2f} items/s  {cpu_ms:7.1f} CPU-ms an item")
        print(f"loop   {loop_rate:7.2f} items/s  {1e3 * loop.cpu_s / len(picked):7.1f} CPU-ms an item")
        print(f"batch / loop: {rate / loop_rate:.2f} times the items a second")
        print(f"apart: {draw_ms:.1f} CPU-ms of drawing, {encode_ms:.1f} ms of encoding and digests an item;"
              f" the batch's CPU time is {cpu_ms / (draw_ms + encode_ms):.2f} of their sum")
        print(f"{len(picked) - differing} of {len(picked)} pictures of the loop are the batch's, bit for bit")
        if flags.kills > 0:
            again = bench.killed(len(lines), flags.jobs, flags.kills)
            unequal = digests(bench.manifest("killed")) != whole
            left = len(list((bench.folder / "killed").glob(".*")))
            print(f"{flags.kills} kills: {len(bench.manifest('killed'))} of {len(lines)} items whole,"
                  f" {'not ' if unequal else ''}equal to the unbroken run; {again} rendered again, {left} files left over")
            differing += again + left + unequal
        is_whole = len(whole) == len(lines) and digests(bench.manifest("apart")) == whole
        return 0 if is_whole and differing == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
