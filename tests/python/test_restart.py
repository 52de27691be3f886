"""What a Python program keeps, loses and gets back when its daemon is killed and started again."""
import threading
import unittest

import hapticclient as haptic
import numpy as np

from own_daemon_case import OwnDaemonCase
from tetrahedron import FACES, corners
from waiting import armed, eventually


class Restart(OwnDaemonCase):
    def setUp(self):
        self.start("[guard]\narm_ramp_ms = 100\n", "survivor")

    def open(self):
        session = self.client.open_session()
        self.addCleanup(session.close)
        return session

    def kill(self):
        self.daemon.kill()
        self.assertTrue(eventually(lambda: not self.client.connected))

    def restart(self):
        self.kill()
        self.daemon.start()
        self.client.reconnect()

    def feel_floor(self, session):
        """Arms, presses into a plane and compares with its law."""
        session.arm()
        self.assertTrue(eventually(lambda: armed(session)))
        session.push_plane((0, 0, 0), (0, 0, 1), material=haptic.Material(200, 0), lease_s=10)
        session.push_intent((0, 0, -0.01), latest=True)

        def pressed():
            sample = session.latest()
            law = np.array((0, 0, -200 * sample["p"][2]))
            return law[2] > 1 and np.linalg.norm(sample["by_source"][haptic.Source.LOCAL_MODEL] - law) < 0.05
        self.assertTrue(eventually(pressed))

    def test_without_a_daemon_each_call_says_so(self):
        session = self.open()
        self.client.scene.create("ball", haptic.ShapeKind.SPHERE, (0.01,))
        self.kill()
        self.assertTrue(eventually(lambda: not session.alive))
        gone = haptic.Code.DISCONNECTED
        for function in (session.latest, session.drain, session.arm, session.counters):
            self.refused(gone, function)
        self.refused(gone, session.push_force, (0, 0, 1))
        self.refused(gone, session.push_object_vertices, 1, [0], [[0, 0, 0]])
        self.assertIn("reconnect", self.refused(gone, session.reopen))
        self.assertIn("reconnect", self.refused(gone, self.client.scene.list))
        self.refused(gone, self.client.scene.upload, np.eye(3), [[0, 1, 2]])
        self.refused(gone, self.client.open_session)
        self.refused(gone, self.client.reconnect)

    def test_a_session_feels_again_on_the_same_device(self):
        session = self.open()
        self.feel_floor(session)
        before = session.describe()
        self.restart()
        self.assertFalse(session.alive, "a connection alone is no session")
        self.refused(haptic.Code.DISCONNECTED, session.latest)
        session.reopen()
        self.assertTrue(session.alive)
        after = session.describe()
        self.assertNotEqual(after.epoch, before.epoch)
        self.assertEqual(self.client.info().epoch, after.epoch)
        self.assertEqual(after.device.uri, before.device.uri)
        self.assertEqual([entry.name for entry in self.client.status().clients if entry.session == after.id], ["survivor"])
        sample = session.latest()
        self.assertFalse(sample["flags"] & haptic.SampleFlag.ARMED, "a restarted daemon holds still")
        self.assertEqual(session.model(0).state, 0, "nothing is pushed yet")
        self.feel_floor(session)

    def test_the_history_begins_anew(self):
        session = self.open()
        first = session.latest()["tick"]

        def told():  # A tick that the servo missed has no sample to lose.
            latest = session.latest()
            return int(latest["tick"]) - int(latest["missed"])
        self.assertTrue(eventually(lambda: told() > first + haptic.HISTORY + 200))
        session.drain()
        self.assertGreater(session.lost, 100)
        self.restart()
        session.reopen()
        first = session.latest()["tick"]
        self.assertTrue(eventually(lambda: session.latest()["tick"] > first + 50))
        read = session.drain()["tick"].astype(np.int64)
        self.assertGreater(len(read), 20)
        self.assertTrue((np.diff(read) > 0).all())
        self.assertLessEqual(len(read) + session.lost, read[-1] + 1, "lost counts this daemon's samples alone")

    def test_the_scene_is_empty_and_takes_the_same_names(self):
        scene = self.client.scene
        tip = corners(0.01), FACES
        report = scene.upload(*tip)
        scene.create("tip", haptic.ShapeKind.MESH, mesh=report.id, flags=haptic.ObjectFlag.ENABLED | haptic.ObjectFlag.KEEP)
        self.restart()
        self.assertEqual((scene.list(), scene.meshes()), ([], []))
        self.refused(haptic.Code.NOT_FOUND, scene.create, "tip", haptic.ShapeKind.MESH, mesh=report.id)
        again = scene.upload(*tip)
        scene.create("tip", haptic.ShapeKind.MESH, mesh=again.id)
        self.assertEqual(scene.find("tip").mesh, again.id)

    def test_a_subscription_ends_its_loop_and_comes_back(self):
        heard = []
        with self.client.subscribe(haptic.EventKind.ARMED, haptic.EventKind.FAULT) as events:
            session = self.open()
            session.arm()
            reader = threading.Thread(target=lambda: heard.extend(events))
            reader.start()
            self.assertTrue(eventually(lambda: len(heard) > 0))
            self.kill()
            reader.join(60)
            self.assertFalse(reader.is_alive(), "the loop ends with the daemon")
            self.assertEqual([event.name for event in heard], ["armed"])
            self.daemon.start()
            self.client.reconnect()
            self.assertIsNone(events.next(0))
            session.reopen()
            session.arm()
            self.assertEqual(events.next(10).name, "armed")
            self.client.stop()
            self.assertEqual(events.next(10).name, "fault")

    def test_a_standing_connection_is_left_alone(self):
        session = self.open()
        id_before = session.describe().id
        self.client.reconnect()
        self.assertTrue(session.alive)
        self.assertEqual(session.describe().id, id_before)

    def test_a_standing_session_is_reopened_at_rest(self):
        session = self.open()
        self.feel_floor(session)
        before = session.describe()
        session.reopen()
        after = session.describe()
        self.assertNotEqual(after.id, before.id)
        self.assertEqual(after.epoch, before.epoch)
        self.assertEqual(session.model(0).state, 0)
        self.assertTrue(eventually(lambda: not session.latest()["flags"] & haptic.SampleFlag.ARMED))
        self.assertTrue(eventually(lambda: [c.session for c in self.client.status().clients if c.name == "survivor"] == [after.id]))
        self.feel_floor(session)

    def test_what_was_closed_refuses_and_does_not_crash(self):
        session, events = self.open(), self.client.subscribe()
        events.close()
        self.refused(haptic.Code.INVALID_ARGUMENT, events.next)
        self.client.close()
        self.assertFalse(self.client.connected)
        self.assertFalse(session.alive)
        self.refused(haptic.Code.DISCONNECTED, session.reopen)
        session.close()
        for function in (session.reopen, session.latest, session.describe, self.client.reconnect, self.client.info):
            self.refused(haptic.Code.INVALID_ARGUMENT, function)
        for thing in (session, events, self.client):
            thing.close()  # Once more changes nothing.

    def test_a_recording_ends_with_the_daemon(self):
        with self.client.record() as recording:
            pieces = []
            with open(recording.fileno(), "rb", buffering=0, closefd=False) as stream:
                pieces.append(stream.read(8))
                self.kill()
                while piece := stream.read(65536):
                    pieces.append(piece)
            self.refused(haptic.Code.DISCONNECTED, recording.stop)
        self.assertTrue(b"".join(pieces).startswith(b"HRBLOCK1"))
        recording.close()


if __name__ == "__main__":
    unittest.main()
