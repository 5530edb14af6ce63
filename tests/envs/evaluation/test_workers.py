"""What becomes of worker processes when something ends them early."""

import multiprocessing
import time

import pytest

from envs.evaluation.workers import run_tasks


def wait_or_fail(seconds, finished):
    if seconds < 0:
        raise ValueError(f"expected seconds to wait, found {seconds}")
    time.sleep(seconds)
    finished()
    return seconds


def test_results_come_in_the_order_of_the_tasks():
    counts = []
    assert run_tasks(wait_or_fail, [0.2, 0.0, 0.1], workers=2, progress=counts.append) == [
        0.2,
        0.0,
        0.1,
    ]
    assert counts == sorted(counts)
    assert counts[-1] == 3


def test_a_task_that_fails_ends_all_workers_at_once():
    began = time.monotonic()
    with pytest.raises(ValueError, match="found -1"):
        run_tasks(wait_or_fail, [120.0, -1, 120.0], workers=2)
    assert time.monotonic() - began < 60.0
    assert not multiprocessing.active_children()


def test_an_interrupt_ends_all_workers_at_once():
    def interrupt(done):
        if done == 1:
            raise KeyboardInterrupt

    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run_tasks(wait_or_fail, [0.0, 120.0, 120.0], workers=2, progress=interrupt)
    assert time.monotonic() - began < 60.0
    assert not multiprocessing.active_children()
