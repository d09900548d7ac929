#!/usr/bin/python3
"""CalculiX models of the paper's two wheels standing on a hard floor: independent of src/wheel.

Half a wheel (symmetry about the vertical plane through the axle), AMALIA also half in width. Large deflections.
The hub, rigid, is pressed down by a prescribed displacement; every node of the rim near the floor has a spring to the
ground that is slack until the node reaches the floor. Units: mm, N, MPa.

  wheel_decks.py NAME OUT.csv [--rim beam|shell] [--drop MM] [--changed POSITION --factor F]

writes the deck, runs ccx and writes hub drop (m) and load (N).
"""
import argparse
import csv
import math
import os
import shutil
import subprocess
import tempfile

E_MODULUS, NU = 200000.0, 0.3
CONTACT = 5.0e3  # N/mm a node
PAIR = 4.98  # N/mm, radial stiffness of the two strips of a position (paper, Section 6.2)
NAMES = ("amalia", "t0_r0")


class Deck:
    def __init__(self):
        self.nodes, self.elements, self.sections, self.boundary, self.springs = [], [], [], [], []
        self.hub = []

    def node(self, x, y, z):
        self.nodes.append((x, y, z))
        return len(self.nodes)

    def beam(self, chain, width, thickness, normal, name):
        """Quadratic beam elements along a chain of nodes (odd count); width along `normal`."""
        first = len(self.elements) + 1
        for i in range(0, len(chain) - 2, 2):
            self.elements.append(("B32R", chain[i:i + 3], name))
        self.sections.append(("beam", name, width, thickness, normal))
        return first

    def fix(self, node, *dofs):
        for dof in dofs:
            self.boundary.append((node, dof))

    def write(self, path, drop, increments):
        # A spring hangs on a node far below, so that it stays upright and does not resist along the floor.
        feet = []
        for node, _, _ in self.springs:
            x, y, z = self.nodes[node - 1]
            feet.append(self.node(x, y, z - 1.0e5))
            self.fix(feet[-1], 1, 2, 3)
        with open(path, "w") as out:
            out.write("*NODE, NSET=ALL\n")
            for i, (x, y, z) in enumerate(self.nodes, 1):
                out.write(f"{i},{x:.9g},{y:.9g},{z:.9g}\n")
            for i, (kind, nodes, name) in enumerate(self.elements, 1):
                out.write(f"*ELEMENT, TYPE={kind}, ELSET={name}\n{i},{','.join(map(str, nodes))}\n")
            number = len(self.elements)
            for (node, gap, share), foot in zip(self.springs, feet):
                number += 1
                out.write(f"*ELEMENT, TYPE=SPRINGA, ELSET=F{number}\n{number},{foot},{node}\n")
                out.write(f"*SPRING, ELSET=F{number}, NONLINEAR\n")
                # A tenth of the stiffness over the first 2 um: a sharp corner of the law keeps Newton from converging.
                k, soft = CONTACT * share, 0.002
                out.write(f"{-k * (0.1 * soft + 10.0):.6f},{-gap - soft - 10.0:.9f}\n")
                out.write(f"{-k * 0.1 * soft:.6f},{-gap - soft:.9f}\n")
                out.write(f"0.,{-gap:.9f}\n1.e-9,{-gap + 1000.0:.9f}\n")
            out.write(f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{E_MODULUS},{NU}\n")
            for kind, name, width, thickness, normal in self.sections:
                if kind == "beam":
                    out.write(f"*BEAM SECTION, ELSET={name}, MATERIAL=STEEL, SECTION=RECT\n")
                    out.write(f"{width:.9g},{thickness:.9g}\n{normal[0]:.9g},{normal[1]:.9g},{normal[2]:.9g}\n")
                else:
                    out.write(f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL\n{thickness:.9g}\n")
            out.write("*NSET, NSET=HUB\n" + ",\n".join(map(str, self.hub)) + "\n")
            out.write("*BOUNDARY\n")
            for node, dof in self.boundary:
                out.write(f"{node},{dof},{dof}\n")
            out.write("*STEP, NLGEOM, INC=1000\n*STATIC\n")
            out.write(f"{1.0 / increments:.9g},1.,1.e-6,{1.0 / increments:.9g}\n*BOUNDARY\nHUB,3,3,{-drop:.9g}\n")
            out.write("*NODE PRINT, NSET=HUB, TOTALS=ONLY\nRF\n*END STEP\n")


def radial(angle):
    """Unit vectors at an angle from the bottom, growing towards +x: outward, tangential."""
    return (math.sin(angle), -math.cos(angle)), (math.cos(angle), math.sin(angle))


def beam_rim(deck, radius, width, thickness, elements):
    """Half a ring of beams from bottom to top in the plane y = 0."""
    chain = []
    for i in range(2 * elements + 1):
        angle = math.pi * i / (2 * elements)
        (ox, oz), _ = radial(angle)
        chain.append(deck.node(radius * ox, 0.0, radius * oz))
        deck.fix(chain[-1], 2)
    deck.beam(chain, width, thickness, (0.0, 1.0, 0.0), "RIM")
    for end in (chain[0], chain[-1]):
        deck.fix(end, 1, 5)
    return chain


def floor(deck, nodes, radius, reach, share):
    for node in nodes:
        x, _, z = deck.nodes[node - 1]
        if z < 0 and math.atan2(x, -z) < reach:
            deck.springs.append((node, z + radius, share(node)))


def positions():
    """Half the wheel's strips or beams: (number from the bottom, angle, in the plane of symmetry)."""
    return [(k, math.pi * k / 8, k in (0, 8)) for k in range(9)]


def amalia(rim, changed, factor):
    """Rim 180 mm by 70 mm, 0.4 mm sheet; a strip from hub to rim at 16 positions on each side, bent to a semicircle of
    27.5 mm in the plane through the axle, as wide as makes a pair's radial stiffness 4.98 N/mm, clamped at both ends."""
    radius, half_width, t, a = 90.0, 35.0, 0.4, 27.5
    per_width = E_MODULUS * t ** 3 / (12.0 * (1.0 - NU ** 2))
    strip = PAIR / 2 * a ** 3 * (math.pi / 2 - 4 / math.pi) / per_width
    deck = Deck()
    elements = 64
    if rim == "beam":
        chain = beam_rim(deck, radius, half_width, t, elements)
        edge = {i: chain[i] for i in range(2 * elements + 1)}
        floor(deck, chain, radius, 0.6, lambda n: 1.0)
        y0 = 0.0
    else:
        across = 6
        grid = {}
        for i in range(2 * elements + 1):
            angle = math.pi * i / (2 * elements)
            (ox, oz), _ = radial(angle)
            for j in range(2 * across + 1):
                if i % 2 and j % 2:
                    continue
                grid[i, j] = deck.node(radius * ox, half_width * j / (2 * across), radius * oz)
        for i in range(0, 2 * elements, 2):
            for j in range(0, 2 * across, 2):
                nodes = [grid[i, j], grid[i + 2, j], grid[i + 2, j + 2], grid[i, j + 2], grid[i + 1, j],
                         grid[i + 2, j + 1], grid[i + 1, j + 2], grid[i, j + 1]]
                deck.elements.append(("S8R", nodes, "RIM"))
        deck.sections.append(("shell", "RIM", 0.0, t, None))
        for (i, j), node in grid.items():
            if i in (0, 2 * elements):
                deck.fix(node, 1, 5, 6)
            if j == 0:
                deck.fix(node, 2, 4, 6)
        floor(deck, grid.values(), radius, 0.6, lambda n: 0.2)
        edge = {i: grid[i, 2 * across] for i in range(0, 2 * elements + 1)}
        y0 = half_width
    for position, angle, in_plane in positions():
        share = 0.5 if in_plane else 1.0
        if position == changed:
            share *= factor
        if share == 0.0:
            continue
        (ox, oz), (tx, tz) = radial(angle)
        end = edge[round(2 * elements * angle / math.pi)]
        chain = []
        pieces = 48
        for k in range(pieces + 1):
            s = math.pi * k / pieces
            r = radius - 2 * a + a * (1 - math.cos(s))
            y = y0 + a * math.sin(s)
            chain.append(end if k == pieces else deck.node(r * ox, y, r * oz))
        # A strip in the plane of symmetry counts half; a softer one is thinner in width.
        deck.beam(chain, strip * share, t, (tx, 0.0, tz), f"STRIP{position}")
        # A clamp holds the whole section of the strip, warping too: the stub across makes the joint rigid.
        r, s0 = radius - 2 * a, 2.0
        stub = [deck.node(r * ox + k * s0 * tx, y0, r * oz + k * s0 * tz) if k else chain[0] for k in (-1, 0, 1)]
        deck.beam(stub, half_width, t, (0.0, 1.0, 0.0), f"STUB{position}")
        for node in stub:
            deck.hub.append(node)
            deck.fix(node, 1, 2, 4, 5, 6)
        if rim == "beam":
            deck.fix(end, 4, 6)
        if in_plane:
            for node in chain[1:-1]:
                deck.fix(node, 1)
    return deck, 4.0


def t0_r0(rim, changed, factor):
    """Rim 260 mm by 120 mm, 0.3 mm sheet; at 16 positions two semicircular beams of 40 mm radius and 50 mm width in the
    wheel's plane, curled to opposite sides, clamped at both ends."""
    if rim != "beam":
        raise SystemExit("t0_r0 has a rim of beams only")
    radius, width, t, a, beam_width = 130.0, 120.0, 0.3, 40.0, 50.0
    deck = Deck()
    elements = 64
    chain = beam_rim(deck, radius, width, t, elements)
    floor(deck, chain, radius, 0.9, lambda n: 1.0)
    for position, angle, in_plane in positions():
        share = factor if position == changed else 1.0
        if share == 0.0:
            continue
        (ox, oz), (tx, tz) = radial(angle)
        end = chain[round(2 * elements * angle / math.pi)]
        for curl in (1.0, -1.0):
            # Of the two beams in the plane of symmetry the half wheel keeps the one on its side.
            if in_plane and curl * (4 - position) < 0:
                continue
            nodes = []
            pieces = 48
            for k in range(pieces + 1):
                s = math.pi * k / pieces
                r, side = radius - 2 * a + a * (1 - math.cos(s)), curl * a * math.sin(s)
                nodes.append(end if k == pieces else deck.node(r * ox + side * tx, 0.0, r * oz + side * tz))
            deck.beam(nodes, beam_width * share, t, (0.0, 1.0, 0.0), f"BEAM{position}{'P' if curl > 0 else 'M'}")
            for node in nodes[:-1]:
                deck.fix(node, 2)
            deck.hub.append(nodes[0])
            deck.fix(nodes[0], 1, 4, 5, 6)
    return deck, 2.0


def run(name, rim, drop, increments, changed=-1, factor=1.0):
    """Rows of hub drop (m) and load (N)."""
    deck, copies = {"amalia": amalia, "t0_r0": t0_r0}[name](rim, changed, factor)
    folder = tempfile.mkdtemp(prefix="wheel_ccx_")
    try:
        deck.write(os.path.join(folder, "wheel.inp"), drop, increments)
        environment = dict(os.environ, OMP_NUM_THREADS="1")
        done = subprocess.run(["ccx", "wheel"], cwd=folder, env=environment, capture_output=True, text=True)
        rows = [(0.0, 0.0)]
        time = None
        path = os.path.join(folder, "wheel.dat")
        for line in open(path) if os.path.exists(path) else ():
            words = line.split()
            if "time" in words:
                time = float(words[-1])
            elif len(words) == 3 and time is not None:
                rows.append((1e-3 * drop * time, -copies * float(words[2])))
        if done.returncode != 0 or len(rows) < 2 or time < 0.999:
            raise SystemExit(f"ccx stopped at {time}:\n" + done.stdout[-1500:] + done.stderr[-500:])
        return rows
    finally:
        shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=NAMES)
    parser.add_argument("out")
    parser.add_argument("--rim", choices=("beam", "shell"), default="beam")
    parser.add_argument("--drop", type=float, help="mm")
    parser.add_argument("--increments", type=int, default=20)
    parser.add_argument("--changed", type=int, default=-1, metavar="POSITION", help="from the bottom")
    parser.add_argument("--factor", type=float, default=1.0, help="on the stiffness of the changed position")
    arguments = parser.parse_args()
    drop = arguments.drop or {"amalia": 4.0, "t0_r0": 16.0}[arguments.name]
    rows = run(arguments.name, arguments.rim, drop, arguments.increments, arguments.changed, arguments.factor)
    with open(arguments.out, "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(["drop_m", "load_n"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
