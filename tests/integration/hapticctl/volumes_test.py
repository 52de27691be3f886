#!/usr/bin/python3
"""hapticctl volumes and export against a real daemon: what it keeps of volumes on disk.

Usage: volumes_test.py BUILD_DIRECTORY [unittest arguments]
"""
import os
import pathlib
import resource
import signal
import subprocess
import unittest

from daemon_case import BUILD, HAPTICCTL, Case, stl


class Volumes(Case):
    """What the daemon keeps of volumes on disk, and how a user gets at it."""
    config = '[builder]\ncache = "DIRECTORY/volumes"\n'

    def test_a_volume_is_listed_and_exported(self):
        self.assertEqual(self.json("volumes"), [])
        path = self.file("t.stl", stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"]))
        self.json("load", path, "--scale", "mm", "--voxel", "1", "--name", "solid", "--at", "0,0,0.2")
        self.json("load", path, "--scale", "mm", "--name", "skin", "--at", "0,0,-0.2")
        out = self.directory / "solid.vdb"
        told = self.json("export", "solid", out)
        self.assertEqual(told["bytes"], out.stat().st_size)
        self.assertEqual(out.read_bytes()[:4], b" BDV")
        kept = list((self.directory / "volumes").glob("*.vdb"))
        self.assertEqual([file.read_bytes() for file in kept], [out.read_bytes()])
        listed = self.json("volumes")
        self.assertEqual([(v["objects"], v["vdb_bytes"]) for v in listed], [(["solid"], told["bytes"])])
        self.assertRegex(self.run_ctl("volumes").stdout, rf"solid +{os.getuid()} ")
        # Read by the importer, which checks its checksum and knows its unit.
        paths = {"PATH": f"{BUILD / 'tools/hapticctl-import'}:{os.environ['PATH']}", "HAPTICD_SOCKET": str(self.socket)}
        again = subprocess.run([HAPTICCTL, "import", out, "--output", self.directory / "again.ply"], capture_output=True,
                               text=True, env={**os.environ, **paths}, check=False)
        self.assertEqual(again.returncode, 0, again.stderr)
        volume = float(again.stdout.split(" cm3")[0].split()[-1])
        self.assertAlmostEqual(volume, 20 * 30 * 50 / 6 / 1000, delta=0.15)  # its edges are cut by a voxel
        # Refusals.
        self.assertIn("--replace", self.run_ctl("export", "solid", out, exit_code=5).stderr)
        self.run_ctl("export", "solid", out, "--replace")
        self.assertIn("no volume", self.run_ctl("export", "skin", out, "--replace", exit_code=1).stderr)
        self.assertIn("solid", self.run_ctl("export", "sold", out, "--replace", exit_code=1).stderr)
        self.assertIn("end it in .vdb", self.run_ctl("export", "solid", self.directory / "solid.ply", exit_code=2).stderr)
        self.assertFalse((self.directory / "solid.ply").exists())
        full = pathlib.Path("/dev/full")
        self.assertEqual(self.run_ctl("export", "solid", full, "--replace", exit_code=5).stdout, "")
        self.assertTrue(full.is_char_device(), "what was there before stays")
        # Cut off by the disk or by Ctrl-C it takes nothing from the file that was there.
        whole, here = out.read_bytes(), set(self.directory.iterdir())
        export = [HAPTICCTL, "--socket", self.socket, "export", "solid"]
        cut = subprocess.run([*export, out, "--replace"], capture_output=True, text=True, check=False,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
        self.assertEqual((cut.returncode, out.read_bytes()), (5, whole), cut.stderr)
        self.assertIn("ulimit -f", cut.stderr)
        pipe = self.directory / "pipe"
        os.mkfifo(pipe)
        with subprocess.Popen([*export, pipe, "--replace"], stderr=subprocess.PIPE, text=True) as cut:
            with pipe.open("rb", buffering=0) as reader:
                reader.read(1)  # The rest is more than a pipe holds.
                cut.send_signal(signal.SIGINT)
                self.assertIn("cancelled", cut.communicate(timeout=300)[1])
        pipe.unlink()
        self.assertEqual((cut.returncode, set(self.directory.iterdir())), (1, here))
        # The same again comes from the disk; when nobody shows it, it stays there.
        self.run_ctl("remove", "solid")
        self.assertEqual([v["objects"] for v in self.json("volumes")], [[]])
        self.json("load", path, "--scale", "mm", "--voxel", "1", "--name", "other", "--at", "0,0,0.2")
        self.assertEqual([v["objects"] for v in self.json("volumes")], [["other"]])
        self.assertEqual(self.json("export", "other", self.directory / "other.vdb")["bytes"], told["bytes"])


if __name__ == "__main__":
    unittest.main()
