"""The figure and table of `accuracy.md`, and the table of README.md: errors against goals, read from the tables of verification.md.

    python3 docs/site/accuracy.py            make them again
    python3 docs/site/accuracy.py --check    fail unless the tables are those of verification.md

A row counts where goal and measured value are both percentages or both plain numbers. Several goals of a row, "1 %, 0.5 %", go with as many measured values; where there is one goal, the largest
value counts.
"""

import pathlib
import re
import sys

import images
from tidelock.plots import Plot

DOCS = pathlib.Path(__file__).resolve().parents[1]
# Marks of the generated part of the page.
BEGIN, END = "<!-- made by docs/site/accuracy.py -->", "<!-- end -->"
# Figures of README.md: what it calls them, and case, resolution and figure of their row.
HIGHLIGHTS = {
    "Poiseuille flow, Re 10: profile": ("Poiseuille, Re 10", "H/Δx 40", "largest error of the profile"),
    "stretched drop: semi-axes": ("drop", "R/Δx 40", "short and long semi-axis"),
    "standing wave, Re 250: decay, period": (
        "standing wave, Re 250, 8 periods, A/H 0.05",
        "H/Δx 100",
        "decay, period",
    ),
    "jet on a plate: force": ("jet on a plate, c₀ = 20 U", "b/Δx 10, 20, 40", "mean force over ρU²b, from 0.3 s on"),
    "cantilever of Gray et al.: period": ("cantilever", "20 across", "period"),
    "block of half the density of water, floating freely: draught": ("Draught", "0.5 free", "draught"),
    "sphere let go under water: acceleration": ("`falling_sphere`", "R/Δx 8", "acceleration after the release"),
    "round rod: torsional frequency": ("`torsion_rod`, free", "8, 12 across", "frequency"),
    "drifting body: imbalance of force across the interface, of the sum of magnitudes": (
        "The drifting-body case",
        "2 mm",
        "largest imbalance of force, of gross",
    ),
}
# Smaller shares are drawn there.
FLOOR = 1e-4
NUMBER = re.compile(r"[−+-]?\d+(?:\.\d+)?(?:e[−-]?\d+)?")


def number(text):
    return abs(float(text.replace("−", "-")))


def shares(goal, measured):
    """Measured values over their goals; empty where they cannot be compared."""
    goal, measured = goal.replace("*", "").strip(), measured.replace("*", "").strip()
    # Ranges, bounds in words and rules such as "falls" are no errors.
    if not re.fullmatch(r"[\d.,;e− %-]+", goal) or not re.fullmatch(r"[\d.,;e−+ %-]+( at worst)?", measured):
        return []
    if ("%" in goal) != ("%" in measured):
        return []
    goals = [number(n) for n in NUMBER.findall(goal)]
    values = [number(n) for n in NUMBER.findall(measured)]
    # Numbers without unit are tolerances if they are small; others are counts, orders and bounds from below.
    if not goals or not values or 0 in goals or ("%" not in goal and max(goals) > 0.01):
        return []
    if len(goals) == 1:
        return [max(values) / goals[0]]
    return [value / own for value, own in zip(values, goals)] if len(goals) == len(values) else []


def tables():
    """Section and header of each table, with each of its rows as a dictionary."""
    section, header = "", None
    for line in (DOCS / "verification.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            section = line.lstrip("# ")
        if not line.startswith("|"):
            header = None
            continue
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if header is None:
            header = cells
            yield section, header, None
        elif not set(line) <= set("|-: "):
            yield section, header, dict(zip(header, cells))


def rows():
    """Case, resolution, figure, goal, measured, largest share of all figures that can be compared."""
    found = []
    case = resolution = ""
    for section, header, row in tables():
        if row is None:
            case = resolution = ""
            continue
        figure = next(iter(row.values()))
        if {"case", "figure", "goal", "measured"} <= set(header):
            if row["case"]:
                new = row["case"].split("[")[0].strip(" ,")
                # Rows that vary the case above them.
                follows = new.startswith(("the same", "(", "with ", "depths"))
                case, resolution = f"{case.split(' – ')[0]} – {new}" if follows else new, ""
            resolution = row.get("resolution") or resolution
            judged = [(case, resolution, row["figure"], row["goal"], row["measured"])]
        elif "goal" in header:
            # A column for each resolution; those of the source paper's settings are reported and not judged.
            columns = header[header.index("goal") + 1 :]
            judged = [(section, c, figure, row["goal"], row.get(c, "")) for c in columns if "paper" not in c]
        else:
            # The goal stands in the head of a column.
            named = [(c, re.search(r"\(goal ([^)]*)\)", c)) for c in header]
            judged = [
                (section, figure, c.split("(")[0].strip(), goal.group(1), row.get(c, "").split(",")[-1])
                for c, goal in named
                if goal
            ]
        for case_, resolution_, figure_, goal, measured in judged:
            of_row = shares(goal, measured)
            if of_row:
                found.append((case_, resolution_, figure_, goal, measured, max(of_row)))
    return found


def draw(found):
    """Draws the shares and returns the size of the picture in bytes."""
    plot = Plot(7.6, 0.125 * len(found) + 0.9)
    axes = plot.add_subplot()
    labels = []
    for k, (case, resolution, figure, _, _, share) in enumerate(found):
        color = "#3a7d44" if share <= 1 else "#c0392b"
        axes.plot([FLOOR, max(share, FLOOR)], [k, k], color=color, linewidth=1, alpha=0.4)
        axes.plot(max(share, FLOOR), k, "o" if share > FLOOR else "<", color=color, markersize=4)
        label = f"{case}, {resolution}: {figure}" if resolution else f"{case}: {figure}"
        label = re.sub(r"[`*]", "", label)
        labels.append(label if len(label) < 75 else label[:72] + "...")
    axes.set_xscale("log")
    axes.axvline(1, color="black", linewidth=1)
    axes.set_yticks(range(len(found)), labels, fontsize=5)
    axes.set_ylim(len(found) - 0.4, -0.6)
    axes.set_xlabel("largest error over its goal")
    axes.grid(axis="x", alpha=0.3)
    return images.save(plot, DOCS / "pictures" / "accuracy.png", 1000)


def between_marks(page, lines):
    """Text of `page` and the same with `lines` between its marks."""
    text = page.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    return text, head + "\n".join([BEGIN, "", *lines, "", END]) + rest.split(END)[1]


def highlights(found):
    """Lines of the table of README.md."""
    measured = {row[:3]: row[4] for row in found}
    missing = [row for row in HIGHLIGHTS.values() if row not in measured]
    if missing:
        sys.exit(f"docs/site/accuracy.py: docs/verification.md has no row {missing[0]}; mend HIGHLIGHTS")
    named = [f"| {name} | {row[1]} | {measured[row].strip()} |" for name, row in HIGHLIGHTS.items()]
    return ["| case | resolution | error |", "|---|---|---|", *named]


def main():
    found = rows()
    met = sum(1 for row in found if row[-1] <= 1)
    lines = [f"{met} of {len(found)} figures that can be compared as numbers meet their goal.", ""]
    lines += ["| case | resolution | figure | goal | measured | error over goal |", "|---|---|---|---|---|---|"]
    for case, resolution, figure, goal, measured, share in found:
        shown = f"{share:.2g}" if share <= 1 else f"**{share:.2g}**"
        lines.append(f"| {case} | {resolution} | {figure} | {goal} | {measured} | {shown} |")
    pages = {DOCS / "accuracy.md": lines, DOCS.parent / "README.md": highlights(found)}
    made = {page: between_marks(page, lines) for page, lines in pages.items()}
    if sys.argv[1:] == ["--check"]:
        for page, (was, now) in made.items():
            if was != now:
                sys.exit(f"{page.name}: not the table of docs/verification.md; run `python3 docs/site/accuracy.py`")
        return
    size = draw(found)
    for page, (_, now) in made.items():
        page.write_text(now, encoding="utf-8")
    print(f"{len(found)} figures, {met} meet their goal; picture of {size} bytes")


if __name__ == "__main__":
    main()
