#!/usr/bin/env python3
"""Prints the figures of steps, batches, gradients, kernels and of the solver beside their bars, from what the benchmarks wrote.

    step_table.py --run build/release/bin [--out DIR]       runs them (two minutes); keeps what they wrote in DIR
    step_table.py step.json [rollout.json gradients.json solver.json kernels.json ...]

Where the machine has AVX-512, --run measures a second time with GRAPHSOLVE_SIMD=avx2; files of both kinds may be given
too. Times are those of a machine whose unit takes 149 ns. Only the standard library. Files of several runs of one
program: the median of each figure.
"""
import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True  # nothing is left in the source tree
import tables

# Benchmark, counter, what it is, bar, aim, does more count as better?
ROWS = [
    ("step/snake n=100", "us_ref", "snake n=100, 101 contacts, us/step", 30, 17, False),
    ("step/snake n=100 sliding, dt 10 us, 1e-6", "us_ref", "the same sliding at dt 10 us, tolerance 1e-6", 100, 60, False),
    ("step/disc c=100", "us_ref", "disc c=100, us/step", 10, 6, False),
    ("step/pendulum n=100", "us_ref", "pendulum n=100, us/step", 15, 7, False),
    ("step/quadruped", "us_ref", "quadruped walking, us/step", 30, 12, False),
    ("step/tree n=1023", "ns_body_it_ref", "balanced tree n=1023, ns per link and iteration", 400, 200, False),
    ("scaling/snake", "slope", "log-log slope in n", 1.10, 1.05, False),
    ("scaling/disc", "slope", "log-log slope in c", 1.10, 1.05, False),
    ("memory/balls", "bytes_body", "memory per body with one contact, bytes", 4000, 2000, False),
    ("box", "env_steps_per_s_ref", "batch of boxes, env-steps/s", 1e6, 2.2e6, True),
    ("snake_10", "env_steps_per_s_ref", "batch of 10-link snakes, env-steps/s", 3e5, 5.6e5, True),
    ("quadruped", "env_steps_per_s_ref", "batch of quadrupeds, env-steps/s", 6e4, 1.3e5, True),
    ("gradients/quadruped", "vector_jacobian", "vector-Jacobian product of the quadruped, steps", 0.3, 0.1, False),
    ("gradients/quadruped", "jacobian", "full Jacobian of the quadruped, steps", 4, 1.2, False),
    ("speed/chain 1000", "times_faster", "refactor + solve, chain n=1000, times faster than the fastest package", 8, 16, True),
    ("speed/tree 10000", "times_faster", "the same, tree n=10,000", 5, 10, True),
    ("batch of 8/chain 1000", "times_faster", "batch of 8 chains n=1000, per system, times faster", 10, 13, True),
    ("batch of 8/tree 1000", "times_faster", "batch of 8 trees n=1000", 10, 13, True),
    ("batch of 8/loop 1000", "times_faster", "batch of 8 loops n=1000", 10, 13, True),
    ("batch of 8/ladder 1000", "times_faster", "batch of 8 ladders n=1000", 10, 13, True),
]
NARROW = 2.2, 1.6  # bar and aim for times as long without AVX-512
FIXED = "slope", "bytes_body"  # whatever the instructions
# Program, what of it the table needs.
PROGRAMS = [
    ("bench_step", "."),
    ("bench_rollout", "."),
    ("bench_gradients", "quadruped"),
    ("bench_kernels", "."),
    ("bench_solver", "^(speed/(chain 1000|tree 10000)|batch of 8/(chain|tree|loop|ladder) 1000)/"),
]


def run_all(programs, out):
    """Runs the benchmarks, on the best instruction set and where that is AVX-512 also without. Returns the files."""
    paths, sets = [], [""]
    while sets:
        chosen = sets.pop(0)
        for program, wanted in PROGRAMS:
            path = out / f"{program}{'-' + chosen if chosen else ''}.json"
            print(f"{program}{' with ' + chosen if chosen else ''} ...", file=sys.stderr, flush=True)
            command = [programs / program, f"--benchmark_filter={wanted}", f"--benchmark_out={path}", "--benchmark_out_format=json"]
            environment = os.environ | ({"GRAPHSOLVE_SIMD": chosen} if chosen else {})
            subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            paths.append(path)
        if not chosen and tables.read(paths[:1])[1]["instruction_set"] == "avx512":
            sets.append("avx2")
    return paths


def load(paths):
    """{instruction set: {name: {counter: [values]}}}, first context of each, the widest first."""
    by_set = {}
    for path in paths:
        runs, context = tables.read([path])
        chosen = context.get("instruction_set", "plain")
        figures, _ = by_set.setdefault(chosen, ({}, context))
        for run in runs:
            if run.get("error_occurred"):
                continue
            name = run["name"].split("/manual_time")[0].split("/iterations")[0].split("/min_time")[0]
            for counter, value in run.items():
                if isinstance(value, (int, float)):
                    figures.setdefault(name, {}).setdefault(counter, []).append(value)
        for name, ratio in against_packages(path):
            figures.setdefault(name, {}).setdefault("times_faster", []).append(ratio)
    return dict(sorted(by_set.items(), key=lambda item: ["avx512", "avx2", "plain"].index(item[0])))


def against_packages(path):
    """Of bench_solver: (problem, times faster than the fastest package that solves it)."""
    for table, problems in tables.load([path])[0].items():
        for problem, solvers in problems.items() if table in ("speed", "batch of 8") else ():
            _, them = tables.fastest(solvers)
            _, us = tables.best(tables.ours(solvers))
            if us and them:
                yield f"{table}/{problem}", them["total_us"] / us["total_us"]


def find(figures, name, counter, more):
    """The figure of a benchmark, or the last size's (slope), or the best of its sizes."""
    if name in figures and counter in figures[name]:
        return statistics.median(figures[name][counter])
    sizes = [(int(key.rsplit("/", 1)[1]), statistics.median(values[counter])) for key, values in figures.items()
             if key.rsplit("/", 1)[0] == name and counter in values and key.rsplit("/", 1)[1].isdigit()]
    if not sizes:
        return None
    return max(value for _, value in sizes) if more else max(sizes)[1]


def short(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def verdict(value, bar, aim, more, slack=1):
    """slack: so many times the bar may be missed where there is no AVX-512."""
    met = (lambda limit: value >= limit if more else value <= limit)
    if met(aim) or met(bar):
        return "aim" if met(aim) else "bar"
    return "bar without AVX-512" if met(bar / slack if more else bar * slack) else "misses the bar"


def bars(figures, narrow, slack):
    """Lines of the table; `narrow`: figures without AVX-512, or none."""
    if all(find(figures, name, counter, more) is None for name, counter, _, _, _, more in ROWS):
        return
    print("| what | figure | mean | bar | aim | |" + (" without AVX-512, times as long (2.2) |" if narrow else ""))
    print("|---|---|---|---|---|---|" + ("---|" if narrow else ""))
    for name, counter, what, bar, aim, more in ROWS:
        value = find(figures, name, counter, more)
        if value is None:
            continue
        mean = find(figures, name, "mean_us_ref", more) if counter == "us_ref" else None
        cells = [what, short(value), "" if mean is None else short(mean), short(bar), short(aim),
                 verdict(value, bar, aim, more, 1 if counter in FIXED else slack)]
        other = find(narrow, name, counter, more) if narrow else None
        if narrow and (other is None or counter in FIXED):
            cells.append("")
        elif narrow:
            ratio = value / other if more else other / value
            cells.append(f"{ratio:.2f}: {verdict(ratio, *NARROW, False)}")
        print("| " + " | ".join(cells) + " |")


def kernels(figures):
    """Nanoseconds per system: factor + solve, by instruction set, packs and pivots one by one."""
    runs = {name.split("/", 1)[1]: counters for name, counters in figures.items() if name.startswith("kernels/")}
    if not runs:
        return
    sets = [chosen for chosen in ("avx512", "avx2", "plain") if any(name.endswith(" " + chosen) for name in runs)]
    ways = [way + chosen for way in (" ", " alone ") for chosen in sets]
    print("\nKernels, rows of a pivot with those of the blocks it couples to, ns per system: factor / solve\n")
    print("| |" + "|".join(f" {'one by one, ' if 'alone' in way else ''}{way.split()[-1]} " for way in ways) + "|")
    print("|" + "---|" * (1 + len(ways)))
    for name in dict.fromkeys(name.rsplit(" ", 1)[0].removesuffix(" alone") for name in runs):
        cell = lambda run: " / ".join(short(statistics.median(run[c])) for c in ("factor_ns", "solve_ns")) if run else ""
        print(f"| {name} | " + " | ".join(cell(runs.get(name + way)) for way in ways) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path, help="what the benchmarks wrote")
    parser.add_argument("--run", type=pathlib.Path, metavar="BIN", help="the folder of the benchmarks: run them first")
    parser.add_argument("--out", type=pathlib.Path, metavar="DIR", help="with --run: keeps their files here")
    options = parser.parse_args()
    if bool(options.run) == bool(options.files):
        parser.error("give either files or --run BIN")
    with tempfile.TemporaryDirectory() as scratch:
        out = options.out or pathlib.Path(scratch)
        out.mkdir(parents=True, exist_ok=True)
        by_set = load(run_all(options.run, out) if options.run else options.files)
    (figures, context), *others = by_set.values()
    print(tables.conditions(context) + "\n")
    widest = next(iter(by_set))
    bars(figures, others[0][0] if others else None, 1 if widest == "avx512" else NARROW[0])
    kernels(figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
