"""A numbered example as a module: its name begins with a digit, so that import does not find it."""
import importlib.util


def load(path):
    """The module; what stands behind `if __name__ == "__main__"` does not run."""
    spec = importlib.util.spec_from_file_location("program", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
