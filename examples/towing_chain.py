"""A chain of six links, hung by both ends from one place, is towed by one end: Kane's equations with multipliers
eliminated.

Problem: what shapes does the chain take, and with which force is it towed?

           fixed o  -> a = 4 ft/s2            o----___                         o-__
                 ||                            \\      ---o  ->                    --__
                 ||  6 links of 1 ft,           \\     /                              --__
                 ||  1 slug each                 o---o                                   --o  ->
                 ||
                  t = 0                        later                             nearly taut, t = 1.7 s

Data: Wang & Huston, Computers & Structures 29 (1988) 331-338: six links, 1 ft and 1 slug each, an end accelerated by
4 ft/s2, both ends together at the start and the links hanging. Folded like this the chain is singular: the equation
of the end's height has no gradient, no motion has the accelerations that Newton's law asks for, and `flexmb.check`
names it. So the links start a little opened.

Formula: with the rates u of the joints as generalised speeds, M u' = Q + A^T lam and A u' = b; N spans the null space
of A, and N^T M (u0 + N z') = N^T Q with A u0 = b has no multipliers. `flexmb.equations` shows the arrays.
Expected: an integration of its own in the angles of the links (tests/examples/test_towing_chain.py).
"""

import numpy as np

import flexmb as fmb

FOOT, SLUG = 0.3048, 14.593903  # m, kg
LINKS, LENGTH, MASS, ACCELERATION, GRAVITY = 6, FOOT, SLUG, 4.0 * FOOT, 9.80665
RADIUS = 1e-3  # m, of a link
OPENED = 0.1  # degrees
DURATION = 1.6  # s


def chain(opened=OPENED):
    """Return the chain, its links turned by so many degrees from the vertical."""
    angles = np.radians([-90.0 + opened] * 3 + [90.0 - opened] * 3)
    points = np.zeros((LINKS + 1, 3))
    points[1:, :2] = LENGTH * np.cumsum(np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
    links = [
        fmb.RigidBody.rod(
            f"link {k}", length=LENGTH, mass=MASS, radius=RADIUS, at=points[k], rotation=(0, 0, angles[k])
        )
        for k in range(LINKS)
    ]
    ends = ["ground.origin"] + [f"link {k}.end" for k in range(LINKS)]
    pins = [fmb.Revolute(f"pin {k}", markers=(ends[k], f"link {k}.start")) for k in range(LINKS)]
    end = fmb.Position("p", marker=ends[-1])
    numbers = {"x": float(points[-1, 0]), "a": ACCELERATION}
    tow = [
        fmb.Constraint("tow", over=[end], equation="p[0] = x + 0.5*a*t**2", parameters=numbers),
        fmb.Constraint("height", over=[end], equation="p[1] = 0"),
    ]
    return fmb.Model(
        name="towing chain",
        bodies=[fmb.Ground(), *links],
        joints=[*pins, *tow],
        gravity=(0, -GRAVITY, 0),
        sensors=[
            *(fmb.Position(f"p{k}", marker=ends[k]) for k in range(LINKS + 1)),
            fmb.Multiplier("pull", joint="tow"),
            fmb.Multiplier("lift", joint="height"),
        ],
    )


def run(samples=17, opened=OPENED, integrator=None):
    """Return the motion; by default Kane's equations with the null space, in closed form."""
    how = integrator or fmb.Explicit(formulation=fmb.NullSpace())
    return fmb.simulate(chain(opened), DURATION, samples=samples, integrator=how)


def shapes(motion):
    """Return the places of the ends of all links in the plane, (nt, 7, 2), m."""
    return np.stack([motion[f"p{k}"][:, :2] for k in range(LINKS + 1)], axis=1)


def without_multipliers(arrays):
    """Return u' by the orthogonal complement: M (u0 + N z') and Q multiplied by N^T, where A u0 = b."""
    N, first = arrays.complement, arrays.A_pinv @ arrays.b
    return first + N @ np.linalg.solve(N.T @ arrays.M @ N, N.T @ (arrays.Q - arrays.M @ first))


def bookkeeping(arrays, name="link 0"):
    """Return what Euler parameters add for one body: p, p', its 4 x 4 block of mass, and row and right-hand side of
    p . p'' = -p' . p'.
    """
    k = [arrays.names.index(f"{name}.p{i}'") for i in range(4)]
    row = arrays.equation_names.index(f"{name}: |p| = 1")
    return arrays.A[row, k], arrays.u[k], arrays.M[np.ix_(k, k)], arrays.A[row], float(arrays.b[row])


def main():
    """Print what is singular, the arrays at the start, and shapes and forces; return the greatest pull, N."""
    print(f"folded: {fmb.check(chain(0.0)).singular}")
    arrays = fmb.equations(chain()).in_joint_coordinates()
    N = arrays.complement
    with np.printoptions(precision=4, suppress=True, linewidth=110):
        print(f"rates {arrays.names}\nM =\n{arrays.M}\nQ = {arrays.Q}\nA =\n{arrays.A}\nb = {arrays.b}\nN =\n{N}")
        u = without_multipliers(arrays)
        print(f"u' = {u} rad/s2, A u' - b = {arrays.A @ u - arrays.b}")
        turned = fmb.equations(chain()).in_euler_parameters()
        p, _, block, _, _ = bookkeeping(turned)
        same = np.abs(turned.B @ without_multipliers(turned) - arrays.B @ u + turned.Bdot_u - arrays.Bdot_u).max()
        print(f"in Euler parameters: M {turned.M.shape} of rank {np.linalg.matrix_rank(turned.M)}, A {turned.A.shape}")
        print(f"first link: p = {p}, its mass\n{block}\naccelerations of all links differ by {same:.1e}")
        motion = run()
        for t, shape, pull, lift in zip(motion.t, shapes(motion), motion["pull"], motion["lift"], strict=True):
            print(f"{t:.1f} s  x {shape[1:, 0]}  y {shape[1:, 1]}  pull {pull:8.1f} N  lift {lift:8.1f} N")
    return float(np.abs(motion["pull"]).max())


if __name__ == "__main__":
    main()
