#!/usr/bin/python3
"""What bash completes is what hapticctl takes. Usage: completion_test.py SOURCE BUILD"""
import os
import pathlib
import re
import subprocess
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
from daemon_case import BUILD, HAPTICCTL, SILENT, Case  # noqa: E402  (it takes the next word)

# Prints what is offered for the command line in its first word, one a line.
SCRIPT = r"""
source /usr/share/bash-completion/bash_completion
source "$COMPLETION"
COMP_LINE=$1 COMP_POINT=${#1}
read -ra COMP_WORDS <<<"$1"
[[ $1 != *" " ]] || COMP_WORDS+=("")
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_hapticctl 2>/dev/null
printf '%s\n' "${COMPREPLY[@]}"
"""
COMMON = {"--json", "--socket", "--admin", "--timeout", "--help"}


def help_of(*words):
    own = BUILD / f"tools/hapticctl-{words[0]}/hapticctl-{words[0]}" if words else HAPTICCTL
    command = [own] if words and own.exists() else [HAPTICCTL, *words]
    return subprocess.run([*command, "--help"], capture_output=True, text=True, check=True).stdout


def options_of(text):
    """Those in the first column of a help page, of both forms."""
    lines = re.findall(r"^  ((?:-\w,?|--[\w-]+,?)+)(?= |$)", text, re.M)
    return {name for line in lines for name in line.split(",")} - {"-h", "--centre"}


class Completion(Case):
    def offered(self, line):
        environment = {**os.environ, **SILENT, "COMPLETION": str(SOURCE / "tools/completion/hapticctl"), "HAPTICD_SOCKET": str(self.socket),
                       "PATH": f"{HAPTICCTL.parent}:{os.environ['PATH']}"}
        done = subprocess.run(["bash", "-c", SCRIPT, "bash", line], capture_output=True, text=True, env=environment, cwd=self.directory,
                              check=True, timeout=30)
        return set(done.stdout.split())

    def test_each_command_is_offered_its_own_options(self):
        general = help_of()
        commands = re.findall(r"^  ([\w-]+) {2,}", general.split("Subcommands:")[1], re.M) + ["import", "cut"]
        self.assertEqual(self.offered("hapticctl "), {*commands, *options_of(general)})
        for command in [*commands, "tool attach", "tool detach"]:
            takes = options_of(help_of(*command.split())) | COMMON
            if command == "import":  # The scale is its own.
                takes |= options_of(help_of("load")) - {"--size"}
            self.assertEqual(self.offered(f"hapticctl {command} -") - {"-"}, takes, command)

    def test_words_are_completed_by_their_place(self):
        self.run_ctl("add", "sphere", "--size", "0.01", "--name", "ball")
        for command in ("get", "set"):
            self.assertEqual(self.offered(f"hapticctl {command} "), {"/" + name for name in self.json("get", "/")}, command)
        (self.directory / "scan").mkdir(exist_ok=True)
        self.file("ball.stl", "")
        for line, wanted in [("tool ", {"attach", "detach"}), ("tool attach ", {"ball"}), ("tool attach --mass 0.2 ball ", {"sim"}),
                             ("tool detach ", {"sim"}), ("arm s", {"sim"}), ("arm sim ", set()), ("limits --force ", set()),
                             ("limits --force 3 ", {"sim"}), ("record a.hrec ", {"sim"}), ("load b", {"ball.stl"}),
                             ("load ball.stl --parent b", {"ball"}), ("load-texture relief.png ", {"ball"}), ("import sc", {"scan"}),
                             ("import --vdb sc", {"scan"}), ("import --raw ui", {"uint8", "uint16", "uint32"}),
                             ("export b", {"ball"}), ("events --kinds touch,un", {"touch,untouch"}), ("--timeout 3 li", {"list", "limits"}),
                             ("--socket /nonexistent remove ", set())]:
            self.assertEqual(self.offered(f"hapticctl {line}"), wanted, line)


if __name__ == "__main__":
    unittest.main()
