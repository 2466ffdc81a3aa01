#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Scores strategies on recorded launches by the method of autotuning_methodology.

    pip install autotuning_methodology       # in an environment of your own
    duet tune --replay surfaces.db --json | tests/bench/methodology.py

For each workload the package computes how good the best plan of a random search would be after so much
time, from the times of all recorded plans, and until when that is within 5 % of the way from the median
to the best. A strategy's score is how far its best plan so far is, in the mean over that time and over
its runs, from the random search's (0) to the best recorded plan's (1). Workloads with fewer than 50
recorded plans are left out: a random search has seen most of them at once.
"""
import json
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
from autotuning_methodology.baseline import RandomSearchCalculatedBaseline
from autotuning_methodology.caching import ResultsDescription
from autotuning_methodology.curves import StochasticOptimizationAlgorithm
from autotuning_methodology.report_experiments import get_strategies_aggregated_performance
from autotuning_methodology.searchspace_statistics import SearchspaceStatistics

LEAST = 50  # plans
LAUNCHES = 4  # of a trial: one to warm up and three that count
START, END, STEPS = 0.01, 0.95, 200  # of the package's own experiments, but for the steps
warnings.simplefilter("ignore")


def read_space(folder, workload, name):
    """The statistics of all recorded plans."""
    results = [{"configuration": {"plan": i}, "invalidity": "correct", "correctness": 1, "objectives": ["ms"],
                "times": {"runtimes": [LAUNCHES * ms * 1e-3]},
                "measurements": [{"name": "ms", "value": ms, "unit": "ms"}]}
               for i, ms in enumerate(workload["recorded_ms"])]
    path = Path(folder) / f"{name}.json"
    path.write_text(json.dumps({"schema_version": "1.0.0", "metadata": {"timeunit": "seconds"}, "results": results}))
    return SearchspaceStatistics(name, "pair", True, ["runtimes"], ["ms"], path, full_validate=False)


def list_best(gains, times, dist):
    """The best plan so far at each time, as the recorded one that is nearest to it; before the first the worst."""
    seconds, ms = np.array(gains).T
    near = dist[np.abs(dist[:, None] - ms).argmin(axis=0)]
    at = np.searchsorted(seconds, times, side="right") - 1
    return np.where(at < 0, dist[-1], near[at])


def read_strategy(folder, row, name, times, dist):
    best = np.array([list_best(gains, times, dist) for gains in row["runs"]]).T
    shape = best.shape
    of = ResultsDescription(Path(folder) / row["strategy"], name, "pair", row["strategy"], row["strategy"], True,
                            ["runtimes"], ["ms"], True)
    at = np.repeat(times[:, None], shape[1], axis=1)
    of.set_results({
        "fevals_results": np.repeat(np.arange(1.0, shape[0] + 1)[:, None], shape[1], axis=1),
        "objective_time_results": at,
        "objective_performance_results": best,
        "objective_performance_best_results": best,
        "objective_performance_stds": np.zeros(shape),
        "objective_time_results_per_key": at[None],
        "objective_performance_results_per_key": best[None],
    })
    return StochasticOptimizationAlgorithm(of)


def read_workload(folder, workload, name):
    space = read_space(folder, workload, name)
    start, end, start_s, end_s = space.cutoff_point_fevals_time_start_end(START, END)
    times = np.linspace(max(start_s, end_s / STEPS), end_s, STEPS)
    curves = [read_strategy(folder, row, name, times, space.objective_performances_total_sorted)
              for row in workload["strategies"]]
    return RandomSearchCalculatedBaseline(space), curves, space, times, np.arange(start, end + 1)


def print_scores(names, spaces):
    scores = get_strategies_aggregated_performance(spaces, 0.95)[0]
    for name, score in zip(names, scores):
        print(f"| {name:10} | {len(spaces):9} | {np.mean(score):6.3f} | {np.std(score):6.3f} |")


def main():
    groups = {}  # workloads on which the same strategies ran
    with tempfile.TemporaryDirectory() as folder:
        for i, workload in enumerate(json.load(sys.stdin)["workloads"]):
            if len(workload["recorded_ms"]) >= LEAST:
                names = tuple(row["strategy"] for row in workload["strategies"])
                groups.setdefault(names, []).append(read_workload(folder, workload, f"workload{i}"))
        print("| strategy   | workloads | score  | spread |\n|---|---|---|---|")
        for names, spaces in groups.items():
            print_scores(names, spaces)


if __name__ == "__main__":
    main()
