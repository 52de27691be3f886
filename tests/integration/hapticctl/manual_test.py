#!/usr/bin/python3
"""The manual pages format without a warning and name what there is. Usage: manual_test.py SOURCE BUILD"""
import pathlib
import re
import subprocess
import sys
import unittest

SOURCE, BUILD = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
MAN = SOURCE / "docs/man"


def words(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


class Manual(unittest.TestCase):
    def test_pages_format_without_a_warning(self):
        for page in MAN.iterdir():
            done = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", page], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "", page.name)

    def test_no_word_is_taken_for_a_macro(self):
        """As Nm, newton metres, is one that prints the program's name; what lost its word prints "file ..." or nothing."""
        for page in MAN.iterdir():
            text = words("man", "-E", "UTF-8", "-l", page)
            for lost in (" file ...", "[]"):
                self.assertNotIn(lost, text.replace(".devices[].missed", ""), page.name)
        self.assertIn("[--torque Nm]", re.sub(r"\s+", " ", words("man", "-E", "UTF-8", "-l", MAN / "hapticctl.1")))

    def page(self, name):
        return (MAN / name).read_text(encoding="utf-8").replace("\\-", "-")

    def test_every_command_and_option_of_hapticctl_stands_in_its_page_and_completion(self):
        hapticctl = BUILD / "tools/hapticctl/hapticctl"
        page, completion = self.page("hapticctl.1"), (SOURCE / "tools/completion/hapticctl").read_text()
        commands = re.findall(r"^  (\w+) {2,}", words(hapticctl, "--help").split("Subcommands:")[1], re.M)
        self.assertGreater(len(commands), 15)
        for command in commands:
            self.assertRegex(page, rf"\.It Cm {command}\b")
            self.assertRegex(completion, rf'commands=".*\b{command}\b')
            for option in re.findall(r"--([a-z-]+)", words(hapticctl, command, "--help").split("\nExit:")[0]):
                if option in ("help", "batch", "count", "delay", "centre"):
                    continue  # Their short forms, or the usual.
                self.assertTrue(re.search(rf"Fl -{option}\b", page), f"{command} --{option} is not in hapticctl.1")
                self.assertIn(f"--{option}", completion)

    def test_every_option_of_hapticctls_own_programs_is_told(self):
        page = self.page("hapticctl.1")
        for name in ("hapticctl-import", "hapticctl-cut"):
            for option in set(re.findall(r"--([a-z-]+)", words(BUILD / "tools" / name / name, "--help"))) - {"help"}:
                self.assertRegex(page, rf"Fl -{option}\b", name)

    def test_every_column_of_monitor_is_told(self):
        header = re.search(r'kCsvHeader =\s*((?:"[^"]*"\s*)+)', (SOURCE / "tools/hapticctl/monitor.cc").read_text())[1]
        page = self.page("hapticctl.1").split(".Sh COLUMNS")[1]
        for column in "".join(re.findall(r'"([^"]*)"', header)).replace("\\n", "").split(","):
            name = re.sub(r"^(surface|effect|local_model|client|gravity|guard|texture|transient)_[xyz]$", r"\1_", column)
            self.assertRegex(page, rf"\b{name}(\b|(?<=_) )", column)

    def test_every_key_and_option_of_hapticd_is_told(self):
        page = self.page("hapticd.toml.5")
        for key in re.findall(r"^(?:# )?(\w+) = ", (SOURCE / "systemd/hapticd.toml").read_text(), re.M):
            self.assertRegex(page, rf"\b{key}\b")
        for option in re.findall(r"--([a-z-]+)", words(BUILD / "daemon/hapticd", "--help")):
            self.assertIn(f"Fl -{option}", self.page("hapticd.8"))

    def test_every_benchmark_and_option_of_haptic_bench_is_told(self):
        bench, page = BUILD / "tools/haptic-bench/haptic-bench", self.page("haptic-bench.1")
        general = words(bench, "--help")
        names = re.findall(r"^  (\w+) {2,}", general.split("Subcommands:")[1], re.M)
        self.assertGreaterEqual(len(names), 2)
        for text in [general] + [words(bench, name, "--help") for name in names]:
            for option in set(re.findall(r"--([a-z-]+)", text)) - {"help"}:
                self.assertIn(f"Fl -{option}", page)
        for name in names:
            self.assertIn(f".It Cm {name}", page)
            self.assertIn(f"\n.Cm {name}\n", page.split(".Sh DESCRIPTION")[0])
        self.assertEqual(subprocess.run([bench, "none"], capture_output=True).returncode, 2)

    def test_completion_is_valid_bash(self):
        words("bash", "-n", SOURCE / "tools/completion/hapticctl")


if __name__ == "__main__":
    unittest.main()
