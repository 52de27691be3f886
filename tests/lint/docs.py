#!/usr/bin/python3
"""What the documentation names is there: links and their sections, files, tests, examples, the client library's names, and
commands that the programs accept.

Usage: docs.py SOURCE [BUILD]. Without BUILD commands are not tried. Prints each breach and exits 1.
"""
import fnmatch
import io
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import tokenize

ROOMS = "proto|rt|drivers|daemon|libclient|tools|tests|systemd|docs|examples"
PROGRAMS = {"hapticctl": "tools/hapticctl/hapticctl", "haptic-bench": "tools/haptic-bench/haptic-bench"}
# Whose pages are installed side by side, but for a folder in it: a link that leads elsewhere is dead there.
INSTALLED = {"docs": "man", "examples": "surgery"}
UNKNOWN = "--no-such-option"


def prose(text):
    """The text without its blocks of code, whose brackets are no links."""
    return re.sub(r"^```.*?^```", lambda block: "\n" * block[0].count("\n"), text, flags=re.M | re.S)


def anchors(page):
    """As forges make them of headings."""
    headings = re.findall(r"^#+ +(.*?)\s*$", prose(page.read_text(encoding="utf-8")), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(page):
    for number, line in enumerate(prose(page.read_text(encoding="utf-8")).splitlines(), 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", line):
            if re.match(r"\w+:", target):
                continue
            name, _, section = target.partition("#")
            to = (page.parent / name).resolve() if name else page
            if not to.exists():
                yield number, f"link to {target}: no such file"
            elif page.parent.name in INSTALLED and (page.parent not in to.parents or INSTALLED[page.parent.name] in to.relative_to(page.parent).parts):
                yield number, f"link to {target}: is not installed beside this page"
            elif section and section not in anchors(to):
                yield number, f"link to {target}: no such section"


def names(page, root, tests):
    """Paths in the tree and tests that a page names."""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        for path in re.findall(rf"(?<![\w/.$-])((?:{ROOMS})/[\w./-]*\w)", line):
            near = (root / path).parent
            if not (root / path).exists() and not (near.is_dir() and list(near.glob(pathlib.Path(path).name + ".*"))):
                yield number, f"{path}: no such file"
        for quoted, slanted in re.findall(r"`([A-Z]\w+\.(?:\*|[A-Z]\w+\*?))`|(?<!\*)\*([A-Z]\w+\.[A-Z]\w+)\*(?!\*)", line):
            named = quoted or slanted
            if named != "Suite.Test" and not fnmatch.filter(tests, named):
                yield number, f"{named}: no such test"


def library(root):
    """All words of the client library's headers and of its Python, but for those in comments and texts."""
    headers = [*(root / "libclient/include/hapticclient").iterdir(), *(root / "tools/haptic-bench/algorithm").glob("*.h")]
    known = set()
    for header in headers:
        known.update(re.findall(r"\w+", re.sub(r"/\*.*?\*/|//[^\n]*|\"[^\"\n]*\"", " ", header.read_text(encoding="utf-8"), flags=re.S)))
    for module in (root / "libclient/python/hapticclient").glob("*.py"):
        words = tokenize.generate_tokens(io.StringIO(module.read_text(encoding="utf-8")).readline)
        known.update(word.string for word in words if word.type == tokenize.NAME)
    return known


def code(page, known):
    """Names of the client library that it does not have, and Python that is none."""
    text = page.read_text(encoding="utf-8")
    for number, line in enumerate(text.splitlines(), 1):
        for name in re.findall(r"\b(haptic_\w+)(?=[(`])|\b(HAPTIC_[A-Z0-9_]*[A-Z0-9])\b|\bhaptic(?:::|\.)([A-Z]\w+)", line):
            if not known.issuperset(filter(None, name)):
                yield number, f"{''.join(name)}: the client library has no such name"
    for block in re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S):
        first = text.count("\n", 0, block.start(1))
        try:
            compile(block[1], "block", "exec")
        except SyntaxError as error:
            yield first + error.lineno, f"is no Python: {error.msg}"


def commands(page):
    """Lines of code and what stands between ticks, as words of a shell; and whether it is a line, which must be whole."""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        pieces = re.findall(r"`((?:hapticctl|haptic-bench) [^`]+)`", line)
        line = line.removeprefix(".Dl ")  # A manual page's.
        if re.match(r"(    )?(hapticctl|haptic-bench) ", line):
            pieces = [line]
        for piece in pieces:
            try:
                words = shlex.split(re.sub(r"\.\.\. *|\[|\]", "", piece), comments=True)
            except ValueError:
                yield number, piece, None, False
                continue
            while words:
                end = next((i for i, word in enumerate(words) if word in ("&&", "|", ";", "&", ">")), len(words))
                if words[0] in PROGRAMS and len(words[:end]) > 1:
                    yield number, piece, words[:end], piece is line
                words = words[end + 1:]


def refused(words, build, folder):
    """What a program says against a command line, or None. Nothing is done: an option nobody knows stands at its end."""
    program = build / PROGRAMS[words[0]]
    other = build / f"tools/{words[0]}-{words[1]}/{words[0]}-{words[1]}"
    given = [str(other), *words[2:]] if other.exists() else [str(program), *words[1:]]
    hands_on = words[1] == "import"  # What it does not know is hapticctl load's; it ends before, for want of a file.
    environment = dict(os.environ, HAPTICD_SOCKET=str(folder / "none"))
    done = subprocess.run(given + ([] if hands_on else [UNKNOWN]), cwd=folder, env=environment, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=300, check=False)
    said = done.stderr.strip().split("\n")[0]
    if hands_on:
        return None if done.returncode == 5 else said
    return None if done.returncode == 2 and re.search(rf'was not expected: {UNKNOWN}("|( \(.* --help tells how\))?$)', said) else said


def examples(root):
    """Examples are counted and listed as there are, and the README leads to every page."""
    programs = sorted(path.name for path in (root / "examples").glob("[0-9][0-9]-*") if path.suffix in (".c", ".cc", ".py"))
    numbers = "none one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen".split()
    for name, counted in (("README.md", r"\[(\w+) examples\]\(examples/\)"), ("README.md", r"(\w+) whole programs"),
                          ("examples/README.md", r"Each of the (\w+)")):
        for number, line in enumerate((root / name).read_text(encoding="utf-8").splitlines(), 1):
            for told in re.findall(counted, line):
                if told.lower() != numbers[len(programs)]:
                    yield f"{name}:{number}: tells of {told} examples: there are {numbers[len(programs)]}"
    for page, leads, what in [("examples/README.md", f"]({name})", name) for name in programs] + \
                             [("README.md", f"](docs/{path.name})", path.name) for path in sorted((root / "docs").glob("*.md"))]:
        if leads not in (root / page).read_text(encoding="utf-8"):
            yield f"{page}:1: leaves out {what}"


def breaches(root, build):
    tests = set()
    for source in (root / "tests").rglob("*.cc"):
        found = re.findall(r"^TEST(?:_[FP])?\((\w+),\s*(\w+)\)", source.read_text(encoding="utf-8"), re.M)
        tests.update(f"{suite}.{test}" for suite, test in found)
    pages = [root / "README.md", *sorted((root / "docs").glob("*.md")), *sorted((root / "examples").rglob("*.md")),
             *sorted((root / "docs/man").iterdir())]
    yield from examples(root)
    known = library(root)
    with tempfile.TemporaryDirectory() as folder:
        for page in pages:
            where = page.relative_to(root)
            for number, what in [*links(page), *names(page, root, tests), *code(page, known)]:
                yield f"{where}:{number}: {what}"
            for number, piece, words, whole in commands(page) if build else []:
                what = refused(words, build, pathlib.Path(folder)) if words else "is no line of a shell"
                if what is not None and not re.search(r"File does not exist" if whole else r"File does not exist|is required", what):
                    yield f"{where}:{number}: {piece.strip()}: {what}"


def main():
    root, build = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else None
    found = list(breaches(root, build))
    print("\n".join(found) if found else "the documentation names what there is")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
