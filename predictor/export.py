"""A trained network as a file for other programs: by `torch.export`, or as ONNX.

The number of agents and that of neighbors stay open, both at least 1; all else is fixed. Inputs
have the names, types and shapes of `predictor.inputs.AgentInputs`; outputs are those of `OUTPUTS`.
What the JSON of the checkpoint says goes into the file.
"""

import io
import json
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import torch
from torch import Tensor, nn
from torch.export import Dim

from crowdsim.recordings.store import write_atomic
from predictor.config import NetworkConfig
from predictor.model import IterativeAttention
from predictor.networks import Network, has_modes

OUTPUTS: Final = ("goal", "path", "mode_path", "mode_logits", "mode_factor")
"""Goal (B, 2) and path (B, F, 2) in the agent frame [m]; of a network with modes also the fields of
`predictor.modes.Modes`."""
DESCRIPTION: Final = "crowdnav.json"
"""Name of what the checkpoint's JSON says, in the metadata of ONNX and in the archive of `.pt2`."""
SUFFIXES: Final = (".onnx", ".pt2")


class _WithModes(nn.Module):
    """A network with modes whose outputs are plain tensors."""

    def __init__(self, network: IterativeAttention) -> None:
        super().__init__()
        self.network = network

    def forward(
        self,
        history: Tensor,
        history_valid: Tensor,
        neighbors: Tensor,
        neighbors_valid: Tensor,
        last_step: Tensor,
        crop: Tensor | None = None,
        crop_valid: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        """The tensors of `OUTPUTS`; arguments as of the network."""
        seen = {
            "history": history,
            "history_valid": history_valid,
            "neighbors": neighbors,
            "neighbors_valid": neighbors_valid,
        }
        if crop is not None and crop_valid is not None:
            seen |= {"crop": crop, "crop_valid": crop_valid}
        goal, path, modes = self.network.forward_modes(last_step, **seen)
        return goal, path, modes.path, modes.logits, modes.factor


def export_network(network: Network, about: dict[str, Any], out: Path) -> None:
    """Write a network whole or not at all.

    Args:
        network: What to write, in `eval` mode.
        about: What the JSON of its checkpoint says; `predictor.onnx_network` needs its `model` and
            `config`.
        out: File to write; `.onnx` for ONNX, `.pt2` for `torch.export.load`.

    Raises:
        ValueError: The suffix is another one, or a package for ONNX is not installed.
    """
    writers = {".onnx": _onnx, ".pt2": _program}
    if out.suffix not in writers:
        raise ValueError(f"expected a file named {' or '.join(SUFFIXES)}, found {out.name!r}")
    module = _WithModes(network).eval() if has_modes(network) else network
    with _quiet(), torch.inference_mode():
        content = writers[out.suffix](module, network.config, json.dumps(about))
    out.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(out, content)


def _onnx(module: nn.Module, config: NetworkConfig, description: str) -> bytes:
    missing = [name for name in ("onnx", "onnxscript") if find_spec(name) is None]
    if missing:
        raise ValueError(
            f"expected the package {missing[0]} to write ONNX, found none; "
            "pip install 'crowdnav-testbed[onnx]'"
        )
    example = _example(config)
    program = torch.onnx.export(
        module,
        kwargs=example,
        dynamic_shapes=_open_shapes(example),
        output_names=list(OUTPUTS if isinstance(module, _WithModes) else OUTPUTS[:2]),
        dynamo=True,
        verbose=False,
    )
    assert program is not None  # with dynamo there always is one
    program.model.metadata_props[DESCRIPTION] = description
    content: bytes = program.model_proto.SerializeToString()
    return content


def _program(module: nn.Module, config: NetworkConfig, description: str) -> bytes:
    example = _example(config)
    program = torch.export.export(
        module, (), example, dynamic_shapes=_open_shapes(example), strict=False
    )
    content = io.BytesIO()
    torch.export.save(program, content, extra_files={DESCRIPTION: description})
    return content.getvalue()


def _example(config: NetworkConfig) -> dict[str, Tensor]:
    """Inputs to trace a network with: more than one of everything, as 1 would be kept fixed."""
    agents, neighbors, steps = 3, 2, config.history_steps
    example = {
        "history": torch.zeros(agents, steps, 2),
        "history_valid": torch.ones(agents, steps, dtype=torch.bool),
        "neighbors": torch.zeros(agents, neighbors, steps, 2),
        "neighbors_valid": torch.ones(agents, neighbors, steps, dtype=torch.bool),
        "last_step": torch.zeros(agents, 2),
    }
    if config.variant != "none":
        crop = torch.zeros(agents, config.crop_px, config.crop_px, 3, dtype=torch.uint8)
        example |= {"crop": crop, "crop_valid": torch.ones(agents, dtype=torch.bool)}
    return example


def _open_shapes(example: dict[str, Tensor]) -> dict[str, dict[int, Dim]]:
    agents, neighbors = Dim("agents", min=1), Dim("neighbors", min=1)
    by_neighbor = {"neighbors": {1: neighbors}, "neighbors_valid": {1: neighbors}}
    return {name: {0: agents, **by_neighbor.get(name, {})} for name in example}


@contextmanager
def _quiet() -> Iterator[None]:
    """Without what torch tells its own developers while it traces."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)
