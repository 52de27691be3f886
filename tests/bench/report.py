#!/usr/bin/python3
"""The page of haptic-bench report: all tables and plots on it, nothing outside of it needed. Usage: report.py HAPTIC_BENCH"""
import html.parser
import pathlib
import subprocess
import sys
import tempfile


class Page(html.parser.HTMLParser):
    """Counts tags and gathers what would be fetched."""

    def __init__(self):
        super().__init__()
        self.count, self.fetched, self.cells = {}, [], []

    def handle_starttag(self, tag, attributes):
        self.count[tag] = self.count.get(tag, 0) + 1
        self.fetched += [value for name, value in attributes
                         if name in ("src", "href", "xlink:href", "data") and not value.startswith("#")]

    def handle_data(self, data):
        self.cells.append(data.strip())


def main():
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "page.html"
        subprocess.run([sys.argv[1], "report", path, "--rounds", "1"], check=True, stdout=subprocess.DEVNULL)
        page = Page()
        page.feed(path.read_text(encoding="utf-8"))
    missing = [text for text in ("16128", "0.5018", "2.885", "0.0417", "god-object", "voxel:cells=128") if text not in page.cells]
    if missing or page.count.get("svg") != 4 or page.count.get("table", 0) < 6 or page.fetched:
        sys.exit(f"the page lacks {missing}, counts {page.count}, fetches {page.fetched[:5]}")


if __name__ == "__main__":
    main()
