#!/usr/bin/python3
"""hapticctl on a terminal: colours, keys, questions, and what top shows.

Usage: terminal_test.py BUILD_DIRECTORY [unittest arguments]
"""
import fcntl
import json
import os
import pty
import struct
import subprocess
import termios
import time
import unittest

from daemon_case import HAPTICCTL, Case, ball, eventually, stl


class TerminalCase(Case):
    """Commands on a pseudo-terminal."""

    def run_on_terminal(self, *arguments, send=(), size=None, **environment):
        """`size`: columns and rows."""
        pid, terminal = pty.fork()
        if pid == 0:
            if size is not None:
                fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", size[1], size[0], 0, 0))
            os.environ.update({"HAPTICD_SOCKET": str(self.socket), "TERM": "xterm", **environment})
            os.execv(HAPTICCTL, ["hapticctl", *map(str, arguments)])
        output, send = b"", list(send)
        try:
            while True:
                chunk = os.read(terminal, 65536)
                output += chunk
                while send and send[0][0] in output:
                    os.write(terminal, send.pop(0)[1])
        except OSError:  # The other side is closed.
            pass
        os.close(terminal)
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), output.decode()


class OnATerminal(TerminalCase):
    """Colours, keys, the question for the scale, progress."""

    def test_colours_only_where_wanted(self):
        self.assertIn("\x1b[1m", self.run_on_terminal("list", NO_COLOR="")[1])
        self.assertNotIn("\x1b", self.run_on_terminal("list", NO_COLOR="1")[1])
        self.assertNotIn("\x1b", self.run_on_terminal("list", TERM="dumb")[1])

    def test_top_takes_keys_and_gives_the_screen_back(self):
        code, output = self.run_on_terminal("top", "-d", "0.1", send=[(b"q quit", b"c"), (b"counts cleared", b"q")])
        self.assertEqual(code, 0)
        self.assertTrue(output.startswith("\x1b[?1049h") and output.endswith("\x1b[?1049l"), output[-40:])

    def test_top_has_24_rows_where_only_columns_are_told(self):
        output = self.run_on_terminal("top", "-n", "1", size=(100, 0))[1]
        self.assertIn("sim", output)
        self.assertNotIn("lines more", output)

    def test_tables_fit_into_80_columns(self):
        """Where the size is unknown, as here, a terminal has 80 columns and 24 rows."""
        self.run_ctl("arm", "--for", "0.05")
        for command in (["status"], ["list"], ["objects"], ["monitor", "--duration", "0.2"]):
            code, output = self.run_on_terminal(*command, NO_COLOR="1")
            self.assertEqual(code, 0)
            lines = [line for line in output.splitlines() if not line.startswith("socket ")]
            self.assertLessEqual(max(map(len, lines)), 80, output)
        for command in ([], ["load"], ["limits"], ["hand"], ["cut"], ["import"]):
            output = self.run_on_terminal(*command, "--help")[1]
            self.assertLessEqual(max(map(len, output.splitlines())), 80, output)
        self.assertIn("SCHEDULING", self.run_ctl("status").stdout, "a file has them all")
        self.assertIn("|f| N", self.run_ctl("monitor", "--duration", "0.1").stdout)

    def test_top_neither_wraps_nor_rolls(self):
        command = [HAPTICCTL, "--socket", self.socket, "monitor", "--csv"]
        others = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for _ in range(8)]
        try:
            self.assertTrue(eventually(lambda: len(self.json("status")["clients"]) == len(others)))
            screen = self.run_on_terminal("top", "-d", "0.1", "-n", "1", size=(60, 10), NO_COLOR="1")[1]
        finally:
            for other in others:
                other.terminate()
                other.wait(60)
        self.assertIn("\x1b[?7l", screen)
        self.assertLess(screen.index("\x1b[?7h"), screen.index("\x1b[?1049l"), "and wraps again")
        self.assertRegex(screen, r"\n[2-9] lines more: hapticctl status")
        self.assertIn("q quit", screen)
        self.assertLess(screen.count("\n"), 10)

    def test_the_scale_is_asked_for(self):
        path = self.file("t.stl", stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"]))
        code, output = self.run_on_terminal("load", path, send=[(b"per file unit: ", b"mm\n")])
        self.assertEqual(code, 0, output)
        self.assertIn("20.0 mm x 30.0 mm x 50.0 mm, closed", output)
        code, output = self.run_on_terminal("load", path, "--name", "other", send=[(b"per file unit: ", b"\n")])
        self.assertEqual(code, 2)
        self.assertEqual([o["name"] for o in self.json("objects")], ["t"])

    def test_ctrl_c_disarms(self):
        code, output = self.run_on_terminal("arm", send=[(b"ramping", b"\x03")])
        self.assertEqual(code, 0)
        self.assertIn("disarmed", output)
        self.assertFalse(self.json("status")["devices"][0]["armed"])


    def test_a_reader_that_stands_still_holds_up_no_signal(self):
        monitor = subprocess.Popen([HAPTICCTL, "--socket", self.socket, "monitor", "--csv"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(monitor.kill)

        def full():
            """As good as: no page of it is left, though each need not be full."""
            before = waiting()
            time.sleep(0.5)
            return (now := waiting()) > 30_000 and now == before

        def waiting():
            return struct.unpack("i", fcntl.ioctl(monitor.stdout, termios.FIONREAD, bytes(4)))[0]

        self.assertTrue(eventually(full))
        monitor.terminate()
        self.assertEqual(monitor.wait(30), 5)
        self.assertEqual(monitor.communicate()[1], "hapticctl: standard output: its reader stands still\n"
                                                   "  what was to come is lost: begin again\n")


class MoreThanThereIsTimeFor(TerminalCase):
    """A tool of many points amid as many meshes as are asked for, none with a volume."""

    def test_collisions_cut_short_are_told_with_their_remedy(self):
        path = self.file("ball.stl", ball(40))
        for k in range(17):
            self.run_ctl("load", path, "--scale", "m", "--name", f"ball{k}")
        for command in (["top", "-b", "-n", "1"], ["status"]):
            self.assertNotIn("cut short", self.run_ctl(*command).stdout)
        self.run_ctl("tool", "attach", "ball0")
        while (told := self.json("get", "/statistics/sim")["collide"])["queries"] < 10:
            time.sleep(0.02)
        self.assertGreater(told["exhausted"], 0)
        for command in (["top", "-b", "-n", "1"], ["status"]):
            self.assertRegex(self.run_ctl(*command).stdout, r"sim: collisions: [\d ]+ answers, [1-9][\d ]* cut short, 0 lost")
        checks = {check["name"]: check for check in json.loads(self.run_ctl("--json", "doctor", exit_code=1).stdout)["checks"]}
        self.assertEqual(checks["daemon: collision default"]["state"], "red")
        self.assertIn("--voxel", checks["daemon: collision default"]["remedy"])
        self.run_ctl("tool", "detach")
        time.sleep(0.1)  # The last answers come.
        self.assertEqual(self.json("status")["devices"][0]["collide"], self.json("get", "/statistics/sim")["collide"])
        keys = [(b"q quit", b"c"), (b"counts cleared", b"q")]
        screens = self.run_on_terminal("top", "-d", "0.1", send=keys, NO_COLOR="1")[1].split("\x1b[H")
        before, after = (next(one for one in screens if words in one) for words in ("q quit", "counts cleared"))
        self.assertIn("cut short", before)
        self.assertNotIn("cut short", after)


if __name__ == "__main__":
    unittest.main()
