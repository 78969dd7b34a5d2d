"""halfshaded in a process of its own, on free ports, as long as a `with` block lasts."""

import subprocess
import urllib.request


class Daemon:
    def __init__(self, build, *flags):
        self.process = subprocess.Popen([build / "server/halfshaded", "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", *flags],
                                        stdout=subprocess.PIPE, text=True)
        words = dict(word.split("=") for word in self.process.stdout.readline().split()[1:])
        self.address, self.http = words["grpc"], words["http"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()

    def metrics(self, begin):
        """Value by the line's name and labels, of those that begin so."""
        text = urllib.request.urlopen(f"http://{self.http}/metrics").read().decode()
        lines = [line.rpartition(" ") for line in text.splitlines() if line.startswith(begin)]
        return {name: float(value) for name, _, value in lines}
