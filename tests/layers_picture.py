"""The picture of tests/layers.py: which folder may include which, as an SVG. An arrow goes from a folder to
one that it may include. Within a panel, an include that other arrows imply has no arrow; between panels there is
one arrow, with the names of the folders it may go to.
"""

import html
import itertools

BOX_W, BOX_H, GAP_X, GAP_Y, PAD, TITLE = 104, 26, 14, 30, 16, 26
INK, BOX, LINE, BORDER = "#1f2a37", "#d5e3f2", "#8a94a0", "#9aa4af"
MERGED = {"model/train"}  # one box for the folder and those below it
NAMES = {"daemon": "supervisor, main"}
BETWEEN = 225             # the columns, for arrows and their names


def box_of(row):
    return next((folder for folder in MERGED if row.startswith(folder + "/")), row)


def panel_of(box):
    top = box.partition("/")[0]
    return "clients and sim" if top in ("clients", "sim") else top


def graph(rows):
    """{box: boxes that it may include}, of `rows`: {folder: folders that it may include}."""
    boxes = list(dict.fromkeys(map(box_of, rows)))
    below = {box: {other for other in boxes if other == box or other.startswith(box + "/")} for box in boxes}
    edges = {box: set() for box in boxes}
    for row, allowed in rows.items():
        for name in allowed.split():
            # A name stands for the folders below it, too; a folder without a row belongs to the row above it.
            named = below.get(box_of(name)) or {other for other in boxes if other.startswith(name + "/")}
            known = max((box for box in boxes if name.startswith(box + "/")), key=len, default=None)
            edges[box_of(row)] |= named or ({known} if known else set())
    return {box: others - {box} for box, others in edges.items()}


def reached(edges, box):
    found, todo = set(), list(edges[box])
    while todo:
        other = todo.pop()
        if other not in found:
            found.add(other)
            todo += edges[other]
    return found


def reduced(edges):
    """Without edges that other edges imply."""
    return {box: {other for other in others if not any(other in reached(edges, via) for via in others - {other})}
            for box, others in edges.items()}


class Panel:
    """Boxes in rows, each above those that it includes, and the lines between them."""

    def __init__(self, title, edges):
        self.title = title
        self.edges = reduced(edges)
        depths = {}

        def depth(box):
            if box not in depths:
                depths[box] = 1 + max(map(depth, self.edges[box]), default=-1)
            return depths[box]
        top = max(map(depth, self.edges))
        # A line that passes rows has a place in each of them: (from, to, row) beside boxes.
        self.rows = [[box for box in self.edges if depths[box] == top - at] for at in range(top + 1)]
        self.lines = []
        for box, others in self.edges.items():
            for other in sorted(others):
                first, last = top - depths[box], top - depths[other]
                way = [box] + [(box, other, at) for at in range(first + 1, last)] + [other]
                for at in range(first + 1, last):
                    self.rows[at].append(way[at - first])
                self.lines.append(way)
        self.order()
        widths = [self.places(row)[1] for row in self.rows]
        self.width = max([*widths, 9 * len(title)]) + 2 * PAD
        self.height = TITLE + len(self.rows) * (BOX_H + GAP_Y) - GAP_Y + 2 * PAD

    def order(self):
        """Exchanges two places of a row wherever that makes the lines shorter, until it does nowhere."""
        pairs = [pair for way in self.lines for pair in zip(way, way[1:])]

        def length():
            centre = {}
            for row in self.rows:
                places, width = self.places(row)
                centre |= {item: x + wide / 2 - width / 2 for item, (x, wide) in places.items()}
            return sum((centre[a] - centre[b]) ** 2 for a, b in pairs)
        best, better = length(), True
        while better:
            better = False
            for row in self.rows:
                for i, j in itertools.combinations(range(len(row)), 2):
                    row[i], row[j] = row[j], row[i]
                    if length() < best:
                        best, better = length(), True
                    else:
                        row[i], row[j] = row[j], row[i]

    @staticmethod
    def places(row):
        """{item: (left, width)} from 0 on, and the width of all."""
        x, found = 0, {}
        for item in row:
            width = BOX_W if isinstance(item, str) else 4
            found[item] = (x, width)
            x += width + GAP_X
        return found, x - GAP_X

    def draw(self, left, top):
        out = [f"<rect x='{left}' y='{top}' width='{self.width}' height='{self.height}' rx='10' fill='none' "
               f"stroke='{BORDER}' stroke-width='1.5'/>",
               f"<text x='{left + PAD}' y='{top + 24}' font-size='15' font-weight='bold' fill='{LINE}'>"
               f"{html.escape(self.title)}</text>"]
        at, boxes = {}, []
        for number, row in enumerate(self.rows):
            places, width = self.places(row)
            y = top + TITLE + PAD + number * (BOX_H + GAP_Y)
            for item, (x, wide) in places.items():
                x += left + (self.width - width) / 2
                at[item] = (x + wide / 2, y, y + BOX_H)
                if isinstance(item, str):
                    name = NAMES.get(item) or item.partition("/")[2] or item
                    boxes += [f"<rect x='{x:.0f}' y='{y}' width='{BOX_W}' height='{BOX_H}' rx='5' fill='{BOX}'/>",
                              f"<text x='{x + BOX_W / 2:.0f}' y='{y + 17}' font-size='12' text-anchor='middle' "
                              f"fill='{INK}'>{html.escape(name)}</text>"]
        for way in self.lines:
            points = [f"{at[way[0]][0]:.0f},{at[way[0]][2]}"]
            for item in way[1:-1]:
                points += [f"{at[item][0]:.0f},{at[item][1]}", f"{at[item][0]:.0f},{at[item][2]}"]
            points.append(f"{at[way[-1]][0]:.0f},{at[way[-1]][1] - 5}")
            out.append(line("M" + "L".join(points), 1.2))
        return out + boxes


def line(path, width):
    return f"<path d='{path}' fill='none' stroke='{LINE}' stroke-width='{width}' marker-end='url(#arrow)'/>"


def may(edges, panel, other):
    """The names of `other`'s boxes that those of `panel` may include; all: "all"; none: ""."""
    every = {box for box in edges if panel_of(box) == other}
    named = {to for box, others in edges.items() if panel_of(box) == panel for to in others} & every
    return "all" if named == every else ", ".join(sorted(name.partition("/")[2] for name in named))


def picture(rows):
    """The SVG of {folder: folders that it may include}; tests/ may include all and is not in it."""
    edges = graph({row: allowed for row, allowed in rows.items() if row != "tests"})
    for box in edges:
        if box in reached(edges, box):
            raise ValueError(f"tests/layers_picture.py: {box} may include itself, by way of others")
    panels = {}
    for name in ("daemon", "clients and sim", "proto", "model"):
        inside = [box for box in edges if panel_of(box) == name]
        panels[name] = Panel(name, {box: edges[box] & set(inside) for box in inside})
    lost = {panel_of(box) for box in edges} - set(panels)
    if lost:
        raise ValueError(f"tests/layers_picture.py: no panel for {', '.join(sorted(lost))}")
    left, right = ("clients and sim", "daemon"), ("proto", "model")
    column = max(panels[name].width for name in left) + BETWEEN
    place = {}
    for x, names in ((1, left), (column, right)):
        y = 1
        for name in names:
            place[name] = (x, y)
            y += panels[name].height + GAP_Y + BOX_H
    width = column + max(panels[name].width for name in right) + 1
    height = max(y + panels[name].height for name, (_, y) in place.items()) + 1
    out = [f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' width='{width}' "
           f"height='{height}' font-family='sans-serif'>",
           "<title>Who may include whom</title><desc>Written by tests/layers.py --write</desc>",
           "<defs><marker id='arrow' viewBox='0 0 8 8' refX='4' refY='4' markerWidth='6' markerHeight='6' "
           f"markerUnits='userSpaceOnUse' orient='auto'><path d='M0,0L8,4L0,8Z' fill='{LINE}'/></marker></defs>"]
    for name, (x, y) in place.items():
        out += panels[name].draw(x, y)
    for a, b in itertools.permutations(place, 2):
        names = may(edges, a, b)
        if names:
            out += between(place[a], panels[a], place[b], panels[b], names)
    return "\n".join([*out, "</svg>", ""])


def between(a_at, a, b_at, b, names):
    """The arrow from one panel to another one, beside it or below it, and what it may go to."""
    if a_at[0] == b_at[0]:
        if a_at[1] > b_at[1]:
            raise ValueError(f"tests/layers_picture.py: {a.title} includes {b.title}, which is above it")
        x, begin, end = a_at[0] + 60, a_at[1] + a.height, b_at[1] - 5
        return [line(f"M{x},{begin}V{end}", 2), label(x + 10, (begin + end) / 2 + 4, names)]
    x, end = a_at[0] + a.width, b_at[0] - 5
    # As level as both panels allow; not in the first row, which has the titles.
    y = min(max(a_at[1], b_at[1]) + TITLE + BOX_H, a_at[1] + a.height - PAD)
    y_end = max(y, b_at[1] + TITLE + PAD)
    beside = 24 / (y_end - y) * (end - x) if y_end > y else 0
    return [line(f"M{x},{y}L{end},{y_end}", 2), label(x + 8 + beside, y + (20 if beside else -6), names)]


def label(x, y, text):
    return f"<text x='{x:.0f}' y='{y:.0f}' font-size='11' fill='{LINE}'>{html.escape(text)}</text>"
