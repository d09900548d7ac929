#!/usr/bin/python3
"""Static beam model of the paper's wheels on a hard, frictionless floor: the independent value where CalculiX does not
converge (floor between two springs, strips or beams missing) and for the hub height over a whole turn.

Rim and beams are corotational Euler-Bernoulli finite elements (Crisfield, Non-linear Finite Element Analysis, vol. 1,
section 7.3) of the elastic line: bending, stretching, large rotations; sheets bend as plates, E / (1 - nu^2). Nothing is shared with
src/wheel: no rigid segments, no time, Newton iterations to equilibrium. AMALIA's strips, which bend across the wheel's
plane, are springs by strip.py. SI units; angles in degrees from the top, growing as the wheel rolls.

  beam_model.py OUT_DIR       writes height.csv (wheel, missing position, load, wheel angle, hub height) and deflection.csv
                              (wheel, load, drop)
"""
import argparse
import csv
import math
import pathlib

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

MODULUS, NU = 200.0e9, 0.3
FLOOR, CORNER = 2.0e7, 1.0e-6  # N/m a rim node; the law's corner is rounded over this length, m
WHEELS = {
    "amalia": {"radius": 0.09, "width": 0.07, "thickness": 0.0004, "load": 42.1,
               "springs": {"radial": 2 * 2490.0, "tangential": 2 * 2590.0, "depth": 0.0275, "turning": 2 * 0.585}},
    "t0_r0": {"radius": 0.13, "width": 0.12, "thickness": 0.0003, "load": 81.75,
              "beams": {"width": 0.05, "thickness": 0.0003, "radius": 0.04}},
}
POSITIONS = 16


def turning(angle):
    """Outward and forward unit vectors (x, z) at an angle from the top."""
    return np.array([math.sin(angle), math.cos(angle)]), np.array([math.cos(angle), -math.sin(angle)])


class Frame:
    """Nodes with x, z and a rotation about the axis that turns x towards z."""

    def __init__(self):
        self.nodes, self.elements, self.fixed, self.springs, self.rim = [], [], [], [], []

    def node(self, at):
        self.nodes.append(at)
        return len(self.nodes) - 1

    def chain(self, nodes, width, thickness):
        area, inertia = width * thickness, width * thickness ** 3 / 12.0
        for a, b in zip(nodes[:-1], nodes[1:]):
            self.elements.append((a, b, MODULUS * area, MODULUS / (1.0 - NU ** 2) * inertia))

    def close(self):
        self.rest = np.array(self.nodes)
        self.a = np.array([e[0] for e in self.elements])
        self.b = np.array([e[1] for e in self.elements])
        self.ea = np.array([e[2] for e in self.elements])
        self.ei = np.array([e[3] for e in self.elements])
        d = self.rest[self.b] - self.rest[self.a]
        self.length = np.hypot(d[:, 0], d[:, 1])
        self.direction = np.arctan2(d[:, 1], d[:, 0])
        self.dofs = np.stack([3 * self.a, 3 * self.a + 1, 3 * self.a + 2, 3 * self.b, 3 * self.b + 1, 3 * self.b + 2], 1)
        self.size = 3 * len(self.nodes)
        self.free = np.ones(self.size, bool)
        for node in self.fixed:
            self.free[3 * node:3 * node + 3] = False
        self.rim = np.array(self.rim)

    def forces(self, u, floor, half_thickness):
        """Out-of-balance force, tangent and the floor's load at displacements u (N x 3)."""
        x = self.rest + u[:, :2]
        d = x[self.b] - x[self.a]
        length = np.hypot(d[:, 0], d[:, 1])
        c, s = d[:, 0] / length, d[:, 1] / length
        turned = np.arctan2(d[:, 1], d[:, 0]) - self.direction
        t1 = u[self.a, 2] - turned
        t2 = u[self.b, 2] - turned
        t1 -= 2.0 * np.pi * np.round(t1 / (2.0 * np.pi))
        t2 -= 2.0 * np.pi * np.round(t2 / (2.0 * np.pi))
        axial = self.ea / self.length * (length - self.length)
        m1 = self.ei / self.length * (4.0 * t1 + 2.0 * t2)
        m2 = self.ei / self.length * (2.0 * t1 + 4.0 * t2)
        zero = np.zeros_like(c)
        r = np.stack([-c, -s, zero, c, s, zero], 1)
        z = np.stack([s, -c, zero, -s, c, zero], 1)
        e1, e2 = np.zeros_like(r), np.zeros_like(r)
        e1[:, 2] = e2[:, 5] = 1.0
        b1, b2 = e1 - z / length[:, None], e2 - z / length[:, None]
        q = axial[:, None] * r + m1[:, None] * b1 + m2[:, None] * b2
        outer = lambda left, right: left[:, :, None] * right[:, None, :]
        k = (self.ea / self.length)[:, None, None] * outer(r, r)
        ei = (self.ei / self.length)[:, None, None]
        k = k + ei * (4.0 * outer(b1, b1) + 2.0 * outer(b1, b2) + 2.0 * outer(b2, b1) + 4.0 * outer(b2, b2))
        k = k + (axial / length)[:, None, None] * outer(z, z)
        k = k + ((m1 + m2) / length ** 2)[:, None, None] * (outer(r, z) + outer(z, r))
        force = np.zeros(self.size)
        np.add.at(force, self.dofs.ravel(), q.ravel())
        rows = np.repeat(self.dofs, 6, axis=1).ravel()
        columns = np.tile(self.dofs, (1, 6)).ravel()
        values = k.ravel()
        extra = []
        for node, along, depth, radial, tangential, turn in self.springs:
            self.spring(u[node], node, along, depth, radial, tangential, turn, force, extra)
        gap = floor - (x[self.rim, 1] - half_thickness)
        press = np.where(gap > CORNER, FLOOR * (gap - 0.5 * CORNER), np.where(gap > 0.0, 0.5 * FLOOR * gap ** 2 / CORNER, 0.0))
        stiff = np.where(gap > CORNER, FLOOR, np.where(gap > 0.0, FLOOR * gap / CORNER, 0.0))
        force[3 * self.rim + 1] -= press
        more = np.array(extra).reshape(-1, 3)
        rows = np.concatenate([rows, more[:, 0].astype(int), 3 * self.rim + 1])
        columns = np.concatenate([columns, more[:, 1].astype(int), 3 * self.rim + 1])
        values = np.concatenate([values, more[:, 2], stiff])
        tangent = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(self.size, self.size))
        return force, tangent, press.sum()

    @staticmethod
    def spring(u, node, along, depth, radial, tangential, turn, force, extra):
        """A strip: radial at the rim, tangential at a depth that turns with the rim, and turning."""
        across = np.array([-along[1], along[0]])
        # The arm from the rim's line to the strip's centre, -depth * along, turned by the node's rotation.
        cosine, sine = math.cos(u[2]), math.sin(u[2])
        arm = -depth * (cosine * along + sine * across)
        arm_rate = -depth * (-sine * along + cosine * across)
        stretch = radial * u[:2].dot(along)
        shift = tangential * (u[:2] + arm + depth * along).dot(across)
        gradient = np.array([across[0], across[1], arm_rate.dot(across)])
        f = np.array([*(stretch * along), turn * u[2]]) + shift * gradient
        k = tangential * np.outer(gradient, gradient)
        k[:2, :2] += radial * np.outer(along, along)
        k[2, 2] += turn - shift * arm.dot(across)
        force[3 * node:3 * node + 3] += f
        extra.extend((3 * node + i, 3 * node + j, k[i, j]) for i in range(3) for j in range(3))


def build(name, angle, missing=None, rim_elements=192, beam_elements=16):
    """The wheel turned by `angle` (rad), hub at the origin; `missing` is a position without its springs or beams."""
    wheel, frame = WHEELS[name], Frame()
    for i in range(rim_elements):
        frame.rim.append(frame.node(wheel["radius"] * turning(angle + 2.0 * math.pi * i / rim_elements)[0]))
    frame.chain(frame.rim + frame.rim[:1], wheel["width"], wheel["thickness"])
    for position in range(POSITIONS):
        if position == missing:
            continue
        outward, forward = turning(angle + 2.0 * math.pi * position / POSITIONS)
        end = frame.rim[position * rim_elements // POSITIONS]
        if "springs" in wheel:
            s = wheel["springs"]
            frame.springs.append((end, outward, s["depth"], s["radial"], s["tangential"], s["turning"]))
            continue
        beam = wheel["beams"]
        for curl in (1.0, -1.0):
            nodes = []
            for k in range(beam_elements):
                s = math.pi * k / beam_elements
                r = wheel["radius"] - 2.0 * beam["radius"] + beam["radius"] * (1.0 - math.cos(s))
                nodes.append(frame.node(r * outward + curl * beam["radius"] * math.sin(s) * forward))
            frame.fixed.append(nodes[0])
            frame.chain(nodes + [end], beam["width"], beam["thickness"])
    frame.close()
    return frame


def balance(frame, u, floor, half_thickness):
    """Newton's iterations, each turning no node by more than 0.1 rad; returns displacements and load, or None."""
    free = frame.free
    for _ in range(40):
        force, tangent, load = frame.forces(u, floor, half_thickness)
        if np.linalg.norm(force[free]) < 1.0e-5:
            return u, load
        step = np.zeros(frame.size)
        step[free] = scipy.sparse.linalg.spsolve(tangent[free][:, free], -force[free])
        step = step.reshape(-1, 3)
        u = u + min(1.0, 0.1 / np.abs(step[:, 2]).max()) * step
    return None


def curve(name, angle, missing, loads, first=0.0005):
    """Rows (hub height, load): touch, every step of a rising floor, and each of the ascending `loads` (N)."""
    wheel = WHEELS[name]
    half = 0.5 * wheel["thickness"]
    frame = build(name, angle, missing)
    u = np.zeros((len(frame.nodes), 3))
    floor = frame.rest[frame.rim, 1].min() - half
    rows, step = [(-floor, 0.0)], first
    for wanted in loads:
        while abs(rows[-1][1] - wanted) > 1.0e-4:
            ahead = step
            if len(rows) > 1:
                slope = (rows[-1][1] - rows[-2][1]) / (rows[-2][0] - rows[-1][0])
                ahead = min(step, (wanted - rows[-1][1]) / slope) if slope > 0.0 else step
            done = balance(frame, u, floor + ahead, half)
            if done is None:
                step = 0.5 * abs(ahead)
                if step < 1.0e-8:
                    raise SystemExit(f"{name} at {math.degrees(angle):.2f} deg: no equilibrium beyond {rows[-1]}")
                continue
            u, load = done
            floor += ahead
            rows.append((-floor, load))
            step = min(1.5 * step, 0.002)
    return rows


def height(name, angle, missing):
    """Hub height under the wheel's load."""
    return curve(name, math.radians(angle), missing, [WHEELS[name]["load"]])[-1][0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--samples", type=int, default=2, help="angles a pitch")
    out = parser.parse_args()
    with open(out.out / "deflection.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["wheel", "load_n", "drop_m"])
        for name, wheel in WHEELS.items():
            rows = curve(name, 0.0, None, [wheel["load"], 1.5 * wheel["load"]])
            writer.writerows((name, f"{load:.6g}", f"{rows[0][0] - h:.9g}") for h, load in rows)
    with open(out.out / "height.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["wheel", "missing", "load_n", "angle_deg", "hub_height_m"])
        for name, wheel in WHEELS.items():
            pitch = 360.0 / POSITIONS
            # Mirrored at the missing position, which is at the bottom at angle 0: half a turn says all.
            for missing, turn in ((None, pitch), (8, 180.0)):
                for i in range(round(turn / pitch * out.samples) + 1):
                    angle = i * pitch / out.samples
                    value = height(name, angle, missing)
                    writer.writerow([name, "" if missing is None else missing, wheel["load"], f"{angle:.6g}", f"{value:.9g}"])
                    file.flush()


if __name__ == "__main__":
    main()
