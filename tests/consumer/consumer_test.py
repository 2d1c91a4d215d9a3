#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Octant as a robot's own program finds it: installed, linked by other compilers and flags, within another project, from Python.

    consumer_test.py SOURCE BUILD

Installs BUILD into a folder of its own and there builds and runs the programs of the guide from its text.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE, BUILD = (os.path.abspath(word) for word in sys.argv[1:3])
HALL = os.path.join(SOURCE, "datasets", "hall")
DEPLOYMENT = os.path.join(HALL, "deployment.true.json")
# The first stop of datasets/hall/heldout; the truth is 4.517, 10.644.
EXPECTED = re.compile(r"x 4\.5\d\d m, y 10\.6\d\d m")
failures = []


def run(*words, ok=True, **more):
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False, **more)
    if ok and done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: exit {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done


def test(function):
    try:
        function()
        print(f"ok       {function.__name__}")
    except Exception as error:  # all of them, one after the other
        failures.append(function.__name__)
        print(f"FAILED   {function.__name__}: {error}")


def readme(language):
    page = os.path.join("apps", "guide", "9-in-your-robot.md")
    with open(os.path.join(SOURCE, page), encoding="utf-8") as file:
        found = re.findall(rf"```{language}\n(.*?)```", file.read(), re.S)
    assert len(found) == 1, f"{len(found)} blocks of {language} in {page}"
    return found[0]


def configure(build, *words, **more):
    run("cmake", "-S", os.path.join(SOURCE, "tests", "consumer"), "-B", build, "-G", "Ninja",
        f"-DCMAKE_PREFIX_PATH={prefix}", f"-DREADME_CPP={cpp}", *words, **more)


def build_and_run(build, names):
    run("cmake", "--build", build, "-j", "2")
    environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=0")
    for name in names:
        for program, words in (("page", [DEPLOYMENT]), ("rooms", [DEPLOYMENT, os.path.join(HALL, "heldout")]),
                               ("c", [DEPLOYMENT]), ("cc", [DEPLOYMENT])):
            out = run(os.path.join(build, f"{program}_{name}"), *words, env=environment).stdout
            assert EXPECTED.search(out), f"{program}_{name} says {out!r}"


def with_gcc():
    """-O0, -march=native, AVX, AddressSanitizer against the libraries as they are."""
    names = ["debug", "native", "asan"]
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        if "avx2" in info.read():
            names.insert(2, "avx")
    build = os.path.join(box, "gcc")
    configure(build, f"-DWITH={';'.join(names)}")
    build_and_run(build, names)


def with_clang():
    if not shutil.which("clang++"):
        print("skipped  clang++ is not here")
        return
    build = os.path.join(box, "clang")
    configure(build, "-DWITH=native", "-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_C_COMPILER=clang")
    build_and_run(build, ["native"])


def other_eigen_settings_do_not_link():
    """Without the settings that octant::models passes on: the linker's message says what to compile with."""
    unit = os.path.join(box, "other.cc")
    with open(unit, "w", encoding="utf-8") as file:
        file.write("#include <octant/models/physics/pose.h>\n"
                   "int main() { return octant::Pose::planar(1, 2, 3).translation_m.x() > 0 ? 0 : 1; }\n")
    eigen = run("pkg-config", "--cflags", "eigen3").stdout.split()
    libraries = [f"-L{library_dir()}", "-loctant_models"]
    wrong = run("c++", "-std=c++20", "-mavx", f"-I{prefix}/include", *eigen, unit, "-o", unit + ".out", *libraries, ok=False)
    assert wrong.returncode != 0, "it links with -mavx"
    assert "CompileWith_EIGEN_MAX_ALIGN_BYTES_16_and_EIGEN_MALLOC_ALREADY_ALIGNED_1" in wrong.stderr, wrong.stderr
    flags = run("pkg-config", "--cflags", "--libs", "octant-models",
                env=dict(os.environ, PKG_CONFIG_PATH=os.path.join(library_dir(), "pkgconfig"))).stdout.split()
    run("c++", "-std=c++20", "-mavx", *flags[:-1], unit, "-o", unit + ".out", *flags)
    run(unit + ".out")


def library_dir():
    for folder, _, files in os.walk(prefix):
        if "liboctant_models.a" in files:
            return folder
    raise RuntimeError("no liboctant_models.a is installed")


def every_installed_header_compiles():
    folder = os.path.join(prefix, "include")
    headers = []
    for where, _, files in os.walk(os.path.join(folder, "octant")):
        headers += [os.path.relpath(os.path.join(where, file), folder) for file in files]
    assert len(headers) > 100, headers
    unit = os.path.join(box, "headers.cc")
    with open(unit, "w", encoding="utf-8") as file:
        file.writelines(f"#include <{header}>\n" for header in sorted(headers))
    eigen = run("pkg-config", "--cflags", "eigen3").stdout.split()
    run("c++", "-std=c++20", "-fsyntax-only", "-DEIGEN_MAX_ALIGN_BYTES=16", "-DEIGEN_MALLOC_ALREADY_ALIGNED=1",
        f"-I{folder}", *eigen, unit)


def library_shows_its_own_symbols_only():
    names = run("nm", "-DC", "--defined-only", os.path.join(library_dir(), "liboctant.so")).stdout
    strange = [line for line in names.splitlines() if "octant::Positioner" not in line and " T octant_" not in line and " W " not in line and " V " not in line
               and " u " not in line]
    assert not strange, strange[:5]
    assert "Eigen" not in names, [line for line in names.splitlines() if "Eigen" in line][:3]


def library_needs_the_runtimes_of_c_and_cpp_alone():
    dynamic = run("readelf", "-d", os.path.join(library_dir(), "liboctant.so")).stdout
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic))
    assert "libc.so.6" in needed, dynamic
    more = {name for name in needed if not name.startswith(("libc.so", "libm.so", "libgcc_s.so", "libstdc++.so", "ld-linux"))}
    assert not more, more


def models_alone_within_another_project():
    """Asks for Eigen and tl::expected only; neither tests nor tools."""
    folder = os.path.join(box, "project")
    os.makedirs(folder)
    with open(os.path.join(folder, "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write("cmake_minimum_required(VERSION 3.22)\nproject(robot LANGUAGES CXX)\nset(OCTANT_COMPONENTS models)\n"
                   f"add_subdirectory({SOURCE} octant)\nadd_executable(robot robot.cc)\n"
                   "target_link_libraries(robot PRIVATE octant::models)\n")
    with open(os.path.join(folder, "robot.cc"), "w", encoding="utf-8") as file:
        file.write("#include <octant/models/deployment.h>\nint main() { return 0; }\n")
    without = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in
               ("Ceres", "NLopt", "OpenSSL", "PNG", "SQLite3", "fmt", "nlohmann_json", "hwy", "GTest", "PkgConfig")]
    build = os.path.join(folder, "build")
    run("cmake", "-S", folder, "-B", build, "-G", "Ninja", *without)
    targets = run("cmake", "--build", build, "--target", "help").stdout
    assert "octant_models" in targets and "_test" not in targets and "octant_io" not in targets, targets
    run("cmake", "--build", build, "--target", "robot.cc.o" if "robot.cc.o" in targets else "CMakeFiles/robot.dir/robot.cc.o")


def python_in_five_lines():
    package = os.path.join(prefix, "lib", "python3", "dist-packages")
    if not os.path.isdir(os.path.join(package, "octant")):
        print("skipped  the Python module was not built")
        return
    world = os.path.join(box, "world")
    os.makedirs(world)
    run(os.path.join(prefix, "bin", "octant"), "simulate", os.path.join(HALL, "scenario.yaml"), "-o", os.path.join(world, "hall"))
    out = run("/usr/bin/python3", "-c", readme("python"), cwd=world, env=dict(os.environ, PYTHONPATH=package)).stdout
    assert "False" in out and "4.5" in out, out


def debian_packages():
    """octant, liboctant and its version, liboctant-dev and python3-octant, unpacked as apt would."""
    if not shutil.which("cpack") or not shutil.which("dpkg-shlibdeps"):
        print("skipped  cpack or dpkg-dev is not here")
        return
    packages, root = os.path.join(box, "packages"), os.path.join(box, "root")
    run("cpack", "-G", "DEB", "-B", packages, "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip", cwd=BUILD)
    names = {name.split("_")[0]: os.path.join(packages, name) for name in os.listdir(packages) if name.endswith(".deb")}
    runtime = next(name for name in names if re.fullmatch(r"liboctant\d.*", name))
    wanted = {"octant", runtime, "liboctant-dev"} | ({"python3-octant"} if os.path.isdir(os.path.join(BUILD, "python", "octant")) else set())
    assert wanted <= set(names), names
    for path in names.values():
        run("dpkg", "-x", path, root)
    assert "libcholmod" in run("dpkg-deb", "-f", names["octant"], "Depends").stdout
    assert "libeigen3-dev" in run("dpkg-deb", "-f", names["liboctant-dev"], "Depends").stdout
    assert run(os.path.join(root, "usr", "bin", "octant"), "--version").stdout.startswith("octant ")
    share = os.path.join(root, "usr", "share")
    for shell, script in (("bash", "bash-completion/completions/octant"), ("zsh", "zsh/site-functions/_octant"), ("fish", "fish/vendor_completions.d/octant.fish")):
        with open(os.path.join(share, script), encoding="utf-8") as file:
            assert file.read() == run(os.path.join(root, "usr", "bin", "octant"), "completion", shell).stdout, script
    with open(os.path.join(share, "man", "man1", "octant.1"), encoding="utf-8") as file:
        assert file.readline().startswith(".TH OCTANT 1")
    assert {name for name in wanted if os.path.isfile(os.path.join(share, "doc", name, "copyright"))} == wanted
    if "python3-octant" in wanted:
        package = os.path.join(root, "usr", "lib", "python3", "dist-packages")
        run("/usr/bin/python3", "-c", "import octant; octant.simulate()", env=dict(os.environ, PYTHONPATH=package), cwd=box)


def pip_install():
    if not os.path.isdir(os.path.join(BUILD, "python", "octant")):
        print("skipped  the Python module was not built")
        return
    if run("/usr/bin/python3", "-m", "pip", "--version", ok=False).returncode != 0:
        print("skipped  pip (python3-pip) is not here")
        return
    target = os.path.join(box, "site")
    run("/usr/bin/python3", "-m", "pip", "install", "--no-deps", "--no-index", "--no-cache-dir", "--target", target, SOURCE,
        env=dict(os.environ, OCTANT_BUILD_DIR=BUILD))
    out = run("/usr/bin/python3", "-c", "import octant; print(octant.__version__, octant.simulate().site.beacons[0])", cwd=box,
              env=dict(os.environ, PYTHONPATH=target)).stdout
    assert "B0" in out, out


with tempfile.TemporaryDirectory(prefix="octant-consumer-") as box:
    prefix = os.path.join(box, "usr")
    run("cmake", "--install", BUILD, "--prefix", prefix)
    cpp = os.path.join(box, "readme.cc")
    with open(cpp, "w", encoding="utf-8") as program:
        program.write(readme("cpp"))
    for each in (with_gcc, with_clang, other_eigen_settings_do_not_link, every_installed_header_compiles,
                 library_shows_its_own_symbols_only, library_needs_the_runtimes_of_c_and_cpp_alone,
                 models_alone_within_another_project, python_in_five_lines,
                 pip_install, debian_packages):
        test(each)
sys.exit(1 if failures else 0)
