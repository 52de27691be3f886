#!/usr/bin/python3
"""A real daemon where something has run out: whoever asks is told, nobody else notices, and it is over when there is room again.

Usage: exhaustion_test.py BUILD_DIRECTORY [unittest arguments]
"""
import fcntl
import os
import pathlib
import re
import resource
import socket
import subprocess
import time
import unittest

from daemon_case import HAPTICCTL, HAPTICD, Case, OwnDaemon, eventually, stl


class Descriptors(Case):
    def descriptors(self):
        return len(os.listdir(f"/proc/{self.daemon.process.pid}/fd"))

    def served(self):
        return subprocess.run([HAPTICCTL, "--socket", self.socket, "status"], capture_output=True, check=False).returncode == 0

    def connect(self):
        client = socket.socket(socket.AF_UNIX)
        self.addCleanup(client.close)
        client.connect(str(self.socket))
        return client

    def test_who_comes_when_none_is_left_is_hung_up_on_and_served_when_there_is(self):
        pid = self.daemon.process.pid
        time.sleep(0.2)  # Whoever asked at the start is gone then.
        before = self.descriptors()
        soft, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (before + 4, hard))
        self.addCleanup(resource.prlimit, pid, resource.RLIMIT_NOFILE, (soft, hard))
        silent = [self.connect() for _ in range(12)]
        said = self.run_ctl("status", exit_code=3).stderr
        self.assertIn("the daemon hung up\n  it ends, or has too many clients: try again, or end some; hapticd's log says why", said)
        self.assertIn("Too many open files (end clients, or raise LimitNOFILE= or ulimit -n)", self.daemon.log())
        self.run_ctl("--admin", "stop")  # Whoever fills it up does not keep it armed.
        for client in silent:
            client.close()
        self.assertTrue(eventually(self.served), "there is room again")
        self.assertTrue(eventually(lambda: self.descriptors() == before), "and nothing is left open")

    def test_who_has_all_the_connections_there_may_be_can_stop_devices_still(self):
        time.sleep(0.2)
        before = self.descriptors()
        silent = [self.connect() for _ in range(64)]
        self.assertTrue(eventually(lambda: self.descriptors() >= before + 64))
        for words in (("status",), ("objects",), ("set", "/objects/a/pos?value=0,0,0"), ("arm",), ("events",)):
            with self.subTest(words):
                self.assertIn("connection: this user, or all together, have as many as there may be: this one may stop "
                              "devices and no more\n  close some", self.run_ctl(*words, exit_code=1).stderr)
        self.assertIn("sim", self.run_ctl("list").stdout)
        self.run_ctl("stop")
        silent += [self.connect() for _ in range(20)]  # The reserve is no room to sit in.
        self.run_ctl("stop", "sim")
        self.assertEqual(64 + 4 - 1, len([1 for client in silent if self.stays(client)]), "one had to go for the stop")
        self.run_ctl("--admin", "status")
        for client in silent:
            client.close()
        self.assertTrue(eventually(self.served), "there is room again")
        self.assertTrue(eventually(lambda: self.descriptors() == before), "and nothing is left open")
        self.assertNotIn("control:", self.daemon.log())

    @staticmethod
    def stays(client):
        client.settimeout(0.01)
        try:
            return client.recv(1) != b""
        except TimeoutError:
            return True


class Log(Case):
    wants_daemon = False

    def expect_nobody_waits(self, reader, writer, begins, **environment):
        """For whoever has the reader and does not read until the daemon has said more than there is room for."""
        daemon = subprocess.Popen([HAPTICD, "--allow-no-rt", "--socket", self.socket], stdout=writer, stderr=writer,
                                  env=os.environ | environment)
        os.close(writer)
        self.addCleanup(os.close, reader)
        self.addCleanup(daemon.wait, 10)
        self.addCleanup(daemon.kill)
        os.set_blocking(reader, False)
        self.assertTrue(eventually(self.socket.exists))
        for _ in range(90):  # Each is two lines.
            self.run_ctl("status")
        self.assertRegex(self.drained(reader), begins)
        self.run_ctl("status")
        self.assertIn("lines are lost here", self.drained(reader))
        daemon.terminate()
        self.assertEqual(daemon.wait(60), 0)

    @staticmethod
    def drained(reader):
        text = b""
        try:
            while piece := os.read(reader, 1 << 20):
                text += piece
        except BlockingIOError:
            pass
        return text.decode()

    def test_a_reader_who_stands_still_holds_nobody_up(self):
        reader, writer = os.pipe()
        fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 8192)
        self.expect_nobody_waits(reader, writer, "ready:")

    def test_nor_does_a_journal_that_stands_still(self):
        reader, writer = socket.socketpair()
        writer.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 16384)
        named = os.fstat(writer.fileno())
        self.expect_nobody_waits(reader.detach(), writer.detach(), "(?m)^<6>device sim:",
                                 JOURNAL_STREAM=f"{named.st_dev}:{named.st_ino}")


class FewDescriptors(Case):
    def test_a_client_that_may_have_no_more_is_told_so(self):
        """However many it lacks: on its way to the daemon, and for what the daemon sends it."""
        for words in (["status"], ["monitor", "--csv", "--duration", "0.1"]):
            for most in range(4, 40):
                limit = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
                done = subprocess.run([HAPTICCTL, "--socket", self.socket, *words], preexec_fn=limit, capture_output=True, text=True)
                if done.returncode == 0:
                    break
                self.assertIn("close some descriptors", done.stderr, f"{words[0]} with {most}")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertGreater(most, 5)


    def test_a_daemon_that_may_have_no_more_serves_or_ends_and_says_why(self):
        """However many it lacks: nobody connects to it and waits for an answer that will not come."""
        folder = pathlib.Path(self.socket).parent / "few"
        for most in range(4, 60):
            limit = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
            daemon = subprocess.Popen([HAPTICD, "--allow-no-rt", "--socket", folder / "control.sock", "--device", "sim://default"],
                                      preexec_fn=limit, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            self.addCleanup(daemon.stdout.close)
            self.addCleanup(daemon.kill)
            said = ""
            while "ready: " not in said and (line := daemon.stdout.readline()):
                said += line
            if "ready: " in said:
                asked = subprocess.run([HAPTICCTL, "--socket", folder / "control.sock", "--timeout", "60", "status"], capture_output=True, text=True, check=False)
                self.assertNotIn("no answer", asked.stderr, f"{most}: {said}")
                daemon.terminate()
                self.assertEqual(daemon.wait(60), 0, said)
                if asked.returncode == 0:
                    break
            elif daemon.wait(60) != 127:  # The loader's own want.
                self.assertIn(daemon.returncode, (5, 6), said)
                self.assertRegex(said, r"error .*: Too many open files \(end [^)]*LimitNOFILE", f"{most}")
        self.assertEqual(asked.returncode, 0, said)
        self.assertGreater(most, 12)


class Threads(Case):
    """A limit of processes binds no root: the daemon is nobody's then."""
    wants_daemon = False
    nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.getuid() == 0 else {}

    def setUp(self):
        self.daemon = OwnDaemon(HAPTICD, config='[builder]\ncache = "DIRECTORY/cache"\n', **self.nobody)
        self.addCleanup(self.daemon.close)
        self.directory, self.socket = self.daemon.directory, self.daemon.socket
        self.directory.chmod(0o777)
        self.daemon.start()

    def tasks(self, most=resource.getrlimit(resource.RLIMIT_NPROC)[0]):
        most = "unlimited" if most == resource.RLIM_INFINITY else most
        subprocess.run(["prlimit", "--pid", str(self.daemon.process.pid), f"--nproc={most}:"], check=True, **self.nobody)

    def test_a_recording_without_a_thread_is_refused_and_hurts_nobody(self):
        self.tasks(1)
        said = self.run_ctl("record", self.directory / "none", "--for", "1", exit_code=1).stderr
        self.assertIn("recording: no thread can be started", said)
        self.assertIn("raise TasksMax= or the user's nproc", said)
        self.tasks()
        self.run_ctl("record", self.directory / "one", "--for", "0.2")

    def load(self):
        """A tetrahedron with a volume."""
        mesh = self.file("mesh.stl", stl(["0 0 0", "0.05 0 0", "0 0.05 0", "0 0 0.05"]))
        self.run_ctl("load", mesh, "--scale", "m", "--voxel", "2", "--replace")

    def kept(self, ending):
        return list((self.directory / "cache").glob("*" + ending))

    def test_a_volume_that_no_thread_can_keep_is_felt_and_kept_the_next_time(self):
        self.tasks(1)
        self.load()
        self.assertIn("a volume is not kept on disk: no thread can be started", self.daemon.log())
        self.assertEqual(self.kept(".hvol"), [])
        self.tasks()
        self.load()
        self.assertTrue(eventually(lambda: self.kept(".hvol")))

    def test_an_openvdb_file_that_no_thread_can_make_is_made_the_next_time(self):
        if not (HAPTICD.parent / "hapticd-builder-vdb").exists():
            self.skipTest("it is not built")
        self.load()
        self.assertTrue(eventually(lambda: self.kept(".vdb")))
        self.kept(".vdb")[0].unlink()
        self.daemon.terminate()  # Its maker's thread lives; the next one has none.
        self.daemon.start()
        self.tasks(1)
        self.load()
        self.assertIn("no OpenVDB file beside a cached volume", self.daemon.log())
        self.tasks()
        self.load()
        self.assertTrue(eventually(lambda: self.kept(".vdb")))


class Memory(Case):
    def room(self, more):
        """Of what the daemon may still take, in KiB."""
        status = pathlib.Path(f"/proc/{self.daemon.process.pid}/status").read_text()
        limit = (int(re.search(r"VmData:\s+(\d+)", status)[1]) + more) * 1024
        resource.prlimit(self.daemon.process.pid, resource.RLIMIT_DATA, (limit, self.hard))

    def setUp(self):
        before = resource.prlimit(self.daemon.process.pid, resource.RLIMIT_DATA)
        self.hard = before[1]
        self.addCleanup(resource.prlimit, self.daemon.process.pid, resource.RLIMIT_DATA, before)

    def cycles(self):
        return self.json("get", "/statistics/sim")["cycles"]

    def test_a_recording_for_which_there_is_none_ends_and_nothing_else_does(self):
        self.room(0)
        said = self.run_ctl("record", self.directory / "none", "--for", "1", exit_code=1).stderr
        self.assertIn("memory: hapticd can have no more\n  end programs, or raise MemoryMax= or ulimit -v", said)
        before = self.cycles()
        self.assertTrue(eventually(lambda: self.cycles() > before), "the servo goes on")
        ends = ""
        for more in (2000, 3000, 4000, 6000, 8000):  # Enough to begin with, but not to write it.
            self.room(more)
            command = [HAPTICCTL, "--socket", self.socket, "record", "--replace", self.directory / "some", "--for", "0.5"]
            ends += subprocess.run(command, capture_output=True, text=True, timeout=300, check=False).stderr
            self.assertIsNone(self.daemon.process.poll(), self.daemon.log())
        self.assertIn("the recording ended by itself: no memory", ends)


if __name__ == "__main__":
    unittest.main()
