#!/usr/bin/python3
"""hapticctl record with a real daemon, and what haptic-bench replay makes of the file: also after a crash of either.

Usage: record_test.py BUILD_DIRECTORY [unittest arguments]
"""
import csv
import json
import os
import pathlib
import random
import resource
import signal
import subprocess
import sys
import time
import unittest

from daemon_case import BUILD, HAPTICCTL, HAPTICD, OwnDaemon, eventually

BENCH = BUILD / "tools/haptic-bench/haptic-bench"
TAP = "sim://default?motion=tap&centre=0,0,0.005&direction=0,0,-1&depth=0.015&period=0.5&hand_stiffness=400"
CLOSE = """
import hapticclient, sys
with hapticclient.Client(sys.argv[1], administration=True) as client:
    print("there", flush=True)
    sys.stdin.readline()
    client.close_device("sim")
"""


class Record(unittest.TestCase):
    def setUp(self):
        self.daemon = OwnDaemon(HAPTICD, "--device", TAP, config="[guard]\narm_ramp_ms = 100\n")
        self.addCleanup(self.daemon.close)
        self.directory, self.socket = self.daemon.directory, self.daemon.socket
        self.daemon.start()
        # Things to feel: they stay when hapticctl has gone.
        self.ctl("add", "plane", "--name", "floor", "--stiffness", "500")
        self.file = self.directory / "session.hrec"

    def ctl(self, *arguments, check=True):
        return subprocess.run([HAPTICCTL, "--socket", self.socket, *map(str, arguments)], capture_output=True, text=True,
                              timeout=300, stdin=subprocess.DEVNULL, check=check)

    def start(self, *arguments, by=()):
        """hapticctl record, from when it records."""
        process = subprocess.Popen([*by, HAPTICCTL, "--socket", self.socket, "record", self.file, *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertIn("recording to", process.stderr.readline())
        return process

    def replay(self, *arguments, exit_code=0):
        done = subprocess.run([BENCH, "replay", self.file, *map(str, arguments)], capture_output=True, text=True,
                              timeout=300, check=False)
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def rows(self):
        out = self.directory / "session.csv"
        self.replay("--export", out)
        with open(out, encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_a_limit_of_file_sizes_is_told_and_ends_nobody(self):
        def small():
            resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

        done = subprocess.run([HAPTICCTL, "--socket", self.socket, "record", self.file, "--for", "20"], capture_output=True,
                              text=True, timeout=300, preexec_fn=small, check=False)
        self.assertEqual(done.returncode, 5, done)
        self.assertIn(f"{self.file}: File too large\n  raise the limit of a file's size (ulimit -f)", done.stderr)
        self.assertIn("holds what came until then", done.stderr)
        self.assertLessEqual(self.file.stat().st_size, 20_000)
        self.assertIn("cut off", self.replay())
        done = subprocess.run([HAPTICCTL, "--json", "--socket", self.socket, "record", self.file, "--for", "20", "--replace"],
                              capture_output=True, text=True, timeout=300, preexec_fn=small, check=False)
        self.assertEqual(done.returncode, 5, done)
        self.assertIn("holds what came until then", json.loads(done.stderr)["error"]["remedy"], "one line of JSON")
        self.ctl("status")
        # A daemon whose log has reached the limit serves on.
        log = self.directory / "full"
        log.write_bytes(b"x" * 20_000)
        self.socket = self.directory / "second/control.sock"
        with open(log, "ab") as full:
            daemon = subprocess.Popen([HAPTICD, "--allow-no-rt", "--socket", self.socket], stdout=full, stderr=full,
                                      preexec_fn=small)
        end = time.monotonic() + 60
        while daemon.poll() is None and self.ctl("status", check=False).returncode != 0:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)

    def test_closed_streams_are_given_to_no_other_file(self):
        """Else the log goes into what is opened first, a device perhaps."""
        socket = self.directory / "closed" / "control.sock"
        command = [HAPTICD, "--allow-no-rt", "--socket", socket, "--device", "sim://default"]
        with subprocess.Popen(["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *command]) as daemon:
            try:
                end = time.monotonic() + 60
                while not socket.exists() and time.monotonic() < end:
                    time.sleep(0.05)
                self.assertEqual([os.readlink(f"/proc/{daemon.pid}/fd/{n}") for n in range(3)], 3 * ["/dev/null"])
            finally:
                daemon.terminate()

    def test_a_session_replays_bit_for_bit_and_says_what_was_felt(self):
        recording = self.start()
        self.ctl("arm", "--for", "1.5")
        recording.send_signal(signal.SIGINT)
        out, _ = recording.communicate(timeout=300)
        self.assertEqual(recording.returncode, 0, out)
        self.assertIn("stopped", out)
        told = self.replay("--verify")
        self.assertIn("bit for bit", told)
        self.assertIn("denormals as zero", told)
        rows = self.rows()
        self.assertGreater(len(rows), 300)
        self.assertGreater(max(float(row["fz"]) for row in rows), 0.2, "the floor was pressed")
        self.assertTrue(any(float(row["object"]) != 0 for row in rows))
        # The export is a trajectory that the benchmark reads, as is the recording, and scores alike: of neither is judged
        # what was sent before the device was armed at full force.
        scores = []
        for trajectory, more in ((self.file, []), (self.directory / "session.csv", ["--max-gap", "1"])):
            done = subprocess.run([BENCH, "run", "-m", "plane:cells=3", "-a", "nearest", "-t", trajectory, "--rounds", "1", "--csv", *more],
                                  check=True, capture_output=True, text=True)
            scores.append({row["quantity"]: row["value"] for row in csv.DictReader(line for line in done.stdout.splitlines() if line[0] != "#")})
        for quantity in ("nearest force MSE", "nearest energy error", "nearest forces"):
            self.assertEqual(scores[0][quantity], scores[1][quantity], quantity)

    def test_the_meshes_of_a_session_are_a_model(self):
        """As they stood, so that nobody needs the file again, or what it was loaded with."""
        roof = self.directory / "roof.obj"
        roof.write_text("v -60 -60 -9\nv 60 -60 -9\nv 60 60 9\nv -60 60 9\nf 1 2 3\nf 1 3 4\n")
        self.ctl("load", roof, "--scale", "mm", "--at", "0,0,0.003", "--rotate", "z,20", "--stiffness", "500", "--damping", "0")
        recording = self.start()
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm", "--for", "1.2"], stdout=subprocess.DEVNULL) as arm:
            time.sleep(0.4)
            self.ctl("add", "sphere", "--name", "late", "--size", "0.001", "--at", "0.1,0,0")
            arm.wait(60)
        recording.send_signal(signal.SIGINT)
        recording.communicate(timeout=300)
        run = [BENCH, "run", "-a", "ours", "-t", self.file, "--rounds", "1", "--stiffness", "500", "-m"]
        samples = self.directory / "samples.csv"
        done = subprocess.run([*run, self.file, "--samples", samples], capture_output=True, text=True, check=True)
        self.assertRegex(done.stderr, r"session.hrec: object \d+: 2 triangles; felt with --stiffness 500 --damping 0 ")
        self.assertRegex(done.stderr, r"hrec: left out: \d+\n")
        self.assertRegex(done.stderr, r"hrec: came later and left out: \d+\n")
        # The floor is no mesh, and lies lower: the daemon's proxy was on the roof, where ours is now.
        with open(samples, encoding="utf-8") as file:
            judged = list(csv.DictReader(file))
        felt = 0
        for row, again in zip(self.rows(), judged, strict=True):
            if row["object"] == "0" or again["judged"] == "0":
                continue
            felt += 1
            for axis in "xyz":
                self.assertAlmostEqual(float(row[f"proxy_{axis}"]), float(again[f"ours_proxy_{axis}"]), delta=1e-8)
        self.assertGreater(felt, 50)
        number = done.stderr.split("object ")[1].split(":")[0]
        subprocess.run([*run, f"{self.file}:object={number}"], capture_output=True, check=True)
        for model, words in ((f"{self.file}:object=7", "it has no mesh 7 (it has objects "), (f"{self.file}:scale=2", "scale"),
                             (f"{self.file}:object={number}.5", "object: is not a whole number (")):
            refused = subprocess.run([*run, model], capture_output=True, text=True, check=False)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(words, refused.stderr)
        # What moves while the hand is on its way cannot stand for it.
        recording = self.start("--replace")
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm", "--for", "1.2"], stdout=subprocess.DEVNULL) as arm:
            time.sleep(0.4)
            self.ctl("set", "/objects/roof/pos?value=0,0,0.004")
            arm.wait(60)
        recording.send_signal(signal.SIGINT)
        recording.communicate(timeout=300)
        refused = subprocess.run([*run, self.file], capture_output=True, text=True, check=False)
        self.assertEqual(refused.returncode, 1)
        self.assertRegex(refused.stderr, rf"object {number} moves or goes at tick \d+ \(a recording in which it stands still")

    def test_nohup_keeps_it_when_the_terminal_closes(self):
        recording = self.start(by=["nohup"])
        recording.send_signal(signal.SIGHUP)
        for _ in range(4):  # Blocks, of which an end writes one.
            size = self.file.stat().st_size
            self.assertTrue(eventually(lambda size=size: self.file.stat().st_size > size), "it goes on")
        recording.send_signal(signal.SIGTERM)
        recording.communicate(timeout=300)
        self.assertEqual(recording.returncode, 0)
        # Without nohup it ends in good order.
        recording = self.start("--replace")
        recording.send_signal(signal.SIGHUP)
        out, _ = recording.communicate(timeout=300)
        self.assertEqual(recording.returncode, 0)
        self.assertIn("stopped", out)

    def test_for_ends_it_and_a_file_that_is_there_stays(self):
        self.ctl("record", self.file, "--for", "0.3")
        before = self.file.read_bytes()
        refused = self.ctl("record", self.file, "--for", "0.3", check=False)
        self.assertEqual(refused.returncode, 5)
        self.assertIn("--replace", refused.stderr)
        self.assertEqual(self.file.read_bytes(), before)
        self.ctl("record", self.file, "--for", "0.3", "--replace")
        self.assertIn("bit for bit", self.replay("--verify"))

    def test_a_files_name_does_not_steer_the_terminal(self):
        done = self.ctl("record", self.directory / "a\x1b[31mb.hrec", "--for", "0.1")
        self.assertNotIn("\x1b", done.stdout + done.stderr)
        self.assertIn("recording to", done.stderr)
        self.assertIn("a?[31mb.hrec: ", done.stdout)

    def test_an_armed_device_is_refused_with_the_remedy_and_leaves_no_file(self):
        arm = subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm"], stdout=subprocess.PIPE, text=True)
        arm.stdout.readline()
        refused = self.ctl("record", self.file, "--for", "0.3", check=False)
        self.assertEqual(refused.returncode, 1, refused.stderr)
        self.assertIn("disarm", refused.stderr)
        self.assertFalse(self.file.exists())
        self.file.write_bytes(b"an older recording")
        self.ctl("record", self.file, "--for", "0.3", "--replace", check=False)
        self.assertEqual(self.file.read_bytes(), b"an older recording", "a refusal replaces nothing")
        arm.send_signal(signal.SIGINT)
        arm.communicate(timeout=300)

    def test_killed_at_any_instant_it_loses_a_second_at_most(self):
        lost = []
        while len(lost) < 3 or (len(lost) < 6 and sum(s < 1 for s in lost) < 3):  # A busy machine may hold it up.
            recording = self.start("--replace")
            began = time.monotonic()
            time.sleep(random.uniform(1.2, 2.2))
            recording.kill()
            elapsed = time.monotonic() - began
            recording.communicate(timeout=300)
            self.assertIn("bit for bit", self.replay("--verify"))
            self.assertIn("cut off", self.replay())
            lost.append(elapsed - float(self.rows()[-1]["t"]))
        self.assertGreaterEqual(sum(s < 1 for s in lost), 3, lost)

    def test_a_killed_daemon_leaves_what_came_until_then(self):
        recording = self.start()
        began = time.monotonic()
        time.sleep(random.uniform(1.2, 2.2))
        self.daemon.kill()
        elapsed = time.monotonic() - began
        _, errors = recording.communicate(timeout=300)
        self.assertEqual(recording.returncode, 4, errors)
        self.assertIn("holds what came until then", errors)
        self.assertIn("the daemon is not there or has restarted\n  see why it ended: journalctl -u hapticd\n", errors)
        self.assertIn("bit for bit", self.replay("--verify"))
        self.assertGreater(float(self.rows()[-1]["t"]), elapsed - 1)

    def test_a_daemon_that_hangs_does_not_hold_up_its_end(self):
        recording = subprocess.Popen([HAPTICCTL, "--timeout", "5", "--socket", self.socket, "record", self.file],
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertIn("recording to", recording.stderr.readline())
        time.sleep(0.7)
        os.kill(self.daemon.process.pid, signal.SIGSTOP)
        try:
            recording.send_signal(signal.SIGINT)
            _, errors = recording.communicate(timeout=300)
        finally:
            os.kill(self.daemon.process.pid, signal.SIGCONT)
            recording.kill()
        self.assertEqual(recording.returncode, 1, errors)
        self.assertIn("no answer within 5000 ms", errors)
        self.assertIn("holds what came until then", errors)
        self.assertIn("cut off", self.replay())

    def test_a_daemon_that_stops_ends_the_recording_in_good_order(self):
        recording = self.start()
        time.sleep(0.5)
        self.daemon.process.terminate()
        recording.communicate(timeout=300)
        self.assertNotEqual(recording.returncode, 0)
        told = self.replay("--verify")
        self.assertIn("bit for bit", told)
        self.assertNotIn("cut off", told)

    def test_what_the_daemon_ended_is_no_success_however_much_is_still_to_be_written(self):
        package = pathlib.Path(__file__).resolve().parents[3] / "libclient/python"
        environment = {**os.environ, "PYTHONPATH": str(package), "PYTHONDONTWRITEBYTECODE": "1",
                       "HAPTICCLIENT_LIBRARY": str(BUILD / "libclient/libhapticclient.so")}
        closer = subprocess.Popen([sys.executable, "-c", CLOSE, self.directory / "admin.sock"], env=environment,
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.assertEqual(closer.stdout.readline(), "there\n")
        recording = self.start()
        time.sleep(0.5)
        recording.send_signal(signal.SIGSTOP)  # As if its disk stood still.
        closer.communicate("now\n", timeout=300)
        self.assertEqual(closer.returncode, 0)
        recording.send_signal(signal.SIGINT)
        recording.send_signal(signal.SIGCONT)
        out, errors = recording.communicate(timeout=300)
        self.assertEqual(recording.returncode, 1, out + errors)
        self.assertIn("ended by itself: the device was closed", errors)

    def test_foreign_and_damaged_files_are_named(self):
        self.file.write_text("t,x,y,z\n0,0,0,0\n" * 10)
        self.assertIn("hapticctl record", self.replay(exit_code=1))
        self.ctl("record", self.file, "--for", "0.5", "--replace")
        data = bytearray(self.file.read_bytes())
        data[len(data) // 2] ^= 1
        self.file.write_bytes(data)
        self.assertRegex(self.replay(exit_code=1), r"session\.hrec: block \d+ at byte \d+: ")
        self.replay("--export", self.directory / "out.xls", exit_code=1)


if __name__ == "__main__":
    unittest.main()
