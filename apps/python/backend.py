# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""What pip calls (PEP 517): a wheel by CMake, with nothing but Python's own library.

OCTANT_BUILD_DIR: a build tree to use again, instead of one from nothing; -DCMAKE... words: OCTANT_CMAKE_ARGS.
"""

import base64
import hashlib
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def _version():
    with open(os.path.join(SOURCE, "CMakeLists.txt"), encoding="utf-8") as file:
        return re.search(r"project\(octant VERSION ([0-9.]+)", file.read()).group(1)


def _install(prefix, build):
    if not os.path.exists(os.path.join(build, "CMakeCache.txt")):
        words = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DOCTANT_BUILD_TESTS=OFF",
                 "-DOCTANT_BUILD_TOOLS=OFF", "-DOCTANT_BUILD_PYTHON=ON", f"-DPython3_EXECUTABLE={sys.executable}"]
        subprocess.run(["cmake", "-S", SOURCE, "-B", build, *words, *shlex.split(os.environ.get("OCTANT_CMAKE_ARGS", ""))],
                       check=True)
    subprocess.run(["cmake", "--build", build, "--target", "octant_python", "-j", str(os.cpu_count())], check=True)
    subprocess.run(["cmake", "--install", build, "--prefix", prefix, "--component", "python"], check=True)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds octant-VERSION-...whl into the directory; its name."""
    del config_settings, metadata_directory
    version = _version()
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    info = f"octant-{version}.dist-info"
    files = {}
    with tempfile.TemporaryDirectory(prefix="octant-wheel-") as box:
        _install(os.path.join(box, "wheel"), os.environ.get("OCTANT_BUILD_DIR") or os.path.join(box, "build"))
        for where, _, names in os.walk(os.path.join(box, "wheel")):
            for name in sorted(names):  # whatever the folders above it, the package is octant/
                with open(os.path.join(where, name), "rb") as file:
                    files["octant/" + name] = file.read()
    if not any(name.startswith("octant/_octant") for name in files):
        raise RuntimeError("the extension was not built: pybind11 (pybind11-dev, python3-dev) is missing")
    files[f"{info}/METADATA"] = (f"Metadata-Version: 2.1\nName: octant\nVersion: {version}\n"
                                 "Summary: Calibration and survey toolkit for time-of-flight beacon positioning\n"
                                 "License: Apache-2.0\nRequires-Python: >=3.9\nRequires-Dist: numpy\n").encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: octant\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    wheel = f"octant-{version}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    """There is none: a checkout is the source."""
    del sdist_directory, config_settings
    raise NotImplementedError("octant has no source distribution: install from a checkout")
