"""What the tests of hapticctl share: a daemon with its simulator, and files to load.

Takes the build directory from the first argument of the program that imports it.
"""
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import time
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support/process"))
from own_daemon import OwnDaemon  # noqa: E402  (it lies there)

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
HAPTICCTL = BUILD / "tools/hapticctl/hapticctl"
HAPTICD = BUILD / "daemon/hapticd"
TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
SILENT = {"TERM": "xterm-256color"}


def png(width, height, grey):
    """A picture of 8 bits of grey."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(grey(x, y) for x in range(width)) for y in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def stl(corners):
    """A text STL of a tetrahedron."""
    lines = ["solid t"]
    for triangle in TETRAHEDRON:
        lines += ["facet normal 0 0 0", "outer loop", *[f"vertex {corners[i]}" for i in triangle], "endloop", "endfacet"]
    return "\n".join(lines + ["endsolid t", ""])


def ball(rings):
    """A text STL of a ball of 50 mm, so many times twice as many facets around."""
    def corner(i, j):
        polar, turn = math.pi * i / rings, math.pi * j / rings
        return " ".join(str(0.05 * x) for x in (math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), math.cos(polar)))
    lines = ["solid ball"]
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
            for facet in ((a, b, c), (a, c, d)):
                lines += ["facet normal 0 0 0", "outer loop", *[f"vertex {p}" for p in facet], "endloop", "endfacet"]
    return "\n".join(lines + ["endsolid ball", ""])


def eventually(holds, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


class Case(unittest.TestCase):
    """A directory of its own, and a daemon for the whole class unless it wants none."""
    wants_daemon = True
    config = ""

    @classmethod
    def setUpClass(cls):
        cls.daemon = OwnDaemon(HAPTICD, config=cls.config)
        cls.addClassCleanup(cls.daemon.close)
        cls.directory, cls.socket = cls.daemon.directory, cls.daemon.socket
        if cls.wants_daemon:
            cls.daemon.start()

    def run_ctl(self, *arguments, exit_code=0, **options):
        environment = {**os.environ, **SILENT, "HAPTICD_SOCKET": str(self.socket)}
        done = subprocess.run([HAPTICCTL, *map(str, arguments)], capture_output=True, text=True, env=environment, timeout=300,
                              stdin=subprocess.DEVNULL, check=False, **options)
        self.assertEqual(done.returncode, exit_code, f"{arguments}\n{done.stdout}\n{done.stderr}")
        self.assertNotIn("\x1b", done.stdout + done.stderr, "no colours in a pipe")
        return done

    def json(self, *arguments):
        return json.loads(self.run_ctl("--json", *arguments).stdout)

    def file(self, name, text):
        path = self.directory / name
        path.write_text(text, encoding="ascii")
        return path
