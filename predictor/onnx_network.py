"""An exported network run by ONNX Runtime."""

import json
from pathlib import Path
from typing import Any, Self

import torch
from torch import Tensor

from predictor.config import NetworkConfig
from predictor.export import DESCRIPTION, OUTPUTS
from predictor.modes import Modes
from predictor.networks import config_from_dict


class OnnxNetwork:
    """Takes the place of the network that it was made of, in use but not in training.

    Args:
        session: `onnxruntime.InferenceSession` of what `predictor.export` wrote.
        config: What the network is.

    Attributes:
        config: What the network is.
    """

    def __init__(self, session: Any, config: NetworkConfig) -> None:
        self.config = config
        self._session = session
        self._inputs = {node.name for node in session.get_inputs()}

    def eval(self) -> Self:
        """Nothing: it is never trained."""
        return self

    def __call__(self, **inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Goal (B, 2) and path (B, F, 2) in the agent frame [m]; `inputs` as of the network."""
        goal, path = self._run(OUTPUTS[:2], inputs)
        return goal, path

    def forward_modes(self, **inputs: Tensor) -> tuple[Tensor, Tensor, Modes]:
        """Goal, path and modes; `inputs` as of the network."""
        goal, path, mode_path, logits, factor = self._run(OUTPUTS, inputs)
        return goal, path, Modes(path=mode_path, logits=logits, factor=factor)

    def _run(self, outputs: tuple[str, ...], inputs: dict[str, Tensor]) -> list[Tensor]:
        # an input that reaches no output is not in the file
        given = {name: inputs[name].numpy() for name in self._inputs}
        return [torch.from_numpy(array) for array in self._session.run(outputs, given)]


def load_onnx(path: Path) -> tuple[OnnxNetwork, dict[str, Any]]:
    """Read what `predictor.export.export_network` wrote; it runs on as many threads as torch.

    Returns:
        The network, and what the JSON of its checkpoint said.

    Raises:
        FileNotFoundError: The file is not there.
        ValueError: ONNX Runtime is not installed, or the file is not such a network.
    """
    content = path.read_bytes()
    try:
        import onnxruntime
    except ImportError as error:
        raise ValueError(
            f"expected the package onnxruntime to run {path}, found none; "
            "pip install 'crowdnav-testbed[onnx]'"
        ) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = torch.get_num_threads(), 1
    try:
        session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its exceptions have no class of their own in common
        raise ValueError(f"{path}: expected ONNX, found {error}") from error
    description = session.get_modelmeta().custom_metadata_map.get(DESCRIPTION)
    if description is None:
        raise ValueError(f"{path}: expected {DESCRIPTION} in its metadata, found none")
    about: dict[str, Any] = json.loads(description)
    return OnnxNetwork(session, config_from_dict(about["model"], about["config"])), about
