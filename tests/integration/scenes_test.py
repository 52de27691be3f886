#!/usr/bin/python3
"""The blocks of a page run as they stand, one after the other. Usage: scenes_test.py PAGE FOLDER, the one of hapticctl; the
daemon is there."""
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PAGE, FOLDER = pathlib.Path(sys.argv.pop(1)), sys.argv.pop(1)


def weave(path):
    """A picture of waves that no step makes too steep."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(120 + 10 * abs(x % 8 - 4) + 10 * abs(y % 8 - 4) for x in range(64)) for y in range(64))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 64, 64, 8, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def tetrahedron(path):
    """A solid of 20 mm."""
    corners = ((0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20))
    facets = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    path.write_text("solid t\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[i]) for i in facet) +
        "endloop\nendfacet\n" for facet in facets) + "endsolid t\n")


class Scenes(unittest.TestCase):
    def test_each_block_runs(self):
        blocks = re.findall(r"^```(sh|python)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)
        self.assertGreater(len(blocks), 5)
        environment = dict(os.environ, PATH=f"{FOLDER}:{os.environ['PATH']}")
        with tempfile.TemporaryDirectory() as folder:
            weave(pathlib.Path(folder) / "weave.png")
            tetrahedron(pathlib.Path(folder) / "skull.stl")
            for kind, block in blocks:
                program = ["sh", "-e", "-c"] if kind == "sh" else ["/usr/bin/python3", "-c"]
                done = subprocess.run([*program, block], cwd=folder, env=environment, capture_output=True, text=True,
                                      stdin=subprocess.DEVNULL, timeout=300, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""), block)
        self.assertRegex(done.stdout, "^the door stands open by -?[1-9]", "it is pushed")


if __name__ == "__main__":
    unittest.main()
