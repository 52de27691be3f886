#!/usr/bin/python3
"""tools/quickstart draws a picture of a real mesh and leaves nothing behind. Usage: quickstart_test.py SOURCE BUILD"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE, BUILD = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))


def processes_naming(text):
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            try:
                if text in (entry / "cmdline").read_bytes().decode(errors="replace"):
                    found.append(entry.name)
            except OSError:
                pass
    return found


class Quickstart(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory(prefix="quickstart-test-")
        # A configuration of the developer's own is not to matter; nor is this one, which no daemon could start with.
        own = pathlib.Path(self.directory.name) / "own"
        (own / "hapticd").mkdir(parents=True)
        (own / "hapticd/hapticd.toml").write_text('[[group]]\nname = "theirs"\ndevices = ["replay:///none.csv"]\n')
        kept = {name: value for name, value in os.environ.items() if not name.startswith("HAPTICD_")}
        self.environment = {**kept, "TMPDIR": self.directory.name, "XDG_CONFIG_HOME": str(own)}
        self.picture = pathlib.Path(self.directory.name) / "picture.png"
        # Named from where the user stands, which is not the source.
        self.command = [SOURCE / "tools/quickstart", "--prebuilt", os.path.relpath(BUILD, "/"), "--seconds", "2", "--output", self.picture,
                        "--mesh", "/usr/share/opencascade/data/stl/bearing.stl", "--scale", "0.001"]

    def tearDown(self):
        left = [path.name for path in pathlib.Path(self.directory.name).iterdir() if path.name not in ("own", self.picture.name)]
        self.assertEqual(left, [], "files left behind")
        self.assertEqual(processes_naming(self.directory.name), [], "processes left running")
        self.directory.cleanup()

    def test_draws_what_was_felt(self):
        done = subprocess.run(self.command, capture_output=True, text=True, env=self.environment, cwd="/", timeout=400,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for word in ("rate", "wake-up", "cycle", "contact", "force", "path", "picture"):
            self.assertIn(f"\n{word} ", done.stdout)
        self.assertNotIn("contact           0.0 s", done.stdout)
        self.assertIn("sim: armed", done.stdout)
        self.assertNotIn("theirs", done.stdout)
        self.assertNotIn("\x1b", done.stdout)
        self.assertTrue(self.picture.read_bytes().startswith(b"\x89PNG"))
        self.assertLess(self.picture.stat().st_size, 300_000)

    def test_an_interrupt_leaves_nothing(self):
        with subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=self.environment,
                              start_new_session=True, cwd="/") as run:
            for line in run.stdout:
                if "Arm the device" in line:
                    break
            time.sleep(0.5)
            os.killpg(run.pid, signal.SIGINT)  # As Ctrl-C does.
            run.communicate(timeout=400)
            self.assertNotEqual(run.returncode, 0)

    def test_a_stop_meanwhile_is_told_with_its_cause(self):
        with subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              env=self.environment, cwd="/") as run:
            for line in run.stdout:
                if "sim: armed" in line:
                    break
            socket, = pathlib.Path(self.directory.name).glob("hapticd-quickstart.*/control.sock")
            subprocess.run([BUILD / "tools/hapticctl/hapticctl", "stop"], check=True, stdout=subprocess.DEVNULL,
                           env={**self.environment, "HAPTICD_SOCKET": str(socket)})
            told = run.communicate(timeout=400)[0]
            self.assertEqual(run.returncode, 1, told)
            self.assertIn("quickstart: the device was disarmed before the hand was through:\n", told)
            self.assertIn("fault latched: emergency stop", told)
            self.assertFalse(self.picture.exists())

    def test_wrong_use_is_told(self):
        mesh = ["--mesh", "/usr/share/opencascade/data/stl/bearing.stl", "--scale"]
        obj = pathlib.Path(self.directory.name) / "own/box.obj"
        obj.write_text("v 0 0 0\n")
        for words, expected in ((["--mesh", "x.stl"], "--scale"), (["--seconds", "soon"], "is no time"), (["--frob"], "unknown option"),
                                (["--seconds", "0.0"], "is no time"), (["--seconds", "1.2.3"], "is no time"),
                                (["--seconds", "0x10"], "is no time"), (["--seconds", "'5"], "is no time"), (["--seconds", "1e9"], "more than an hour"),
                                (["--seconds"], "--seconds needs a value"), ([*mesh, "-1"], "is no length"), ([*mesh, "."], "is no length"),
                                (["--output", "/none/x.png"], "cannot be written"), (["--output", "/tmp"], "end in .png"),
                                (["--mesh", "none.stl", "--scale", "1"], "no such file"),
                                (["--mesh", obj, "--scale", "1"], "does not end in .stl")):
            # Before anything is built or started: there is no such build.
            done = subprocess.run([self.command[0], "--prebuilt", "/none", *words], capture_output=True, text=True,
                                  env=self.environment, check=False)
            self.assertIn(expected, done.stderr)
            self.assertEqual(done.returncode, 2)

    def test_setup_takes_one_word_it_knows(self):
        for words in ([""], ["frob"], ["build", "test"]):  # An empty one, as of a variable that is not set, is not "all".
            done = subprocess.run([SOURCE / "tools/setup", *words], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn("usage: tools/setup", done.stderr)


if __name__ == "__main__":
    unittest.main()
