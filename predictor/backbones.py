"""Map encoders whose features come from a network for pictures of the `transformers` package."""

from dataclasses import replace
from typing import Any, Self, TypeVar

import torch
from torch import Tensor, nn

from predictor.backbone_config import BACKBONES, SIZES, BackboneConfig
from predictor.config import ModelConfig, NetworkConfig
from predictor.position_codes import grid_code

NetworkT = TypeVar("NetworkT", bound=nn.Module)


class BackboneEncoder(nn.Module):
    """Tokens of the map crop, one for each place in it, with a two-dimensional position code.

    Batch normalization and the like stay as they were learned, whether the rest is trained or not:
    statistics of a batch would make its forecasts depend on each other.

    Args:
        config: What the network is.
        backbone: What encodes its map; the weights are random.

    Raises:
        ValueError: The package is not installed.
    """

    mean: Tensor
    deviation: Tensor
    position_code: Tensor

    def __init__(self, config: ModelConfig, backbone: BackboneConfig) -> None:
        super().__init__()
        self.config = backbone
        self.backbone = _architecture(backbone).requires_grad_(backbone.trained)
        self.linear = nn.Linear(backbone.width, config.width)
        code = grid_code(config.crop_px // backbone.cell_px, config.width)
        self.register_buffer("position_code", code, persistent=False)
        for name in ("mean", "deviation"):
            channels = torch.tensor(getattr(backbone, name))[:, None, None]
            self.register_buffer(name, channels, persistent=False)

    def train(self, mode: bool = True) -> Self:
        """Leave the backbone as in use."""
        super().train(mode)
        self.backbone.eval()
        return self

    def forward(self, crop: Tensor) -> Tensor:
        """Encode (B, S, S, 3) uint8 pictures as tokens (B, P, C)."""
        scaled = crop.permute(0, 3, 1, 2) / 255.0  # (B, 3, S, S)
        features = self.backbone((scaled - self.mean) / self.deviation).last_hidden_state
        if self.config.kind == "vit":
            places = features[:, 1:]  # (B, P, E), without the token of the class
        else:
            places = features.flatten(2).transpose(1, 2)  # (B, P, E)
        tokens: Tensor = self.linear(places) + self.position_code
        return tokens


def with_backbone(config: NetworkConfig, source: str | None, *, trained: bool) -> ModelConfig:
    """Another backbone in the place of the one of the variant, its size of crop with it.

    Args:
        config: What the network is; its variant must have a backbone.
        source: Name on the hub or folder of the backbone; None keeps the published one.
        trained: Whether training changes its weights.

    Raises:
        ValueError: The variant has no backbone, the package is not installed, or the source cannot
            be had or is of another kind.
    """
    if not isinstance(config, ModelConfig) or config.backbone is None:
        raise ValueError(
            f"a backbone needs one of the variants {', '.join(BACKBONES)}, got {config.variant!r}"
        )
    found = config.backbone if source is None else _described(source, config.backbone)
    crop_px = found.sizes.get("image_size", config.crop_px)
    return replace(config, backbone=replace(found, trained=trained), crop_px=crop_px)


def with_pretrained(network: NetworkT) -> NetworkT:
    """Give the backbone of a network, if it has one with a source, the weights from there.

    Raises:
        ValueError: They cannot be had.
    """
    encoder = getattr(network, "map_encoder", None)
    if isinstance(encoder, BackboneEncoder) and encoder.config.source is not None:
        pretrained = _from_source(encoder.config.source, encoder.config)
        encoder.backbone.load_state_dict(pretrained.state_dict())
    return network


def _architecture(backbone: BackboneConfig) -> nn.Module:
    package = _transformers()
    if backbone.kind == "resnet":
        built: nn.Module = package.ResNetModel(package.ResNetConfig(**backbone.sizes))
    else:
        config = package.ViTConfig(**backbone.sizes)
        built = package.ViTModel(config, add_pooling_layer=False)
    return built.eval()


def _from_source(source: str, backbone: BackboneConfig) -> nn.Module:
    package = _transformers()
    level = package.logging.get_verbosity()
    package.logging.set_verbosity_error()  # no report on the layers that are not wanted
    try:
        if backbone.kind == "resnet":
            found: nn.Module = package.ResNetModel.from_pretrained(source, use_safetensors=True)
        else:
            found = package.ViTModel.from_pretrained(
                source, add_pooling_layer=False, use_safetensors=True
            )
    except OSError as error:
        raise _cannot_be_had(source, "weights", error) from error
    finally:
        package.logging.set_verbosity(level)
    return found


def _described(source: str, expected: BackboneConfig) -> BackboneConfig:
    """What the backbone of a source is, and how it wants its pictures."""
    package = _transformers()
    try:
        found: dict[str, Any] = package.AutoConfig.from_pretrained(source).to_dict()
        picture, _ = package.ImageProcessingMixin.get_image_processor_dict(source)
    except (OSError, ValueError) as error:
        raise _cannot_be_had(source, "description", error) from error
    if found["model_type"] != expected.kind:
        raise ValueError(
            f"{source}: expected a backbone of the kind {expected.kind}, "
            f"found {found['model_type']}"
        )
    return BackboneConfig(
        kind=expected.kind,
        sizes={name: found[name] for name in SIZES[expected.kind]},
        source=source,
        mean=tuple(picture.get("image_mean", expected.mean)),
        deviation=tuple(picture.get("image_std", expected.deviation)),
    )


def _cannot_be_had(source: str, what: str, error: Exception) -> ValueError:
    reason = str(error).partition("\n")[0]
    return ValueError(
        f"expected the {what} of {source} in a folder of that name or on the Hugging Face hub, "
        f"found neither: {reason}"
    )


def _transformers() -> Any:
    try:
        import transformers
    except ImportError as error:
        raise ValueError(
            f"expected the package transformers for the variants {', '.join(BACKBONES)}, found "
            "none; pip install 'crowdnav-testbed[backbones]'"
        ) from error
    return transformers
