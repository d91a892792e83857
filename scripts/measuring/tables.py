"""Numbers and tables of the pages."""

import statistics


def number(value, digits=3):
    """A number with `digits` significant digits and commas between thousands; a dash for None."""
    if value is None:
        return "–"
    if isinstance(value, int):
        return f"{value:,}"
    text = f"{value:.{digits}g}"
    if abs(float(text)) >= 10**digits:
        return f"{value:,.0f}"
    return f"{value:.1e}" if "e" in text else text


def ratio(value):
    return "–" if value is None else f"{value:.2f}"


def percent(value):
    return "–" if value is None else f"{number(100 * value, 2)} %"


def power(size):
    """A cubic grid: 512³."""
    return f"{size}³"


def median(values):
    return statistics.median(values)


def table(columns, rows):
    """Markdown. A column is its title, with a colon at the end where numbers stand in it."""
    lines = [
        "| " + " | ".join(title.removesuffix(":") for title in columns) + " |",
        "|" + "|".join("---:" if title.endswith(":") else "---" for title in columns) + "|",
    ]
    for row in rows:
        if len(row) != len(columns):
            raise ValueError(f"{len(row)} cells for {len(columns)} columns: {row}")
        lines.append("| " + " | ".join(str(cell) for cell in row) + " |")
    return "\n".join(lines)
