"""Results as plain text: a line for each input and method, then the means."""

#: The figures of a line: heading, key, format.
SHAPES = [
    ("IoU", "iou", ".3f"),
    ("mean", "distance", ".2f"),
    ("largest", "largest", ".1f"),
    ("volume", "volume", ".3f"),
    ("pieces", "pieces", ".3g"),
    ("true", "true_pieces", ".3g"),
    ("Dice", "dice", ".3f"),
    ("least", "least_dice", ".3f"),
    ("seconds", "seconds", ".1f"),
]
LABELS = [
    ("Dice", "dice", ".3f"),
    ("least", "least_dice", ".3f"),
    ("voxels", "voxels", ".4f"),
    ("pieces", "pieces", ".3g"),
    ("true", "true_pieces", ".3g"),
    ("seconds", "seconds", ".1f"),
]
INPUT, METHOD, FIGURE = 16, 15, 9


def show(title, rows, columns):
    """Prints a table of rows that have an input, a method and figures."""
    if not rows:
        return
    print(f"\n{title}\n")
    headings = "".join(f"{heading:>{FIGURE}}" for heading, _, _ in columns)
    print(f"{'input':<{INPUT}}{'method':<{METHOD}}{headings}")
    previous = None
    for row in rows:
        name = row["input"] if row["input"] != previous else ""
        previous = row["input"]
        print(f"{name:<{INPUT}}{row['method']:<{METHOD}}{figures(row, columns)}")
    print()
    for method in dict.fromkeys(row["method"] for row in rows):
        mine = [row for row in rows if row["method"] == method]
        name = f"means of {len(mine)}"
        print(f"{name:<{INPUT}}{method:<{METHOD}}{figures(means(mine, columns), columns)}")


def means(rows, columns):
    """Of every figure the mean over the rows that have it."""
    mean = {}
    for _, key, _ in columns:
        known = [row[key] for row in rows if row.get(key) is not None]
        mean[key] = sum(known) / len(known) if known else None
    return mean


def figures(row, columns):
    return "".join(
        f"{'-' if row.get(key) is None else format(row[key], form):>{FIGURE}}"
        for _, key, form in columns
    )
