/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/avatar.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/nn/init.h"
#include "libtensor/ops/splat/gaussians.h"

enum { GLOBAL = AVATAR_JOINTS * 12, LOCAL = AVATAR_JOINT + AVATAR_LOCAL, POSE = AVATAR_JOINTS * AVATAR_LOCAL };
enum { PLACE = 3, SCALE = 3, ROTATION = 4, DELTAS = PLACE + SCALE + ROTATION, BASIS = 15, SH = 16 };
enum { HALF = AVATAR_JOINTS / 2 };
enum { DEFORM_LAYERS = 4, LOOK_LAYERS = 3 };

static int encoding(const avatar_opts *o)
{
    return 2 * o->grid.levels;
}

static void pose_encoder_new(avatar *m, lt_params *set, const char *prefix, int hands)
{
    set_mlp_new(&m->root, set, lt_name(set, "%s.pose.root", prefix), hands, (int[]){ GLOBAL, AVATAR_LOCAL }, 1);
    for (int i = 0; i < AVATAR_JOINTS; i++) {
        set_mlp_new(&m->joint[i], set, lt_name(set, "%s.pose.%d", prefix, i), hands,
                    (int[]){ LOCAL, LOCAL, AVATAR_LOCAL }, 2);
        m->joint[i].slope = 0;                  /* relu */
    }
}

void avatar_new(avatar *m, lt_params *set, const char *prefix, int hands, int objects, const avatar_opts *opts)
{
    const int w = opts->deform, seen = opts->feature + BASIS + AVATAR_SHADE + AVATAR_CODE;

    *m = (avatar){ .opts = *opts };
    m->table = lt_params_add(set, lt_name(set, "%s.hash", prefix), "table", LT_WEIGHT,
                             LT_SHAPE(lt_hash_grid_entries(&opts->grid), 2));
    pose_encoder_new(m, set, prefix, hands);
    set_mlp_new(&m->deform, set, lt_name(set, "%s.deform", prefix), hands,
                (int[]){ encoding(opts) + POSE, w, w, w, DELTAS + AVATAR_SHADE }, DEFORM_LAYERS);
    for (int i = 0; i < 2; i++)
        set_mlp_new(&m->look[i], set, lt_name(set, i ? "%s.look_object" : "%s.look_hand", prefix),
                    i ? objects : hands, (int[]){ seen, opts->look, opts->look, 3 }, LOOK_LAYERS);
    m->code = lt_params_add_rows(set, prefix, "code", LT_SHAPE(opts->frames, AVATAR_CODE));
}

void avatar_init(const avatar *m, uint64_t seed)
{
    lt_init_uniform(m->table, seed, 1e-4);
    set_mlp_init(&m->root, seed);
    for (int i = 0; i < AVATAR_JOINTS; i++)
        set_mlp_init(&m->joint[i], seed);
    set_mlp_init(&m->deform, seed);
    set_mlp_init(&m->look[0], seed);
    set_mlp_init(&m->look[1], seed);
    lt_init_normal(m->code, seed, 1);
}

lt_status avatar_touch(const avatar *m, int hand, int object, int64_t frame)
{
    lt_status st = set_mlp_touch(&m->root, hand);

    for (int i = 0; i < AVATAR_JOINTS && !st; i++)
        st = set_mlp_touch(&m->joint[i], hand);
    if (!st)
        st = set_mlp_touch(&m->deform, hand);
    if (!st)
        st = set_mlp_touch(&m->look[0], hand);
    if (!st)
        st = set_mlp_touch(&m->look[1], object);
    return st ? st : lt_param_touch(m->code, frame, 1);
}

/* ---- deformation ----------------------------------------------------------------------------------------- */

/* (1, 96): each joint knows what is said of its parent, the wrist what is said of all of them */
static lt_tensor *pose_code(const avatar *m, lt_tensor *pose, lt_tensor *which)
{
    lt_tensor *all = lt_reshape(lt_slice(pose, 1, 0, 12), LT_SHAPE(1, GLOBAL)), *local[AVATAR_JOINTS];
    lt_tensor *const global = set_mlp_forward(&m->root, all, which);

    for (int i = 0; i < AVATAR_JOINTS; i++) {
        const int parent = lt_hand_parent[i];
        lt_tensor *const part[] = { lt_slice(pose, 0, i, 1), parent < 0 ? global : local[parent] };

        local[i] = set_mlp_forward(&m->joint[i], lt_concat(part, 2, 1), which);
    }
    return lt_concat((lt_tensor *[]){ lt_concat(local, HALF, 1), lt_concat(local + HALF, HALF, 1) }, 2, 1);
}

/* What all Gaussians share goes into the first layer once, as its bias. */
static lt_tensor *with_shared(const set_mlp *mlp, lt_tensor *own, lt_tensor *shared, int own_column,
                              int shared_column, lt_tensor *which)
{
    const set_layer l = set_mlp_layer(mlp, 0, which);
    const int64_t width = lt_dim(l.weight, 0);
    lt_tensor *bias = lt_linear(shared, lt_slice(l.weight, 1, shared_column, lt_dim(shared, 1)), l.bias);

    return lt_linear(own, lt_slice(l.weight, 1, own_column, lt_dim(own, 1)), lt_reshape(bias, LT_SHAPE(width)));
}

vpm_out avatar_deform(const avatar *m, lt_tensor *places, lt_tensor *pose, lt_tensor *started, lt_tensor *which)
{
    lt_tensor *enc = vpm_encode_by(m->table, &m->opts.grid, places), *out;

    out = with_shared(&m->deform, enc, pose_code(m, pose, which), 0, encoding(&m->opts), which);
    out = lt_mul(set_mlp_rest(&m->deform, 0, out, which), started);
    return (vpm_out){
        .place = lt_slice(out, 1, 0, PLACE), .scale = lt_slice(out, 1, PLACE, SCALE),
        .rotation = lt_slice(out, 1, PLACE + SCALE, ROTATION), .appearance = lt_slice(out, 1, DELTAS, AVATAR_SHADE),
    };
}

/* ---- appearance ------------------------------------------------------------------------------------------ */

lt_tensor *avatar_code(const avatar *m, lt_graph *g, lt_tensor *frame)
{
    const int64_t n = m->opts.frames;
    lt_tensor *share;
    lt_real *x;

    if (frame)
        return lt_rows(lt_use(g, m->code), frame, 1);
    x = lt_constant_reals(g, LT_SHAPE(1, n), &share);
    for (int64_t i = 0; x && i < n; i++)
        x[i] = 1 / (lt_real)n;
    return lt_matmul(share, lt_use(g, m->code));
}

/*
 * Spherical harmonics of a direction but for the constant one, (N, 15): three at a time, as the colours of
 * coefficients that are one half, which keeps a colour 1/2 + b / 2 above 0 for each basis function b.
 */
static lt_tensor *harmonics(lt_tensor *direction)
{
    const int64_t N = lt_dim(direction, 0);
    const int32_t all = 3;
    lt_graph *g = direction->graph;
    lt_tensor *degree = lt_constant(g, LT_I32, LT_SHAPE(1), &all), *part[BASIS / 3];

    for (int p = 0; p < BASIS / 3; p++) {
        lt_tensor *sh;
        lt_real *x = lt_constant_reals(g, LT_SHAPE(N, SH, 3), &sh);

        for (int64_t i = 0; x && i < N; i++)
            for (int c = 0; c < 3; c++)
                x[(i * SH + 1 + 3 * p + c) * 3 + c] = (lt_real)0.5;
        part[p] = lt_sh_colour(sh, direction, degree);
    }
    return lt_scale(lt_sub(lt_concat(part, BASIS / 3, 1), lt_scalar(g, 0.5)), 2);
}

lt_tensor *avatar_colour(const avatar *m, bool object, lt_tensor *feature, lt_tensor *direction, lt_tensor *shade,
                         lt_tensor *code, lt_tensor *which)
{
    const set_mlp *look = &m->look[object];
    lt_tensor *const part[] = { feature, harmonics(direction), shade };
    lt_tensor *own = lt_concat(part, shade ? 3 : 2, 1);

    own = with_shared(look, own, code, 0, m->opts.feature + BASIS + AVATAR_SHADE, which);
    return lt_sigmoid(set_mlp_rest(look, 0, own, which));
}
