#!/usr/bin/python3
"""Stiffness of one side strip of the AMALIA wheel, clamped at hub and rim, from a CalculiX shell model.

The strip is a semicircle of 27.5 mm in the plane through the axle, 0.4 mm thick, as wide as makes its radial stiffness half of
a pair's 4.98 N/mm (a plate bends: E / (1 - nu^2)). Prints the stiffness against moving its rim end radially and tangentially
and against turning it about the axle, and what that means for config/wheels/amalia.yaml. Units: mm, N.
"""
import math
import os
import subprocess
import tempfile

from wheel_decks import E_MODULUS, NU, PAIR, Deck

RADIUS, THICKNESS, MOVE = 27.5, 0.4, 0.001


def width():
    per_width = E_MODULUS * THICKNESS ** 3 / (12.0 * (1.0 - NU ** 2))
    return PAIR / 2 * RADIUS ** 3 * (math.pi / 2 - 4 / math.pi) / per_width


def move(mode, along=32, across=8):
    """Force (x tangential, z radial) and moment about the axle at the rim end per unit of motion."""
    deck, grid = Deck(), {}
    for i in range(2 * along + 1):
        s = math.pi * i / (2 * along)
        for j in range(2 * across + 1):
            if not (i % 2 and j % 2):
                x = width() * (j / (2 * across) - 0.5)
                grid[i, j] = deck.node(x, RADIUS * math.sin(s), RADIUS * (1 - math.cos(s)))
    for i in range(0, 2 * along, 2):
        for j in range(0, 2 * across, 2):
            corners = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
            deck.elements.append(("S8R", [grid[i + a, j + b] for a, b in corners], "STRIP"))
    deck.sections.append(("shell", "STRIP", 0.0, THICKNESS, None))
    lines = ""
    for j in range(2 * across + 1):
        deck.fix(grid[0, j], 1, 2, 3, 4)
        node = grid[2 * along, j]
        deck.hub.append(node)
        deck.fix(node, 4)
        x = deck.nodes[node - 1][0]
        motion = {"radial": (0, 0, MOVE), "tangential": (MOVE, 0, 0), "turning": (0, 0, -MOVE * x)}[mode]
        lines += "".join(f"{node},{k + 1},{k + 1},{motion[k]}\n" for k in range(3))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "strip.inp")
        deck.write(path, 0.0, 1)
        with open(path) as file:
            text = file.read().replace("*STEP, NLGEOM", "*STEP").replace("HUB,3,3,-0\n", lines)
        with open(path, "w") as file:
            file.write(text.replace(", TOTALS=ONLY", ""))
        subprocess.run(["ccx", "strip"], cwd=folder, capture_output=True, check=True)
        force_x = force_z = moment = 0.0
        with open(os.path.join(folder, "strip.dat")) as file:
            for words in (line.split() for line in file):
                if len(words) == 4 and words[0].isdigit():
                    fx, fz = float(words[1]), float(words[3])
                    force_x += fx / MOVE
                    force_z += fz / MOVE
                    moment -= deck.nodes[int(words[0]) - 1][0] * fz / MOVE
    return force_x, force_z, moment


def main():
    radial = move("radial")[1]
    tangential, _, coupling = move("tangential")
    turning = move("turning")[2]
    depth = -coupling / tangential
    print(f"width {width():.2f} mm")
    print(f"radial_stiffness {1e3 * radial:.0f} N/m")
    print(f"tangential_stiffness {1e3 * tangential:.0f} N/m at a depth of {1e-3 * depth:.4f} m")
    print(f"turning_stiffness {1e-3 * (turning - tangential * depth ** 2):.3f} N m/rad")


if __name__ == "__main__":
    main()
