"""The class in C++ steps as Python does, and refuses what it cannot run."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _inputs.exported_files import REFUSED, write_wrong_file

from aicon_torch import Foresight, load_exported, make_policy
from aicon_torch.export.codegen import compile_library
from aicon_torch.export.codegen.compiler import FLAGS, compiler_command
from aicon_torch.models.nav2d import Options

pytestmark = pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler (apt install g++)")

HEADERS = Path(__file__).parents[2] / "examples/cpp"

PROGRAM = """
#include <cmath>
#include <cstdio>
#include "aicon_policy.hpp"

template <typename Real>
static void take_a_step(const char *file, const std::vector<double> &readings) {
  aicon::Policy<Real> policy(file);
  const Real *command = policy.step(std::vector<Real>(readings.begin(), readings.end()));
  for (int i = 0; i < policy.commands(); ++i) std::printf("%.17g ", double(command[i]));
}

// Before a step, without readings, with them, and when an episode is to begin.
static void tell_where_it_begins(const char *file, const std::vector<double> &readings) {
  aicon::Policy<double> policy(file);
  std::printf("%d", policy.begins());
  policy.step(std::vector<double>(readings.size(), std::nan("")));
  std::printf("%d", policy.begins());
  policy.step(readings);
  std::printf("%d", policy.begins());
  policy.reset();
  std::printf("%d", policy.begins());
}

// A step, another one, and the moment between them once more.
static void go_back(const char *file, const std::vector<double> &readings) {
  aicon::Policy<double> policy(file);
  policy.step(readings);
  const std::vector<double> moment = policy.memory();
  for (int time = 0; time < 2; ++time) {
    const double *command = policy.step(readings);
    for (int i = 0; i < policy.commands(); ++i) std::printf("%.17g ", command[i]);
    policy.memory() = moment;
  }
}

// Two files are copied to one place, one after the other, and loaded from there.
static void load_from_one_place(char **files, const std::vector<double> &readings) {
  std::vector<aicon::Policy<double>> policies;
  for (int i = 1; i < 3; ++i) {
    std::ofstream(files[0], std::ios::binary) << std::ifstream(files[i], std::ios::binary).rdbuf();
    policies.emplace_back(files[0]);
  }
  for (auto &policy : policies) {
    const double *command = policy.step(readings);
    std::printf("%.17g ", std::hypot(command[0], command[1]));
  }
}

int main(int count, char **words) {
  const bool in_one_place = words[1][0] == 'c';
  std::vector<double> readings;
  for (int i = in_one_place ? 5 : 3; i < count; ++i) readings.push_back(std::stod(words[i]));
  try {
    if (in_one_place) load_from_one_place(words + 2, readings);
    else if (words[1][0] == 'b') tell_where_it_begins(words[2], readings);
    else if (words[1][0] == 'm') go_back(words[2], readings);
    else if (words[1][0] == 'f') take_a_step<float>(words[2], readings);
    else take_a_step<double>(words[2], readings);
  } catch (const std::exception &error) {
    std::printf("refused: %s", error.what());
  }
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program, and an exported policy with its source."""
    folder = tmp_path_factory.mktemp("cpp")
    (folder / "program.cpp").write_text(PROGRAM)
    build = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{HEADERS}", "program.cpp"]
    subprocess.run([*build, "-o", "program", "-ldl"], cwd=folder, check=True, timeout=300)

    policy = make_policy("nav2d", law=Foresight(iterations=1))
    policy.export(folder / "good.c")
    compile_library((folder / "good.c").read_text(), folder / "good.so")
    slower = make_policy("nav2d", law=Foresight(iterations=1), max_speed=0.1)
    slower.export(folder / "slow.so")
    return folder


def said(folder: Path, file: Path, readings: Any = (), does: str = "double") -> str:
    """What the program prints: one step in a precision, or what else it does."""
    numbers = [str(float(reading)) for reading in readings]
    command = [str(folder / "program"), does, str(file), *numbers]
    text: str = subprocess.run(
        command, capture_output=True, check=True, text=True, timeout=300
    ).stdout
    return text


def test_the_source_compiles_without_a_warning(folder: Path, tmp_path: Path) -> None:
    command = [*compiler_command(), *FLAGS, "-Wall", "-Werror", "-shared"]
    words = ["-o", str(tmp_path / "quiet.so"), str(folder / "good.c"), "-lm"]
    built = subprocess.run([*command, *words], capture_output=True, text=True)
    assert built.returncode == 0, built.stderr


def test_a_step_is_that_of_python(folder: Path) -> None:
    policy = load_exported(folder / "good.so")
    observation = {"bearing": np.full(1, 0.5), "range": np.full(1, 0.5)}
    action, _ = policy.predict(observation)

    text = said(folder, folder / "good.so", policy.flat_readings(observation))
    command = np.array(text.split(), dtype=np.float64)
    np.testing.assert_array_equal(command.astype(np.float32), action)


def test_it_says_that_its_commands_are_not_to_be_sent(folder: Path) -> None:
    observation = {"bearing": np.full(1, 0.5), "range": np.full(1, 0.5)}
    readings = load_exported(folder / "good.so").flat_readings(observation)
    assert said(folder, folder / "good.so", readings, does="begins") == "1101"


def test_a_moment_is_kept_and_brought_back(folder: Path) -> None:
    observation = {"bearing": np.full(1, 0.5), "range": np.full(1, 0.5)}
    readings = load_exported(folder / "good.so").flat_readings(observation)
    commands = said(folder, folder / "good.so", readings, does="moment").split()
    assert commands[:2] == commands[2:]


def test_a_policy_that_replaces_another_one_is_the_one_that_runs(
    folder: Path, tmp_path: Path
) -> None:
    """Both are loaded from one place, the second one while the first is."""
    observation = {"bearing": np.full(1, 0.5), "range": np.full(1, 0.5)}
    readings = load_exported(folder / "good.so").flat_readings(observation)
    files = [str(tmp_path / "policy.so"), "good.so", "slow.so"]
    command = ["./program", "copies", *files, *map(str, readings)]
    text = subprocess.run(command, cwd=folder, capture_output=True, check=True, text=True).stdout

    usual, slow = (float(word) for word in text.split())
    np.testing.assert_allclose(slow / usual, 0.1 / Options().max_speed, rtol=1e-6)


@pytest.mark.parametrize(("name", "words"), REFUSED.items())
def test_wrong_files_are_refused(name: str, words: str, folder: Path, tmp_path: Path) -> None:
    text = said(folder, write_wrong_file(name, folder / "good.so", tmp_path))
    assert text.startswith("refused")
    assert re.search(words, text), text


def test_another_precision_is_refused(folder: Path) -> None:
    text = said(folder, folder / "good.so", does="float")
    assert "numbers of 8 bytes, and this class in 4" in text


def test_another_number_of_readings_is_refused(folder: Path) -> None:
    text = said(folder, folder / "good.so", readings=(0.5, 0.5, 0.0))
    assert "step: 3 readings, expected 7" in text
