"""String stability: how much of an error passes from robot to robot along a chain with delay."""

import numpy as np


def link_gain(omega, gain, tau, delayed="difference"):
    """Return ``|G(j omega)|`` [-] from a robot to the one that follows it, ``omega`` [rad/s] any shape.

    ``delayed = "difference"``, ``e_i' = kappa (e_j - e_i)(t - tau)``:
    ``G = kappa e^(-s tau)/(s + kappa e^(-s tau))``; at most 1 at all frequencies iff
    ``2 kappa tau <= 1``, since ``|s + kappa e^(-s tau)|^2 = kappa^2 + omega (omega - 2 kappa sin(omega
    tau))``.  ``"state"``, ``e_i' = kappa (e_j(t - tau) - e_i)``: ``kappa/|j omega + kappa|``, never above
    1.  Compare Seiler, Pant and Hedrick, "Disturbance propagation in vehicle strings", 2004.
    """
    s = 1j * np.asarray(omega, dtype=float)
    late = gain * np.exp(-s * tau)
    return np.abs(late / (s + (late if delayed == "difference" else gain)))


def held_link_gain(omega, gain, period, steps, delayed="difference"):
    """Return ``|G|`` [-] as :func:`held_link` has it."""
    return np.abs(held_link(omega, gain, period, steps, delayed))


def held_link(omega, gain, period, steps, delayed="difference"):
    """Return G (complex) where commands are held for ``period`` [s] and tau is so many ``steps``.

    ``z - 1 = a z^-d (...)``, ``a = kappa Tc``, ``z = e^(j omega Tc)``.
    """
    z, a = np.exp(1j * np.asarray(omega, dtype=float) * period), gain * period
    late = a * z ** (-steps)
    return late / (z - 1.0 + (late if delayed == "difference" else a))


def worst_frequency(gain, tau, delayed="difference"):
    """Return ``(omega [rad/s], |G|)`` where a robot passes on most; (0, 1) if none is above 1."""
    omega = np.linspace(1e-3, 4.0, 8000) * gain
    found = link_gain(omega, gain, tau, delayed)
    row = int(np.argmax(found))
    return (float(omega[row]), float(found[row])) if found[row] > 1.0 + 1e-9 else (0.0, 1.0)


def amplitudes(time, values, omega):
    """Return the amplitudes (n,) of ``values`` (m, n) at ``omega`` [rad/s], by least squares."""
    return np.abs(phasors(time, values, omega))


def phasors(time, values, omega):
    """Return c (n,) complex of the part ``Im c e^(j omega t)`` of ``values`` (m, n), by least squares."""
    base = np.column_stack([np.sin(omega * time), np.cos(omega * time), np.ones_like(time)])
    found = np.linalg.lstsq(base, values, rcond=None)[0]
    return found[0] + 1j * found[1]
