"""Stand-ins until the core has both (temporary)."""

# ruff: noqa
# mypy: ignore-errors
from __future__ import annotations
import math
import numpy as np


class ResolvedRate:
    def __init__(self, robot, task="pointing", null_space="limits", null_gain=1.0, rate_hz=1000.0, **_):
        self.robot, self.gain = robot, null_gain
        lim = robot.spec.coordinate_limits
        self.lo = np.array([l.lower for l in lim])
        self.hi = np.array([l.upper for l in lim])
        self.vmax = np.array([l.velocity for l in lim])
        self.mid, self.span2 = (self.lo + self.hi) / 2, (self.hi - self.lo) ** 2
        self.J, self.T = np.zeros((6, robot.n)), np.eye(4)
        self.scale, self.sigma_min = 1.0, math.nan
        self.u = None

    def step(self, q, twist, dt, base_twist=None, out=None):
        self.robot.jacobian(q, out=self.J)
        self.robot.forward_kinematics(q, out=self.T)
        A = np.vstack((self.J[:3], self.T[:3, :2].T @ self.J[3:]))
        v = np.concatenate((twist[:3], self.T[:3, :2].T @ twist[3:]))
        M = A @ A.T
        w, U = np.linalg.eigh(M)
        s = math.sqrt(max(w[0], 0.0))
        self.sigma_min = s
        lam2 = (1 - (s / 0.04) ** 2) * 0.04**2 if s < 0.04 else 0.0
        z = self.gain * (self.mid - q) / self.span2 * 4 / 4
        Minv = U @ ((1 / (w + lam2 + 1e-12))[:, None] * U.T)
        qd = z + A.T @ (Minv @ (v - A @ z))
        self.scale = min(1.0, 1.0 / max(1e-12, np.max(np.abs(qd) / self.vmax)))
        # keep inside position limits
        qd *= self.scale
        out[:] = qd
        return out


class Predictor:
    """Quasi-periodic EKF."""

    M = 2

    def __init__(self, rate_hz, axes=3, method="switch", **_):
        self.rate, self.axes, self.method = rate_hz, axes, method
        self.buf = []
        self.x = None
        self.stamp = -1.0
        m = self.M
        self.n = 2 + 3 * (1 + 2 * m)
        self.q = np.array([0.05, 0.02] + ([10.0] + [0.02] * (2 * m)) * 3)
        self.R = np.eye(3) * (3 * 0.3) ** 2

    def _start(self):
        t = np.array([b[0] for b in self.buf])
        y = np.array([b[1] for b in self.buf])
        t0 = t[-1]
        best = None
        for f in np.linspace(0.1, 0.6, 200):
            A = self._basis(2 * math.pi * f * (t - t0))
            c, *_ = np.linalg.lstsq(A, y, rcond=None)
            r = ((A @ c - y) ** 2).sum()
            if best is None or r < best[0]:
                best = (r, f, c)
        _, f, c = best
        self.x = np.concatenate(([0.0, 2 * math.pi * f], c.T.ravel()))
        self.P = np.diag([0.1, 0.1] + ([1.0] + [1.0] * (2 * self.M)) * 3)
        self.stamp = t0

    def _basis(self, th):
        cols = [np.ones_like(th)]
        for k in range(1, self.M + 1):
            cols += [np.cos(k * th), np.sin(k * th)]
        return np.stack(cols, -1)

    def update(self, stamp, y):
        y = np.array(y) * 1e3
        if self.x is None:
            self.buf.append((stamp, y))
            if stamp - self.buf[0][0] >= 12.0:
                self._start()
            return True
        dt = stamp - self.stamp
        if dt <= 0:
            return False
        x = self.x
        x[0] += x[1] * dt
        F = np.eye(self.n)
        F[0, 1] = dt
        self.P = F @ self.P @ F.T + np.diag(self.q * dt)
        h, H = self._meas(x)
        S = H @ self.P @ H.T + self.R
        K = np.linalg.solve(S, H @ self.P).T
        x += K @ (y - h)
        self.P -= K @ H @ self.P
        self.P = (self.P + self.P.T) / 2
        x[1] = min(max(x[1], 2 * math.pi * 0.08), 2 * math.pi * 1.0)
        self.stamp = stamp
        return True

    def _meas(self, x):
        C = x[2:].reshape(3, -1)
        b = self._basis(np.array(x[0]))
        k = np.arange(1, self.M + 1)
        db = np.zeros(1 + 2 * self.M)
        db[1::2] = -k * np.sin(k * x[0])
        db[2::2] = k * np.cos(k * x[0])
        H = np.zeros((3, self.n))
        H[:, 0] = C @ db
        for j in range(3):
            H[j, 2 + j * len(b) : 2 + (j + 1) * len(b)] = b
        return C @ b, H

    def predict(self, t, out=None):
        if self.x is None:
            r = self.buf[-1][1] if self.buf else np.zeros(3)
        else:
            th = self.x[0] + self.x[1] * (t - self.stamp)
            r = self.x[2:].reshape(3, -1) @ self._basis(np.array(th))
        out[:] = r * 1e-3
        return out

    def velocity(self, t, out=None):
        if self.x is None:
            return np.zeros(3)
        w = self.x[1]
        th = self.x[0] + w * (t - self.stamp)
        k = np.arange(1, self.M + 1)
        db = np.zeros(1 + 2 * self.M)
        db[1::2] = -k * np.sin(k * th)
        db[2::2] = k * np.cos(k * th)
        return self.x[2:].reshape(3, -1) @ db * w * 1e-3
