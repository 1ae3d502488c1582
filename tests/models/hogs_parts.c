/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/models/hogs_parts.h"

#include "models/hogs/avatar.h"
#include "models/hogs/contact.h"
#include "models/hogs/occupancy.h"
#include "tests/geometry/hashed_hand.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SETS = 3, WHICH = 1 };       /* of which the second is used */
enum { N = 11, VIT = 7, SIDE = 3 }; /* Gaussians; numbers of a cell of the map, and its cells along a side */

/* ---- recording --------------------------------------------------------------------------------------------- */

static lt_tensor *input(model_record *r, const char *name, lt_shape shape)
{
    return model_input(r, name, shape);
}

static lt_tensor *typed(model_record *r, const char *name, lt_dtype type, lt_shape shape)
{
    lt_tensor *t = lt_input(r->g, name, type, shape.rank, shape.dim);

    model_port_add(&r->inputs, name, t);
    return t;
}

/* The loss becomes the sum over outputs of their products with an input d_NAME. */
static void output(model_record *r, const char *name, const char *d_name, lt_tensor *t)
{
    lt_tensor *term;

    model_port_add(&r->outputs, name, lt_output(t, name));
    term = lt_sum(lt_mul(t, input(r, d_name, t->shape)));
    r->loss = r->loss ? lt_add(r->loss, term) : term;
}

static void skin(lt_params *set, model_record *r)
{
    const hogs_box box = { input(r, "centre", LT_SHAPE(3)), input(r, "inverse", LT_SHAPE(3)) };
    lt_tensor *places = hogs_in_box(&box, lt_want_grad(input(r, "places", LT_SHAPE(N, 3)))), *w;
    skin_field m;

    skin_field_new(&m, set, "skin", SETS, 8);
    w = skin_field_forward(&m, places, typed(r, "which", LT_I32, LT_SHAPE(1)));
    output(r, "weights", "d_weights", w);
    output(r, "l_skin", "d_l_skin", skin_field_loss(w, input(r, "target", LT_SHAPE(N, SKIN_FIELD_BONES))));
}

static void vpm_part(lt_params *set, model_record *r, vpm_opts o)
{
    vpm_gaussians g;
    vpm_penalties l;
    vpm_condition c;
    vpm_out out;
    vpm m;
    lt_tensor *place, *which;

    o.vit = VIT, o.condition = 6, o.trunk = 8, o.appearance = 5;
    o.grid = (lt_hash_grid_opts){ .levels = 2, .base = 2, .finest = 4, .log2_size = 5 };
    vpm_new(&m, set, "vpm", SETS, &o);
    which = typed(r, "which", LT_I32, LT_SHAPE(1));
    place = input(r, "place", LT_SHAPE(1, N, 2));
    c = vpm_condition_of(&m, input(r, "F", LT_SHAPE(1, VIT)), input(r, "map", LT_SHAPE(1, SIDE * SIDE, VIT)), SIDE,
                         SIDE);
    g = (vpm_gaussians){
        .encoding = vpm_encode(&m, input(r, "centres", LT_SHAPE(N, 3))),
        .covariance = input(r, "covariance", LT_SHAPE(N, 6)), .sh = input(r, "sh", LT_SHAPE(N, 48)),
        .opacity = input(r, "opacity", LT_SHAPE(N, 1)),
    };
    out = vpm_forward(&m, &c, &g, place, which);
    output(r, "place_change", "d_place", out.place);
    output(r, "scale_change", "d_scale", out.scale);
    output(r, "rotation_change", "d_rotation", out.rotation);
    output(r, "appearance", "d_appearance", out.appearance);
    output(r, "colour", "d_colour", vpm_colour(&m, lt_want_grad(input(r, "c_sh", LT_SHAPE(N, 3))), out.appearance));
    output(r, "condition", "d_condition", vpm_condition_at(&c, place));
    l = vpm_penalties_of(&out, input(r, "weight", LT_SHAPE(N)));
    output(r, "l_place", "d_l_place", l.place);
    output(r, "l_scale", "d_l_scale", l.scale);
    output(r, "l_rotation", "d_l_rotation", l.rotation);
}

static void vpm_fpg(lt_params *set, model_record *r)
{
    vpm_part(set, r, (vpm_opts){ .global = true, .pixel = true, .gaussian = true });
}

static void vpm_fg(lt_params *set, model_record *r)
{
    vpm_part(set, r, (vpm_opts){ .global = true, .gaussian = true, .one_blob = true });
}

static void vpm_fp(lt_params *set, model_record *r)
{
    vpm_part(set, r, (vpm_opts){ .global = true, .pixel = true, .alpha3 = true });
}

static void vpm_pg(lt_params *set, model_record *r)
{
    vpm_part(set, r, (vpm_opts){ .pixel = true, .gaussian = true });
}

/* A hand, and an object, as they are seen in a frame to train on */
static void avatar_part(lt_params *set, model_record *r)
{
    const avatar_opts o = { .grid = { .levels = 2, .base = 2, .finest = 4, .log2_size = 5 },
                            .deform = 8, .look = 6, .feature = 5, .frames = SETS };
    lt_tensor *which = typed(r, "which", LT_I32, LT_SHAPE(1)), *feature, *direction;
    vpm_out out;
    avatar m;

    avatar_new(&m, set, "avatar", SETS, SETS, &o);
    out = avatar_deform(&m, input(r, "centres", LT_SHAPE(N, 3)),
                        input(r, "articulation", LT_SHAPE(AVATAR_JOINTS, AVATAR_JOINT)),
                        input(r, "started", LT_SHAPE(1)), which);
    output(r, "place_change", "d_place", out.place);
    output(r, "scale_change", "d_scale", out.scale);
    output(r, "rotation_change", "d_rotation", out.rotation);
    output(r, "shade", "d_shade", out.appearance);
    feature = lt_want_grad(input(r, "feature", LT_SHAPE(N, 5)));
    direction = lt_want_grad(input(r, "direction", LT_SHAPE(N, 3)));
    output(r, "colour", "d_colour",
           avatar_colour(&m, false, feature, direction, out.appearance, avatar_code(&m, r->g, which), which));
    output(r, "rigid", "d_rigid",
           avatar_colour(&m, true, feature, direction, NULL, avatar_code(&m, r->g, which), which));
}

static void gpm_part(lt_params *set, model_record *r, int width)
{
    enum { B = 2, P = 40, E = 4, CONDITION = 6 };
    const gpm_opts o = {
        .encoding = E, .condition = CONDITION, .width = width, .layers = 2, .heads = 3, .ffn = 10,
        .level = { .points = 9, .samples = 8, .radius = 0.6, .width = { 5, 6, 9 } },
    };
    vpm_condition c = { .h = SIDE, .w = SIDE };
    gpm_in in = { .condition = &c };
    gpm_truth truth;
    gpm_losses l;
    gpm_out out;
    gpm m;

    gpm_new(&m, set, "", &o);
    in.points = input(r, "points", LT_SHAPE(B, P, 3));
    in.encoding = input(r, "encoding", LT_SHAPE(B, P, E));
    in.covariance = input(r, "covariance", LT_SHAPE(B, P, 6));
    in.colour = input(r, "colour", LT_SHAPE(B, P, 3));
    in.opacity = input(r, "opacity", LT_SHAPE(B, P, 1));
    in.place = input(r, "place", LT_SHAPE(B, P, 2));
    in.rgb = input(r, "rgb", LT_SHAPE(B, P, 3));
    in.root = input(r, "root", LT_SHAPE(B, 3));
    c.base = input(r, "base", LT_SHAPE(B, CONDITION));
    c.map = input(r, "map", LT_SHAPE(B, SIDE * SIDE, CONDITION));
    out = gpm_forward(&m, &in);
    truth = (gpm_truth){
        .initial = { input(r, "R", LT_SHAPE(B, 3, 3)), input(r, "t", LT_SHAPE(B, 3)) },
        .truth = { input(r, "true_R", LT_SHAPE(B, 3, 3)), input(r, "true_t", LT_SHAPE(B, 3)) },
        .translation = input(r, "offset", LT_SHAPE(B, 3)), .corners = input(r, "corners", LT_SHAPE(B, 8, 3)),
        .weight = input(r, "weight", LT_SHAPE(B)),
    };
    output(r, "delta_T", "d_delta_T", out.delta_T);
    output(r, "delta_R", "d_delta_R", out.delta_R);
    l = gpm_pose_losses(&out, &truth);
    model_port_add(&r->outputs, "l_rot", lt_output(l.rotation, "l_rot"));
    model_port_add(&r->outputs, "l_trans", lt_output(l.translation, "l_trans"));
    model_port_add(&r->outputs, "l_corner", lt_output(l.corner, "l_corner"));
    output(r, "l_pose", "d_l_pose", l.pose);
}

static void gpm_wide(lt_params *set, model_record *r) { gpm_part(set, r, 0); }      /* 3 + 9 + 6 + 48 = 66 */
static void gpm_projected(lt_params *set, model_record *r) { gpm_part(set, r, 12); }

static void contact(lt_params *set, model_record *r)
{
    enum { B = 2, HAND = 60, SURFACE = 50 };
    const contact_in in = {
        .hand = input(r, "hand", LT_SHAPE(B, HAND, 3)), .zone = typed(r, "zone", LT_I32, LT_SHAPE(B, HAND)),
        .surface = input(r, "surface", LT_SHAPE(B, SURFACE, 3)),
        .inside = typed(r, "inside", LT_U8, LT_SHAPE(B, OCCUPANCY_CELLS)), .box = input(r, "box", LT_SHAPE(B, 6)),
        .pose = { lt_want_grad(input(r, "near_R", LT_SHAPE(B, 3, 3))),
                  lt_want_grad(input(r, "near_t", LT_SHAPE(B, 3))) },
    };
    const contact_losses l = contact_losses_of(&in);

    (void)set;
    output(r, "l_cont", "d_l_cont", l.contact);
    output(r, "l_pen", "d_l_pen", l.penetration);
}

const hogs_part hogs_parts[] = {
    { "skin", skin }, { "vpm_fpg", vpm_fpg }, { "vpm_fg", vpm_fg }, { "vpm_fp", vpm_fp }, { "vpm_pg", vpm_pg },
    { "gpm_wide", gpm_wide }, { "gpm_projected", gpm_projected }, { "contact", contact },
    { "avatar", avatar_part },
};
const int n_hogs_parts = (int)LT_COUNT(hogs_parts);

/* ---- filling -------------------------------------------------------------------------------------------------- */

static uint32_t seed_of(const char *name)
{
    uint32_t h = 2166136261u;

    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 16777619u;
    return h;
}

static bool ends_with(const char *name, const char *end)
{
    const size_t n = strlen(name), k = strlen(end);

    return n >= k && strcmp(name + n - k, end) == 0;
}

static void fill_parameter(lt_param *p)
{
    const bool near_one = p->shape.rank == 1 && (ends_with(p->name, ".weight") || ends_with(p->name, "running_var"));
    const int64_t n = lt_param_numel(p);
    const double fan = (double)(p->shape.rank == 3 ? p->shape.dim[2] : n / p->shape.dim[0]);
    const double scale = ends_with(p->name, "bias") || p->shape.rank == 1 ? 0.125 : sqrt(3 / fan);

    for (int64_t i = 0; i < n; i++)
        p->data[i] = (lt_real)(float)(near_one + (near_one ? 0.5 : scale) * hashed(seed_of(p->name), (uint32_t)i));
    if (p->rows)
        lt_param_touch(p, WHICH, 1);
}

static void fill_integers(const char *name, int32_t *v, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        v[i] = strcmp(name, "which") == 0 ? WHICH : (int32_t)(i % 8) - 1;
}

/* A ball of 20 cells about the middle */
static void fill_ball(uint8_t *v, int64_t n)
{
    for (int64_t i = 0; i < n; i++) {
        const double x = (double)(i % 64) - 31.5, y = (double)(i / 64 % 64) - 31.5, z = (double)(i / 4096 % 64) - 31.5;

        v[i] = x * x + y * y + z * z < 400;
    }
}

/* Where a number is between; 0 to 1 for what is not named */
static const struct {
    const char *name;
    double lo, hi;
} ranges[] = {
    { "places", -0.1, 0.1 }, { "centres", -1, 1 }, { "covariance", 0, 1e-4 }, { "sh", -1, 1 }, { "place", -0.4, 2.4 },
    { "F", -1, 1 }, { "map", -1, 1 }, { "near_t", -0.01, 0.01 }, { "hand", -0.07, 0.07 }, { "surface", -0.05, 0.05 },
    { "inverse", 5, 10 }, { "t", 0, 0.1 }, { "true_t", 0, 0.1 }, { "offset", -0.05, 0.05 }, { "corners", -0.1, 0.1 },
};

static void fill_reals(const char *name, lt_real *v, int64_t n)
{
    double lo = 0, hi = 1;

    for (size_t i = 0; i < LT_COUNT(ranges); i++)
        if (strcmp(ranges[i].name, name) == 0)
            lo = ranges[i].lo, hi = ranges[i].hi;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)(float)(lo + (hi - lo) * (hashed(seed_of(name), (uint32_t)i) / 2 + 0.5));
    for (int64_t i = 0; i < n && strcmp(name, "near_R") == 0; i++)     /* near the identity */
        v[i] = (lt_real)(float)((i % 9 % 4 == 0) + 0.1 * (double)v[i]);
    for (int64_t i = 0; i < n && strcmp(name, "box") == 0; i++)
        v[i] = i % 6 < 3 ? (lt_real)-0.0625 : 512;
}

void hogs_part_fill(lt_params *set, const model_record *r, const lt_plan *plan)
{
    for (lt_param *p = lt_params_first(set); p; p = p->next)
        fill_parameter(p);
    for (int i = 0; i < r->inputs.n; i++) {
        const model_port *port = &r->inputs.port[i];
        void *data = lt_plan_data(plan, port->tensor);

        if (!data)
            continue;
        if (port->tensor->dtype == LT_F32)
            fill_reals(port->name, data, lt_numel(port->tensor));
        else if (port->tensor->dtype == LT_I32)
            fill_integers(port->name, data, lt_numel(port->tensor));
        else
            fill_ball(data, lt_numel(port->tensor));
    }
}
