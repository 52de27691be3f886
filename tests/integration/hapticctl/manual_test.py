#!/usr/bin/python3
"""The manual pages format without a warning and name what there is. Usage: manual_test.py SOURCE BUILD"""
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest

SOURCE, BUILD = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
MAN = SOURCE / "docs/man"


def words(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def options_of(help_text):
    """The long options in the first column of a help page; of several names of one all."""
    lines = re.findall(r"^  ((?:-\w,|--[\w-]+[{,]?)+)", help_text, re.M)
    return {name for line in lines for name in re.findall(r"--([\w-]*[a-z])", line)} - {"help", "version"}


def flags_in(page):
    return set(re.findall(r"\bFl -([\w-]*[a-z])", page))


def items_of(section):
    """{name: text} of a section's .It Cm entries, .It line included."""
    pieces = re.split(r"^\.It Cm ([\w-]+)", section, flags=re.M)
    return dict(zip(pieces[1::2], pieces[2::2]))


class Manual(unittest.TestCase):
    def test_pages_format_without_a_warning(self):
        for page in MAN.iterdir():
            done = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", page], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "", page.name)
        done = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", *MAN.iterdir()], capture_output=True, text=True, check=False)
        self.assertEqual(done.stdout, "")

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
            for option in re.findall(r"--([a-z-]+)", words(hapticctl, command, "--help")):
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
        header = re.search(r'kCsvHeader =\s*((?:"[^"]*"\s*)+)', (SOURCE / "tools/hapticctl/command/monitor.cc").read_text())[1]
        page = self.page("hapticctl.1").split(".Sh COLUMNS")[1]
        for column in "".join(re.findall(r'"([^"]*)"', header)).replace("\\n", "").split(","):
            name = re.sub(r"^(surface|effect|local_model|client|gravity|guard|texture|transient)_[xyz]$", r"\1_", column)
            self.assertRegex(page, rf"\b{name}(\b|(?<=_) )", column)

    def test_every_name_of_an_object_and_a_device_is_told_in_the_protocol(self):
        names = (SOURCE / "docs/protocol.md").read_text(encoding="utf-8").split("### Resource names")[1].split("\n### ")[0]
        told = dict(zip(("object", "device"), names.split("\n| `/devices/NAME`")))
        for what, text in told.items():
            source = (SOURCE / f"daemon/resource/{what}_properties.cc").read_text().split("Properties[] = {")[1].split("\n};")[0]
            properties = re.findall(r'^    (?:\{|\w+Of<.*>\(\s*)"(\w+)"', source, re.M)
            self.assertGreater(len(properties), 30)
            for name in properties:
                self.assertRegex(text, r"`effect_`" if name.startswith("effect_") else rf"[`/]{name}`")

    def test_help_of_the_daemon_fits_a_terminal(self):
        for name in ("hapticd", "hapticd-safe"):
            for line in words(BUILD / "daemon" / name, "--help").splitlines():
                self.assertLessEqual(len(line), 80, f"{name}: {line}")

    def test_every_key_and_option_of_hapticd_is_told(self):
        page = self.page("hapticd.toml.5")
        for key in re.findall(r"^(?:# )?(\w+) = ", (SOURCE / "systemd/hapticd.toml").read_text(), re.M):
            self.assertRegex(page, rf"\b{key}\b")
        for option in re.findall(r"--([a-z-]+)", words(BUILD / "daemon/hapticd", "--help")):
            self.assertIn(f"Fl -{option}", self.page("hapticd.8"))

    def test_every_default_of_the_configuration_is_as_told(self):
        defaults = tomllib.loads(words(BUILD / "daemon/hapticd", "--config", "/dev/null", "--print-config"))
        page = self.page("hapticd.toml.5").replace("\\(dq", '"')
        sections = dict(re.findall(r"^\.Sh \[(\w+)\]\n(.*?)(?=^\.Sh)", page, re.M | re.S))
        for name, table in defaults.items():
            told = re.findall(r"^\.It Li (\w+) Op Li (.+)$", sections[name], re.M)
            self.assertEqual({key: tomllib.loads(f"x = {value}")["x"] for key, value in told}, table, name)

    def test_the_range_of_every_number_of_the_configuration_is_as_told(self):
        daemon = BUILD / "daemon/hapticd"
        sections = dict(re.findall(r"^\.Sh \[(\w+)\]\n(.*?)(?=^\.Sh)", self.page("hapticd.toml.5"), re.M | re.S))
        defaults = tomllib.loads(words(daemon, "--config", "/dev/null", "--print-config"))
        with tempfile.NamedTemporaryFile("w+", suffix=".toml") as file:
            for section, key in [(name, key) for name, table in defaults.items() for key, value in table.items()
                                 if type(value) in (int, float) and not key.endswith("mode")]:
                file.seek(0)
                file.truncate()
                file.write(f"[{section}]\n{key} = 1000000000\n")
                file.flush()
                done = subprocess.run([daemon, "--check-config", "--config", file.name], capture_output=True, text=True, check=False)
                told = re.search(r"out of range \((.* to .*)\)", done.stderr)
                self.assertTrue(told, f"{section}.{key}: {done.stderr}")
                text = re.search(rf"^\.It Li {key} .*?(?=^\.It |^\.El)", sections[section], re.M | re.S)[0]
                self.assertRegex(text, rf"(?<![\d.]){re.escape(told[1])}(?![\d.]*\d)")

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

    def test_each_benchmarks_options_stand_with_it_and_no_others(self):
        bench, page = BUILD / "tools/haptic-bench/haptic-bench", self.page("haptic-bench.1")
        general = options_of(words(bench, "--help"))
        usage = {re.search(r"^\.Cm (\w+)", block, re.M)[1]: block
                 for block in page.split(".Sh SYNOPSIS")[1].split(".Sh DESCRIPTION")[0].split("\n.Nm\n")[1:]}
        items = items_of(page.split(".Ss Benchmarks")[1].split(".Sh EXIT")[0])
        self.assertEqual(sorted(usage), sorted(items))
        for name, block in usage.items():
            takes = options_of(words(bench, name, "--help"))
            shorts = {"a": "algorithm", "m": "model", "t": "trajectory"}
            told = flags_in(block) | {shorts[flag] for flag in re.findall(r"\bFl ([a-z])\b", block)}
            self.assertEqual(told - general, takes, f"synopsis of {name}")
            self.assertLessEqual(flags_in(items[name]), takes | general, name)

    def test_each_commands_options_stand_with_it_and_no_others(self):
        hapticctl, page = BUILD / "tools/hapticctl/hapticctl", self.page("hapticctl.1")
        general = options_of(words(hapticctl, "--help"))
        body, placement = page.split(".Sh COMMANDS")[1].split(".Ss Other")[0].split("of\n.Cm load\nand\n.Cm add :")
        placement, items = flags_in(placement), items_of(body)
        for name, text in items.items():
            own = BUILD / f"tools/hapticctl-{name}/hapticctl-{name}"
            command = [own] if own.exists() else [hapticctl, *name.split()]
            takes = options_of(words(*command, "--help")) - {"centre"}
            if name == "tool":
                takes |= options_of(words(*command, "attach", "--help"))
            told = flags_in(text) | (placement if name in ("load", "add") else set())
            told -= {"csv"} if name == "hand" else set()
            missing = takes - told
            self.assertEqual(missing, set(), f"{name} has them")
            self.assertLessEqual(told, takes | general | ({"voxel"} if name == "import" else set()), f"{name} has them not")

    def test_words_that_options_take_are_told_as_they_are_completed(self):
        page, completion = self.page("hapticctl.1"), (SOURCE / "tools/completion/hapticctl").read_text()
        api = (SOURCE / "libclient/src/api/events.cc").read_text()
        kinds = re.findall(r'"([a-z-]+)"', re.search(r"kNames\[HAPTIC_EVENT_KINDS\] = \{(.*?)\};", api, re.S)[1])
        self.assertEqual(re.search(r'kinds="(.*?)"', completion)[1].split(), kinds)
        numbers = re.search(r'--raw\).*?-W "(.*?)"', completion)[1].split()
        for words_of, option, first in [(kinds, "events", "names some of"), (numbers, "import", "kind being")]:
            told = items_of(page)[option].split(first)[1].split("\n.")[0]
            listed = [word for word in re.findall(r"[a-z][\w-]*", told) if word not in ("and", "or")]
            self.assertEqual(listed, words_of, option)

    def test_every_fault_of_a_played_device_is_told(self):
        names = re.search(r"kFaultNames\[\] = \{(.*?)\};", (SOURCE / "tools/haptic-emu/fault.h").read_text(), re.S)[1]
        told = re.search(r"A fault is (.*?):", (SOURCE / "docs/writing-a-driver.md").read_text(encoding="utf-8"), re.S)[1]
        self.assertEqual(re.findall(r"`(.*?)`", told), re.findall(r'"(.*?)"', names))

    def test_completion_is_valid_bash(self):
        words("bash", "-n", SOURCE / "tools/completion/hapticctl")


if __name__ == "__main__":
    unittest.main()
