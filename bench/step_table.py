#!/usr/bin/env python3
"""Prints the simulator's figures beside their bars, from what bench_step, bench_rollout and bench_gradients wrote.

    bench_step --benchmark_out=step.json --benchmark_out_format=json      (the other two alike)
    step_table.py step.json [rollout.json gradients.json ...]

Times are those of a machine whose unit takes 149 ns. Only the standard library. Files of several runs of one program:
the median of each figure.
"""
import statistics
import sys

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
    ("box", "env_steps_per_s_ref", "batch of boxes, env-steps/s", 1e6, 2.2e6, True),
    ("snake_10", "env_steps_per_s_ref", "batch of 10-link snakes, env-steps/s", 3e5, 5.6e5, True),
    ("quadruped", "env_steps_per_s_ref", "batch of quadrupeds, env-steps/s", 6e4, 1.3e5, True),
    ("gradients/quadruped", "vector_jacobian", "vector-Jacobian product of the quadruped, steps", 0.3, 0.1, False),
    ("gradients/quadruped", "jacobian", "full Jacobian of the quadruped, steps", 4, 1.2, False),
]


def load(paths):
    """{name: {counter: [values]}}, first context."""
    figures = {}
    runs, context = tables.read(paths)
    for run in runs:
        name = run["name"].split("/manual_time")[0].split("/iterations")[0]
        for counter, value in run.items():
            if isinstance(value, (int, float)):
                figures.setdefault(name, {}).setdefault(counter, []).append(value)
    return figures, context


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


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    figures, context = load(sys.argv[1:])
    print(tables.conditions(context) + "\n")
    print("| what | figure | mean | bar | aim | |\n|---|---|---|---|---|---|")
    for name, counter, what, bar, aim, more in ROWS:
        value = find(figures, name, counter, more)
        if value is None:
            continue
        mean = find(figures, name, "mean_us_ref", more) if counter == "us_ref" else None
        met = (lambda limit: value >= limit if more else value <= limit)
        verdict = "aim" if met(aim) else "bar" if met(bar) else "misses the bar"
        print(f"| {what} | {short(value)} | {'' if mean is None else short(mean)} | {short(bar)} | {short(aim)} | {verdict} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
