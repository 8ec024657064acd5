"""The runs of a sweep: on all cores of this machine, or on the machines of a dask cluster."""

from __future__ import annotations

import traceback
from collections.abc import Generator
from dataclasses import dataclass

from soup_lab.experiments.experiment import Case, Experiment
from soup_lab.experiments.identity import code_digest, run_digest
from soup_lab.headless.pool import share_out
from soup_lab.headless.runs import RunPlan, Summary, run_once
from soup_msgs_py.errors import InputError, RunError

CONNECT_S = 10.0  # how long a dask scheduler may take to answer


@dataclass(frozen=True)
class Job:
    """One run of a sweep."""

    case: Case
    seed: int
    run: str  # its fingerprint


@dataclass(frozen=True)
class Failure:
    """Why a run has no summary."""

    reason: str
    details: str


Outcome = tuple[Job, Summary | Failure]
Outcomes = dict[tuple[str, int], Summary | Failure]  # by digest of the case and seed


class OtherCodeError(RunError):
    """A worker has other code or libraries than the sweep began with."""

    def __init__(self) -> None:
        super().__init__("a worker has other code or libraries than the sweep began with: start both from the same")

    def __reduce__(self) -> tuple[type[OtherCodeError], tuple[()]]:
        """How it comes from one process to another."""
        return OtherCodeError, ()


def jobs(experiment: Experiment) -> list[Job]:
    """All runs, seed by seed, so that a sweep that is cut short has as many of each case."""
    code = code_digest()
    return [
        Job(case, seed, run_digest(case.digest, seed, code))
        for seed in experiment.seeds
        for case in experiment.cases()
    ]  # fmt: skip


def run_local(todo: list[Job], processes: int | None = None) -> Generator[Outcome]:
    """Run jobs on this machine; outcomes as they come.

    Args:
        todo: What to run.
        processes: How many at once; without: one a core.

    Raises:
        RunError: A process died.
        OtherCodeError: The code was changed while the processes started.
    """
    if not todo:
        return
    code = code_digest()
    tasks = [(job.case.plan, job.seed, code) for job in todo]
    for k, outcome in share_out(attempt, tasks, processes, prepare=code_digest):  # notes at once which code it is
        yield todo[k], outcome


def run_on_dask(todo: list[Job], address: str) -> Generator[Outcome]:
    """Run jobs on a dask cluster whose workers have the same code; outcomes as they come.

    Args:
        todo: What to run.
        address: Of the scheduler, for instance tcp://host:8786.

    Raises:
        InputError: No scheduler answers.
        RunError: The cluster lost a run.
        OtherCodeError: A worker has other code.
    """
    from distributed import Client, as_completed  # takes a second to import, and most sweeps do without

    allowed = "the address of a dask scheduler that runs, for instance tcp://host:8786"
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError("--scheduler", "", f"no scheduler at {address}", allowed) from error
    with client:
        code = code_digest()
        plans = {job.case.digest: client.scatter(job.case.plan) for job in todo}  # sent once, not once a run
        futures = {
            client.submit(attempt, plans[job.case.digest], job.seed, code, key=f"soup-{job.run}", pure=False): job
            for job in todo
        }
        try:
            for future in as_completed(futures):
                error = future.exception()
                if error is not None and not isinstance(error, RunError):
                    raise RunError(f"the cluster lost {futures[future].case.label}: {error}") from error
                yield futures[future], future.result()
        finally:
            client.cancel(list(futures))


def attempt(plan: RunPlan, seed: int, code: str) -> Summary | Failure:
    """One run, in a worker; what goes wrong comes back as a value, so that the others go on.

    Args:
        plan: What to run.
        seed: Its seed.
        code: Fingerprint of the code that the sweep is about.

    Raises:
        OtherCodeError: This worker has other code.
    """
    if code_digest() != code:
        raise OtherCodeError
    try:
        return run_once(plan, seed)
    except Exception as error:  # a person's own policy may fail in any way
        text = " ".join(str(error).split())
        reason = text if isinstance(error, (InputError, RunError)) else f"{type(error).__name__}: {text}"
        return Failure(reason, traceback.format_exc())
