/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of a predicted object pose: ADD and its kin, BOP's MSSD and MSPD, HOISDF's centres and
 * boxes. */
#include "eval/metrics/object_pose.h"

#include "assets/ycb/ycb.h"
#include "eval/metrics/metrics.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>

/* An error as this header promises it: whatever is not finite is infinite. */
static double or_infinite(double error)
{
    return isfinite(error) ? error : INFINITY;
}

/* ---- how large, how symmetric ------------------------------------------------------------ */

const char *eval_diameter_name(eval_diameter_mode mode)
{
    return mode == EVAL_BBOX_DIAG ? "bbox_diag" : "max_dist";
}

/* box: lowest corner, then highest */
static void bounds(int n, const double *x, double box[2][3])
{
    for (int k = 0; k < 3; k++) {
        box[0][k] = INFINITY;
        box[1][k] = -INFINITY;
    }
    for (int i = 0; i < 3 * n; i++) {
        box[0][i % 3] = fmin(box[0][i % 3], x[i]);
        box[1][i % 3] = fmax(box[1][i % 3], x[i]);
    }
}

double eval_diameter(eval_diameter_mode mode, int n, const double *x)
{
    double box[2][3], largest = 0;

    if (n <= 0)
        return 0;
    if (mode == EVAL_BBOX_DIAG) {
        bounds(n, x, box);
        return lt_vec3_distance(box[0], box[1]);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++)
            largest = fmax(largest, lt_vec3_distance(x + 3 * i, x + 3 * j));
    }
    return largest;
}

static const struct { const char *name; unsigned adds; } symmetry_list[] = {
    [EVAL_SYM_NONE] = { "none", 0 },
    [EVAL_SYM_HFL] = { "hfl", YCB_ADDS_HFL },
    [EVAL_SYM_POSECNN] = { "posecnn", YCB_ADDS_POSECNN },
    [EVAL_SYM_BOP] = { "bop", YCB_ADDS_BOP },
};

const char *eval_symmetry_name(eval_symmetry_list list)
{
    return symmetry_list[list].name;
}

bool eval_is_symmetric(eval_symmetry_list list, int ycb_class)
{
    const ycb_object *o = ycb_find(ycb_class);

    return o && (o->adds & symmetry_list[list].adds);
}

/* ---- distances of model points ----------------------------------------------------------- */

double eval_add(int n, const double *x, const lt_pose *e, const lt_pose *g)
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        double a[3], b[3];

        lt_rigid_apply(e->R, e->t, x + 3 * i, a);
        lt_rigid_apply(g->R, g->t, x + 3 * i, b);
        sum += lt_vec3_distance(a, b);
    }
    return n > 0 ? or_infinite(sum / n) : NAN;
}

lt_status eval_adds(eval_adds_direction direction, int n, const double *x,
                    const lt_pose *e, const lt_pose *g, double *out)
{
    const lt_pose *from = direction == EVAL_FROM_TRUE ? g : e;
    const lt_pose *to = direction == EVAL_FROM_TRUE ? e : g;
    double *memory = lt_alloc(7 * (size_t)n * sizeof(double));
    lt_status st;

    if (!memory)
        return lt_error(LT_ENOMEM, "ADD-S of %d points: no memory", n);
    lt_pose_apply(from, n, x, memory);
    lt_pose_apply(to, n, x, memory + 3 * (size_t)n);
    st = eval_nearest(n, memory, n, memory + 3 * (size_t)n, memory + 6 * (size_t)n, NULL);
    if (!st)
        *out = n > 0 ? or_infinite(eval_mean(n, memory + 6 * (size_t)n)) : NAN;
    lt_release(memory);
    return st;
}

/* K p over (z + z_eps), so that z_eps moves the principal point too, as in the scripts that
 * have one. */
static void project(const lt_camera *c, const double p[3], double z_eps, double uv[2])
{
    uv[0] = (c->fx * p[0] + c->cx * p[2]) / (p[2] + z_eps);
    uv[1] = (c->fy * p[1] + c->cy * p[2]) / (p[2] + z_eps);
}

/* The distance of one posed model point in metres, or in pixels where there is a camera. */
static double point_error(const double *x, const lt_pose *e, const lt_pose *g,
                          const lt_camera *camera, double z_eps)
{
    double a[3], b[3], ua[2], ub[2];

    lt_rigid_apply(e->R, e->t, x, a);
    lt_rigid_apply(g->R, g->t, x, b);
    if (!camera)
        return or_infinite(lt_vec3_distance(a, b));
    project(camera, a, z_eps, ua);
    project(camera, b, z_eps, ub);
    return or_infinite(hypot(ua[0] - ub[0], ua[1] - ub[1]));
}

static double largest_error(int n, const double *x, const lt_pose *e, const lt_pose *g,
                            const lt_camera *camera)
{
    double largest = 0;

    for (int i = 0; i < n; i++)
        largest = fmax(largest, point_error(x + 3 * i, e, g, camera, 0));
    return largest;
}

static double best_over_symmetries(int n, const double *x, const lt_pose *e, const lt_pose *g,
                                   int n_sym, const lt_pose *sym, const lt_camera *camera)
{
    double best = largest_error(n, x, e, g, camera);

    for (int s = 0; s < n_sym; s++) {
        const lt_pose other = lt_pose_compose(g, &sym[s]);

        best = fmin(best, largest_error(n, x, e, &other, camera));
    }
    return best;
}

double eval_mssd(int n, const double *x, const lt_pose *e, const lt_pose *g,
                 int n_sym, const lt_pose *sym)
{
    return best_over_symmetries(n, x, e, g, n_sym, sym, NULL);
}

double eval_mspd(int n, const double *x, const lt_pose *e, const lt_pose *g,
                 int n_sym, const lt_pose *sym, const lt_camera *camera)
{
    return best_over_symmetries(n, x, e, g, n_sym, sym, camera);
}

/* ---- rotation, translation, image, boxes ------------------------------------------------- */

double eval_rotation_error_deg(const lt_pose *e, const lt_pose *g)
{
    return or_infinite(lt_rot_angle(g->R, e->R) * (180 / M_PI));
}

double eval_reprojection_px(int n, const double *x, const lt_pose *e, const lt_pose *g,
                            const lt_camera *camera, double z_eps)
{
    double sum = 0;

    for (int i = 0; i < n; i++)
        sum += point_error(x + 3 * i, e, g, camera, z_eps);
    return n > 0 ? sum / n : NAN;
}

double eval_oce(const lt_pose *e, const lt_pose *g)
{
    return or_infinite(lt_vec3_distance(e->t, g->t));
}

/* The box of the posed points, along the axes of the camera. */
static void posed_bounds(int n, const double *x, const lt_pose *pose, double box[2][3])
{
    double point[3], one[2][3];

    bounds(0, NULL, box);
    for (int i = 0; i < n; i++) {
        lt_rigid_apply(pose->R, pose->t, x + 3 * i, point);
        bounds(1, point, one);
        for (int k = 0; k < 3; k++) {
            box[0][k] = fmin(box[0][k], one[0][k]);
            box[1][k] = fmax(box[1][k], one[1][k]);
        }
    }
}

double eval_mce(int n, const double *x, const lt_pose *e, const lt_pose *g)
{
    double box_e[2][3], box_g[2][3], sum = 0;

    if (n <= 0)
        return NAN;
    posed_bounds(n, x, e, box_e);
    posed_bounds(n, x, g, box_g);
    for (int corner = 0; corner < 8; corner++) {
        double a[3], b[3];

        for (int k = 0; k < 3; k++) {
            a[k] = box_e[corner >> k & 1][k];
            b[k] = box_g[corner >> k & 1][k];
        }
        sum += lt_vec3_distance(a, b);
    }
    return or_infinite(sum / 8);
}
