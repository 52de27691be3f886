"""A daemon of a test's own, to be killed and started again on the same socket."""
import ctypes
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

import hapticclient as haptic

from waiting import eventually

_LIBC = ctypes.CDLL(None)
_PR_SET_PDEATHSIG = 1


class OwnDaemon:
    """$HAPTICD_PROGRAM with a simulated hand. DIRECTORY in the configuration is a directory that goes with close()."""

    def __init__(self, config=""):
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="hapticd-python-test-"))
        self.socket = str(self.directory / "control.sock")
        (self.directory / "hapticd.toml").write_text(config.replace("DIRECTORY", str(self.directory)))
        self.start()

    def start(self):
        with open(self.directory / "log", "ab") as log:
            self._process = subprocess.Popen(
                [os.environ["HAPTICD_PROGRAM"], "--allow-no-rt", "--socket", self.socket, "--device", "sim://",
                 "--config", self.directory / "hapticd.toml"], stdout=log, stderr=log,
                preexec_fn=lambda: _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL))
        if not eventually(self._answers, 30):
            raise RuntimeError((self.directory / "log").read_text())

    def _answers(self):
        try:
            with haptic.Client(self.socket):
                return True
        except haptic.HapticError:
            return False

    def kill(self):
        self._process.kill()
        self._process.wait()

    def close(self):
        self._process.terminate()
        self._process.wait(20)
        shutil.rmtree(self.directory)


class OwnDaemonCase(unittest.TestCase):
    """A test of such a daemon: `daemon` and a connection to it, `client`, from start() to the end."""

    def start(self, config="", name="python"):
        self.daemon = OwnDaemon(config)
        self.addCleanup(self.daemon.close)
        self.client = haptic.Client(self.daemon.socket, name=name)
        self.addCleanup(self.client.close)

    def refused(self, code, function, *arguments, **named):
        """The words of a refusal of that kind."""
        with self.assertRaises(haptic.HapticError) as caught:
            function(*arguments, **named)
        self.assertEqual(caught.exception.code, code)
        return str(caught.exception)
