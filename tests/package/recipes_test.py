#!/usr/bin/python3
"""The files for package managers can be parsed, name what they must, and have the version of CMake.
    recipes_test.py SOURCE
"""
import json
import re
import sys
import tomllib
import xml.etree.ElementTree as xml
from pathlib import Path

source = Path(sys.argv[1])
version = re.search(r"project\(bullet_ccd VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text())[1]

package = xml.parse(source / "package.xml").getroot()
assert package.tag == "package" and package.get("format") == "3"
for tag in ("name", "version", "description", "maintainer", "license"):
    assert (package.findtext(tag) or "").strip(), f"package.xml has no <{tag}>"
assert package.find("maintainer").get("email")
assert package.findtext("export/build_type") == "cmake"

project = tomllib.loads((source / "pyproject.toml").read_text())
assert project["build-system"]["build-backend"] == "scikit_build_core.build"

port = json.loads((source / "tools/recipes/vcpkg/vcpkg.json").read_text())
assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", port["name"])

conda = (source / "tools/recipes/conda/meta.yaml").read_text()
versions = {"package.xml": package.findtext("version"), "pyproject.toml": project["project"]["version"],
            "vcpkg.json": port["version"],
            "meta.yaml": re.search(r'version: "([0-9.]+)"', conda)[1]}
wrong = {file: found for file, found in versions.items() if found != version}
assert not wrong, f"CMake says {version}, but {wrong}"
try:
    import yaml
except ImportError:
    pass
else:
    assert yaml.safe_load(conda)["test"]["imports"] == ["bullet_ccd"]
