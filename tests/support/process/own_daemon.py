"""A daemon of a test's own, for tests in Python."""
import ctypes
import fcntl
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

_LIBC = ctypes.CDLL(None)
_PR_SET_PDEATHSIG = 1
_PATIENT = "\n[servo]\nmissed_limit = 100000\n"  # That a busy machine holds the servo up is no fault.


def _locked_directory():
    """As TemporaryDirectory in temporary_directory.h: should this test be killed, the next one of C++ sweeps it."""
    for _ in range(1000):
        fresh = tempfile.mkdtemp(prefix="hapticd-new-")
        path = fresh.replace("hapticd-new-", "hapticd-tests-")
        lock = -1
        try:
            lock = os.open(fresh, os.O_RDONLY | os.O_DIRECTORY)
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.rename(fresh, path)
            return pathlib.Path(path), lock
        except OSError:  # Another, who sweeps, was quicker than the lock.
            if lock >= 0:
                os.close(lock)
    raise RuntimeError("no directory can be made")


class OwnDaemon:
    """hapticd in a directory of its own, which has its sockets, hapticd.toml and log. Stands still until start().

    DIRECTORY in the configuration, which has no [servo], is that directory; without one all is as built in, whatever whoever runs the test has
    configured for a daemon of theirs. `options` are those of subprocess.Popen. close() ends it and removes the directory;
    it does not outlive a test that is killed.
    """

    def __init__(self, program, *arguments, config="", **options):
        self.directory, self._lock = _locked_directory()
        self.socket = self.directory / "control.sock"
        self.options = options
        self.process = None
        file = self.directory / "hapticd.toml"
        file.write_text(config.replace("DIRECTORY", str(self.directory)) + _PATIENT)
        self._command = [program, "--allow-no-rt", "--socket", self.socket, "--config", file, *arguments]

    def start(self):
        """Until it is ready. Also again, on the same socket."""
        said = len(self.log())
        with open(self.directory / "log", "ab") as log:
            self.process = subprocess.Popen(self._command, stdout=log, stderr=log, **self.options,
                                            preexec_fn=lambda: _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL))
        end = time.monotonic() + 30
        while "ready: " not in self.log()[said:]:
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(self.log())
            time.sleep(0.01)

    def log(self):
        path = self.directory / "log"
        return path.read_text() if path.exists() else ""

    def kill(self):
        self.process.kill()
        self.process.wait()

    def terminate(self):
        """Gives its exit code."""
        self.process.terminate()
        return self.process.wait(60)

    def close(self):
        try:
            if self.process is not None:
                self.terminate()
        finally:
            if self.process is not None:
                self.kill()
            shutil.rmtree(self.directory)
            os.close(self._lock)
