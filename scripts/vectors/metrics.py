#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference scores for tests/eval: the official formulas in NumPy and SciPy, double precision.

    cd tests/eval && ../../scripts/vectors/metrics.py

writes scorers/ho3d_vectors.h, scorers/dexycb_vectors.h, object_vectors.h, vsd_vectors.h and image_vectors.h.

Predictions are made by the same linear congruential generator here and in the tests, and rounded to float32.
"""
import numpy as np
from scipy.linalg import orthogonal_procrustes
from scipy.ndimage import correlate1d
from scipy.spatial import cKDTree

J, V, N = 21, 778, 4


class Lcg:
    """x in [-1, 1), exact in double; tests/eval/lcg.h is its twin."""

    def __init__(self, seed):
        self.state = seed

    def __call__(self, n):
        out = np.empty(n)
        for i in range(n):
            self.state = (self.state * 1664525 + 1013904223) & 0xffffffff
            out[i] = (self.state >> 8) / 8388608.0 - 1.0
        return out


def truth(draw, n):
    """A cloud of n points 0.1 m to each side of (0.05, 0.02, -0.6)."""
    return (draw(3 * n).reshape(n, 3) * 0.1 + [0.05, 0.02, -0.6]).astype('f4')


def predict(kind, draw, g):
    noise = draw(g.size).reshape(g.shape)
    g = g.astype('f8')
    x, y, z = g.T
    if kind == 0:                                   # nearly right
        p = g + noise * 0.002
    elif kind == 1:                                 # noisy, and elsewhere
        p = g + noise * 0.01 + [0.01, -0.02, 0.03]
    elif kind == 2:                                 # larger, turned
        p = np.stack([-y, x, z], 1) * 1.3 + noise * 0.005
    elif kind == 3:                                 # seen in a mirror
        p = np.stack([-x, y, z], 1) + noise * 0.005
    else:
        p = g * 0
    return p.astype('f4')


def procrustes(g, p):
    g_mean, p_mean = g.mean(0), p.mean(0)
    g, p = g - g_mean, p - p_mean
    g_norm, p_norm = np.linalg.norm(g) + 1e-8, np.linalg.norm(p) + 1e-8
    R, s = orthogonal_procrustes(g / g_norm, p / p_norm)
    return (p / p_norm) @ R.T * s * g_norm + g_mean


def scale_translation(g, p):
    s = np.linalg.norm(p[4] - p[0])
    p = (p / s if s > 0 else p) * np.linalg.norm(g[4] - g[0])
    return p - p[0] + g[0]


def mean_auc(d):
    """d (frames, points): what EvalUtil.get_measures(0, 0.05, 100) returns."""
    t = np.linspace(0, 0.05, 100)
    auc = [np.trapz([(c <= x).mean() for x in t], t) / np.trapz(np.ones(100), t) for c in d.T]
    return 100 * d.mean(0).mean(), np.mean(auc)


def f_score(g, p, t):
    to_p, to_g = cKDTree(p).query(g)[0], cKDTree(g).query(p)[0]
    a, b = (to_p < t).mean(), (to_g < t).mean()
    return 2 * a * b / (a + b) if a + b > 0 else 0.0


def ho3d(kind):
    draw = Lcg(kind + 1)
    d = {k: [] for k in ('xyz', 'pa', 'st', 'mesh', 'mesh_pa', 'f')}
    for _ in range(N):
        gj = truth(draw, J)
        pj = predict(kind, draw, gj)
        gv = truth(draw, V)
        pv = predict(kind, draw, gv)
        gj, pj, gv, pv = (a.astype('f8') for a in (gj, pj, gv, pv))
        al = procrustes(gv, pv)
        for key, a, b in (('xyz', gj, pj), ('pa', gj, procrustes(gj, pj)), ('st', gj, scale_translation(gj, pj)),
                          ('mesh', gv, pv), ('mesh_pa', gv, al)):
            d[key].append(np.linalg.norm(a - b, axis=1))
        d['f'].append([f_score(gv, q, t) for t in (0.005, 0.015) for q in (pv, al)])
    out = []
    for key in ('xyz', 'pa', 'st', 'mesh', 'mesh_pa'):
        out += mean_auc(np.array(d[key]))
    return out + list(np.mean(d['f'], 0))


def umeyama(g, p):
    g_mean, p_mean = g.mean(0), p.mean(0)
    H = (p - p_mean).T @ (g - g_mean) / len(g)
    U, S, Vt = np.linalg.svd(H)
    if np.linalg.det(Vt.T @ U.T) < 0:
        S[-1] *= -1
        Vt[-1] *= -1
    c = S.sum() / p.var(0).sum() if p.var(0).sum() > 0 else 0.0
    return c * (p - p_mean) @ (Vt.T @ U.T).T + g_mean


def dexycb(kind):
    draw = Lcg(kind + 201)
    d = [[], [], [], []]
    for _ in range(N):
        g = truth(draw, J)
        p = predict(kind, draw, g).astype('f8')
        g = g.astype('f8')
        for i, q in enumerate((p, p - p[0] + g[0], procrustes(g, p), umeyama(g, p))):
            d[i].append(np.linalg.norm(g - q, axis=1))
    out = []
    for e in d:
        mean, auc = mean_auc(np.array(e))
        out += [10 * mean, auc]
    return out


# ---- object poses ----------------------------------------------------------------------------------------

def rotation(v):
    """Cayley's rotation (I - S)^-1 (I + S) of v, rational and so the same everywhere."""
    S = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.linalg.solve(np.eye(3) - S, np.eye(3) + S)


def objects(kind):
    draw = Lcg(100 + kind)
    x = draw(3 * 50).reshape(50, 3) * [0.05, 0.08, 0.03]
    Rg, tg = rotation(draw(3)), draw(3) * 0.1 + [0, 0, 0.7]
    Re, te = rotation(draw(3) * 0.2) @ Rg, tg + draw(3) * 0.02
    e, g = x @ Re.T + te, x @ Rg.T + tg
    flip = np.diag([-1.0, -1.0, 1.0])
    g_flip = (x @ flip) @ Rg.T + tg
    K = np.array([[600, 0, 320], [0, 610, 240], [0, 0, 1.0]])

    def px(a, eps=0.0):
        uvw = a @ K.T
        return uvw[:, :2] / (uvw[:, 2:] + eps)

    def corners(a):
        b = np.stack([a.min(0), a.max(0)])
        return np.array([[b[i, 0], b[j, 1], b[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])

    def norm(a):
        return np.linalg.norm(a, axis=-1)

    return [norm(e - g).mean(), cKDTree(e).query(g)[0].mean(), cKDTree(g).query(e)[0].mean(),
            min(norm(e - g).max(), norm(e - g_flip).max()),
            min(norm(px(e) - px(g)).max(), norm(px(e) - px(g_flip)).max()),
            np.degrees(np.arccos(np.clip((np.trace(Re @ Rg.T) - 1) / 2, -1, 1))), norm(te - tg),
            norm(px(e, 1e-5) - px(g, 1e-5)).mean(), norm(corners(e) - corners(g)).mean(),
            norm(x.max(0) - x.min(0)), norm(x[:, None] - x[None]).max()]


def vsd(kind):
    """BOP's visible surface discrepancy for tau = 0.05 .. 0.5 of the diameter; some pixels measure nothing."""
    draw = Lcg(300 + kind)
    h, w, delta, diameter = 12, 16, 0.015, 0.2
    g = 0.7 + 0.05 * draw(h * w).reshape(h, w)
    e = g + [0.001, 0.01, 0.03, 0.08][kind] * draw(h * w).reshape(h, w)
    measured = np.minimum(g, e) + 0.03 * draw(h * w).reshape(h, w)
    for image in (g, e, measured):
        image[draw(h * w).reshape(h, w) > 0.5] = 0
    v, u = np.mgrid[:h, :w]
    slant = np.sqrt(((u - 7.5) / 20) ** 2 + ((v - 5) / 21) ** 2 + 1)
    g, e, measured = [slant * image.astype('f4').astype('f8') for image in (g, e, measured)]

    def visible(surface):
        return (surface > 0) & ((surface - measured <= delta) | (measured == 0))

    seen_g = visible(g)
    seen_e = visible(e) | (seen_g & (e > 0))
    both, either = seen_g & seen_e, seen_g | seen_e
    distance = np.abs(g - e)[both] / diameter
    return [((distance >= t).sum() + either.sum() - both.sum()) / either.sum() for t in np.arange(1, 11) * 0.05]


def images(kind):
    """PSNR of all pixels and of those where the first channel of a is above a half, SSIM of both forms, as in
    scikit-image's structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False)."""
    draw = Lcg(400 + kind)
    c, h, w = [(3, 37, 53), (1, 11, 11), (3, 16, 90), (2, 40, 12), (3, 45, 33)][kind]
    a = (0.5 + 0.5 * draw(c * h * w).reshape(c, h, w)).astype('f4')
    if kind == 4:                                   # flat and bright but for one corner
        a[:, 9:, 8:] = 0.9
    b = a + np.float32([0.02, 0.3, 1, 0.1, 0.005][kind]) * draw(c * h * w).reshape(c, h, w).astype('f4')
    a, b = a.astype('f8'), b.astype('f8')

    def psnr(d):
        return -10 * np.log10(np.mean(d ** 2))

    def ssim(pad):
        g = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
        g /= g.sum()
        x, y = (np.pad(v, ((0, 0), (pad, pad), (pad, pad))) for v in (a, b))
        mean = lambda v: correlate1d(correlate1d(v, g, 1), g, 2)[:, 5:-5, 5:-5]
        ux, uy = mean(x), mean(y)
        vx, vy, vxy = mean(x * x) - ux * ux, mean(y * y) - uy * uy, mean(x * y) - ux * uy
        s = (2 * ux * uy + 1e-4) * (2 * vxy + 9e-4) / ((ux ** 2 + uy ** 2 + 1e-4) * (vx + vy + 9e-4))
        return s.mean()

    return [psnr(a - b), psnr((a - b)[:, a[0] > 0.5]), ssim(0), ssim(5)]


def table(path, what, name, rows):
    with open(path, 'w') as f:
        f.write('/* SPDX-License-Identifier: Apache-2.0 */\n')
        f.write('/* %s. */\n/* Made by scripts/vectors/metrics.py; do not edit. */\n' % what)
        f.write('static const double %s[%d][%d] = {\n' % (name, len(rows), len(rows[0])))
        for r in rows:
            lines = [' '.join('%.12g,' % v for v in r[i:i + 5]) for i in range(0, len(r), 5)]
            f.write('    {\n        ' + '\n        '.join(lines) + '\n    },\n')
        f.write('};\n')


table('scorers/ho3d_vectors.h', 'The 14 lines of scores.txt for five sets of predictions', 'ho3d_wanted',
      [ho3d(k) for k in range(5)])
table('scorers/dexycb_vectors.h', 'The scores of eval/scorers/dexycb_score.h for five sets of predictions', 'dexycb_wanted',
      [dexycb(k) for k in range(5)])
table('object_vectors.h', 'Errors of five object poses, in the order of test_object_pose.c', 'object_wanted',
      [objects(k) for k in range(5)])
table('vsd_vectors.h', 'VSD of four pairs of depth images, tau 0.05 .. 0.5', 'vsd_wanted', [vsd(k) for k in range(4)])
table('image_vectors.h', 'PSNR of all and of bright pixels, SSIM valid and zero-padded, of five pairs of pictures',
      'image_wanted', [images(k) for k in range(5)])
