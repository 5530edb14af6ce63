"""What each package may load: checked in a fresh interpreter, for every module of the package."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LEARNING = {"torch", "gymnasium", "stable_baselines3"}
HEAVY = LEARNING | {"numba", "pymunk", "cv2", "numpy", "pyarrow", "shapely", "matplotlib", "rich"}
OF_EXTRAS = {"transformers", "onnx", "onnxruntime", "onnxscript", "tensorboard"}
MUST_STAY_OUT = {
    "crowdsim": LEARNING | {"predictor", "envs", "scripts"},
    "predictor": {"pymunk", "gymnasium", "stable_baselines3", "envs", "scripts"} | OF_EXTRAS,
}
IMPORT_EVERYTHING = """
import importlib, json, pkgutil, sys
package = importlib.import_module(sys.argv[1])
for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    importlib.import_module(module.name)
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""


def loaded_by(code: str, *arguments: str) -> set[str]:
    process = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    return set(json.loads(process.stdout))


@pytest.mark.parametrize("package", MUST_STAY_OUT)
def test_no_module_of_a_package_loads_what_belongs_elsewhere(package: str) -> None:
    loaded = loaded_by(IMPORT_EVERYTHING, package)
    assert package in loaded
    assert not loaded & MUST_STAY_OUT[package]


def test_envs_register_themselves_without_simulator_network_or_training_library() -> None:
    code = """
import json, sys
import envs, gymnasium
assert "crowdnav/CrowdNav-v0" in gymnasium.registry
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""
    assert not loaded_by(code) & {"pymunk", "torch", "stable_baselines3", "scripts"}


def test_program_starts_without_anything_heavy() -> None:
    code = """
import json, sys
import scripts.__main__
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""
    assert not loaded_by(code) & (HEAVY | {"crowdsim", "envs"})


def test_predictor_reaches_no_part_of_the_simulator_but_recordings() -> None:
    code = IMPORT_EVERYTHING.replace('name.partition(".")[0]', "name")
    of_crowdsim = {name for name in loaded_by(code, "predictor") if name.startswith("crowdsim")}
    assert {name for name in of_crowdsim if not name.startswith("crowdsim.recordings")} == {
        "crowdsim"
    }
