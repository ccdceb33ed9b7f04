"""The heavy symmetric top in closed form, by theta functions with 60 digits; knows nothing of poinsot.

A, A, C are the moments about the fixed point, the centre of mass is at l on the third body axis, gravity acts along
-s3, and P = M g l > 0. With p = C omega3 along the axis of the body, G along s3 and e the energy without p^2/(2 C),
u = cos(theta) solves

    u'^2 = f(u) = 2 (e - P u)(1 - u^2)/A - (G - p u)^2/A^2,    u1 <= u <= u2 <= 1 <= u3 the roots,

so u = u1 + (u2 - u1) sn^2(s), s' = mu. The Cayley-Klein parameters alpha = q0 + i q3 and beta = q1 + i q2 have
|alpha|^2 = (1 + u)/2, |beta|^2 = (1 - u)/2, and from q' = q (0, omega)/2 follows

    2 alpha'/alpha = i (omega3 - p/A) + (u' + i (G + p)/A)/(u + 1),
    2 beta'/beta   = i (p/A - omega3) + (u' - i (G - p)/A)/(u - 1).

Each last term is (u'(s) + u'(c))/(u(s) - u(c)) with u(c) = -1 or 1, a difference of two zeta functions: alpha and beta
are an exponential times theta1(v - i eta)/theta4(v) and theta2(v - i eta)/theta4(v), v = pi s/(2 K) (Klein and
Sommerfeld's form). No angle is needed, so the vertical is a point like any other.
"""

import mpmath
import numpy as np

mp = mpmath.MPContext()
mp.dps = 60


class LagrangeTop:
    """The motion that starts at t = 0 from a quaternion (x_space = q x_body q~) and a momentum along the body axes."""

    def __init__(self, transverse, axial, gravity, quaternion, momentum):
        A, C, P = self.constants = [mp.mpf(float(x)) for x in (transverse, axial, gravity)]
        q = [mp.mpf(float(x)) for x in quaternion]
        norm = mp.sqrt(mp.fsum(x * x for x in q))
        alpha, beta = mp.mpc(q[0], q[3]) / norm, mp.mpc(q[1], q[2]) / norm
        g1, g2, p = (mp.mpf(float(x)) for x in momentum)
        u = abs(alpha) ** 2 - abs(beta) ** 2
        # (g1 - i g2)(gamma1 + i gamma2), gamma = s3 along the body axes: its parts are G - p u and -A u'.
        product = mp.mpc(g1, -g2) * 2j * mp.conj(alpha) * beta
        G = product.real + p * u
        self.axial_momentum, self.vertical_momentum = p, G
        e = (g1 * g1 + g2 * g2) / (2 * A) + P * u
        u1, u2, u3 = self.roots = _roots(
            2 * P / A, -2 * e / A - (p / A) ** 2, 2 * G * p / A**2 - 2 * P / A, 2 * e / A - (G / A) ** 2
        )
        m, complement = (u2 - u1) / (u3 - u1), (u3 - u2) / (u3 - u1)
        K, mu = mp.ellipk(m), mp.sqrt(P * (u3 - u1) / (2 * A))
        self.period = 2 * K / mu
        self.nome = mp.exp(-mp.pi * mp.ellipk(complement) / K)
        self.rate = mp.pi / self.period
        self.amplitude = 2 * mu * (u2 - u1) * (self._theta(4, 0) / self._theta(2, 0)) ** 2
        started = mp.ellipf(mp.asin(_clipped_root(u - u1, u2 - u1)), m)
        self.phase = mp.pi / (2 * K) * (started if product.imag < 0 else -started)

        def zero(amplitude, sign):
            return mp.mpc(0, mp.pi / (2 * K) * mp.sign(sign) * mp.ellipf(amplitude, complement))

        self.zero_alpha = zero(mp.atan(mp.sqrt(max(1 + u1, 0) / (u2 - u1))), G + p)
        self.zero_beta = zero(mp.asin(_clipped_root((1 - u2) * (u3 - u1), (1 - u1) * (u3 - u2))), G - p)
        turning = (p / C - p / A) / 2
        # The logarithmic derivatives where u' = 0: of alpha at u2, of beta at u1.
        self.rate_alpha = turning + (G + p) / (2 * A * (1 + u2)) + self._shift(self.zero_alpha)
        self.rate_beta = -turning + (G - p) / (2 * A * (1 - u1)) + self._shift(self.zero_beta)
        self.factor_alpha = alpha / self._quotient(1, self.phase, self.zero_alpha)
        self.factor_beta = beta / self._quotient(2, self.phase, self.zero_beta)

    def states(self, times):
        """The quaternions (n, 4), whose sign is that of the start, and the momenta along the body axes (n, 3)."""
        q, g = zip(*(self.state(t) for t in times), strict=True)
        return np.array(q, dtype=float), np.array(g, dtype=float)

    def state(self, t):
        """The quaternion and the momentum along the body axes at one time, with all their digits."""
        t = mp.mpf(t)
        v = self.phase + self.rate * t
        alpha = self.factor_alpha * mp.expj(self.rate_alpha * t) * self._quotient(1, v, self.zero_alpha)
        beta = self.factor_beta * mp.expj(self.rate_beta * t) * self._quotient(2, v, self.zero_beta)
        u = abs(alpha) ** 2 - abs(beta) ** 2
        u_rate = self.amplitude * mp.fprod(self._theta(i, v) for i in (1, 2, 3)) / self._theta(4, v) ** 3
        A, p = self.constants[0], self.axial_momentum
        g = 1j * mp.mpc(self.vertical_momentum - p * u, A * u_rate) / (2 * alpha * mp.conj(beta))
        return (alpha.real, beta.real, beta.imag, alpha.imag), (g.real, g.imag, p)

    def _quotient(self, i, v, zero):
        return self._theta(i, v - zero) / self._theta(4, v)

    def _shift(self, zero):
        return self.rate * (self._theta(2, zero, 1) / self._theta(2, zero)).imag

    def _theta(self, i, z, derivative=0):
        return mp.jtheta(i, z, self.nome, derivative)


def _roots(a, b, c, d):
    """The three real roots of a x^3 + b x^2 + c x + d, a > 0, in rising order (Viete)."""
    b, c, d = b / a, c / a, d / a
    radius = mp.sqrt((b * b - 3 * c) / 9)
    cosine = (9 * b * c - 2 * b**3 - 27 * d) / (54 * radius**3)
    angle = mp.acos(max(-1, min(1, cosine))) / 3
    return [2 * radius * mp.cos(angle - 2 * mp.pi * k / 3) - b / 3 for k in (2, 1, 0)]


def _clipped_root(numerator, denominator):
    """The square root of a ratio between 0 and 1, also where rounding leaves that range."""
    return mp.sqrt(max(0, min(1, numerator / denominator)))
