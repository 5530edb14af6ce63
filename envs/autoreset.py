"""When the batched environment starts an ended episode anew, in Gymnasium's words."""

from typing import Final

import gymnasium

try:
    from gymnasium.vector import AutoresetMode
except ImportError as error:
    raise ImportError(
        "the batched environment needs Gymnasium 1.1 or later, which has a word for when episodes "
        f"start anew; found {gymnasium.__version__}, with which single environments work"
    ) from error

SAME_STEP: Final = AutoresetMode.SAME_STEP
"""Within the step in which it ended."""
