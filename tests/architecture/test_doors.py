"""Each third-party package has one door, and `import flexmb` opens none of the heavy ones."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from architecture.rooms import DOORS, HEAVY
from architecture.sources import FILES, PACKAGE, ROOT, for_each, imports, name


@for_each(FILES)
def test_third_party_packages_have_one_door(path):
    inside = path.relative_to(PACKAGE).as_posix()
    wrong = []
    for module, line in imports(path):
        package = module.split(".")[0]
        if package == "flexmb" or (package in sys.stdlib_module_names and package not in DOORS):
            continue
        doors = DOORS.get(package)
        if doors is None:
            wrong.append(f"{name(path)}:{line} imports {package}, which has no door")
        elif not inside.startswith(doors):
            wrong.append(f"{name(path)}:{line} imports {package}; its door is {', '.join(doors)}")
    assert not wrong, "\n".join(wrong)


def test_import_of_flexmb_is_light():
    code = f"import sys, flexmb; print(*sorted(set({HEAVY!r}) & set(sys.modules)))"
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert child.stdout.split() == []


@pytest.mark.skipif("CI" not in os.environ, reason="developers test their working copy")
def test_the_installed_package_is_tested():
    """A test run of the source tree would not see that a file is missing in the package."""
    spec = find_spec("flexmb")
    assert spec is not None
    assert ROOT not in Path(spec.origin).parents
