#!/usr/bin/python3
"""The most memory that a server takes, and which renders take it.

    tests/stress/peak_memory.py --build build/release [--size 1280x720] [--lights 2] [--jobs 4] [-- flags of halfshaded]

Every method, with its default options, on ten scenes made by rule (S7 has a million triangles), under lights of two sizes, one
render at a time through a server whose caches are small; then all of them again, --jobs at a time. Prints what the server has
before the first render, the most it had during each (VmHWM, taken anew for each) over what it had at the start, and what it keeps
when it has rested: MB of 10^6 bytes.

Exits with 1 where the most is over twice the caches' limits together and one frame.
"""

import argparse
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from daemon import Daemon

SCENES = ["S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8", "plant", "colonnade"]
METHODS = ["hard", "multi_map", "pcss", "sssm", "ssm", "pdsm", "ray", "shaft"]
CACHE_MB = {"scene-cache": 128, "gl-scene": 128, "light-cache": 128, "ray-scene": 128, "view-cache": 64, "result-cache": 64}
LIGHT_SHARES = [0.2, 0.5]
RESOURCE_EXHAUSTED = 75  # exit code of halfshade


class Server(Daemon):
    def __init__(self, build, flags):
        super().__init__(build, "--log-level", "warn", *(f"--{name}-mb={mb}" for name, mb in CACHE_MB.items()), *flags)

    def memory_mb(self, field):
        """VmRSS, what it has; VmHWM, the most it had since forget_peak."""
        lines = pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        return next(int(line.split()[1]) * 1024 / 1e6 for line in lines if line.startswith(field))

    def cpu_s(self):
        """Of user and of system."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return [int(field) / os.sysconf("SC_CLK_TCK") for field in fields[11:13]]

    def forget_peak(self):
        pathlib.Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def caches_mb(self):
        """Those of contexts, which have no flag of their own each, among them."""
        return {name.split('"')[1]: value / 1e6 for name, value in self.metrics("halfshade_cache_bytes").items()}


class Renders:
    def __init__(self, build, folder, scenes, size, lights):
        self.build, self.folder, self.scenes, self.size, self.shares = build, folder, scenes, size, LIGHT_SHARES[:lights]

    def make_scenes(self):
        for scene in self.scenes:
            for share in self.shares:
                made = self.run("tests/support/make_scene", scene, f"{scene}.glb", "--light", str(share), "--view",
                                f"{scene}-{share}.json")
                made.check_returncode()

    def run(self, program, *arguments):
        return subprocess.run([self.build / program, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True)

    def render(self, server, scene, method, share):
        """False: refused, since the light's data are larger than the cache."""
        ran = self.run("client/halfshade", "--timeout", "600", "render", f"{scene}.glb", "--view", f"{scene}-{share}.json",
                       "--size", self.size, "--method", method, "--server", server.address, "--json")
        if ran.returncode not in (0, RESOURCE_EXHAUSTED):
            sys.exit(f"{scene} by {method}: exit code {ran.returncode}\n{ran.stderr}")
        return ran.returncode == 0

    def one_at_a_time(self, server, base_mb):
        """The most of all renders; prints that of each scene and method."""
        most, refused, kept = 0, 0, {}
        print("MB over base " + "".join(f"{method:>10}" for method in METHODS), flush=True)
        for scene in self.scenes:
            print(f"{scene:13}", end="")
            for method in METHODS:
                server.forget_peak()
                drawn = [self.render(server, scene, method, share) for share in self.shares]
                peak = server.memory_mb("VmHWM")
                print(f"{peak - base_mb:10.0f}{' ' if all(drawn) else '-'}", end="", flush=True)
                most, refused = max(most, peak), refused + drawn.count(False)
                for cache, mb in server.caches_mb().items():
                    kept[cache] = max(mb, kept.get(cache, 0))
            print()
        print(f"-: {refused} refused\nmost kept, MB: " + ", ".join(f"{cache} {mb:.0f}" for cache, mb in sorted(kept.items())))
        return most

    def together(self, server, jobs):
        """The most of all renders, so many at a time."""
        server.forget_peak()
        every = [(scene, method, share) for scene in self.scenes for method in METHODS for share in self.shares]
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            list(pool.map(lambda one: self.render(server, *one), every))
        return server.memory_mb("VmHWM")


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--build", required=True, type=pathlib.Path)
    flags.add_argument("--scenes", nargs="+", default=SCENES, choices=SCENES)
    flags.add_argument("--size", default="1280x720")
    flags.add_argument("--lights", type=int, default=len(LIGHT_SHARES), choices=range(1, len(LIGHT_SHARES) + 1))
    flags.add_argument("--jobs", type=int, default=4)
    flags.add_argument("server_flags", nargs="*", help="of halfshaded, after --")
    flags = flags.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        renders = Renders(flags.build.resolve(), pathlib.Path(temporary), flags.scenes, flags.size, flags.lights)
        renders.make_scenes()
        with Server(renders.build, flags.server_flags) as server:
            base, start = server.memory_mb("VmRSS"), server.memory_mb("VmHWM")
            alone = renders.one_at_a_time(server, base)
            together = renders.together(server, flags.jobs) if flags.jobs > 1 else 0
            time.sleep(15)  # a canary has been drawn
            rest, (user_s, system_s) = server.memory_mb("VmRSS"), server.cpu_s()
    width, height = map(int, flags.size.split("x"))
    limit, frame = sum(CACHE_MB.values()) * 2**20 / 1e6, 16 * width * height / 1e6
    most = max(start, alone, together)
    print(f"caches' limits {limit:.0f} MB, a frame {frame:.0f} MB; before the first render {base:.0f} MB")
    print(f"at most {alone:.0f} MB one at a time, {together:.0f} MB {flags.jobs} at a time; at rest {rest:.0f} MB")
    print(f"CPU time {user_s:.1f} s of the user's, {system_s:.1f} s of the system's")
    print(f"{(most - frame) / limit:.2f} times the limits, and a frame")
    return 0 if most <= 2 * limit + frame else 1


if __name__ == "__main__":
    sys.exit(main())
