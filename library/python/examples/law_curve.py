"""Uniaxial curves of material laws against their closed forms, incompressible.

    PYTHONPATH=build-python/python /usr/bin/python3 library/python/examples/law_curve.py
"""
import numpy as np

import limberg


def pulled(material, stretch):
    """Cauchy stress along the pull, kPa, of stretches (n,): sideways l**-1/2, the faces there free of stress."""
    F = np.zeros((len(stretch), 3, 3))
    F[:, 0, 0] = stretch
    F[:, 1, 1] = F[:, 2, 2] = stretch ** -0.5
    cauchy = material.piola_kPa(F) @ F.transpose(0, 2, 1)  # J = 1
    return cauchy[:, 0, 0] - cauchy[:, 2, 2]  # the pressure takes the sideways stress off


CASES = [
    ("stable neo-Hookean, 60 kPa", dict(young_kPa=60, poisson=0.499),
     lambda s, mu: mu * (s ** 2 - 1 / s)),
    ("Mooney-Rivlin, 6 and 4 kPa", dict(law="mooney-rivlin", constants=dict(c10_kPa=6, c01_kPa=4)),
     lambda s, mu: 2 * (s ** 2 - 1 / s) * (6 + 4 / s)),
    ("Ogden, 3 kPa^9 and -1 kPa^-4", dict(law="ogden", constants=dict(mu_kPa=[3, -1], alpha=[9, -4])),
     lambda s, mu: 3 * (s ** 9 - s ** -4.5) - (s ** -4 - s ** 2)),
]


def main():
    stretch = np.linspace(1.0, 1.5, 11)
    worst = {}
    for name, given, closed in CASES:
        material = limberg.Material(**given)
        stress, expected = pulled(material, stretch), closed(stretch, material.mu_kPa)
        worst[name] = float(np.max(np.abs(stress - expected)) / np.max(np.abs(expected)))
        print(f"{name}: largest difference from the closed form {worst[name]:.1e} of the largest stress")
        for s, k in zip(stretch[::2], stress[::2]):
            print(f"    {s:.2f}  {k:9.3f} kPa")
    return worst


if __name__ == "__main__":
    main()
