#!/usr/bin/python3
"""hapticctl import and cut, programs of their own, against a real daemon.

Usage: import_test.py BUILD_DIRECTORY [unittest arguments]
"""
import json
import math
import os
import signal
import struct
import subprocess
import time
import unittest

from daemon_case import BUILD, HAPTICCTL, SILENT, Case, eventually, stl


class ImportAndCut(Case):
    def test_a_scan_becomes_a_solid(self):
        """A scan becomes a solid in one command, by a program that hapticctl finds on PATH."""
        path = self.directory / "ball.mha"
        header = "NDims = 3\nDimSize = 20 20 20\nElementSpacing = 1 1 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        at = [(x - 9.5, y - 9.5, 2 * (z - 9.5)) for z in range(20) for y in range(20) for x in range(20)]
        path.write_bytes(header.encode() + b"".join(struct.pack("<h", round(1000 - 100 * math.hypot(*p))) for p in at))
        paths = {"PATH": f"{BUILD / 'tools/hapticctl-import'}:{HAPTICCTL.parent}:{os.environ['PATH']}",
                 "HAPTICD_SOCKET": str(self.socket)}
        command = [HAPTICCTL, "import", path, "--iso", "300", "--voxel", "0.5", "--center", "--at", "0,0,-0.3"]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **SILENT, **paths}, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("MetaImage: 20 x 20 x 20 values, 1 x 1 x 2 mm apart", done.stdout)
        self.assertIn("volume: voxels of 0.5 mm", done.stdout)
        reader = subprocess.Popen(["true"], stdin=subprocess.PIPE)  # A reader that does not read: as of "| head -1".
        reader.wait()
        gone = subprocess.run([BUILD / "tools/hapticctl-import/hapticctl-import", *command[2:5], "--name", "unread"], stdout=reader.stdin, stderr=subprocess.PIPE, text=True,
                              env={**os.environ, **SILENT, **paths}, check=False)
        reader.stdin.close()
        self.assertEqual((gone.returncode, gone.stderr), (0, ""))
        self.run_ctl("remove", "unread")
        with open("/dev/full", "w", encoding="ascii") as full:
            for more in (["--name", "unsaid"], ["--output", self.directory / "unsaid.ply"]):
                unsaid = subprocess.run([*command[:5], *more], stdout=full, stderr=subprocess.PIPE, text=True,
                                        env={**os.environ, **SILENT, **paths}, check=False)
                self.assertEqual(unsaid.returncode, 5)
                self.assertIn("standard output: No space left", unsaid.stderr)
        mesh = [m for m in self.json("get", "/meshes").values() if m["voxel"] == 0.0005000000237487257]
        self.assertEqual(len(mesh), 1)
        self.assertAlmostEqual(mesh[0]["upper"][2], 0.007, delta=0.0002)  # where 1000 - 100 r is 300
        self.run_ctl("remove", "ball")
        failed = subprocess.run([*command[:3], "--iso", "5000"], capture_output=True, text=True,
                                env={**os.environ, **paths}, check=False)
        self.assertEqual(failed.returncode, 5)
        self.assertIn("there is no surface", failed.stderr)
        for more, code, said in ((["--iso", "300", "--smoth", "3"], 2, "--smoth"), (["--iso", "300", "--center"], 2, "--center"),
                                 (["--iso", "300", "--crop", "0:9,0:9"], 5, "for example 0:100,20:80,0:50"),
                                 (["--iso", "300", "--voxel", "1", "--vdb", self.directory / "none/x.vdb"], 5, "No such file or directory")):
            failed = subprocess.run([*command[:3], "--output", self.directory / "x.ply", *more], capture_output=True, text=True,
                                    env={**os.environ, **paths}, check=False)
            self.assertEqual(failed.returncode, code, failed.stderr)
            self.assertIn(said, failed.stderr)

    def test_where_nothing_can_be_said_the_exit_code_still_tells(self):
        """A refusal whose words find no room was an abort, which import took for a damaged file's."""
        with open("/dev/full", "w", encoding="ascii") as full:
            for program, *words in (("import", "none.mha", "--iso", "3"), ("import", "none.mha", "--iso", "3", "--output", "x.ply"),
                                    ("cut", "none.stl", "--plane", "0,0,0", "--pull", "0,0,1")):
                command = [BUILD / f"tools/hapticctl-{program}/hapticctl-{program}", *words]
                self.assertEqual(subprocess.run(command, cwd=self.directory, stderr=full, check=False).returncode, 5, words)
            for program in ("import", "cut"):
                command = [BUILD / f"tools/hapticctl-{program}/hapticctl-{program}", "--help"]
                done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
                self.assertEqual(done.returncode, 5)
                self.assertIn("standard output: No space left on device (make room where it goes)", done.stderr)

    def test_what_a_file_says_does_not_steer_the_terminal(self):
        scan, mesh = self.directory / "said.mha", self.file("\x1b[31mopen.stl", stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"]))
        scan.write_bytes("NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = a\x1b[31mb\x9bc\xe9\x7f\n".encode())
        for words, code, said in (((BUILD / "tools/hapticctl-import/hapticctl-import", scan, "--iso", "5"), 5, "a?[31mb?c\xe9?: cannot be read"),
                                  ((BUILD / "tools/hapticctl-cut/hapticctl-cut", mesh, "--plane", "0,0,10", "--pull", "0,0,1"), 0, "?[31mopen-body.ply")):
            done = subprocess.run(words, capture_output=True, text=True, encoding="utf-8", check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(said, done.stdout + done.stderr)
            self.assertNotRegex(done.stdout + done.stderr, r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")

    def test_numbers_of_import_are_finite(self):
        for option in ("--iso", "--label", "--smooth", "--resample", "--voxel"):
            command = [BUILD / "tools/hapticctl-import/hapticctl-import", "no.mha", option, "nan"]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"{option}: 'nan' is not a finite number", done.stderr)

    def test_options_of_import_that_cannot_work_are_refused(self):
        raw, vdb = self.directory / "ball.raw", self.directory / "ball.vdb"
        raw.write_bytes(bytes(255 if (i % 12 - 6)**2 + (i // 12 % 12 - 6)**2 + (i // 144 - 6)**2 < 16 else 0 for i in range(12**3)))
        of_raw = ["--raw", "uint8", "--raw-size", "12,12,12", "--iso", "100"]

        def imported(*words, exit_code=0):
            command = [BUILD / "tools/hapticctl-import/hapticctl-import", *words]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, exit_code, done.stderr)
            return done.stderr

        imported(raw, *of_raw, "--voxel", "1", "--vdb", vdb)
        ply = self.directory / "ball.ply"
        for option, value in (("--scale", "mm"), ("--grid", "1"), ("--series", "1")):
            self.assertIn(f"{option}: is for", imported(raw, *of_raw, option, value, "--output", ply, exit_code=5))
        for scale in ("1e-30", "1e30", "0", "-1"):
            self.assertIn("--scale: is not a length of a unit (mm, cm, m, inch, um, ft or metres per unit, from 1e-9 to 1000)",
                          imported(vdb, "--scale", scale, "--output", ply, exit_code=5))
        self.assertIn("--scale: is empty", imported(vdb, "--scale", "", "--output", ply, exit_code=2))
        self.assertFalse(ply.exists())
        before = raw.read_bytes()
        self.assertIn("FILE: is empty", imported("", *of_raw, "--output", ply, exit_code=2))
        imported(raw, *of_raw[:-1], "-1e300", "--output", ply)  # All of it: as a float that was no number.
        ply.unlink()
        self.assertIn("--label: no value is that", imported(raw, *of_raw[:-2], "--label", "7", "--output", ply, exit_code=5))
        self.assertIn("--vdb: " + str(ply) + " is the surface's file",
                      imported(raw, *of_raw, "--voxel", "1", "--output", f"{ply.parent}/./{ply.name}", "--vdb", ply, exit_code=5))
        self.assertFalse(ply.exists())
        self.assertIn(f"hapticctl import: {raw}: is the file that is imported", imported(raw, *of_raw, "--output", raw, exit_code=5))
        self.assertEqual(raw.read_bytes(), before)
        for options, name in ((["--output"], "ball.stl"), (["--voxel", "1", "--vdb"], "ball.ply")):
            self.assertIn(f"{name}: is no name for a {'.vdb' if '--vdb' in options else '.ply'} file",
                          imported(raw, *of_raw, *options, self.directory / name, exit_code=5))
            self.assertFalse((self.directory / name).exists())
        for name in ("ball.PLY", "ball.ply.tmp", "ball_0.5mm", "ball"):
            imported(raw, *of_raw, "--output", self.directory / name)
            self.assertEqual((self.directory / name).read_bytes()[:3], b"ply")

    def test_import_leaves_nothing_behind_when_it_is_ended(self):
        scan, folder = self.directory / "never.mha", self.directory / "temporary"
        os.mkfifo(scan)  # Whoever reads it waits.
        folder.mkdir()
        for end in (signal.SIGINT, signal.SIGTERM):
            importer = subprocess.Popen([BUILD / "tools/hapticctl-import/hapticctl-import", scan, "--iso", "300"],
                                        env={**os.environ, "TMPDIR": str(folder)}, stdout=subprocess.PIPE)
            while not list(folder.iterdir()):
                time.sleep(0.01)
            time.sleep(0.2)
            importer.send_signal(end)
            importer.communicate()  # Until its child has closed its end too.
            self.assertEqual(importer.returncode, -end)
            self.assertEqual(list(folder.iterdir()), [])

    def test_what_ends_import_ends_what_it_has_started_to_load(self):
        """Else the object came into the scene of whoever had just given it up."""
        scan, folder, started, told = (self.directory / name for name in ("late.raw", "temporary_too", "started", "told"))
        scan.write_bytes(bytes(255 if 0 < x < 3 and 0 < y < 3 and 0 < z < 3 else 0 for z in range(4) for y in range(4) for x in range(4)))
        folder.mkdir()
        loader = self.file("loader", f"#!/bin/sh\ntrap 'echo > {told}; exit 1' INT TERM HUP\necho > {started}\n"
                                     "for i in $(seq 400); do sleep 0.05; done\n")
        loader.chmod(0o755)
        for end in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            importer = subprocess.Popen([BUILD / "tools/hapticctl-import/hapticctl-import", scan, "--raw", "uint8", "--raw-size", "4,4,4", "--iso", "9"],
                                        env={**os.environ, "TMPDIR": str(folder), "HAPTICCTL": str(loader)}, stdout=subprocess.DEVNULL)
            self.assertTrue(eventually(started.exists))
            importer.send_signal(end)
            self.assertEqual(importer.wait(60), 1)
            self.assertTrue(told.exists(), end)
            self.assertEqual(list(folder.iterdir()), [])
            started.unlink()
            told.unlink()

    def test_cut(self):
        """A mesh in two by a program that hapticctl finds on PATH; no daemon needed."""
        path = self.file("block.stl", stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"]))
        paths = {"PATH": f"{BUILD / 'tools/hapticctl-cut'}:{os.environ['PATH']}", "HAPTICD_SOCKET": "/nonexistent"}
        command = [HAPTICCTL, "cut", path, "--plane", "0,0,10", "--pull", "0,0,1"]
        before = path.read_bytes()
        for words in (["--body", path], ["--fragment", path], ["--body", self.directory / "x.ply", "--fragment", self.directory / "x.ply"]):
            done = subprocess.run([*command, *words], capture_output=True, text=True, env={**os.environ, **paths}, check=False)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertIn(f"hapticctl cut: {words[-2]}: {words[-1]} is the ", done.stderr)
            self.assertFalse((self.directory / "x.ply").exists())
        for other in ("./y.ply", self.directory / "y.ply"):  # However a file that is not there yet is named.
            done = subprocess.run([*command, "--body", other, "--fragment", "y.ply"], capture_output=True, text=True,
                                  env={**os.environ, **paths}, cwd=self.directory, check=False)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertIn("hapticctl cut: --fragment: y.ply is the body's file", done.stderr)
            self.assertFalse((self.directory / "y.ply").exists())
        for part in ("--body", "--fragment"):
            done = subprocess.run([*command, part, self.directory / "x.stl"], capture_output=True, text=True, env={**os.environ, **paths}, check=False)
            self.assertEqual(done.returncode, 5, done.stdout + done.stderr)
            self.assertIn("x.stl: is no name for a .ply file", done.stderr)
            self.assertFalse((self.directory / "x.stl").exists())
        for seed in ("-1", "99999999999999999999"):  # Not the largest number that there is, in silence.
            done = subprocess.run([*command, "--seed", seed], capture_output=True, text=True, env={**os.environ, **paths}, check=False)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertIn(f"--seed: {seed}", done.stderr)
        self.assertEqual(path.read_bytes(), before)
        done = subprocess.run([*command, "--kerf", "1", "--voxel", "0.7"], capture_output=True, text=True,
                              env={**os.environ, **paths}, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open("/dev/full", "w", encoding="ascii") as full:
            unsaid = subprocess.run([*command, "--voxel", "2"], stdout=full, stderr=subprocess.PIPE, text=True, env={**os.environ, **paths},
                                    check=False)
        self.assertEqual(unsaid.returncode, 5)
        self.assertIn("standard output: No space left", unsaid.stderr)
        share = {line.split()[0]: float(line.split("(")[1].split()[0]) for line in done.stdout.splitlines() if "(" in line}
        self.assertAlmostEqual(share["fragment"], 100 * 0.79 ** 3, delta=1)  # of a tetrahedron's height
        self.assertAlmostEqual(share["body"], 100 * (1 - 0.81 ** 3), delta=1)
        for part in ("body", "fragment"):
            self.assertTrue(path.with_name(f"block-{part}.ply").read_bytes().startswith(b"ply"))
        failed = subprocess.run([*command[:3], "--pull", "0,0,1"], capture_output=True, text=True,
                                env={**os.environ, **paths}, check=False)
        self.assertEqual(failed.returncode, 2)
        self.assertIn("--plane or --shell", failed.stderr)
        failed = subprocess.run([*command, "--voxel", "2", "--body", self.directory / "none/x.ply"], capture_output=True, text=True,
                                env={**os.environ, **paths}, check=False)
        self.assertEqual(failed.returncode, 5)
        self.assertIn("No such file or directory", failed.stderr)

    def test_import_and_cut_where_they_are_built(self):
        """Without PATH: hapticctl finds them beside itself as they lie after a build, and import finds hapticctl."""
        environment = {**os.environ, "PATH": "/usr/bin:/bin", "HAPTICD_SOCKET": str(self.socket)}
        scan = self.directory / "cube.mha"
        header = "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
        scan.write_bytes(header.encode() + bytes([9 if 0 < x % 4 < 3 and 0 < y % 4 < 3 and 0 < z % 4 < 3 else 0
                                                 for z in range(4) for y in range(4) for x in range(4)]))
        done = subprocess.run([HAPTICCTL, "import", scan, "--iso", "5"], capture_output=True, text=True, env=environment, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.run_ctl("remove", "cube")
        # Of what goes to load, the word behind is its value, and not the scan, though there is a file of that name.
        (self.directory / "die").write_bytes(scan.read_bytes())
        done = subprocess.run([HAPTICCTL, "import", "--name", "die", "--at", "-0.1,0,0", "--iso", "5", scan], capture_output=True,
                              text=True, env=environment, cwd=self.directory, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(self.json("get", "/objects/die/pos"), [-0.1, 0, 0])
        self.run_ctl("remove", "die")
        # What stands before the command is for it, too: another daemon's scene had got it.
        elsewhere = {**environment, "HAPTICD_SOCKET": "/nonexistent"}
        done = subprocess.run([HAPTICCTL, "--json", "--socket", str(self.socket), "import", scan, "--iso", "5", "--name=die", "--size", "0.1"],
                              capture_output=True, text=True, env=elsewhere, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        die = json.loads(done.stdout)
        self.assertIn("triangles of", done.stderr)
        self.assertEqual(die["name"], "die")
        self.assertAlmostEqual(die["upper"][0] - die["lower"][0], 0.1, delta=1e-6)
        self.run_ctl("remove", "die")
        self.assertIn("--plane", subprocess.run([HAPTICCTL, "cut", "--help"], capture_output=True, text=True, env=environment, check=True).stdout)
        for name, words in (("import", "FILE is required"), ("cut", "MESH is required")):
            done = subprocess.run([HAPTICCTL, name], capture_output=True, text=True, env=environment, check=False)
            self.assertEqual(done.stderr, f"hapticctl {name}: {words} (hapticctl {name} --help tells how)\n")
            self.assertEqual(done.returncode, 2)
        self.assertIn("import, a scan as an object", self.run_ctl("--help").stdout)


if __name__ == "__main__":
    unittest.main()
