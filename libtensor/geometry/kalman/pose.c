/* SPDX-License-Identifier: Apache-2.0 */
/* The filter of a pose: an error state of 12 numbers about a place and a unit quaternion. */
#include "libtensor/geometry/kalman/kalman.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/solve6.h"

enum { N = LT_POSE_STATES, M = 6, DP = 0, DV = 3, DTHETA = 6, DW = 9 };

static const double ACCELERATION = 2, SPIN = 10;            /* m/s^2, rad/s^2 */
static const double ACROSS = 0.005, ALONG = 0.015;          /* m, deviations of a measured place by the camera's axis */
static const double TURN = 0.0873;                          /* rad, of a measured orientation: 5 degrees */
static const double GOOD_REPROJECTION = 4;                  /* px; above it, a measurement counts for less */
static const double START[4] = { 0.02, 0.5, 0.35, 2 };      /* m, m/s, rad, rad/s: deviations at the first one */
static const double GATE = 16.812;          /* squared deviations: 99 % of chi squared with 6 degrees of freedom */

static const int measured_state[M] = { DP, DP + 1, DP + 2, DTHETA, DTHETA + 1, DTHETA + 2 };

static void start(lt_pose_filter *f, const lt_pose_measurement *m)
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

/* q = exp(v scale) q */
static void turn_by(double q[4], const double v[3], double scale)
{
    double turn[4];

    lt_quat_exp(v, scale, turn);
    lt_quat_mul(turn, q, q);
    lt_quat_unit(q);
}

static void predict(lt_pose_filter *f, double dt)
{
    double F[N][N] = { { 0 } }, turn[4], R[9];

    lt_quat_exp(f->w, dt, turn);
    lt_rot_from_quat(turn, R);
    for (int i = 0; i < N; i++)
        F[i][i] = 1;
    for (int i = 0; i < 3; i++) {
        F[DP + i][DV + i] = F[DTHETA + i][DW + i] = dt;
        for (int j = 0; j < 3; j++)
            F[DTHETA + i][DTHETA + j] = R[3 * i + j];
        f->p[i] += f->v[i] * dt;
    }
    turn_by(f->q, f->w, dt);
    sandwich(F, f->P);
    add_process_noise(f->P, DP, ACCELERATION, dt);
    add_process_noise(f->P, DTHETA, SPIN, dt);
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
            lt_quat_mul(m->q, m->symmetry[k], q);
        lt_quat_difference(q, f->q, d);
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
    turn_by(f->q, d + DTHETA, 1);
}

/* False, and nothing changed, where the measurement is too far off. */
static bool update(lt_pose_filter *f, const lt_pose_measurement *m)
{
    double y[M], z[M], R[M][M], S[M][M], K[N][M], distance = 0;

    innovation(f, m, y);
    measurement_noise(m, R);
    for (int i = 0; i < M; i++)
        for (int j = 0; j < M; j++)
            S[i][j] = f->P[measured_state[i]][measured_state[j]] + R[i][j];
    if (!lt_cholesky6(S))
        return false;
    memcpy(z, y, sizeof(z));
    lt_solve6(S, z);
    for (int i = 0; i < M; i++)
        distance += y[i] * z[i];
    if (!(distance <= GATE))
        return false;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < M; j++)
            K[i][j] = f->P[i][measured_state[j]];
        lt_solve6(S, K[i]);
    }
    joseph(f->P, K, R);
    inject(f, K, y);
    return true;
}

lt_filter_state lt_pose_filter_step(lt_pose_filter *f, double dt, const lt_pose_measurement *measured)
{
    lt_pose_measurement unit = measured ? *measured : (lt_pose_measurement){ .n_symmetries = 0 };
    const lt_pose_measurement *m = lt_all_finite(3, unit.p) && lt_quat_unit(unit.q) ? &unit : NULL;

    if (f->state == LT_FILTER_OFF) {
        if (m)
            start(f, m);
        return f->state;
    }
    predict(f, dt);
    if (m && update(f, m)) {
        f->missed = 0;
        return f->state = LT_FILTER_ON;
    }
    f->state = ++f->missed > LT_POSE_COAST ? LT_FILTER_OFF : LT_FILTER_COAST;
    return f->state;
}
