#!/usr/bin/python3
"""What one client sees of a server that a crowd besets, each in a process of its own.

    cmake --build build/release --target halfshaded make_scene halfshade_python
    PYTHONPATH=build/release/client/python /usr/bin/python3 tests/stress/crowd.py --build build/release

500 connections that are silent, stop in the preface or in a message, or send a byte a second: the client's renders beside those without
them. Then --crowd clients, a connection each, that ask a server with a queue of 8 again as soon as they are answered: how soon the
client is refused, by its own clock and by the server's (halfshade_call_seconds).

The client has nothing else to do, and as root a higher priority than the crowd: what it waits for is the server. Prints figures and
judges none: the machine's other work is in them.
"""

import argparse
import multiprocessing
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time

import grpc
import halfshade
from daemon import Daemon
from halfshade.v1 import render_pb2_grpc

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
HALF_A_MESSAGE = PREFACE + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0]) + bytes([0, 1, 0, 1, 4])  # SETTINGS, and of HEADERS a half
PUSHBACK = "grpc-retry-pushback-ms"


def start(build, *flags):
    return Daemon(build, "--log-level", "off", "--result-cache-mb", "0", *flags)


def refused_within(daemon, bound):
    """How many renders were refused within `bound` seconds of their arrival, one of the histogram's."""
    name = f'halfshade_call_seconds_bucket{{code="RESOURCE_EXHAUSTED",rpc="Render",le="{bound}"}}'
    return int(sum(daemon.metrics(name).values()))


def stub_of(address, client):
    """On a connection of its own."""
    return render_pb2_grpc.RenderServiceStub(grpc.insecure_channel(address, options=[("client", client)]))


def ask(stub, scene, seed):
    """Milliseconds, and the error or None. No two requests are alike."""
    request = halfshade.make_request(scene, ("visibility",), width=64, height=64, seed=seed, method={"hard": {"map_size": 64}})
    begin, error = time.monotonic(), None
    try:
        stub.Render(request, timeout=30)
    except grpc.RpcError as refusal:
        error = refusal
    return 1e3 * (time.monotonic() - begin), error


def percentile99(values):
    return sorted(values)[len(values) * 99 // 100]


def good_client_ms(stub, scene, count, first_seed):
    answers = [ask(stub, scene, first_seed + i) for i in range(count)]
    for _, error in answers:
        if error is not None:
            sys.exit(f"the good client: {error}")
    return percentile99([ms for ms, _ in answers])


def beside_slow_clients(build, scene_file, count, connections):
    with start(build) as server:
        scene = halfshade.connect(server.address).upload(scene_file)
        stub = stub_of(server.address, 0)
        good_client_ms(stub, scene, count, 0)  # what is drawn first is slow
        before = good_client_ms(stub, scene, count, count)
        host, port = server.address.split(":")
        bad = [socket.create_connection((host, int(port))) for _ in range(connections)]
        for i, connection in enumerate(bad):
            connection.sendall([b"", PREFACE[:10], HALF_A_MESSAGE, HALF_A_MESSAGE][i % 4])
        is_over = threading.Event()

        def send_bytes():
            while not is_over.wait(1):
                for connection in bad[3::4]:
                    try:
                        connection.send(b"\0")
                    except OSError:
                        pass

        sender = threading.Thread(target=send_bytes)
        sender.start()
        beside = good_client_ms(stub, scene, count, 2 * count)
        is_over.set()
        sender.join()
        print(f"{count} renders one after the other: p99 {before:.1f} ms without, {beside:.1f} ms beside {connections} bad connections"
              f" ({beside / before:.2f})", flush=True)


def be_a_crowd(address, scene, first, clients, end, nice):
    os.nice(nice)

    def be_one(client):
        stub, seed = stub_of(address, client), client * 1_000_000
        while time.monotonic() < end:
            seed += 1
            _, error = ask(stub, scene, seed)
            if error is not None:
                time.sleep(0.05)

    threads = [threading.Thread(target=be_one, args=(first + i,)) for i in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def refused_in_a_crowd(build, scene_file, crowd, seconds):
    with start(build, "--queue", "8") as server:
        scene = halfshade.connect(server.address).upload(scene_file)
        end = time.monotonic() + seconds
        spawn = multiprocessing.get_context("spawn")  # gRPC's threads outlive no fork
        processes = 4
        nice = 5 if os.geteuid() == 0 else 0
        asking = [spawn.Process(target=be_a_crowd, args=(server.address, scene, 1 + i * crowd, crowd // processes, end, nice))
                  for i in range(processes)]
        for process in asking:
            process.start()
        time.sleep(seconds / 4)  # until all are there
        refusals, without_pushback, seed, stub = [], 0, 0, stub_of(server.address, 0)
        while time.monotonic() < end - seconds / 8:
            seed += 1
            ms, error = ask(stub, scene, seed)
            if error is not None and error.code() == grpc.StatusCode.RESOURCE_EXHAUSTED:
                refusals.append(ms)
                without_pushback += PUSHBACK not in dict(error.trailing_metadata())
            time.sleep(0.01)
        for process in asking:
            process.join()
        total = refused_within(server, "+Inf")
        shares = ", ".join(f"{100 * refused_within(server, bound) / total:.1f} % within {1e3 * float(bound):.0f} ms"
                           for bound in ("0.001", "0.002", "0.005", "0.01"))
        print(f"{crowd} clients: of its renders one more client was refused {len(refusals)}, {without_pushback} without push-back;"
              f" p99 {percentile99(refusals):.1f} ms" if refusals else "nothing was refused: no overload")
        print(f"by the server's clock, of {total} refusals: {shares}", flush=True)


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--build", required=True, type=pathlib.Path)
    flags.add_argument("--renders", type=int, default=1000)
    flags.add_argument("--connections", type=int, default=500)
    flags.add_argument("--crowd", type=int, default=100)
    flags.add_argument("--seconds", type=float, default=20)
    flags = flags.parse_args()
    build = flags.build.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        scene = pathlib.Path(temporary) / "scene.glb"
        subprocess.run([build / "tests/support/make_scene", "S1", scene], check=True)
        beside_slow_clients(build, scene, flags.renders, flags.connections)
        refused_in_a_crowd(build, scene, flags.crowd, flags.seconds)


if __name__ == "__main__":
    main()
