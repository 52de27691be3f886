"""What tests share that kill their daemon and start it again on the same socket."""
import os
import pathlib
import sys
import unittest

import hapticclient as haptic

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support/process"))
from own_daemon import OwnDaemon  # noqa: E402  (it lies there)


class OwnDaemonCase(unittest.TestCase):
    """A test of $HAPTICD_PROGRAM with a simulated hand: `daemon` and a connection to it, `client`, from start() to the end."""

    def start(self, config="", name="python"):
        self.daemon = OwnDaemon(os.environ["HAPTICD_PROGRAM"], "--device", "sim://", config=config)
        self.addCleanup(self.daemon.close)
        self.daemon.start()
        self.client = haptic.Client(self.daemon.socket, name=name)
        self.addCleanup(self.client.close)

    def refused(self, code, function, *arguments, **named):
        """The words of a refusal of that kind."""
        with self.assertRaises(haptic.HapticError) as caught:
            function(*arguments, **named)
        self.assertEqual(caught.exception.code, code)
        return str(caught.exception)
