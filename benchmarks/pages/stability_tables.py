"""The tables of docs/stability.md: stated against true errors, and what else was asked."""

from __future__ import annotations

from collections import Counter

from pages.numbers import WHAT, Lines, Results, count_by_name, power, powers

_BARS = "compared | held | off by more than 3 times | error: median | largest"
_OVER = "stated over true, median"
_DEFAULT = 1e-6


# --- stated against true errors -------------------------------------------------------------------


def errors(
    ladder: Results, references: Results, locked: Results, fixed_step: Results, stated: Results
) -> Lines:
    """Yield true errors and how the stated ones bound them, a row for each set of points."""
    yield f"points | rtol | {_BARS} | {_OVER}"
    for row in ladder["steps"]:
        yield f"{ladder['points']} random | {power(row['rtol'])} | {_bars(row)}"
    default = power(_DEFAULT)
    yield f"{references['points']} wide, plain iteration | {default} | {_bars(references)}"
    yield f"{locked['points']} locked, near resonance | {default} | {_bars(locked)}"
    yield f"{fixed_step['points']} by Euler–Cromer | - | {_bars(fixed_step)}"
    for box, tolerances in stated.items():
        for rtol, found in tolerances.items():
            for kind, row in found["kinds"].items():
                # Of every motion at the default, of all films elsewhere.
                motions = float(rtol) == _DEFAULT and not kind.startswith("gamma")
                if motions or kind == "all" or "all" not in found["kinds"]:
                    yield f"{box}, {kind} | {power(rtol)} | {_bars(row)}"


def _bars(row: Results) -> str:
    held, errors = f"{100 * row['held']:.1f} %", (row["error_median"], row["error_max"])
    largest = " | ".join(f"{error:.1e}" for error in errors)
    return f"{row['compared']} | {held} | {row['far_off']} | {largest} | {row['over_median']:.2g}"


_SYMBOLS = {
    "dissipated_energy": "W",
    "friction_force_in_phase": "F′",
    "friction_force_out_of_phase": "F″",
}


def work(work: Results) -> Lines:
    """Yield the same of the work of the drive and the first harmonic, and how many wrong signs."""
    yield f"points | rtol | of | {_BARS} | {_OVER} | wrong signs"
    for points, tolerances in work.items():
        for rtol, found in tolerances.items():
            for name, symbol in _SYMBOLS.items():
                row = found[name]
                yield f"{points} | {power(rtol)} | {symbol} | {_bars(row)} | {row['wrong_sign']}"


# --- what else was asked --------------------------------------------------------------------------


def verdicts(*parts: Results) -> Lines:
    """Yield what was asked about orbits, steps, extremes and drift, and what came of it."""
    references, locked, stated, step_map, fixed_step, extremes, *others = parts
    acceleration, freezing, multipliers, watched, long_run = others
    yield WHAT
    closed = f"{references['compared']} orbits that closed by plain iteration"
    wrong = f"{len(references['wrong'])}, {references['other_period']}"
    yield f"{closed}: wrong ones, other periods | {wrong}"
    balance = f"{100 * locked['balance_held']:.1f} %, {locked['balance_max']:.1e}"
    yield f"locked blocks: force within 1e-5 of abs(2K − Mω²) X_m, largest error | {balance}"
    yield from _closed_form(stated)
    unseen = step_map["counts"]["wrong, and no check afterwards would see it"]
    periods = f"Euler–Cromer, {len(step_map['cells'])} periods"
    yield f"{periods}: wrong, and no check would see it | {unseen}"
    near = f"Euler–Cromer, {fixed_step['points']} orbits near the largest step"
    yield f"{near} | {count_by_name(fixed_step['statuses'])}"
    yield from _extremes(extremes)
    yield from _jumps("random starts", acceleration)
    yield from _jumps("films with several orbits", acceleration["several"])
    yield from _freezing(freezing)
    yield from _multipliers(multipliers)
    yield from _watched(watched)
    for scene in long_run["scenes"]:
        drifts = powers(scene[name] for name in ("drift_stress", "drift_force", "balance_after"))
        what = f"{long_run['periods']} periods, {scene['scene']}"
        yield f"{what}: drift of stress and force, balance | {drifts}"


def _closed_form(stated: Results) -> Lines:
    """Yield the worst force of locked blocks whose force is known in closed form."""
    for box, tolerances in stated.items():
        off = [found["balance_max"] for found in tolerances.values()]
        if max(off) > 0.0:
            what = f"locked blocks of {box} films, largest, at {powers(tolerances, 0)}"
            yield f"{what} | {powers(off)}"


def _extremes(found: Results) -> Lines:
    yield f"{found['points']} extremes at random | {count_by_name(found['statuses'])}"
    alone = Counter(sorted(row["status"] for row in found["one_at_a_time"]))
    yield f"... one at a time | {count_by_name(alone)}"
    sample = found["sample"]
    held = f"{100 * sample['held']:.1f} % of {sample['compared']}, {len(sample['wrong'])}"
    yield f"... within what was stated at a hundredth of the tolerance; far off | {held}"


def _jumps(kind: str, found: Results) -> Lines:
    same = f"{found['same']} of {found['compared']}"
    fewer = f"{found['periods_plain'] / found['periods']:.2g} times fewer periods"
    yield f"{found['points']} {kind}: on the orbit of plain iteration | {same}, {fewer}"
    both = f"{count_by_name(found['statuses'])}; {count_by_name(found['statuses_plain'])}"
    yield f"... statuses with jumps, without | {both}"


def _freezing(found: Results) -> Lines:
    """Yield how many films that freeze late or briefly ended on another orbit."""
    for start, what in (("late", "off rest"), ("rest", "from rest")):
        row = found[start]
        films = f"{row['points']} films near resonance, {what}: not where plain iteration ends"
        periods = f"{row['periods']:.0f} periods instead of {row['periods_plain']:.0f}"
        yield f"{films} | {len(row['wrong'])} of {row['compared']}, {periods}"
    short, steps = found["short"], found["short"]["steps"]
    rtols = powers((row["rtol"] for row in steps), 0)
    missed = ", ".join(str(row["missed"] + row["missed_near"]) for row in steps)
    films = f"{short['points']} films that freeze in a short passage: missed at {rtols}"
    yield f"{films} | {missed} of {min(row['compared'] for row in steps)}"


def _multipliers(found: Results) -> Lines:
    """Yield how far multipliers are off those of central differences."""
    for box, tolerances in found.items():
        rows = {rtol: row for rtol, row in tolerances.items() if rtol != "known"}
        what = f"multipliers of {tolerances['known']} orbits, {box}: within what is allowed"
        held = ", ".join(f"{100 * row['held']:.1f} %" for row in rows.values())
        yield f"{what}, at {powers(rows, 0)} | {held}"
        medians, worst = (
            powers(row[name] for row in rows.values()) for name in ("error_median", "error_max")
        )
        yield f"... error: medians; largest | {medians}; {worst}"


def _watched(found: Results) -> Lines:
    for what in ("weakly_viscous", "everywhere"):
        row = found[what]
        films = f"{row['points']} films {what.replace('_', ' ')}"
        yield f"{films} | {count_by_name(row['statuses'])}"
    plain, long = found["aperiodic"]["films"], found["long_cycles"]
    apart = max((film["standard_errors_apart"] for film in plain), default=0.0)
    what = f"... {len(plain)} aperiodic: mean from that of plain iteration"
    yield f"{what} | up to {apart:.1f} standard errors"
    yield f"... long cycles that still close later | {long['closed']} of {long['found']}"
    films, lengths = found["windows"], list(found["windows"][0]["lengths"])
    least = [min(film["lengths"][length]["covered"] for film in films) for length in lengths]
    what = f"{len(films)} wandering films, windows of {', '.join(lengths)}: covered at least"
    yield f"{what} | {', '.join(f'{value:.0%}' for value in least)}"
