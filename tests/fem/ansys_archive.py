"""Archives of Ansys, as CDWRITE writes them, for the tests."""


def nblock(points, angles=None):
    """Return NBLOCK of points by number."""
    lines = [f"NBLOCK,6,SOLID,{max(points):10d},{len(points):10d}", "(3i9,6e21.13e3)"]
    for label, point in points.items():
        row = [*point, *(angles or {}).get(label, ())]
        lines.append(f"{label:9d}{0:9d}{0:9d}" + "".join(f"{x:21.13E}" for x in row))
    return "\n".join([*lines, "N,R5.3,LOC,       -1,"]) + "\n"


def eblock(elements):
    """Return EBLOCK of (number, type, material, real, section, system, nodes)."""
    lines = [f"EBLOCK,19,SOLID,{elements[-1][0]:10d},{len(elements):10d}", "(19i9)"]
    for label, kind, material, real, section, system, nodes in elements:
        row = [material, kind, real, section, system, 0, 0, 0, len(nodes), 0, label, *nodes]
        for k in range(0, len(row), 19):
            lines.append("".join(f"{n:9d}" for n in row[k : k + 19]))
    return "\n".join([*lines, "       -1"]) + "\n"


def rlblock(sets):
    """Return RLBLOCK of real constants by number."""
    lines = [f"RLBLOCK,{len(sets):8d},{max(sets):8d},{max(map(len, sets.values())):8d},       7"]
    lines += ["(2i8,6g16.9)", "(7g16.9)"]
    for number, values in sets.items():
        lines.append(f"{number:8d}{len(values):8d}" + "".join(f"{x:16.9G}" for x in values[:6]))
        for k in range(6, len(values), 7):
            lines.append("".join(f"{x:16.9G}" for x in values[k : k + 7]))
    return "\n".join(lines) + "\n"


def cmblock(name, kind, numbers):
    """Return CMBLOCK of a component; a negative number closes a range."""
    lines = [f"CMBLOCK,{name:<8},{kind},{len(numbers):8d}  ! users {kind.lower()} component definition", "(8i10)"]
    for k in range(0, len(numbers), 8):
        lines.append("".join(f"{n:10d}" for n in numbers[k : k + 8]))
    return "\n".join(lines) + "\n"


def material(number, **values):
    """Return MPDATA of a material."""
    return "".join(
        f"MPTEMP,R5.0, 1, 1,  0.00000000    ,\nMPDATA,R5.0, 1,{key:<4},{number:8d}, 1, {value:.9g},\n"
        for key, value in values.items()
    )


STEEL = material(1, EX=210e9, NUXY=0.3, DENS=7850.0)


def archive(types, *parts):
    """Return a whole archive; types are number to element, with key options by number behind."""
    lines = ["/COM,ANSYS RELEASE 2023 R1", "/PREP7", "/NOPR", "*IF,_CDRDOFF,EQ,1,THEN", "_CDRDOFF= ", "*ELSE"]
    lines += ["NUMOFF,NODE,      100", "*ENDIF", "DOF,DELETE"]
    for number, (element, *options) in types.items():
        lines.append(f"ET,{number:9d},{element}")
        lines += [f"KEYOP,{number:9d},{k:2d},{value:9d}" for k, value in options]
    return "\n".join(lines) + "\n" + "".join(parts) + "EXTOPT,ATTR,      0,      0,      0\n/GO\nFINISH\n"


def brick20(counts, sizes):
    """Return points by number and nodes (20,) of bricks of second order in a block, midsides as Ansys orders them."""
    number, points, cells = {}, {}, []

    def node(*at):
        if at not in number:
            number[at] = len(number) + 1
            points[number[at]] = tuple(s * a / (2 * c) for s, a, c in zip(sizes, at, counts, strict=True))
        return number[at]

    corners = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    for k in range(counts[2]):
        for j in range(counts[1]):
            for i in range(counts[0]):
                own = [(2 * i + a, 2 * j + b, 2 * k + c) for a, b, c in corners]
                middle = [tuple((p + q) // 2 for p, q in zip(own[a], own[b], strict=True)) for a, b in edges]
                cells.append([node(*at) for at in own + middle])
    return points, cells
