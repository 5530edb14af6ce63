"""Networks for pictures from the `transformers` package that can encode the map; free of torch."""

from dataclasses import dataclass, fields
from typing import Any, Final, Literal, Self

Kind = Literal["resnet", "vit"]

SIZES: Final[dict[Kind, tuple[str, ...]]] = {
    "resnet": (
        "embedding_size",
        "hidden_sizes",
        "depths",
        "layer_type",
        "hidden_act",
        "downsample_in_first_stage",
        "downsample_in_bottleneck",
    ),
    "vit": (
        "hidden_size",
        "num_hidden_layers",
        "num_attention_heads",
        "intermediate_size",
        "hidden_act",
        "layer_norm_eps",
        "qkv_bias",
        "image_size",
        "patch_size",
    ),
}
"""What `ResNetConfig` and `ViTConfig` of the package call what a network of that kind is."""


@dataclass(frozen=True, kw_only=True)
class BackboneConfig:
    """A network for pictures that encodes the map.

    Attributes:
        kind: Its architecture, as `model_type` of the package.
        sizes: What it is, by the names of `SIZES`.
        source: Name on the Hugging Face hub, or folder, of the weights that a training begins
            with; None begins with random ones.
        mean: What is taken from each channel of RGB in [0, 1], ...
        deviation: ... and what the rest is divided by.
        trained: Whether training changes its weights.

    Raises:
        ValueError: The kind is unknown, or a size is missing or unknown.
    """

    kind: Kind
    sizes: dict[str, Any]
    source: str | None
    mean: tuple[float, float, float]
    deviation: tuple[float, float, float]
    trained: bool = False

    def __post_init__(self) -> None:
        if self.kind not in SIZES:
            raise ValueError(f"kind must be one of {', '.join(SIZES)}, got {self.kind!r}")
        odd = sorted(self.sizes.keys() ^ set(SIZES[self.kind]))
        if odd:
            raise ValueError(f"sizes must be {', '.join(SIZES[self.kind])}; they differ in {odd}")

    @property
    def width(self) -> int:
        """Size of its tokens."""
        return int(
            self.sizes["hidden_sizes"][-1] if self.kind == "resnet" else self.sizes["hidden_size"]
        )

    @property
    def cell_px(self) -> int:
        """Side of the square of the picture that a token stands for [pixels]."""
        if self.kind == "vit":
            return int(self.sizes["patch_size"])
        # two halvings before the first stage, one before each later one
        first = 3 if self.sizes["downsample_in_first_stage"] else 2
        return int(2 ** (first + len(self.sizes["hidden_sizes"]) - 1))

    def require_crop(self, crop_px: int) -> None:
        """Raise ValueError where it takes no pictures of this side [pixels]."""
        if self.kind == "vit" and crop_px != self.sizes["image_size"]:
            raise ValueError(
                f"crop_px must be {self.sizes['image_size']}, as its position codes are for that, "
                f"got {crop_px}"
            )
        if crop_px % self.cell_px != 0 or crop_px < 2 * self.cell_px:
            raise ValueError(
                f"crop_px must be a multiple of {self.cell_px} and at least {2 * self.cell_px}, "
                f"got {crop_px}"
            )

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Build from a plain dict, such as that of the JSON of a checkpoint.

        Raises:
            ValueError: A key is unknown or missing, or a value is out of range.
        """
        odd = sorted(values.keys() ^ {field.name for field in fields(cls)})
        if odd:
            raise ValueError(f"keys of a backbone differ in {odd}")
        channels = {name: tuple(values[name]) for name in ("mean", "deviation")}
        return cls(**{**values, **channels})


BACKBONES: Final = {
    "resnet18": BackboneConfig(
        kind="resnet",
        sizes={
            "embedding_size": 64,
            "hidden_sizes": [64, 128, 256, 512],
            "depths": [2, 2, 2, 2],
            "layer_type": "basic",
            "hidden_act": "relu",
            "downsample_in_first_stage": False,
            "downsample_in_bottleneck": False,
        },
        source="microsoft/resnet-18",
        mean=(0.485, 0.456, 0.406),
        deviation=(0.229, 0.224, 0.225),
    ),
    "vit_b16": BackboneConfig(
        kind="vit",
        sizes={
            "hidden_size": 768,
            "num_hidden_layers": 12,
            "num_attention_heads": 12,
            "intermediate_size": 3072,
            "hidden_act": "gelu",
            "layer_norm_eps": 1e-12,
            "qkv_bias": True,
            "image_size": 224,
            "patch_size": 16,
        },
        source="google/vit-base-patch16-224",
        mean=(0.5, 0.5, 0.5),
        deviation=(0.5, 0.5, 0.5),
    ),
}
"""The backbone of each variant that has one, as it is published."""

PICTURE_PX: Final = 224
"""Side of the pictures that they were trained on."""
