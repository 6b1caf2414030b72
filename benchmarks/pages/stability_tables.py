"""The two tables of docs/stability.md: stated against true errors, and what else was asked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from pages.numbers import Results, count_by_name

Row = tuple[str, ...]
Lines = Iterator[tuple[str, str]]

_DEFAULT = 1e-6
_IN_ALL = "all"


# --- stated against true errors -------------------------------------------------------------------


def errors(
    ladder: Results, references: Results, locked: Results, fixed_step: Results, stated: Results
) -> list[Row]:
    """Return true errors and how the stated ones bound them, a row for each set of points."""
    head = ("points", "rtol", "compared", "held", "off by more than 3 times")
    rows = [(*head, "error: median", "largest", "stated over true, median")]
    random = f"{ladder['points']} random"
    rows += [_bars(random, f"{row['rtol']:.0e}", row) for row in ladder["steps"]]
    default = f"{_DEFAULT:.0e}"
    rows.append(_bars(f"{references['points']} wide, plain iteration", default, references))
    rows.append(_bars(f"{locked['points']} locked, near resonance", default, locked))
    rows.append(_bars(f"{fixed_step['points']} by Euler–Cromer", "-", fixed_step))
    return rows + [
        _bars(f"{box}, {kind}", _power(rtol), row)
        for box, tolerances in stated.items()
        for rtol, found in tolerances.items()
        for kind, row in found["kinds"].items()
        if _is_shown(kind, rtol, found["kinds"])
    ]


def _is_shown(kind: str, rtol: str, kinds: Results) -> bool:
    """Return whether the page has a row: of every motion at the default, of all films elsewhere."""
    if kind == _IN_ALL or _IN_ALL not in kinds:
        return True
    return float(rtol) == _DEFAULT and not kind.startswith("gamma")


def _bars(points: str, rtol: str, row: Results) -> Row:
    return (
        points,
        rtol,
        str(row["compared"]),
        f"{100 * row['held']:.1f} %",
        str(row["far_off"]),
        f"{row['error_median']:.1e}",
        f"{row['error_max']:.1e}",
        f"{row['over_median']:.2g}",
    )


_SYMBOLS = {
    "dissipated_energy": "W",
    "friction_force_in_phase": "F′",
    "friction_force_out_of_phase": "F″",
}


def work(work: Results) -> list[Row]:
    """Return the same of the work of the drive and the first harmonic, and how many wrong signs."""
    head = ("points", "rtol", "of", "compared", "held", "off by more than 3 times")
    rows = [(*head, "error: median", "largest", "stated over true, median", "wrong signs")]
    for points, tolerances in work.items():
        for rtol, found in tolerances.items():
            for name, symbol in _SYMBOLS.items():
                kind, power, *bars = _bars(points, _power(rtol), found[name])
                rows.append((kind, power, symbol, *bars, str(found[name]["wrong_sign"])))
    return rows


# --- what else was asked --------------------------------------------------------------------------


def verdicts(
    references: Results,
    locked: Results,
    stated: Results,
    step_map: Results,
    fixed_step: Results,
    extremes: Results,
    acceleration: Results,
    freezing: Results,
    multipliers: Results,
    watched: Results,
    long_run: Results,
) -> list[Row]:
    """Return what was asked about orbits, steps, extremes and drift, and what came of it."""
    closed = f"{references['compared']} orbits that closed by plain iteration"
    wrong = f"{len(references['wrong'])}, {references['other_period']}"
    balance = f"{100 * locked['balance_held']:.1f} %, {locked['balance_max']:.1e}"
    unseen = step_map["counts"]["wrong, and no check afterwards would see it"]
    return [
        ("what", "value"),
        (f"{closed}: wrong ones, other periods", wrong),
        ("locked blocks: force within 1e-5 of abs(2K − Mω²) X_m, largest error", balance),
        *_closed_form(stated),
        (
            f"Euler–Cromer, {len(step_map['cells'])} periods: wrong, and no check would see it",
            str(unseen),
        ),
        (
            f"Euler–Cromer, {fixed_step['points']} orbits near the largest step",
            count_by_name(fixed_step["statuses"]),
        ),
        *_extremes(extremes),
        *_jumps("random starts", acceleration),
        *_jumps("films with several orbits", acceleration["several"]),
        *_freezing(freezing),
        *_multipliers(multipliers),
        *_watched(watched),
        *_drifts(long_run),
    ]


def _closed_form(stated: Results) -> Lines:
    """Return the worst force of locked blocks whose force is known in closed form."""
    for box, tolerances in stated.items():
        off = [found["balance_max"] for found in tolerances.values()]
        if max(off) > 0.0:
            what = f"locked blocks of {box} films, largest, at {', '.join(map(_power, tolerances))}"
            yield what, ", ".join(f"{value:.1e}" for value in off)


def _freezing(found: Results) -> Lines:
    """Return how many films that freeze late or briefly ended on another orbit."""
    for start, what in (("late", "off rest"), ("rest", "from rest")):
        row = found[start]
        periods = f"{row['periods']:.0f} periods instead of {row['periods_plain']:.0f}"
        wrong = f"{len(row['wrong'])} of {row['compared']}, {periods}"
        yield f"{row['points']} films near resonance, {what}: not where plain iteration ends", wrong
    short = found["short"]
    rtols = ", ".join(_power(row["rtol"]) for row in short["steps"])
    missed = ", ".join(str(row["missed"] + row["missed_near"]) for row in short["steps"])
    compared = min(row["compared"] for row in short["steps"])
    what = f"{short['points']} films that freeze in a short passage: missed at {rtols}"
    yield what, f"{missed} of {compared}"


def _multipliers(found: Results) -> Lines:
    """Return how far multipliers are off those of central differences."""
    for box, tolerances in found.items():
        rows = {rtol: row for rtol, row in tolerances.items() if rtol != "known"}
        what = f"multipliers of {tolerances['known']} orbits, {box}: within what is allowed"
        yield f"{what}, at {', '.join(map(_power, rows))}", _percents(rows.values(), "held")
        medians = ", ".join(f"{row['error_median']:.1e}" for row in rows.values())
        worst = ", ".join(f"{row['error_max']:.1e}" for row in rows.values())
        yield "... error: medians; largest", f"{medians}; {worst}"


def _percents(rows: Iterable[Results], name: str) -> str:
    return ", ".join(f"{100 * row[name]:.1f} %" for row in rows)


def _power(rtol: str | float) -> str:
    return f"{float(rtol):.0e}"


def _extremes(found: Results) -> Lines:
    yield f"{found['points']} extremes at random", count_by_name(found["statuses"])
    alone = Counter(sorted(row["status"] for row in found["one_at_a_time"]))
    yield "... one at a time", count_by_name(alone)
    sample = found["sample"]
    held = f"{100 * sample['held']:.1f} % of {sample['compared']}, {len(sample['wrong'])}"
    yield "... within what was stated at a hundredth of the tolerance; far off", held


def _jumps(kind: str, found: Results) -> Lines:
    same = f"{found['same']} of {found['compared']}"
    fewer = f"{found['periods_plain'] / found['periods']:.2g} times fewer periods"
    yield f"{found['points']} {kind}: on the orbit of plain iteration", f"{same}, {fewer}"
    both = f"{count_by_name(found['statuses'])}; {count_by_name(found['statuses_plain'])}"
    yield "... statuses with jumps, without", both


def _watched(found: Results) -> Lines:
    for what in ("weakly_viscous", "everywhere"):
        row = found[what]
        yield f"{row['points']} films {what.replace('_', ' ')}", count_by_name(row["statuses"])
    plain, long = found["aperiodic"], found["long_cycles"]
    apart = max((film["standard_errors_apart"] for film in plain["films"]), default=0.0)
    what = f"... {len(plain['films'])} aperiodic: mean from that of plain iteration"
    yield what, f"up to {apart:.1f} standard errors"
    yield "... long cycles that still close later", f"{long['closed']} of {long['found']}"
    films, lengths = found["windows"], list(found["windows"][0]["lengths"])
    least = [min(film["lengths"][length]["covered"] for film in films) for length in lengths]
    what = f"{len(films)} wandering films, windows of {', '.join(lengths)}: covered at least"
    yield what, ", ".join(f"{value:.0%}" for value in least)


def _drifts(found: Results) -> Lines:
    for scene in found["scenes"]:
        drifts = f"{scene['drift_stress']:.1e}, {scene['drift_force']:.1e}"
        what = f"{found['periods']} periods, {scene['scene']}: drift of stress and force, balance"
        yield what, f"{drifts}, {scene['balance_after']:.1e}"
