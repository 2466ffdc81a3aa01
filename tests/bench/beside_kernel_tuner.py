#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Kernel Tuner and Duet on one device, with the same text of the example tasks' kernels.

    pip install kernel_tuner pyopencl        # in an environment of your own
    tests/bench/beside_kernel_tuner.py build/release/duet nvidia:0 [TASK ...]

Kernel Tuner measures every set of parameters by the device's clock. Duet tunes the task on the device
alone, by whole launches. Kernel Tuner then measures both choices once more, in ROUNDS rounds, since the
least of many times is a lucky one; beyond is the median of the rounds' ratios, with the least and the most.
"""
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import warnings

import kernel_tuner
import numpy as np
import pyopencl as cl

FOLDER = os.environ.get("DUET_TASKS") or os.path.join(os.path.dirname(__file__), "../../examples/tasks")
random = np.random.default_rng(1)
warnings.filterwarnings("ignore", "Kernel .* lists do not match")  # it cannot read arguments that are a macro


def floats(n, low=0.0, high=1.0):
    return random.uniform(low, high, n).astype(np.float32)


def items(n):
    return [np.uint64(0), np.uint64(n)]


# Of each task: n, its work-units, the kernel's arguments, parameters, and what a group does.
def saxpy(n):
    return n, items(n) + [np.float32(2), floats(n), floats(n)], "WG*PER_ITEM"


def nbody(n):
    bodies = floats(4 * n)
    values = [np.uint32(n), np.float32(0.01), np.float32(1 / n), bodies, np.zeros_like(bodies)]
    return n, items(n) + values, "WG"


def histogram(n):
    data = random.integers(0, 256, n, dtype=np.uint8)
    return n, items(n) + [data, np.zeros(256, np.uint32)], "WG*PER_ITEM"


def stencil(n):
    width = 1024
    cells = floats(n * width)
    values = [np.uint32(width), np.uint32(n), np.float32(0.2), cells, np.zeros_like(cells)]
    return n * width, items(n) + values, "WG*PER_ITEM"


def matmul(n):
    a, b = floats(n * n, -1), floats(n * n, -1)
    return n * n, items(n) + [np.uint32(n), a, b, np.zeros_like(a)], "WG*COLUMNS"


def black_scholes(n):
    values = [floats(n, 5, 30), floats(n, 1, 100), floats(n, 0.25, 10), floats(n), floats(n)]
    return n, items(n) + [np.float32(0.02), np.float32(0.3)] + values, "WG*PER_ITEM"


PER_ITEM = {"WG": [1, 16, 64, 256], "PER_ITEM": [1, 4, 16]}
TASKS = {
    "saxpy": (saxpy, 4000000, PER_ITEM),
    "nbody": (nbody, 8192, {"WG": [1, 16, 64, 128, 256], "TILE": [0, 1]}),
    "histogram": (histogram, 16000000, {"WG": [16, 64, 256], "PER_ITEM": [16, 64, 256]}),
    "stencil": (stencil, 2048, PER_ITEM),
    "matmul": (matmul, 1024, {"WG": [1, 16, 64], "COLUMNS": [1, 2, 4, 8, 16]}),
    "black_scholes": (black_scholes, 1000000, PER_ITEM),
}


def run_duet(duet, *words):
    env = dict(os.environ, DUET_KERNEL_DIR=FOLDER)
    ran = subprocess.run([duet, *words], env=env, capture_output=True, text=True)
    if ran.returncode:
        sys.exit(f"duet {' '.join(words)}: {ran.stderr}")
    return ran.stdout


def find_device(duet, selector):
    """Where pyopencl has the device that Duet calls so."""
    listed = json.loads(run_duet(duet, "devices", "--json"))["devices"]
    name = next(d["name"] for d in listed if d["selector"] == selector)
    for p, platform in enumerate(cl.get_platforms()):
        for d, device in enumerate(platform.get_devices()):
            if device.name.strip() == name:
                return p, d
    sys.exit(f"{selector}: pyopencl has no device '{name}'")


def split_source(source, params):
    """The text without the values of its parameters, and these."""
    values, lines = {}, []
    for line in source.splitlines():
        found = re.match(r"#define (\w+) (-?\d+)$", line)
        if found and found[1] in params and found[1] not in values:
            values[found[1]] = int(found[2])
        else:
            lines.append(line)
    return "\n".join(lines) + "\n", values


def tune_by_duet(duet, selector, name, n, defaults):
    with tempfile.TemporaryDirectory() as folder:
        text = run_duet(duet, "tune", "--json", "--task", f"{FOLDER}/{name}.task.lua", "-n", str(n), "--pair",
                        selector, "--profile", f"{folder}/p.db", "--wait", "0")
    row = json.loads(text)["workloads"][0]
    chosen = dict(defaults)
    for key, value in re.findall(r"\.(\w+)=(-?\d+)", row["variant_b"]):
        chosen[key] = int(value)
    return chosen, row["trials"] if "trials" in row else row["launches"]


ROUNDS = 7


def measure_both(both, params, run):
    """How much longer the second choice takes than the first, in each round: by the least of a round's times."""
    def time_of(r):
        return min(run({key: [r[key]] for key in params})[0]["times"])

    beyond = []
    for _ in range(ROUNDS):
        first, second = map(time_of, both)
        beyond.append(100 * (second / first - 1))
    return sorted(beyond)


def compare(duet, selector, platform, device, name):
    make, n, params = TASKS[name]
    n = int(os.environ.get("DUET_N", n)) if len(sys.argv) == 4 else n
    units, args, group = make(n)
    text, defaults = split_source(run_duet(duet, "source", name, "--device", selector), params)

    def run(space):
        return kernel_tuner.tune_kernel(name, text, units, args, space, grid_div_x=[group], block_size_names=["WG"],
                                        lang="OpenCL", platform=platform, device=device, iterations=9, quiet=True)[0]

    results = run(params)
    times = [r for r in results if isinstance(r["time"], float)]
    best = min(times, key=lambda r: r["time"])
    chosen, launches = tune_by_duet(duet, selector, name, n, defaults)
    ours = next(r for r in times if all(r[key] == chosen[key] for key in params))
    words = [" ".join(f"{key}={r[key]}" for key in params) for r in (best, ours)]
    beyond = [0.0] if best is ours else measure_both((best, ours), params, run)
    print(f"| {name:13} | {n:9} | {words[0]:20} | {best['time']:9.4f} ms | {words[1]:20} | {ours['time']:9.4f} ms "
          f"| {statistics.median(beyond):+6.1f} % | {beyond[0]:+6.1f} to {beyond[-1]:+6.1f} | {len(results):3} | {launches} |",
          flush=True)


def main():
    duet, selector = sys.argv[1:3]
    platform, device = find_device(duet, selector)
    print("| task          |         n | Kernel Tuner's best  |       time   | Duet's choice        |    its time  "
          "| beyond  |                  | all | launches |\n|---|---|---|---|---|---|---|---|---|---|", flush=True)
    for name in sys.argv[3:] or TASKS:
        compare(duet, selector, platform, device, name)


if __name__ == "__main__":
    main()
