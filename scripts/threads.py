"""How many threads the numerical libraries of this process may use."""

import os

VARIABLES = (
    "OMP_NUM_THREADS",  # torch, scikit-image and whatever else is built on OpenMP
    "MKL_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)


def bound_threads(count: int, *, override: bool = False) -> None:
    """Bound the threads of torch, BLAS and OpenCV; call it before any of them is imported.

    One thread is the default of the program: batches here are small, worker processes come on top,
    and two contended torch threads were measured to make a forward pass 100 times slower.

    Args:
        count: Threads per library. Worker processes inherit the bound.
        override: Also where the user's environment says otherwise.
    """
    for variable in VARIABLES:
        if override:
            os.environ[variable] = str(count)
        else:
            os.environ.setdefault(variable, str(count))
