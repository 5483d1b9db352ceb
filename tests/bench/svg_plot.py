"""Line plots as SVG text, readable on a light and on a dark page, without anything but Python's standard library.

    text = line_plot("Psi against vertices", "vertices", "Psi", [Series("refine", [(2500, 38.1), (5000, 19.3)])], log_x=True)
"""
import math
from dataclasses import dataclass, field
from html import escape

# Okabe and Ito's colours, which the colour-blind can tell apart; one of each pair for light pages, one for dark.
COLOURS = [
    ("#0072b2", "#56b4e9"),
    ("#d55e00", "#ff9a4d"),
    ("#008f6b", "#2fd6a8"),
    ("#b0478c", "#e79ac8"),
    ("#7a6a00", "#f0e442"),
]

WIDTH, HEIGHT = 720, 440
LEFT, RIGHT, TOP, BOTTOM = 74, 22, 46, 58

STYLE = """
text { font: 13px system-ui, -apple-system, "Segoe UI", sans-serif; fill: #24292f }
.title { font-size: 15px; font-weight: 600 }
.page { fill: #ffffff } .grid { stroke: #d8dee4; stroke-width: 1 } .axis { stroke: #57606a; stroke-width: 1.2; fill: none }
.level { stroke: #57606a; stroke-width: 1.5; stroke-dasharray: 2 4 } .legend { fill: #ffffff; fill-opacity: .85 }
path { fill: none; stroke-width: 2.2; stroke-linejoin: round }
%LIGHT%
@media (prefers-color-scheme: dark) {
text { fill: #e6edf3 }
.page { fill: #0d1117 } .grid { stroke: #30363d } .axis { stroke: #8b949e } .level { stroke: #9da7b1 }
.legend { fill: #0d1117 }
%DARK% }
"""


@dataclass
class Series:
    name: str
    points: list  # of (x, y)
    dashed: bool = False
    dots: bool = True


@dataclass
class Level:
    """A horizontal line, for instance what cannot be undercut."""

    name: str
    y: float


@dataclass
class Axis:
    """Maps values to pixels. `first` and `last` are the pixels of `low` and `high`."""

    low: float
    high: float
    first: float
    last: float
    log: bool = False
    ticks: list = field(default_factory=list)

    def __call__(self, value):
        low, high, value = (math.log(v) if self.log else v for v in (self.low, self.high, value))
        return self.first + (value - low) / (high - low) * (self.last - self.first)


def nice_step(span, n_wanted):
    rough = span / n_wanted
    power = 10 ** math.floor(math.log10(rough))
    return next(m * power for m in (1, 2, 2.5, 5, 10) if m * power >= rough * 0.999)


def linear_axis(values, first, last, from_zero, n_ticks):
    low, high = min(values), max(values)
    if from_zero:
        low = min(low, 0)
    if high == low:
        high = low + 1
    step = nice_step(high - low, n_ticks)
    low, high = math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step
    n = round((high - low) / step)
    return Axis(low, high, first, last, False, [low + i * step for i in range(n + 1)])


def log_axis(values, first, last):
    low, high = min(values), max(values)
    low, high = low / (high / low) ** 0.04 / 1.02, high * (high / low) ** 0.04 * 1.02
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = (1, 1.5, 2, 2.5, 3, 4, 5, 7) if high / low < 8 else (1, 2, 5) if high / low < 300 else (1,)
    ticks = [m * 10.0**d for d in decades for m in steps if low <= m * 10.0**d <= high]
    return Axis(low, high, first, last, True, ticks)


def label(value):
    if value == 0:
        return "0"
    if abs(value) >= 1000:
        return f"{value:,.0f}"
    return f"{value:.4g}"


def dots_of(series, x, y, colour):
    return [f'<circle class="f{colour}" cx="{x(a):.1f}" cy="{y(b):.1f}" r="3.2"/>' for a, b in series.points]


def path_of(series, x, y, colour):
    route = " ".join(f"{'L' if i else 'M'}{x(a):.1f},{y(b):.1f}" for i, (a, b) in enumerate(series.points))
    dash = ' stroke-dasharray="7 5"' if series.dashed else ""
    return f'<path class="s{colour}" d="{route}"{dash}/>'


def along(route):
    """Points close together along a polyline of pixels."""
    for (x0, y0), (x1, y1) in zip(route, route[1:]):
        n = 1 + int(math.hypot(x1 - x0, y1 - y0) / 4)
        yield from ((x0 + (x1 - x0) * i / n, y0 + (y1 - y0) * i / n) for i in range(n + 1))


def emptiest_corner(routes, width, height):
    """Left and top of a box of this size in the corner of the plot that hides least of the curves."""
    inset = 8
    lefts, tops = (WIDTH - RIGHT - width - inset, LEFT + inset), (TOP + inset, HEIGHT - BOTTOM - height - inset)
    corners = [(left, top) for left in lefts for top in tops]
    crowd = [pixel for route in routes for pixel in along(route)]

    def hidden(corner):
        left, top = corner
        return sum(left - 4 <= x <= left + width + 4 and top - 4 <= y <= top + height + 4 for x, y in crowd)

    return min(corners, key=hidden)


def legend(series, levels, routes):
    names = [s.name for s in series] + [level.name for level in levels]
    width, height = 52 + 7.2 * max(map(len, names)), 20 * len(names) + 8
    left, top = emptiest_corner(routes, width, height)
    parts = [f'<rect class="legend" x="{left:.0f}" y="{top}" width="{width:.0f}" height="{height}" rx="4"/>']
    for i, name in enumerate(names):
        y = top + 18 + 20 * i
        if i < len(series):
            dash = ' stroke-dasharray="7 5"' if series[i].dashed else ""
            parts.append(f'<path class="s{i % len(COLOURS)}" d="M{left + 8:.0f},{y - 4} h26"{dash}/>')
        else:
            parts.append(f'<line class="level" x1="{left + 8:.0f}" x2="{left + 34:.0f}" y1="{y - 4}" y2="{y - 4}"/>')
        parts.append(f'<text x="{left + 42:.0f}" y="{y}">{escape(name)}</text>')
    return parts


def style():
    def rules(shade):
        return "".join(f".s{i} {{ stroke: {c[shade]} }} .f{i} {{ fill: {c[shade]} }} " for i, c in enumerate(COLOURS))

    return STYLE.replace("%LIGHT%", rules(0)).replace("%DARK%", rules(1))


def line_plot(title, x_label, y_label, series, levels=(), log_x=False, log_y=False, y_from_zero=False):
    """The SVG text of a plot. Points that a logarithmic axis cannot show are left out."""
    series = [
        Series(s.name, [(a, b) for a, b in s.points if (a > 0 or not log_x) and (b > 0 or not log_y)], s.dashed, s.dots)
        for s in series
    ]
    series = [s for s in series if s.points]
    xs = [a for s in series for a, _ in s.points]
    ys = [b for s in series for _, b in s.points] + [level.y for level in levels]
    left, right, top, bottom = LEFT, WIDTH - RIGHT, TOP, HEIGHT - BOTTOM
    x = log_axis(xs, left, right) if log_x else linear_axis(xs, left, right, False, 8)
    y = log_axis(ys, bottom, top) if log_y else linear_axis(ys, bottom, top, y_from_zero, 6)
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
        f"<title>{escape(title)}</title><style>{style()}</style>",
        f'<rect class="page" width="{WIDTH}" height="{HEIGHT}" rx="6"/>',
        f'<text class="title" x="{left}" y="28">{escape(title)}</text>',
    ]
    for tick in x.ticks:
        parts.append(f'<line class="grid" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="{top}" y2="{bottom}"/>')
        parts.append(f'<text x="{x(tick):.1f}" y="{bottom + 20}" text-anchor="middle">{label(tick)}</text>')
    for tick in y.ticks:
        parts.append(f'<line class="grid" x1="{left}" x2="{right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>')
        parts.append(f'<text x="{left - 8}" y="{y(tick) + 4.5:.1f}" text-anchor="end">{label(tick)}</text>')
    parts.append(f'<path class="axis" d="M{left},{top} V{bottom} H{right}"/>')
    parts.append(f'<text x="{(left + right) / 2}" y="{HEIGHT - 14}" text-anchor="middle">{escape(x_label)}</text>')
    middle = (top + bottom) / 2
    parts.append(f'<text text-anchor="middle" transform="translate(18 {middle}) rotate(-90)">{escape(y_label)}</text>')
    for level in levels:
        parts.append(f'<line class="level" x1="{left}" x2="{right}" y1="{y(level.y):.1f}" y2="{y(level.y):.1f}"/>')
    for i, s in enumerate(series):
        parts.append(path_of(s, x, y, i % len(COLOURS)))
        if s.dots:
            parts.extend(dots_of(s, x, y, i % len(COLOURS)))
    routes = [[(x(a), y(b)) for a, b in s.points] for s in series]
    routes += [[(left, y(level.y)), (right, y(level.y))] for level in levels]
    return "\n".join(parts + legend(series, levels, routes) + ["</svg>", ""])
