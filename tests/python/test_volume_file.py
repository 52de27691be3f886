"""A mesh uploaded with its volume from Python, and that volume as an OpenVDB file."""
import fcntl
import os
import signal
import sys
import unittest
import unittest.mock

import hapticclient.client
import hapticclient as haptic
import numpy as np

from own_daemon_case import OwnDaemonCase
from tetrahedron import FACES, corners
from waiting import eventually

CORNERS = corners(0.02)


class VolumeFile(OwnDaemonCase):
    def show(self, name, **volume):
        mesh = self.client.scene.upload(CORNERS, FACES, **volume)
        self.client.scene.create(name, haptic.ShapeKind.MESH, mesh=mesh.id)
        return mesh

    def file_of(self, name):
        """The whole file, once it is made."""
        found = []
        self.assertTrue(eventually(lambda: found.append(self.client.scene.volume_file(name)) or found, 30))
        with open(found[0], "rb") as file:
            self.assertTrue(fcntl.fcntl(file, fcntl.F_GETFD) & fcntl.FD_CLOEXEC)
            with self.assertRaises(OSError):
                os.write(file.fileno(), b"x")  # It is there to be read.
            return file.read()

    def test_is_the_file_that_the_daemon_keeps(self):
        self.start('[builder]\ncache = "DIRECTORY/volumes"\n')
        self.show("solid", voxel_m=0.001)
        content = self.file_of("solid")
        kept = [path.read_bytes() for path in (self.daemon.directory / "volumes").glob("*.vdb")]
        self.assertTrue(kept == [content], "the daemon's file, byte by byte")
        self.assertEqual(content[:4], b" BDV")
        self.show("coarse", voxel_m=0.002)
        self.assertTrue(self.file_of("coarse") != content)
        self.show("skin")
        self.assertIn("no volume", self.refused(haptic.Code.NOT_FOUND, self.client.scene.volume_file, "skin"))
        self.assertIn("sold", self.refused(haptic.Code.NOT_FOUND, self.client.scene.volume_file, "sold"))
        # A new daemon finds it on the disk again.
        self.daemon.kill()
        self.daemon.start()
        self.client.reconnect()
        self.show("again", voxel_m=0.001)
        self.assertTrue(self.file_of("again") == content)

    def test_what_a_signal_raises_ends_the_upload(self):
        """As Ctrl-C does. It comes while the library waits, and Python hears it as progress is told."""
        self.start()
        scene = self.client.scene

        class Enough(BaseException):
            pass

        def stop(_signal, _frame):
            raise Enough

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, stop))
        hook = sys.unraisablehook
        for progress in (None, lambda _fraction, _stage: None):
            signal.setitimer(signal.ITIMER_REAL, 0.3)
            with self.assertRaises(Enough):
                scene.upload(CORNERS, FACES, voxel_m=0.0001, progress=progress)  # For seconds.
        self.assertEqual(scene.meshes(), [])
        self.assertIs(sys.unraisablehook, hook)

    def test_nor_does_one_that_comes_when_it_is_built_leave_the_mesh_behind(self):
        self.start()
        library = hapticclient.client._lib  # pylint: disable=protected-access
        for name in ("haptic_upload_commit", "haptic_upload_close"):
            function = getattr(library, name)

            def interrupted(*arguments, function=function):
                function(*arguments)
                raise KeyboardInterrupt  # Python's own handler does so as the library returns, and anywhere after.

            with unittest.mock.patch.object(library, name, interrupted):
                with self.assertRaises(KeyboardInterrupt):
                    self.client.scene.upload(CORNERS, FACES)
            self.assertEqual(self.client.scene.meshes(), [], name)

    def test_is_refused_where_none_are_kept(self):
        with unittest.mock.patch.dict(os.environ, HAPTICD_CONFIG="/none"):  # Who runs this may have a configuration.
            self.start()
        self.show("solid", voxel_m=0.001)
        self.assertIn("builder.cache", self.refused(haptic.Code.UNSUPPORTED, self.client.scene.volume_file, "solid"))
        # An upload asks for a volume by any of its numbers, and they are checked.
        upload = self.client.scene.upload
        for wrong in ({"point_spacing_m": 0.001}, {"fill_holes": True}, {"voxel_m": -1}, {"voxel_m": 0.001, "point_spacing_m": -1},
                      {"weld_m": 1}):
            self.refused(haptic.Code.INVALID_ARGUMENT, upload, CORNERS, FACES, **wrong)
        self.refused(haptic.Code.BAD_MESH, upload, CORNERS, FACES[:3], voxel_m=0.001)
        self.assertFalse(upload(CORNERS, FACES[:3], voxel_m=0.001, fill_holes=True).closed)
        apart = CORNERS[np.reshape(FACES, -1)] + np.repeat(np.eye(4, 3), 3, axis=0) * 1e-5  # Facets that do not quite meet.
        self.assertFalse(upload(apart, range(12)).closed)
        self.assertTrue(upload(apart, range(12), weld_m=1e-4).closed)


if __name__ == "__main__":
    unittest.main()
