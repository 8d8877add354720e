#!/usr/bin/env python3
"""Prints the solver's tables from what bench_solver wrote.

    bench_solver --benchmark_out=solver.json --benchmark_out_format=json [--benchmark_repetitions=5]
    tables.py solver.json [more.json] [--full]

Only the standard library. With repetitions, and with several files of one machine, every figure is the median.
--full lists every hard problem instead of the worst of each kind.
"""
import json
import statistics
import sys

REFERENCE_UNIT = 149.0  # ns; bars in us hold where the unit takes this long


def read(paths):
    """All measured runs, and the context of the first file."""
    runs, context = [], None
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                data = json.load(file)
            data["context"]["unit_ns"], data["benchmarks"]
        except OSError as error:
            sys.exit(f"{path}: {error.strerror}")
        except (ValueError, KeyError, TypeError):
            sys.exit(f"{path}: not what a benchmark of this project wrote to its end (--benchmark_out_format=json)")
        context = context or data["context"]
        runs += [run for run in data["benchmarks"] if run.get("run_type") != "aggregate"]
    return runs, context


def conditions(context):
    """What the figures were measured with."""
    return (f"unit {float(context['unit_ns']):.0f} ns (reference {REFERENCE_UNIT:.0f}); {context.get('cpu', '')}, "
            f"{context['num_cpus']} cores; {context['compiler']}, {context['flags'].strip()}, "
            f"{context.get('instruction_set', 'plain')} chosen at run time; commit {context['commit']}; {context['date']}; "
            "one thread, thread CPU time, medians")


def load(paths):
    """{table: {problem: {solver: {counter: median, 'error': reason, 'label': text}}}}, context of the first file."""
    tables = {}
    runs, context = read(paths)
    for run in runs:
        table, problem, solver = run["name"].split("/")[:3]
        tables.setdefault(table, {}).setdefault(problem, {}).setdefault(solver, []).append(run)
    for problems in tables.values():
        for solvers in problems.values():
            for solver, repetitions in solvers.items():
                solvers[solver] = merge(repetitions)
    return tables, context


def merge(repetitions):
    merged = {"label": repetitions[0].get("label", "")}
    errors = [run["error_message"] for run in repetitions if run.get("error_occurred")]
    if errors:
        return merged | {"error": errors[0]}
    for key, value in repetitions[0].items():
        if isinstance(value, (int, float)):
            merged[key] = statistics.median(run[key] for run in repetitions)
    return merged


def short(value):
    """Three digits."""
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def print_table(title, header, rows):
    if not rows:  # what was not measured
        return
    print(f"\n## {title}\n")
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(row) + " |")


def ours(solvers, path=None):
    """Those that solve it: all, or of one path, 'one by one' or 'in packs'. Forced instruction sets are not among them,
    nor RobustSolver, whose solve may hold a factorization."""
    forced = ("plain", "avx2", "avx512")
    return {name: run for name, run in solvers.items()
            if name.startswith("graphsolve") and "error" not in run and not name.endswith(forced) and "robust" not in name
            and (path is None or ("packs" in name) == (path == "in packs"))}


def best(runs):
    return min(runs.items(), key=lambda item: item[1]["total_us"]) if runs else (None, None)


def fastest(solvers):
    """Of the packages that solve this very matrix: a positive definite twin is another one."""
    solved = {name: run for name, run in solvers.items()
              if not name.startswith("graphsolve") and "error" not in run and not run["label"]}
    return best(solved)


def verdict(value, bar, smaller=False):
    good = value <= bar if smaller else value >= bar
    return f"{value:.2f} ({'<=' if smaller else '>='} {bar:g}: {'pass' if good else 'FAIL'})"


def all_solvers(problems):
    names = []
    for solvers in problems.values():
        names += [name for name in solvers if name not in names]
    return names


def times(runs, table, title):
    problems = runs.get(table, {})
    if not problems:
        return
    names = all_solvers(problems)
    cell = lambda run: ("" if run is None else run["error"] if "error" in run
                        else f"{short(run['refactor_us'])} / {short(run['solve_us'])}" + ("*" if run["label"] else ""))
    print_table(title, ["us: refactor / solve"] + names,
                [[problem] + [cell(solvers.get(name)) for name in names] for problem, solvers in problems.items()])
    if any(run.get("label") for solvers in problems.values() for run in solvers.values()):
        print("\n\\* on a positive definite matrix of the same pattern")


def family(problem):
    return problem.split(" ")[0].rstrip(",")


def bars_of_item_1(runs):
    problems, rows = runs.get("speed", {}), []
    for problem, solvers in problems.items():
        if "," in problem:
            continue
        rival, them = fastest(solvers)
        for path in ("one by one", "in packs"):
            name, us = best(ours(solvers, path))
            if not us:
                continue
            ratio = lambda run: run["total_us"] / us["total_us"] if run and "total_us" in run else None
            against = bars_against(family(problem), ratio(them), rival, ratio(solvers.get("CHOLMOD simplicial")),
                                   ratio(solvers.get("CHOLMOD supernodal")))
            whole = lambda run: run["total_us"] + run["write_us"]
            rows.append([problem, name.replace("graphsolve ", ""), short(us["total_us"])] +
                        [f"{verdict(value, bar)} {other}" for value, bar, other in against if value] +
                        [""] * (2 - len([value for value, _, _ in against if value])) +
                        [short(us["write_us"]), short(whole(them) / whole(us)) if them else ""])
    print_table("Refactor + solve, times faster: pivots one by one, and eight at a time",
                ["problem", "fastest of ours", "us", "", "", "write us", "times faster than the fastest with write"], rows)
    rows = []
    for problem, solvers in problems.items():
        ldu, ldlt = solvers.get("graphsolve ldu", {}), solvers.get("graphsolve ldlt", {})
        if family(problem) in ("chain", "tree", "quadruped") and "total_us" in ldu and "total_us" in ldlt:
            rows.append([problem, verdict(ldu["total_us"] / ldlt["total_us"], 1.3, smaller=True)])
    if rows:
        print_table("LDU over LDL' on trees", ["problem", "ratio"], rows)


def bars_against(kind, fastest_ratio, rival, simplicial, supernodal):
    if kind in ("chain", "tree", "quadruped", "loop", "ladder"):
        return [(fastest_ratio, 3.5, f"fastest, {rival}"), (simplicial, 5, "simplicial")]
    if kind == "grid":
        return [(simplicial, 10, "simplicial"), (supernodal, 4, "supernodal")]
    return [(fastest_ratio, 5 if kind == "control" else 1, f"fastest, {rival}")]


def bars_of_item_2(runs, scale):
    fill_bars = {"chain": 1.0, "tree": 1.0, "quadruped": 1.0, "control": 1.0, "loop": 1.3, "ladder": 1.45, "grid": 3.5}
    rows = []
    for problem, solvers in runs.get("speed", {}).items():
        for path in ("one by one", "in packs"):  # the default ordering, and the cheapest of several, without a bar
            name, run = next(((name, run) for name, run in ours(solvers, path).items() if "fill" in run), (None, None))
            if not run or "," in problem:
                continue
            kind, per_node, default = family(problem), run["analysis_us"] * scale / run["nodes"], path == "one by one"
            fill = verdict(run["fill"], fill_bars[kind], smaller=True) if default and kind in fill_bars else short(run["fill"])
            analysis = verdict(per_node, 2, smaller=True) if default and kind not in ("grid", "random") else short(per_node)
            rows.append([problem, name, fill, analysis])
    print_table("Fill and analysis of the default ordering, and of the cheapest in packs",
                ["problem", "solver", "fill", "ordering + symbolic, us per node on the unit"], rows)


def bars_of_issue_4(runs):
    rows, singles = [], {"chain 1000": (8, 16), "tree 10000": (5, 10)}
    entries = [("one " + problem, solvers, *singles[problem])
               for problem, solvers in runs.get("speed", {}).items() if problem in singles]
    entries += [("8 x " + problem + ", per system", solvers, 10, 13)
                for problem, solvers in runs.get("batch of 8", {}).items()]
    for title, solvers, bar, aim in entries:
        rival, them = fastest(solvers)
        name, us = best(ours(solvers))
        if us and them:
            ratio = them["total_us"] / us["total_us"]
            rows.append([title, name.replace("graphsolve ", ""), short(us["total_us"]), rival, short(them["total_us"]),
                         verdict(ratio, bar), f"{aim} ({'reached' if ratio >= aim else 'not reached'})"])
    print_table("Refactor + solve in packs against the fastest package",
                ["problem", "fastest of ours", "us", "fastest package", "us", "times faster", "aim"], rows)
    rows = []
    for title, solvers, _, _ in entries:
        _, us = best(ours(solvers))
        forced = lambda name: best({n: run for n, run in solvers.items() if n.endswith(name) and "error" not in run})[1]
        narrow, plain = forced("packs avx2"), forced("packs plain")
        if us and narrow:
            ratio = narrow["total_us"] / us["total_us"]
            rows.append([title, short(narrow["total_us"]), verdict(ratio, 2.2, smaller=True),
                         f"1.6 ({'reached' if ratio <= 1.6 else 'not reached'})",
                         short(plain["total_us"]) if plain else ""])
    if rows:
        print_table("Without AVX-512, forced: times as long",
                    ["problem", "us with AVX2", "over the best", "aim", "us, plain"], rows)


def error_cell(run):
    if run is None:
        return ""
    if "error" in run:
        return run["error"]
    return f"{run.get('refined_error', run['backward_error']):.1e}{rung(run)}"


def rung(run):
    """Which rung RobustSolver took, where it was not the first."""
    return ["", ", reordered", ", shifted", ", threshold pivoting"][int(run.get("rung", 0))]


def hard(runs, full):
    problems = runs.get("hard", {})
    if not problems:
        return
    names = all_solvers(problems)
    title = "Componentwise backward error (graphsolve: after refinement; bar 1e-15)"
    if full:
        print_table(title, ["problem"] + names, [[problem] + [error_cell(solvers.get(name)) for name in names]
                                                 for problem, solvers in problems.items()])
        return
    groups = {}
    for problem, solvers in problems.items():
        parts = [part for part in problem.split(", ")[1:] if part != "leaves"]
        groups.setdefault(", ".join(parts) or "plain", []).append(solvers)
    print_table(title + ": worst of the families", ["kind"] + names,
                [[kind] + [worst([s[name] for s in members if name in s]) for name in names]
                 for kind, members in groups.items()])


def worst(members):
    failed = [run["error"] for run in members if "error" in run]
    errors = [run.get("refined_error", run["backward_error"]) for run in members if "error" not in run]
    text = f"{max(errors):.1e}" if errors else ""
    later = [run for run in members if run.get("rung", 0) > 0]
    if later:
        text += f", {len(later)} by {', '.join(sorted({rung(run)[2:] for run in later}))}"
    return text + (f" {len(failed)} of {len(members)} failed ({failed[0]})" if failed else "")


def real(runs):
    problems, rows = runs.get("real", {}), []
    if not problems:
        return
    names = all_solvers(problems)
    for problem, solvers in problems.items():
        cholmod = [run["refactor_us"] for name, run in solvers.items() if name.startswith("CHOLMOD")
                   and "error" not in run and not run["label"]]
        us = [run["refactor_us"] for run in ours(solvers).values()]
        ratio = verdict(min(us) / min(cholmod), 1.5, smaller=True) if us and cholmod else ""
        cell = lambda run: ("" if run is None else run["error"] if "error" in run else
                            f"{short(run['refactor_us'])} ({error_cell(run)})" + ("*" if run["label"] else ""))
        rows.append([problem] + [cell(solvers.get(name)) for name in names] + [ratio])
    print_table("Real matrices: factor time in us (backward error)",
                ["matrix"] + names + ["ours over CHOLMOD's fastest"], rows)
    print("\n\\* on a positive definite matrix of the same pattern")


def main():
    paths = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    if not paths or set(sys.argv[1:]) - set(paths) - {"--full"}:
        print(__doc__, file=sys.stderr)
        return 2
    runs, context = load(paths)
    unit = float(context["unit_ns"])
    print(f"{conditions(context)}; {context.get('packages', 'no packages to compare with')}, BLAS {context.get('blas', '-')}")
    times(runs, "speed", "Symmetric values")
    bars_of_item_1(runs)
    bars_of_item_2(runs, REFERENCE_UNIT / unit)
    bars_of_issue_4(runs)
    times(runs, "unsymmetric", "Unsymmetric values")
    times(runs, "batch of 8", "Batch of 8 equal systems, per system")
    hard(runs, "--full" in sys.argv)
    real(runs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
