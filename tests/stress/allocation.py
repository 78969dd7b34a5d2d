#!/usr/bin/python3
"""What huge pages save: page faults and CPU time a frame, by method, with halfshaded's own allocation and without them.

    tests/stress/allocation.py --build build/release [--size 1280x720] [--frames 12] [--rounds 3]

One light of a new seed in each frame of the colonnade, so that its light data are made anew. Servers take turns; medians of rounds.
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from daemon import Daemon

METHODS = ["hard", "multi_map", "pcss", "sssm", "shaft", "ray"]
LIGHT = {"center": (2, 5, 1), "edge_u": (1, 0, 0), "edge_v": (0, 0, 1), "direction": (0, -1, 0)}
SETTINGS = {"own": None, "without huge pages": "thp:never"}


def usage(pid):
    """Page faults, and CPU-ms of user and system."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[7]), 1e3 * (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(options, halfshade, scene_file):
    """Of each method: faults and CPU-ms a frame."""
    width, height = map(int, options.size.split("x"))
    with Daemon(options.build, "--log-level", "warn", "--result-cache-mb", "0") as daemon:
        client = halfshade.connect(daemon.address)
        scene = client.upload(scene_file)
        figures = {}
        for method in METHODS:
            def render(seed):
                client.render(scene, outputs=("frame",), width=width, height=height, lights=[LIGHT], method={method: {}}, seed=seed)
            for seed in range(3):
                render(seed)
            before = usage(daemon.process.pid)
            for seed in range(options.frames):
                render(100 + seed)
            after = usage(daemon.process.pid)
            figures[method] = [(b - a) / options.frames for a, b in zip(before, after)]
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--frames", type=int, default=12)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    sys.path.append(str(options.build / "client/python"))
    import halfshade

    runs = {name: [] for name in SETTINGS}
    with tempfile.TemporaryDirectory() as folder:
        scene_file = pathlib.Path(folder) / "scene.glb"
        subprocess.run([options.build / "tests/support/make_scene", "colonnade", scene_file], check=True)
        for _ in range(options.rounds):
            for name, conf in SETTINGS.items():
                os.environ.pop("MALLOC_CONF", None)
                if conf:
                    os.environ["MALLOC_CONF"] = conf
                runs[name].append(measure(options, halfshade, scene_file))
    for method in METHODS:
        faults, cpu_ms = ([statistics.median(run[method][i] for run in runs[name]) for name in SETTINGS] for i in range(2))
        print(f"{method:10} {faults[0]:6.0f} faults a frame, {faults[1]:6.0f} {list(SETTINGS)[1]}; "
              f"{cpu_ms[0]:6.0f} CPU-ms, {cpu_ms[1]:6.0f}: {cpu_ms[0] / cpu_ms[1]:.2f}")


main()
