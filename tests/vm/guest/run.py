"""Runs inside the virtual machine, started by its one unit: every check, in order, and reports each on the serial line."""
import importlib
import json
import traceback

from guest import report

# The order matters: what is installed first is tested by all that follow, and the last removes it.
TOPICS = ["install", "service", "access", "felt", "deaths", "panel", "falcon", "hid", "vendor", "sleep", "load", "remove"]
ALWAYS = TOPICS[:2]  # the others need a service that is installed and enabled


def main():
    wanted = report.options().get("only") or TOPICS
    for topic in TOPICS:
        if topic not in wanted and topic not in ALWAYS:
            continue
        module = importlib.import_module(f"guest.{topic}")
        for name, check in list(vars(module).items()):
            if name.startswith("check_"):
                report.run(topic, name.removeprefix("check_"), check)


if __name__ == "__main__":
    try:
        main()
    except Exception:  # a fault of the tests: said, then the machine switches off
        print(report.MARK + json.dumps({"fault": traceback.format_exc()}), flush=True)
    else:
        print(report.MARK + json.dumps({"end": True}), flush=True)
