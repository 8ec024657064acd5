"""Processes that share work; they end with the one that shares it out, however that ends."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from soup_lab.launch.part import end_with
from soup_msgs_py.errors import RunError


def share_out(
    work: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    processes: int | None = None,
    prepare: Callable[[], object] | None = None,
) -> Generator[tuple[int, Any]]:
    """Call a function once a task, in other processes; the number of each task and its outcome, as they come.

    Args:
        work: What to call.
        tasks: Its arguments.
        processes: How many at once; without: one a core.
        prepare: Called first in each process.

    Raises:
        RunError: A process died.
    """
    if not tasks:
        return
    spawn = multiprocessing.get_context("spawn")
    workers = min(processes or len(os.sched_getaffinity(0)), len(tasks))
    with ProcessPoolExecutor(workers, mp_context=spawn, initializer=_follow_the_starter, initargs=(prepare,)) as pool:
        try:
            # Ctrl-C in the middle of a start would leave a process that nobody knows
            mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                futures = {pool.submit(work, *task): k for k, task in enumerate(tasks)}
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BaseException as error:
            # `shutdown` forgets them
            workers_now, calls = list((pool._processes or {}).values()), getattr(pool, "_call_queue", None)
            pool.shutdown(wait=False, cancel_futures=True)
            for process in workers_now:
                process.terminate()
            if isinstance(error, BrokenProcessPool):
                raise RunError("one of the processes was killed, perhaps for lack of memory") from error
            if calls is not None:
                # who hands over a task larger than a pipe would wait for ever for its dead reader (CPython gh-94777)
                calls._reader.close()
            raise


def _follow_the_starter(prepare: Callable[[], object] | None) -> None:
    """Leave Ctrl-C to the starter, and end with it even when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    starter = multiprocessing.parent_process()
    if starter is not None and starter.pid is not None:
        end_with(starter.pid, signal.SIGKILL)
    if prepare is not None:
        prepare()
