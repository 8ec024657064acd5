"""All parts in one process: headless runs, sweeps, reports, benchmarks, bag record and replay."""
