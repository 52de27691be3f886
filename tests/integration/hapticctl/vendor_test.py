#!/usr/bin/python3
"""A device behind a vendor's SDK in a real daemon: a plane is felt, and what is left when the helper or the daemon is killed.

Usage: vendor_test.py BUILD_DIRECTORY PLAYED_SDK. The played SDK keeps its device in a file: the grip's place and the motors'
force are its first six doubles (tests/fakes/vendor_sdk). Nothing is timed: each wait ends when what it waits for has happened.
"""
import json
import mmap
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

from daemon_case import BUILD, HAPTICCTL, HAPTICD, OwnDaemon

SDK = pathlib.Path(sys.argv.pop(1)).resolve()
STATE_BYTES = 4096
PATIENCE_S = 20


class Vendor(unittest.TestCase):
    def setUp(self):
        self.uri = f"dhd://default?sdk={SDK}"
        self.daemon = OwnDaemon(HAPTICD, config=f'[guard]\narm_ramp_ms = 100\n[[group]]\nname = "desk"\ndevices = ["{self.uri}"]\n')
        self.addCleanup(self.daemon.close)
        self.directory, self.socket = self.daemon.directory, self.daemon.socket
        path = self.directory / "device"
        path.write_bytes(bytes(STATE_BYTES))
        with open(path, "r+b") as file:
            self.device = mmap.mmap(file.fileno(), STATE_BYTES)
        self.place(0.02)
        self.arming = None
        self.daemon.options["env"] = {**os.environ, "FAKE_SDK_STATE": str(path)}
        self.daemon.start()

    def tearDown(self):
        if self.arming is not None:
            self.arming.kill()
            self.arming.wait()

    def ctl(self, *arguments):
        return subprocess.run([HAPTICCTL, "--socket", self.socket, *map(str, arguments)], capture_output=True, text=True, check=False)

    def until(self, condition):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                self.fail(self.daemon.log())
            time.sleep(0.005)

    def place(self, z):
        self.device[0:24] = struct.pack("3d", 0, 0, z)

    def force(self):
        return struct.unpack("3d", self.device[24:48])

    def helper(self):
        done = subprocess.run(["pgrep", "-P", str(self.daemon.process.pid), "-x", "hapticd-vendor"], capture_output=True, text=True, check=False)
        return int(done.stdout) if done.stdout.strip() else 0

    def arm(self):
        self.arming = subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm", "dhd"], stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def armed(self):
        """Arming is refused while a new helper is still opening the device: asked again."""
        if self.arming.poll() is not None:
            self.arm()
        return " armed" in self.ctl("status").stdout

    def press(self):
        """Armed over a plane, and 4 mm into it."""
        self.place(0.02)
        self.assertEqual(self.ctl("add", "plane", "--name", "floor", "--stiffness", "500", "--replace").returncode, 0)
        self.arm()
        self.until(self.armed)
        for step in range(240):
            self.place(0.02 - step * 1e-4)
            time.sleep(0.001)
        self.until(lambda: self.force()[2] > 1)
        self.assertEqual(self.force()[:2], (0, 0))

    def test_a_plane_is_felt_and_a_dead_helper_is_a_fault_that_ends_at_zero(self):
        self.press()
        first = self.helper()
        os.kill(first, signal.SIGKILL)
        self.until(lambda: "FAULT" in self.ctl("status").stdout)
        self.until(lambda: self.force() == (0, 0, 0))
        self.until(lambda: self.helper() not in (0, first))
        self.arming.kill()
        self.arming.wait()
        self.press()

    def test_a_dead_daemon_leaves_zero_and_safe_reaches_the_device_again(self):
        self.press()
        armed = self.directory / "armed"
        self.assertEqual(armed.read_text().strip("\0\n "), self.uri)
        self.daemon.kill()
        self.until(lambda: self.force() == (0, 0, 0))
        done = subprocess.run([BUILD / "daemon/hapticd-safe", armed], capture_output=True, text=True, check=False,
                              env={**os.environ, "FAKE_SDK_STATE": str(self.directory / "device")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("made safe", done.stdout + done.stderr)

    def test_a_daemon_starts_without_a_device_that_does_not_open_and_finds_it_later(self):
        self.daemon.terminate()
        later = self.directory / "later.so"
        uri = f"dhd://default?sdk={later}"
        (self.directory / "hapticd.toml").write_text(
            f'[[group]]\nname = "desk"\ndevices = ["{uri}"]\n[[group]]\nname = "other"\ndevices = ["sim://omega3"]\n')
        self.daemon.start()
        rows = {device["uri"]: device for device in json.loads(self.ctl("list", "--json").stdout)}
        self.assertTrue(rows["sim://omega3"]["open"])
        self.assertFalse(rows[uri]["open"])
        self.assertIn("later.so", rows[uri]["problem"])
        self.assertRegex(self.ctl("list").stdout, r"missing\s.*later\.so")
        told = self.ctl("info", uri).stdout
        self.assertRegex(told, r"state\s+missing\n\s+why\s+.*later\.so")
        self.assertNotIn("actuates", told, "nobody has asked it")
        doctor = self.ctl("doctor").stdout
        self.assertRegex(doctor, r"RED\s+daemon: missing device\s+dhd://.*group desk")
        log = self.daemon.log()
        self.assertEqual(log.count("is missing"), 1, log)
        shutil.copy(SDK, self.directory / "copying")
        os.rename(self.directory / "copying", later)  # whole at once
        self.until(lambda: "device dhd" in self.ctl("doctor").stdout)
        self.assertNotIn("missing", self.ctl("list").stdout + self.ctl("doctor").stdout)
        self.assertEqual(self.daemon.terminate(), 0)

    def test_a_device_of_the_command_line_must_open(self):
        (self.directory / "second").mkdir()
        done = subprocess.run([HAPTICD, "--allow-no-rt", "--socket", self.directory / "second/control.sock", "--device",
                               "dhd://default?sdk=/nowhere/lib.so"], capture_output=True, text=True, check=False, timeout=300)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("/nowhere/lib.so", done.stdout + done.stderr)

    def test_an_sdk_that_is_not_there_is_told_by_name(self):
        absent = "dhd://0?sdk=/nowhere/libdhd.so.3"
        refused = self.ctl("arm", absent)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("administrator", refused.stderr, "which library is loaded is not a client's choice")
        self.socket = self.directory / "admin.sock"
        told = self.ctl("arm", absent)
        self.assertNotEqual(told.returncode, 0)
        self.assertIn("/nowhere/libdhd.so.3", told.stderr)
        self.assertIn("install", told.stderr)
        self.assertIn("vendor SDKs", self.ctl("doctor").stdout)


if __name__ == "__main__":
    unittest.main()
