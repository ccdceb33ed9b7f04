"""Sections of a free and of a heavy body.

A free body and a heavy one: the section of Andoyer's variables, with and without a little gravity.

Without forces l and L/G move along curves of equal energy. Gravity on a body with a fixed point keeps the energy and
the momentum about the vertical alone; so weak that it is a thirtieth of the kinetic energy, it turns the separatrix
between rotation about the long and the short axis into a belt of chaos (Galgani, Giorgilli and Strelcyn 1981, Nuovo
Cimento B 61, 1, studied it in these variables).
"""

import matplotlib.pyplot as plt
import numpy as np

import poinsot as pt

moments, energy, vertical = np.array([1.0, 1.6, 2.5]), 0.35, 0.3
body, lever = pt.Body(moments), np.array([0.6, 0.3, 0.742])


def starts(system, l, ratio):
    """States at g = 0 with l, L/G, the momentum about the vertical and the energy: G follows."""
    A, B, C = moments
    per_G2 = ((1 - ratio**2) * (np.sin(l) ** 2 / A + np.cos(l) ** 2 / B) + ratio**2 / C) / 2
    G = np.sqrt(energy / per_G2)
    for _ in range(60):
        state = pt.Andoyer(l, 0.0 * l, 0.0 * l, ratio * G, G, vertical + 0.0 * l).state()
        G = np.sqrt((energy - system.potential_energy(state)) / per_G2)
    return state


ratio = np.concatenate([np.linspace(-0.93, 0.93, 32), np.linspace(0.1, 0.7, 4), np.linspace(0.1, 0.7, 4)])
l = np.concatenate([np.full(32, 0.0), np.full(4, np.pi / 2), np.full(4, -np.pi / 2)])
figure, panels = plt.subplots(1, 2, figsize=(10, 4.8), sharey=True, layout="constrained")
spread = []
for panel, weight in zip(panels, (0.0, 0.012), strict=True):
    system = pt.System(body, pt.UniformGravity(weight, lever))
    section = pt.analysis.andoyer_section(system, starts(system, l, ratio), 6000.0, progress=False)
    states = section.motion.events[0].states
    assert np.max(np.abs(system.energy(states) - energy)) < 1e-12
    assert np.max(np.abs(states.angular_momentum_space[:, 2] - vertical)) < 1e-12
    A, B, C = moments
    D = (1 - section.y**2) * (np.sin(section.x) ** 2 / A + np.cos(section.x) ** 2 / B) + section.y**2 / C
    spread.append(np.nanmax(D, axis=1) - np.nanmin(D, axis=1))  # of 2T/G^2, which tells the curves of a free body apart
    pt.plot.section(section, ax=panel)
    panel.set_title(f"weight {weight}, energy {energy}")
panels[1].set_ylabel("")
figure.savefig("heavy_body_section.png", dpi=150)
print(
    f"2T/G^2 along a motion spreads by {np.max(spread[0]):.1e} without gravity, by up to {np.max(spread[1]):.3f} with"
)
assert np.max(spread[0]) < 1e-12
assert np.max(spread[1]) > 0.02
