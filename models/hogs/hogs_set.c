/* SPDX-License-Identifier: Apache-2.0 */
/* One set in one frame: its rows, changed by what is seen or by the pose, then placed, turned and coloured. */
#include "models/hogs/hogs_set.h"

#include "libtensor/ops/splat/gaussians.h"

lt_tensor *hogs_integers_of(const hogs *m, model_record *r, const char *name, int b, lt_shape shape)
{
    return hogs_integers(r, r->batch > 1 ? lt_name(m->gaussians.centre->set, "%s%d", name, b) : name, shape);
}

lt_tensor *hogs_frame_of(lt_tensor *x, int b, bool keep)
{
    lt_tensor *one = lt_dim(x, 0) > 1 ? lt_slice(x, 0, b, 1) : x;
    lt_shape s = one->shape;

    if (keep)
        return one;
    s.rank--;
    for (int i = 0; i < s.rank; i++)
        s.dim[i] = s.dim[i + 1];
    return lt_reshape(one, s);
}

static vpm_condition condition_of(const vpm_condition *c, int b)
{
    return (vpm_condition){
        .base = c->base && lt_dim(c->base, 0) > 1 ? hogs_frame_of(c->base, b, true) : c->base,
        .map = c->map ? hogs_frame_of(c->map, b, true) : NULL, .h = c->h, .w = c->w,
    };
}

/* ---- what a frame tells ----------------------------------------------------------------------------------- */

vit_out hogs_see(const hogs *m, lt_tensor *image)
{
    return vit_forward(&m->vit, m->config.raw_vit ? image : vit_normalise(image));
}

void hogs_take_seen(model *m)
{
    ((hogs *)m->self)->takes_seen = true;
}

static vit_out seen_of(const hogs *m, model_record *r, bool training)
{
    const int64_t B = r->batch, S = m->sizes.crop, C = m->sizes.vpm.vit, cells = m->sizes.map * m->sizes.map;

    if (!training || !m->takes_seen)
        return hogs_see(m, model_input(r, "image", LT_SHAPE(B, 3, S, S)));
    return (vit_out){ .feature = model_input(r, "feature", LT_SHAPE(B, C)),
                      .patches = model_input(r, "patches", LT_SHAPE(B, cells, C)) };
}

static hogs_seen see_image(const hogs *m, model_record *r, bool training)
{
    const vit_out seen = seen_of(m, r, training);

    return (hogs_seen){ .vpm = {
        vpm_condition_of(&m->hand, seen.feature, seen.patches, m->sizes.map, m->sizes.map),
        vpm_condition_of(&m->object, seen.feature, seen.patches, m->sizes.map, m->sizes.map),
    } };
}

hogs_seen hogs_look(const hogs *m, model_record *r, hogs_stage stage)
{
    const bool training = stage != HOGS_RENDER;
    lt_tensor *frame;

    if (!m->is->avatar)
        return see_image(m, r, training);
    frame = training ? hogs_integers(r, "frame_code", LT_SHAPE(1)) : NULL;
    return (hogs_seen){
        .pose = model_input(r, "articulation", LT_SHAPE(AVATAR_JOINTS, AVATAR_JOINT)),
        .started = model_input(r, "started", LT_SHAPE(1)), .code = avatar_code(&m->avatar, r->g, frame),
    };
}

/* ---- a set in its canonical place ------------------------------------------------------------------------ */

hogs_box hogs_set_box(const hogs *m, lt_tensor *which, bool object)
{
    lt_tensor *box = lt_rows(lt_use(which->graph, m->box[object]), which, 1);

    return (hogs_box){
        .centre = lt_reshape(lt_slice(box, 1, 0, 3), LT_SHAPE(3)),
        .inverse = lt_reshape(lt_slice(box, 1, 3, 3), LT_SHAPE(3)),
    };
}

lt_tensor *hogs_identity(lt_graph *g)
{
    lt_tensor *t;
    lt_real *x = lt_constant_reals(g, LT_SHAPE(1, 3, 4), &t);

    for (int k = 0; x && k < 3; k++)
        x[5 * k] = 1;
    return t;
}

static const vpm *vpm_of(const hogs *m, bool object)
{
    return object ? &m->object : &m->hand;
}

static lt_tensor *in_box(const hogs_drawn_set *s)
{
    return hogs_in_box(&s->box, lt_detach(s->rows.centre));
}

static vpm_gaussians read_rows(const hogs *m, const hogs_drawn_set *s)
{
    const gaussian_rows *g = &s->rows;
    const int64_t N = lt_dim(g->centre, 0);
    lt_tensor *axes = lt_splat_axes(lt_detach(g->log_scale), lt_detach(g->quaternion), hogs_identity(g->centre->graph));

    return (vpm_gaussians){
        .encoding = vpm_encode(vpm_of(m, s->object), in_box(s)), .covariance = lt_splat_covariance(axes),
        .sh = lt_reshape(g->sh, LT_SHAPE(N, 3 * GAUSSIANS_SH)), .opacity = g->opacity,
    };
}

/* p' = p + dp, log s' = log s + ds, q' = (1, dq) q                                                    [Eq. 9 to 11] */
static void apply_deltas(hogs_drawn_set *s)
{
    s->centre = lt_add(s->rows.centre, s->deltas.place);
    s->log_scale = lt_add(s->rows.log_scale, s->deltas.scale);
    s->quaternion = lt_quaternion_turn(s->rows.quaternion, s->deltas.rotation);
}

/* By V-PM, or a hand's by its pose */
static void change(const hogs *m, hogs_drawn_set *s, const vpm_condition *condition, const hogs_seen *seen)
{
    const bool bends = m->is->avatar && !s->object;

    s->centre = s->rows.centre, s->log_scale = s->rows.log_scale, s->quaternion = s->rows.quaternion;
    if (!m->is->avatar)
        s->read = read_rows(m, s);
    if (bends)
        s->deltas = avatar_deform(&m->avatar, in_box(s), seen->pose, seen->started, s->set);
    else if (m->is->geometry || m->is->colour)
        s->deltas = vpm_forward(vpm_of(m, s->object), condition, &s->read, s->place, s->set);
    if (bends || m->is->geometry)
        apply_deltas(s);
}

typedef struct {
    const char *set, *row, *alive, *place;
} set_names;

static const set_names names[2] = {
    { "hand_set", "hand_row", "hand_alive", "hand_place" },
    { "object_set", "object_row", "object_alive", "object_place" },
};

hogs_set_in hogs_set_inputs(const hogs *m, model_record *r, bool object)
{
    const int64_t N = gaussians_capacity(&m->gaussians);

    return (hogs_set_in){
        .alive = model_input(r, names[object].alive, LT_SHAPE(r->batch, N, 1)),
        .place = model_input(r, names[object].place, LT_SHAPE(r->batch, N, 2)),
    };
}

/* x (N, ..) at the rows `drawn` (1, P) */
static lt_tensor *drawn_of(lt_tensor *x, lt_tensor *drawn)
{
    lt_shape s = x->shape;
    lt_tensor *rows = lt_reshape(x, LT_SHAPE(1, s.dim[0], lt_numel(x) / s.dim[0]));

    s.dim[0] = lt_dim(drawn, 1);
    return lt_reshape(lt_gather(rows, drawn), s);
}

static gaussian_rows drawn_rows(const gaussian_rows *g, lt_tensor *drawn)
{
    return (gaussian_rows){
        .centre = drawn_of(g->centre, drawn), .log_scale = drawn_of(g->log_scale, drawn),
        .quaternion = drawn_of(g->quaternion, drawn), .opacity = drawn_of(g->opacity, drawn),
        .sh = drawn_of(g->sh, drawn),
    };
}

hogs_drawn_set hogs_set_of(const hogs *m, model_record *r, bool object, int b, const hogs_set_in *in,
                           const hogs_seen *seen, lt_tensor *drawn)
{
    const vpm_condition condition = condition_of(&seen->vpm[object], b);
    hogs_drawn_set s = { .object = object, .code = seen->code,
                         .set = hogs_integers_of(m, r, names[object].set, b, LT_SHAPE(1)) };

    s.alive = hogs_frame_of(in->alive, b, false);
    s.rows = gaussians_rows(&m->gaussians, hogs_integers_of(m, r, names[object].row, b, LT_SHAPE(1)), s.alive);
    s.place = hogs_frame_of(in->place, b, true);
    if (drawn)
        s.rows = drawn_rows(&s.rows, drawn), s.place = lt_gather(s.place, drawn);
    s.box = hogs_set_box(m, s.set, object);
    change(m, &s, &condition, seen);
    return s;
}

/* ---- posed and coloured ---------------------------------------------------------------------------------- */

lt_tensor *hogs_bend(const hogs *m, const hogs_drawn_set *s, lt_tensor *bones)
{
    lt_tensor *weights = skin_field_forward(&m->skin, hogs_in_box(&s->box, s->centre), s->set);

    return lt_blend_transforms(weights, bones);
}

void hogs_set_place(hogs_drawn_set *s, lt_tensor *transforms)
{
    s->posed = lt_transform_points(s->centre, transforms);
    s->axes = lt_splat_axes(s->log_scale, s->quaternion, transforms);
}

/* The camera is where the directions come from; in canonical space, turned by the training's noise. */
void hogs_set_colour(const hogs *m, hogs_drawn_set *s, lt_tensor *transforms, lt_tensor *view, lt_tensor *degree)
{
    lt_tensor *direction = lt_transform_points(lt_transform_back(s->posed, lt_detach(transforms)), view);

    if (m->is->avatar) {
        s->colour = avatar_colour(&m->avatar, s->object, s->rows.feature, direction, s->deltas.appearance, s->code,
                                  s->set);
        return;
    }
    s->colour = lt_sh_colour(s->rows.sh, direction, degree);
    if (m->is->colour)
        s->colour = vpm_colour(vpm_of(m, s->object), s->colour, s->deltas.appearance);
}
