"""A policy in WebAssembly takes the readable step, and the class that loads it checks it."""

import json
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import record_replay
from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.bench import record_episodes
from aicon_baselines.cli.command_line import run_command
from aicon_torch import Foresight, OptionError, load_exported, make_policy
from aicon_torch.export.codegen import compile_library, has_compiler
from aicon_torch.export.codegen.targets import WEB
from aicon_torch.export.exported_memory import ExportedMemory
from aicon_torch.export.layout import Layout

pytestmark = [
    pytest.mark.skipif(not shutil.which("node"), reason="no Node.js"),
    pytest.mark.skipif(not find_spec("ziglang"), reason="no ziglang (pip install ziglang)"),
]

MODULE = Path(__file__).parents[2] / "examples" / "web" / "aicon_policy.mjs"
CONDITIONS = {
    "nav2d": "range",
    "pusht": "deterministic",
    "arm_push": "true_pose",
    "reach": "ur5_pose_home",
}
STEPS = 1000
"""How many are replayed."""

READABLE = 100
"""The readable step, which is slow, is taken at every so many of them."""


def in_node(program: str, *words: str) -> Any:
    """What a program prints, in JSON; it has the class."""
    whole = f"import {{ Policy }} from {json.dumps(MODULE.as_uri())};\n{program}"
    command = ["node", "--input-type=module", "-", *words]
    done = subprocess.run(command, input=whole, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


REPLAY = """
    import { readFileSync, writeFileSync } from "node:fs";
    const folder = process.argv[2];
    // Node.js puts small files side by side in one buffer.
    const whole = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
    const numbers = (name) => new Float64Array(whole(name).buffer);
    const policy = await Policy.load(`${folder}/policy.wasm`);
    const readings = numbers("readings.bin"), starts = numbers("starts.bin");
    const found = new Float64Array(starts.length * policy.memory.length);
    for (const [row, starting] of starts.entries()) {
        if (starting) policy.reset();
        const from = row * policy.readings;
        policy.step(readings.subarray(from, from + policy.readings));
        found.set(policy.memory, row * policy.memory.length);
    }
    writeFileSync(`${folder}/memories.bin`, found);
    console.log(starts.length);
"""


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
@pytest.mark.slow
@pytest.mark.parametrize("task", CONDITIONS)
def test_every_step_is_the_readable_one(task: str, tmp_path: Path) -> None:
    """And the very same as that of the library of this machine, to the last bit."""
    pytest.importorskip("mujoco", reason="no MuJoCo (pip install mujoco)")
    policy: Any = factory(task, "aicon")(CONDITIONS[task])
    policy.export(tmp_path / "policy.c")
    source = (tmp_path / "policy.c").read_text()
    compile_library(source, tmp_path / "policy.wasm", WEB)
    compile_library(source, tmp_path / "policy.so")
    library = load_exported(tmp_path / "policy.so", perception=policy.perception)
    layout = Layout.from_json(library.metadata["memory"])

    # What was read, and what the library remembers of it; the readable step from the same memory.
    state: Any = None
    rows: dict[str, list[Any]] = {"readings": [], "starts": [], "native": []}
    readable: dict[int, Any] = {}
    episodes = record_episodes(task, CONDITIONS[task], STEPS, library)
    for step, (observation, begins) in enumerate(episodes):
        before = None if begins else state
        _, state = library.predict(observation, before)
        rows["readings"].append(library.flat_readings(observation).reshape(-1))
        rows["starts"].append(float(begins))
        rows["native"].append(state.flat.reshape(-1))
        if step % READABLE == 0:
            _, memory = policy.predict(observation, None if before is None else dict(before))
            flat = ExportedMemory.of(memory, layout, np.float64).flat
            readable[step] = flat.reshape(-1)
    for name in ("readings", "starts"):
        np.array(rows[name], dtype=np.float64).tofile(tmp_path / f"{name}.bin")

    assert in_node(REPLAY, str(tmp_path)) == STEPS
    found = np.fromfile(tmp_path / "memories.bin").reshape(STEPS, -1)
    np.testing.assert_array_equal(found, rows["native"])
    for step, expected in readable.items():
        np.testing.assert_allclose(found[step], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
@pytest.mark.slow
@pytest.mark.usefixtures("optimized_elsewhere")
def test_what_was_recorded_is_replayed_and_timed(tmp_path: Path) -> None:
    folder = str(tmp_path)
    run_command(record_replay.COMMAND, ["nav2d", folder, "--target", "wasm32-web"])

    # Each command is the one of the library, or the program fails.
    replay = ["node", str(MODULE.with_name("replay.mjs")), folder, "1000"]
    printed = subprocess.run(replay, check=True, capture_output=True, text=True).stdout
    assert "1000 steps, every command as recorded" in printed and "one step: median" in printed

    # Another command than recorded is an error.
    commands = np.fromfile(tmp_path / "commands.bin")
    commands[7] += 1e-15
    commands.tofile(tmp_path / "commands.bin")
    failed = subprocess.run(replay, capture_output=True, text=True)
    assert failed.returncode == 1 and "step 3: another command" in failed.stderr


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy, exported."""
    path = tmp_path_factory.mktemp("web") / "policy.wasm"
    make_policy("nav2d", law=Foresight(iterations=1)).export(path, task="nav2d")
    return path


def test_it_tells_what_it_holds_and_what_it_decided(small: Path) -> None:
    told = in_node(
        """
        const policy = await Policy.load(process.argv[2]);
        const blank = policy.memory.slice(), moments = [];
        for (let step = 0; step < 2; ++step) {
            policy.memory.set(blank);
            policy.reset();
            for (const x of [0, 0.01, 0.02]) {  // a new bearing and a new range in each step
                policy.step([0.5 + x, 1.0 + x, NaN, 0, 0, NaN, NaN]);
            }
            moments.push(Array.from(policy.memory, String));
        }
        console.log(JSON.stringify({
            sizes: [policy.readings, policy.commands], task: policy.metadata.description.task,
            meetings: policy.meetings, decided: policy.decided("x_rob"),
            same: String(moments[0]) === String(moments[1]), goals: policy.metadata.goals }));
        """,
        str(small),
    )

    # It names its parts, and begins an episode as before.
    assert told["sizes"] == [7, 2] and told["task"] == "nav2d" and told["same"]
    assert told["goals"] == ["reach", "avoid"] and told["meetings"] == ["x_rob"]

    # Three gradients met, one of which is zero and was not used.
    assert np.shape(told["decided"]["gradients"]) == (3, 2)
    assert sorted(told["decided"]["ranks"]) == [-1, 0, 1]
    assert -1 <= told["decided"]["cosine"] <= 1


def test_it_begins_with_the_first_readings_that_come(small: Path) -> None:
    """Until then its commands are not to be sent."""
    told = in_node(
        """
        const policy = await Policy.load(process.argv[2]);
        const take = (bearing, range) =>
            [Array.from(policy.step([bearing, range, NaN, 0, 0, NaN, NaN])), policy.begins];
        const before = policy.begins, lacking = take(NaN, NaN), first = take(0.5, 1.0);
        policy.reset();
        const reset = policy.begins, again = take(0.5, 1.0);
        console.log(JSON.stringify({ before, lacking, first, reset, again }));
        """,
        str(small),
    )

    assert told["before"] and told["lacking"][1] and told["reset"]
    commands, begins = told["first"]
    assert not begins and np.linalg.norm(commands) > 0.0
    assert told["again"] == told["first"]


@pytest.mark.parametrize("place", ["anywhere", "end"])
def test_a_damaged_file_is_refused(place: str, small: Path, tmp_path: Path) -> None:
    spoilt = bytearray(small.read_bytes())
    if place == "end":  # another digit of the checksum
        spoilt[-3:-2] = b"1" if spoilt[-3:-2] == b"0" else b"0"
    else:
        spoilt[len(spoilt) // 2] ^= 1

    (tmp_path / "spoilt.wasm").write_bytes(bytes(spoilt))
    said = in_node(
        "console.log(JSON.stringify(await Policy.load(process.argv[2]).catch(String)));",
        str(tmp_path / "spoilt.wasm"),
    )
    assert "is damaged" in said


def test_readings_of_another_number_are_refused(small: Path) -> None:
    said = in_node(
        """
        const policy = await Policy.load(process.argv[2]);
        let said = "nothing";
        try { policy.step([1, 2]); } catch (error) { said = String(error); }
        console.log(JSON.stringify(said));
        """,
        str(small),
    )
    assert "2 readings, expected 7" in said


def test_in_python_it_is_for_another_machine(small: Path) -> None:
    with pytest.raises(OptionError, match="is a library for wasm32-web, and this machine"):
        load_exported(small)
