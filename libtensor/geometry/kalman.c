/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/geometry/kalman.h"

#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

/* ---- a point ------------------------------------------------------------------------------------------- */

static const double POINT_ACCELERATION = 8, POINT_DEVIATION = 0.008, POINT_START = 0.02, POINT_SPEED = 1;
static const double POINT_GATE = 11.345;
enum { POINT_REJECTIONS = 3 };

static void point_start(lt_point_filter *f, const double *measured)
{
    *f = (lt_point_filter){ .started = true };
    for (int i = 0; i < 3; i++) {
        f->x[i] = measured[i];
        f->P[i][0] = POINT_START * POINT_START;
        f->P[i][2] = POINT_SPEED * POINT_SPEED;
    }
}

/* x += v dt;  P = F P F^T + Q, F = [1 dt; 0 1], Q = a^2 [dt^4/4 dt^3/2; dt^3/2 dt^2] */
static void point_predict(lt_point_filter *f, double dt)
{
    const double a = POINT_ACCELERATION * dt;

    for (int i = 0; i < 3; i++) {
        double *P = f->P[i];

        f->x[i] += f->v[i] * dt;
        P[0] += dt * (2 * P[1] + dt * P[2]) + a * a * dt * dt / 4;
        P[1] += dt * P[2] + a * a * dt / 2;
        P[2] += a * a;
    }
}

static void point_update(lt_point_filter *f, const double *measured)
{
    for (int i = 0; i < 3; i++) {
        double *P = f->P[i];
        const double S = P[0] + POINT_DEVIATION * POINT_DEVIATION, y = measured[i] - f->x[i];
        const double kx = P[0] / S, kv = P[1] / S;

        f->x[i] += kx * y;
        f->v[i] += kv * y;
        P[2] -= kv * P[1];
        P[1] -= kx * P[1];
        P[0] -= kx * P[0];
    }
}

static double point_distance(const lt_point_filter *f, const double *measured)
{
    double sum = 0;

    for (int i = 0; i < 3; i++) {
        const double y = measured[i] - f->x[i];

        sum += y * y / (f->P[i][0] + POINT_DEVIATION * POINT_DEVIATION);
    }
    return sum;
}

static bool all_finite(const double *x, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

bool lt_point_filter_step(lt_point_filter *f, double dt, const double *measured)
{
    const double *m = measured && all_finite(measured, 3) ? measured : NULL;

    if (!f->started) {
        if (m)
            point_start(f, m);
        return m;
    }
    point_predict(f, dt);
    if (!m)
        return false;
    if (point_distance(f, m) <= POINT_GATE) {
        f->rejected = 0;
        point_update(f, m);
        return true;
    }
    if (++f->rejected < POINT_REJECTIONS)
        return false;
    point_start(f, m);
    return true;
}

/* ---- quaternions (w, x, y, z) ---------------------------------------------------------------------------- */

static void q_mul(const double a[4], const double b[4], double out[4])
{
    const double r[4] = {
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    };

    memcpy(out, r, sizeof(r));
}

static void q_exp(const double v[3], double scale, double out[4])
{
    const double angle = scale * sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double s = angle > 1e-8 ? sin(angle / 2) / angle * scale : scale / 2;

    out[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++)
        out[1 + i] = s * v[i];
}

/* The rotation vector of a q^-1, the shorter way round */
static void q_difference(const double a[4], const double q[4], double out[3])
{
    const double inverse[4] = { q[0], -q[1], -q[2], -q[3] };
    double d[4], length, scale;

    q_mul(a, inverse, d);
    for (int i = 0; d[0] < 0 && i < 4; i++)
        d[i] = i ? -d[i] : d[i];
    d[0] = fabs(d[0]);
    length = sqrt(d[1] * d[1] + d[2] * d[2] + d[3] * d[3]);
    scale = length < 1e-8 ? 2 : 2 * atan2(length, d[0]) / length;
    for (int i = 0; i < 3; i++)
        out[i] = scale * d[1 + i];
}

/* False where q is no rotation: 0, or not finite. */
static bool q_normalise(double q[4])
{
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);

    for (int i = 0; i < 4; i++)
        q[i] /= n;
    return isfinite(n) && n > 0;
}

/* q = exp(v scale) q */
static void q_turn(double q[4], const double v[3], double scale)
{
    double turn[4];

    q_exp(v, scale, turn);
    q_mul(turn, q, q);
    q_normalise(q);
}

/* ---- a pose ---------------------------------------------------------------------------------------------- */

enum { N = LT_POSE_STATES, M = 6, DP = 0, DV = 3, DTHETA = 6, DW = 9 };

static const double POSE_ACCELERATION = 2, POSE_SPIN = 10, POSE_GATE = 16.812;
static const double ACROSS = 0.005, ALONG = 0.015, TURN = 0.0873, GOOD_REPROJECTION = 4;
static const double START[4] = { 0.02, 0.5, 0.35, 2 };      /* deviations of p, v, orientation, w */

static const int measured_state[M] = { DP, DP + 1, DP + 2, DTHETA, DTHETA + 1, DTHETA + 2 };

static void pose_start(lt_pose_filter *f, const lt_pose_measurement *m)
{
    *f = (lt_pose_filter){ .state = LT_FILTER_ON };
    memcpy(f->p, m->p, sizeof(f->p));
    memcpy(f->q, m->q, sizeof(f->q));
    for (int i = 0; i < N; i++)
        f->P[i][i] = START[i / 3] * START[i / 3];
}

/* A P A^T in place, for square A */
static void sandwich(const double A[N][N], double P[N][N])
{
    double AP[N][N] = { { 0 } };

    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++)
            for (int j = 0; j < N && A[i][k] != 0; j++)
                AP[i][j] += A[i][k] * P[k][j];
    memset(P, 0, N * sizeof(P[0]));
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            for (int k = 0; k < N; k++)
                P[i][j] += AP[i][k] * A[j][k];
}

static void add_process_noise(double P[N][N], int first, double deviation, double dt)
{
    const double s = deviation * deviation * dt * dt;

    for (int i = first; i < first + 3; i++) {
        P[i][i] += s * dt * dt / 4;
        P[i][i + 3] += s * dt / 2;
        P[i + 3][i] += s * dt / 2;
        P[i + 3][i + 3] += s;
    }
}

static void pose_predict(lt_pose_filter *f, double dt)
{
    double F[N][N] = { { 0 } }, turn[4], R[9];

    q_exp(f->w, dt, turn);
    lt_rot_from_quat(turn, R);
    for (int i = 0; i < N; i++)
        F[i][i] = 1;
    for (int i = 0; i < 3; i++) {
        F[DP + i][DV + i] = F[DTHETA + i][DW + i] = dt;
        for (int j = 0; j < 3; j++)
            F[DTHETA + i][DTHETA + j] = R[3 * i + j];
        f->p[i] += f->v[i] * dt;
    }
    q_turn(f->q, f->w, dt);
    sandwich(F, f->P);
    add_process_noise(f->P, DP, POSE_ACCELERATION, dt);
    add_process_noise(f->P, DTHETA, POSE_SPIN, dt);
}

/* The innovation: of the orientations that look the same, the one nearest to the filter's */
static void innovation(const lt_pose_filter *f, const lt_pose_measurement *m, double y[M])
{
    double best = INFINITY;

    for (int i = 0; i < 3; i++)
        y[i] = m->p[i] - f->p[i];
    for (int k = -1; k < m->n_symmetries; k++) {
        double q[4], d[3], angle;

        memcpy(q, m->q, sizeof(q));
        if (k >= 0)
            q_mul(m->q, m->symmetry[k], q);
        q_difference(q, f->q, d);
        angle = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (k < 0 || angle < best)
            memcpy(y + 3, d, sizeof(d));
        best = fmin(best, angle);
    }
}

/* Of a measurement: across and along the camera's axis, turned to the world; of its orientation */
static void measurement_noise(const lt_pose_measurement *m, double R[M][M])
{
    const double variance[3] = { ACROSS * ACROSS, ACROSS * ACROSS, ALONG * ALONG }, *C = m->R_world_cam;
    const double worse = fmax(1, m->reprojection_px / GOOD_REPROJECTION);

    memset(R, 0, M * sizeof(R[0]));
    for (int i = 0; i < 3; i++) {
        R[3 + i][3 + i] = worse * TURN * TURN;
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                R[i][j] += worse * C[3 * i + k] * C[3 * j + k] * variance[k];
    }
}

/* S = L L^T in place; false where S is not positive definite. */
static bool cholesky(double S[M][M])
{
    for (int i = 0; i < M; i++)
        for (int j = 0; j <= i; j++) {
            double sum = S[i][j];

            for (int k = 0; k < j; k++)
                sum -= S[i][k] * S[j][k];
            if (i == j && !(sum > 0))
                return false;
            S[i][j] = i == j ? sqrt(sum) : sum / S[j][j];
        }
    return true;
}

/* b = S^-1 b */
static void solve(double L[M][M], double b[M])
{
    for (int i = 0; i < M; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= L[i][k] * b[k];
        b[i] /= L[i][i];
    }
    for (int i = M - 1; i >= 0; i--) {
        for (int k = i + 1; k < M; k++)
            b[i] -= L[k][i] * b[k];
        b[i] /= L[i][i];
    }
}

/* P = (I - K H) P (I - K H)^T + K R K^T, which stays symmetric and positive whatever K is   [Joseph] */
static void joseph(double P[N][N], double K[N][M], double R[M][M])
{
    double A[N][N] = { { 0 } };

    for (int i = 0; i < N; i++) {
        A[i][i] = 1;
        for (int j = 0; j < M; j++)
            A[i][measured_state[j]] -= K[i][j];
    }
    sandwich(A, P);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            for (int k = 0; k < M; k++)
                for (int l = 0; l < M; l++)
                    P[i][j] += K[i][k] * R[k][l] * K[j][l];
}

static void inject(lt_pose_filter *f, double K[N][M], const double y[M])
{
    double d[N] = { 0 };

    for (int i = 0; i < N; i++)
        for (int j = 0; j < M; j++)
            d[i] += K[i][j] * y[j];
    for (int i = 0; i < 3; i++) {
        f->p[i] += d[DP + i];
        f->v[i] += d[DV + i];
        f->w[i] += d[DW + i];
    }
    q_turn(f->q, d + DTHETA, 1);
}

/* False, and nothing changed, where the measurement is too far off. */
static bool pose_update(lt_pose_filter *f, const lt_pose_measurement *m)
{
    double y[M], z[M], R[M][M], S[M][M], K[N][M], distance = 0;

    innovation(f, m, y);
    measurement_noise(m, R);
    for (int i = 0; i < M; i++)
        for (int j = 0; j < M; j++)
            S[i][j] = f->P[measured_state[i]][measured_state[j]] + R[i][j];
    if (!cholesky(S))
        return false;
    memcpy(z, y, sizeof(z));
    solve(S, z);
    for (int i = 0; i < M; i++)
        distance += y[i] * z[i];
    if (!(distance <= POSE_GATE))
        return false;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < M; j++)
            K[i][j] = f->P[i][measured_state[j]];
        solve(S, K[i]);
    }
    joseph(f->P, K, R);
    inject(f, K, y);
    return true;
}

lt_filter_state lt_pose_filter_step(lt_pose_filter *f, double dt, const lt_pose_measurement *measured)
{
    lt_pose_measurement unit = measured ? *measured : (lt_pose_measurement){ .n_symmetries = 0 };
    const lt_pose_measurement *m = all_finite(unit.p, 3) && q_normalise(unit.q) ? &unit : NULL;

    if (f->state == LT_FILTER_OFF) {
        if (m)
            pose_start(f, m);
        return f->state;
    }
    pose_predict(f, dt);
    if (m && pose_update(f, m)) {
        f->missed = 0;
        return f->state = LT_FILTER_ON;
    }
    f->state = ++f->missed > LT_POSE_COAST ? LT_FILTER_OFF : LT_FILTER_COAST;
    return f->state;
}
