/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/metrics/vsd.h"

#include <math.h>

/* From the camera's centre to the surface at pixel (x, y), over its depth */
static double slant(const lt_camera *c, int x, int y)
{
    const double u = (x - c->cx) / c->fx, v = (y - c->cy) / c->fy;

    return sqrt(u * u + v * v + 1);
}

/* Whether a surface is seen: not behind what was measured, where anything was. */
static bool visible(double surface, double measured, double delta)
{
    return surface > 0 && (measured == 0 || surface - measured <= delta);
}

void eval_vsd(const eval_vsd_view *view, const float *e, const float *g, int n, const double *tau, double *errors)
{
    int64_t all = 0, apart = 0;

    for (int k = 0; k < n; k++)
        errors[k] = 0;
    for (int y = 0; y < view->height; y++)
        for (int x = 0; x < view->width; x++) {
            const int64_t i = (int64_t)y * view->width + x;
            const double s = e[i] > 0 || g[i] > 0 ? slant(&view->camera, x, y) : 0;
            const double measured = s * (double)view->measured[i], at_e = s * (double)e[i], at_g = s * (double)g[i];
            const bool g_seen = visible(at_g, measured, view->delta);
            const bool e_seen = visible(at_e, measured, view->delta) || (g_seen && at_e > 0);

            all += g_seen || e_seen;
            apart += g_seen != e_seen;
            for (int k = 0; k < n && g_seen && e_seen; k++)
                errors[k] += fabs(at_g - at_e) / view->diameter >= tau[k];
        }
    for (int k = 0; k < n; k++)
        errors[k] = all ? (errors[k] + (double)apart) / (double)all : 1;
}
