#!/usr/bin/python3
"""Finds constants, types and functions of unnamed namespaces that two files of one program have: compiled in batches
(HAPTICD_UNITY, tools/cmake/Settings.cmake) they would clash, and then only in a build of that kind. So would those of a
header that one of its files includes. And constants that a class of the same folder has as well: its functions take its
own, silently.

Usage: names.py ROOT. Prints each name with the files that have it, and exits 1.
"""
import collections
import pathlib
import re
import sys

# Programs and what of their folders is compiled otherwise; in tests each folder with files is one.
PROGRAMS = {"rt": r"_(portable|avx2|avx512)\.cc$", "drivers": r"_(driver|io)\.cc$",
            "daemon": r"/(main|builder|recording)/|/(memfd|builder_protocol|snapshot_memory)\.cc$",
            "daemon/builder": r"/vdb/", "daemon/recording": r"^$", "libclient": r"^$", "tools/mesh_file": r"^$", "tools/hapticctl": r"/main\.cc$",
            "tools/hapticctl-import": r"/(main|vdb_file|scan_file|dicom_series|nifti_whole)\.cc$", "tools/hapticctl-cut": r"/main\.cc$",
            "tools/haptic-emu": r"/main\.cc$", "tools/haptic-bench": r"/(peers|example)/|/main\.cc$"}
TEST_RT = tuple(f"tests/unit/{room}" for room in ("base", "scene", "geometry", "render", "guard", "effect", "finger", "cycle"))
ONE_BY_ONE = ("tests/fakes", "tests/fuzz", "tests/rt", "tests/support", "tests/install")
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|[{};()]|[^{};()"\']+')
COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*.*?\*/', re.S)
SCOPE = re.compile(r"(?:inline\s+)?namespace\s*([\w:]*)\s*$")
TYPE = re.compile(r"^(?:struct|class|union|enum(?:\s+class)?)\s+(?:alignas\(\w+\)\s*)?(\w+)")
MEMBER = re.compile(r"^\s+static constexpr [^=;{(]*?\b(k[A-Z]\w*)\b", re.M)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
OPEN = re.compile(r"^namespace \w+(::test)? \{", re.M)  # One that others are in.
SHARED = re.compile(r"^inline const(?:expr)? [^;]*;", re.M)
FUNCTION = re.compile(r"\b([a-z]\w*)\s*\((.*)\)[^()]*$", re.S)


def declarations(text):
    """Each declaration at the outermost level of an unnamed namespace, to its body or end."""
    text = COMMENT.sub(lambda found: found[0] if found[0][0] in "\"'" else "", text)  # "sim://default" holds none.
    text = re.sub(r"^\s*#.*$", "", text, flags=re.M)
    scopes, bodies, round_ones, words = [], 0, 0, ""
    for token in TOKEN.findall(text):
        if bodies == 0 and token == "{" and round_ones == 0 and (scope := SCOPE.search(words)):
            scopes.append(scope.group(1))
            words = ""
        elif bodies == 0 and token == "}" and scopes:
            scopes.pop()
            words = ""
        elif token == "{":
            bodies += 1
            words += "{" if bodies == 1 and round_ones == 0 else ""
        elif token == "}":
            bodies -= 1
            if bodies == 0 and round_ones == 0 and not re.search(r"=|\bk[A-Z]\w*\s*\{", words.split("(")[0]):
                if "" in scopes:
                    yield words
                words = ""
        elif bodies == 0 and token == ";" and round_ones == 0:
            if "" in scopes:
                yield words
            words = ""
        else:
            round_ones += {"(": 1, ")": -1}.get(token, 0) if bodies == 0 else 0
            words += token if bodies == 0 else ""


def types(parameters):
    """Without names and defaults, which tell no two functions apart."""
    parted = re.split(r",(?![^<(]*[>)])", re.sub(r" ?= ?[^,]*", "", parameters))
    return ", ".join(re.sub(r"^(.*[\s&*>])\w+(\[.*\])?$", r"\1\2", one.strip()).strip() for one in parted)


def constants(words):
    """What a declaration declares, without what it is made of."""
    inner = None
    while inner != words:
        inner, words = words, re.sub(r"[({][^(){}]*[)}]", "", words)
    return re.findall(r"\b(k[A-Z]\w*)", re.sub(r"=[^,;]*", "", words))


def names(path):
    for words in declarations(path.read_text(encoding="utf-8")):
        words = " ".join(words.split())
        words = re.sub(r"^template <[^{(]*> ", "", words)
        if re.match(r"(using|TEST|INSTANTIATE|TYPED|namespace|extern|static_assert)", words):
            continue
        if kind := TYPE.match(words):
            if "{" in words:
                yield kind.group(1)
        elif re.match(r"(?:inline |static )*(?:constexpr|const)\b[^(]*\bk[A-Z]", words):
            yield from constants(words)
        elif function := FUNCTION.search(words.split("{")[0].replace("HD_RT", "")):
            yield f"{function.group(1)}({types(function.group(2))})"


def headers(root, files):
    """Those of the tree that the files include themselves."""
    named = {name for path in files for name in INCLUDE.findall(path.read_text(encoding="utf-8"))}
    return sorted(root / name for name in named if (root / name).is_file())


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    programs = collections.defaultdict(list)
    for path in sorted(root.glob("tests/**/*.cc")):
        folder = str(path.parent.relative_to(root))
        if not folder.startswith(ONE_BY_ONE):
            rooms = {"session": "tests/session", "unit": "tests/unit, test_rt" if folder in TEST_RT else folder}
            programs[rooms.get(path.relative_to(root).parts[1], folder)].append(path)
    for folder, others in PROGRAMS.items():
        programs[folder] = [p for p in sorted((root / folder).rglob("*.cc")) if not re.search(others, str(p))]
    members = collections.defaultdict(dict)
    for header in {h for files in programs.values() for p in files for h in p.parent.glob("*.h")}:
        members[header.parent].update((name, header) for name in MEMBER.findall(header.read_text(encoding="utf-8")))
    found = 0
    for program, files in programs.items():
        have = collections.defaultdict(set)
        for header in headers(root, files):
            text = header.read_text(encoding="utf-8")
            for words in SHARED.findall(COMMENT.sub("", text)) if OPEN.search(text) else ():
                for name in constants(words):
                    have[name].add(header)
        for path in files:
            for name in names(path):
                have[name].add(path)
                if header := members[path.parent].get(name):
                    found += 1
                    print(f"{name} of {path.relative_to(root)}: a class in {header.name} has one, which goes before it")
        for name, paths in have.items():
            if len(paths) > 1:
                found += 1
                print(f"{name} of {program}: " + ", ".join(str(p.relative_to(root)) for p in sorted(paths)))
    print(f"{found} names to tell apart" if found else "each program calls one thing by one name")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
