/* SPDX-License-Identifier: Apache-2.0 */
/* The graph: what the image shows, V-PM, articulation, G-PM, one drawing of everything. */
#include "models/hogs/hogs.h"

#include "libtensor/ops/splat/gaussians.h"

static const double NEAR = 0.2;                 /* metres: nothing nearer is drawn */

/* ---- inputs ---------------------------------------------------------------------------------------------- */

lt_tensor *hogs_integers(model_record *r, const char *name, lt_shape shape)
{
    lt_tensor *t = lt_input(r->g, name, LT_I32, shape.rank, shape.dim);

    model_port_add(&r->inputs, name, t);
    return t;
}

/* Of frame b alone: graphs take no slices of integers. */
static lt_tensor *integers_of(const hogs *m, model_record *r, const char *name, int b, lt_shape shape)
{
    return hogs_integers(r, r->batch > 1 ? lt_name(m->gaussians.centre->set, "%s%d", name, b) : name, shape);
}

/* x (B, ...) of frame b, without its first dimension, which keeps it 1 where `keep` */
static lt_tensor *frame_of(lt_tensor *x, int b, bool keep)
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

static lt_tensor *transform_input(model_record *r, const char *name, int64_t n)
{
    return model_input(r, name, LT_SHAPE(n, 3, 4));
}

/* ---- what the image shows -------------------------------------------------------------------------------- */

static void look(const hogs *m, model_record *r, vpm_condition *hand, vpm_condition *object)
{
    const int64_t S = m->sizes.crop;
    lt_tensor *image = model_input(r, "image", LT_SHAPE(r->batch, 3, S, S));
    const vit_out seen = vit_forward(&m->vit, m->config.raw_vit ? image : vit_normalise(image));

    if (hand)
        *hand = vpm_condition_of(&m->hand, seen.feature, seen.patches, m->sizes.map, m->sizes.map);
    *object = vpm_condition_of(&m->object, seen.feature, seen.patches, m->sizes.map, m->sizes.map);
}

static vpm_condition condition_of(const vpm_condition *c, int b)
{
    return (vpm_condition){
        .base = c->base && lt_dim(c->base, 0) > 1 ? frame_of(c->base, b, true) : c->base,
        .map = c->map ? frame_of(c->map, b, true) : NULL, .h = c->h, .w = c->w,
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

static vpm_gaussians read_rows(const hogs *m, const hogs_drawn_set *s)
{
    const gaussian_rows *g = &s->rows;
    const int64_t N = lt_dim(g->centre, 0);
    lt_tensor *axes = lt_splat_axes(lt_detach(g->log_scale), lt_detach(g->quaternion), hogs_identity(g->centre->graph));

    return (vpm_gaussians){
        .encoding = vpm_encode(vpm_of(m, s->object), hogs_in_box(&s->box, lt_detach(g->centre))),
        .covariance = lt_splat_covariance(axes),
        .sh = lt_reshape(g->sh, LT_SHAPE(N, 3 * GAUSSIANS_SH)), .opacity = g->opacity,
    };
}

/* V-PM: p' = p + dp, log s' = log s + ds, q' = (1, dq) q                                               [Eq. 8 to 11] */
static void change(const hogs *m, hogs_drawn_set *s, const vpm_condition *condition)
{
    const gaussian_rows *g = &s->rows;

    s->centre = g->centre, s->log_scale = g->log_scale, s->quaternion = g->quaternion;
    if (!m->is->geometry && !m->is->colour)
        return;
    s->deltas = vpm_forward(vpm_of(m, s->object), condition, &s->read, s->place, s->set);
    if (!m->is->geometry)
        return;
    s->centre = lt_add(g->centre, s->deltas.place);
    s->log_scale = lt_add(g->log_scale, s->deltas.scale);
    s->quaternion = lt_quaternion_turn(g->quaternion, s->deltas.rotation);
}

typedef struct {
    const char *set, *row, *alive, *place;
} set_names;

static const set_names names[2] = {
    { "hand_set", "hand_row", "hand_alive", "hand_place" },
    { "object_set", "object_row", "object_alive", "object_place" },
};

/* The places and who is in use, of all frames */
typedef struct {
    lt_tensor *alive, *place;
} set_inputs;

static set_inputs inputs_of(const hogs *m, model_record *r, bool object)
{
    const int64_t N = gaussians_capacity(&m->gaussians);

    return (set_inputs){
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

/* Of frame b, whole, or only its rows `drawn` (1, P) */
static hogs_drawn_set set_of(const hogs *m, model_record *r, bool object, int b, const set_inputs *in,
                             const vpm_condition *seen, lt_tensor *drawn)
{
    const vpm_condition condition = condition_of(seen, b);
    hogs_drawn_set s = { .object = object, .set = integers_of(m, r, names[object].set, b, LT_SHAPE(1)) };

    s.alive = frame_of(in->alive, b, false);
    s.rows = gaussians_rows(&m->gaussians, integers_of(m, r, names[object].row, b, LT_SHAPE(1)), s.alive);
    s.place = frame_of(in->place, b, true);
    if (drawn)
        s.rows = drawn_rows(&s.rows, drawn), s.place = lt_gather(s.place, drawn);
    s.box = hogs_set_box(m, s.set, object);
    s.read = read_rows(m, &s);
    change(m, &s, &condition);
    return s;
}

/* ---- posed and coloured ---------------------------------------------------------------------------------- */

/* Linear blend skinning by the learnt field, at p'                                                     [Eq. 3, 4] */
static lt_tensor *hand_transforms(const hogs *m, const hogs_drawn_set *s, lt_tensor *bones)
{
    lt_tensor *weights = skin_field_forward(&m->skin, hogs_in_box(&s->box, s->centre), s->set);

    return lt_blend_transforms(weights, bones);
}

static lt_tensor *object_transform(const hogs_pose *pose)
{
    lt_tensor *const part[] = { lt_reshape(pose->R, LT_SHAPE(3, 3)), lt_reshape(pose->t, LT_SHAPE(3, 1)) };

    return lt_reshape(lt_concat(part, 2, 1), LT_SHAPE(1, 3, 4));
}

/* The camera is where the directions come from; in canonical space, turned by the training's noise.    [Eq. 6, 7] */
static lt_tensor *colour_of(const hogs *m, const hogs_drawn_set *s, lt_tensor *seen_from, lt_tensor *degree)
{
    lt_tensor *colour = lt_sh_colour(s->rows.sh, seen_from, degree);

    return m->is->colour ? vpm_colour(vpm_of(m, s->object), colour, s->deltas.appearance) : colour;
}

static void pose_set(hogs_drawn_set *s, lt_tensor *transforms)
{
    s->posed = lt_transform_points(s->centre, transforms);
    s->axes = lt_splat_axes(s->log_scale, s->quaternion, transforms);
}

static lt_tensor *direction_of(const hogs_drawn_set *s, lt_tensor *transforms, lt_tensor *view)
{
    return lt_transform_points(lt_transform_back(s->posed, lt_detach(transforms)), view);
}

/* ---- drawing --------------------------------------------------------------------------------------------- */

static lt_tensor *both(lt_tensor *hand, lt_tensor *object)
{
    return lt_concat((lt_tensor *[]){ hand, object }, 2, 0);
}

static lt_tensor *zeros_on_screen(model_record *r, const char *name, int64_t N)
{
    return lt_want_grad(model_input(r, name, LT_SHAPE(N, 2)));
}

static void put_out(model_record *r, const char *name, lt_tensor *t)
{
    model_port_add(&r->outputs, name, lt_output(t, name));
}

static hogs_drawn draw(const hogs *m, model_record *r, hogs_stage stage, const hogs_drawn_set *hand,
                       const hogs_drawn_set *object)
{
    const int64_t N = gaussians_capacity(&m->gaussians);
    const int32_t first = (int32_t)N;
    const lt_splat_in in = {
        .centre = both(hand->posed, object->posed), .axes = both(hand->axes, object->axes),
        .opacity = lt_reshape(both(hand->rows.opacity, object->rows.opacity), LT_SHAPE(2 * N)),
        .colour = both(hand->colour, object->colour), .camera = model_input(r, "camera", LT_SHAPE(4)),
        .offset = stage == HOGS_RENDER ? NULL : both(zeros_on_screen(r, "hand_offset", N),
                                                     zeros_on_screen(r, "object_offset", N)),
        .first = lt_constant(r->g, LT_I32, (lt_shape){ 0 }, &first),
    };
    lt_tensor *images = lt_splat_raster(&in, &(lt_splat_opts){
        .width = m->config.width, .height = m->config.height, .near_z = NEAR, .white = m->config.white, .sets = true });

    if (stage == HOGS_RENDER) {
        put_out(r, "centre", in.centre);
        put_out(r, "axes", in.axes);
        put_out(r, "alpha", in.opacity);
        put_out(r, "colour", in.colour);
    }
    put_out(r, "frame", images);
    put_out(r, "radius", lt_result(images, 1));
    return (hogs_drawn){ .hand = *hand, .object = *object, .images = images, .radius = lt_result(images, 1) };
}

/* ---- G-PM ------------------------------------------------------------------------------------------------ */

static hogs_pose initial_pose(model_record *r)
{
    return (hogs_pose){
        .R = model_input(r, "rotation", LT_SHAPE(r->batch, 3, 3)),
        .t = model_input(r, "translation", LT_SHAPE(r->batch, 3)),
    };
}

/* How many points G-PM looks at: in training as many as it draws, else all of them */
static int64_t points_of(const hogs *m, hogs_stage stage)
{
    return stage == HOGS_RENDER ? gaussians_capacity(&m->gaussians) : m->sizes.gpm_points;
}

static lt_tensor *drawn_input(const hogs *m, model_record *r, hogs_stage stage, int b)
{
    return integers_of(m, r, "drawn", b, LT_SHAPE(1, points_of(m, stage)));
}

/* x (N, ..) of one set as (1, P, C), at the rows `drawn`; NULL: it has only those */
static lt_tensor *of_frame(lt_tensor *x, lt_tensor *drawn)
{
    const int64_t N = lt_dim(x, 0);
    lt_tensor *one = lt_reshape(x, LT_SHAPE(1, N, lt_numel(x) / N));

    return drawn ? lt_gather(one, drawn) : one;
}

static lt_tensor *of_frames(lt_tensor *const *x, int B)
{
    return B > 1 ? lt_concat(x, B, 0) : x[0];
}

static gpm_out refine(const hogs *m, model_record *r, hogs_stage stage, const hogs_drawn_set *object,
                      lt_tensor *drawn, const vpm_condition *condition)
{
    enum { ENCODING, COVARIANCE, COLOUR, OPACITY, PLACE, READ };
    const int B = (int)r->batch;
    const int64_t P = points_of(m, stage);
    lt_tensor *x[READ][HOGS_BATCH];
    gpm_in in = { .condition = condition };

    for (int b = 0; b < B; b++) {
        x[ENCODING][b] = of_frame(object[b].read.encoding, drawn);
        x[COVARIANCE][b] = of_frame(object[b].read.covariance, drawn);
        x[COLOUR][b] = of_frame(object[b].colour, drawn);
        x[OPACITY][b] = of_frame(object[b].rows.opacity, drawn);
        x[PLACE][b] = drawn ? lt_gather(object[b].place, drawn) : object[b].place;
    }
    in.points = model_input(r, "points", LT_SHAPE(B, P, 3));
    in.count = hogs_integers(r, "count", LT_SHAPE(B));
    in.start = hogs_integers(r, "start", LT_SHAPE(B));
    in.rgb = model_input(r, "rgb", LT_SHAPE(B, P, 3));
    in.root = model_input(r, "root", LT_SHAPE(B, 3));
    in.encoding = of_frames(x[ENCODING], B), in.covariance = of_frames(x[COVARIANCE], B);
    in.colour = of_frames(x[COLOUR], B), in.opacity = of_frames(x[OPACITY], B);
    in.place = of_frames(x[PLACE], B);
    return gpm_forward(&m->gpm, &in);
}

/* R' = polar(R_o + Delta R), T' = T_o + Delta T */
static hogs_pose refined_pose(const hogs_pose *initial, const gpm_out *offsets)
{
    hogs_pose pose = gpm_refined(initial, offsets);

    pose.R = lt_nearest_rotation(pose.R, initial->R);
    return pose;
}

/* Under the initial pose: how it is seen from, for the colours that G-PM reads */
static void colour_object(const hogs *m, hogs_drawn_set *s, const hogs_pose *pose, lt_tensor *view, lt_tensor *degree)
{
    lt_tensor *transform = object_transform(pose);

    pose_set(s, transform);
    s->colour = colour_of(m, s, direction_of(s, transform, view), degree);
}

/* ---- stages ---------------------------------------------------------------------------------------------- */

static hogs_pose pose_of(const hogs_pose *all, int b)
{
    return (hogs_pose){ frame_of(all->R, b, true), frame_of(all->t, b, true) };
}

/* G-PM alone: the object's Gaussians and the image are as they are. Only those that are drawn are made. */
static void record_poses(const hogs *m, model_record *r)
{
    vpm_condition seen;
    const hogs_pose initial = initial_pose(r);
    lt_tensor *view = transform_input(r, "view", 1), *degree = hogs_integers(r, "degree", LT_SHAPE(1));
    hogs_drawn_set object[HOGS_BATCH];
    hogs_pose refined;
    set_inputs in;
    gpm_out offsets;

    look(m, r, NULL, &seen);
    in = inputs_of(m, r, true);
    for (int b = 0; b < r->batch; b++) {
        const hogs_pose pose = pose_of(&initial, b);

        object[b] = set_of(m, r, true, b, &in, &seen, drawn_input(m, r, HOGS_POSES, b));
        colour_object(m, &object[b], &pose, view, degree);
    }
    offsets = refine(m, r, HOGS_POSES, object, NULL, &seen);
    refined = refined_pose(&initial, &offsets);
    hogs_pose_losses(m, &offsets, &initial, &refined, r);
}

/* A graph that draws is of one frame: of others it says so when it is compiled. */
static lt_status refuse(lt_call *c)
{
    return lt_fail(c, "draws one frame at a time, found a batch of %lld", (long long)lt_dim(c->in[0], 0));
}

static void never(const lt_call *c)
{
    (void)c;
}

static const lt_op one_frame_op = { .name = "hogs_frame", .infer = refuse, .forward = never };

static void refuse_batch(const hogs *m, model_record *r)
{
    lt_tensor *image = model_input(r, "image", LT_SHAPE(r->batch, 3, m->sizes.crop, m->sizes.crop));

    r->loss = lt_apply(&one_frame_op, NULL, 0, &image, 1);
}

/* Draw one frame, with the object's pose refined where G-PM takes part. */
static void record_scene(const hogs *m, hogs_stage stage, model_record *r)
{
    const bool refines = m->is->gpm && (stage == HOGS_JOINT || stage == HOGS_RENDER);
    vpm_condition hand_seen, object_seen;
    const hogs_pose initial = initial_pose(r);
    hogs_pose refined = initial;
    lt_tensor *bones = transform_input(r, "bones", SKIN_FIELD_BONES), *view = transform_input(r, "view", 1);
    lt_tensor *degree = hogs_integers(r, "degree", LT_SHAPE(1)), *transforms;
    hogs_drawn_set hand, object;
    set_inputs hand_in, object_in;
    gpm_out offsets = { 0 };
    hogs_drawn drawn;

    look(m, r, &hand_seen, &object_seen);
    hand_in = inputs_of(m, r, false), object_in = inputs_of(m, r, true);
    hand = set_of(m, r, false, 0, &hand_in, &hand_seen, NULL);
    object = set_of(m, r, true, 0, &object_in, &object_seen, NULL);
    transforms = hand_transforms(m, &hand, bones);
    pose_set(&hand, transforms);
    hand.colour = colour_of(m, &hand, direction_of(&hand, transforms, view), degree);
    colour_object(m, &object, &initial, view, degree);
    if (refines) {
        offsets = refine(m, r, stage, &object, drawn_input(m, r, stage, 0), &object_seen);
        refined = refined_pose(&initial, &offsets);
        colour_object(m, &object, &refined, view, degree);
    }
    drawn = draw(m, r, stage, &hand, &object);
    put_out(r, "pose_rotation", refined.R);
    put_out(r, "pose_translation", refined.t);
    if (stage == HOGS_RENDER)
        return;
    hogs_scene_losses(m, stage, &drawn, r);
    if (refines)
        hogs_pose_losses(m, &offsets, &initial, &refined, r);
}

void hogs_record(const model *self, hogs_stage stage, model_record *r)
{
    const hogs *m = self->self;

    if (stage == HOGS_SKIN)
        hogs_skin_loss(m, hogs_skin_weight(stage), hogs_integers(r, "hand_set", LT_SHAPE(1)), r);
    else if (stage == HOGS_POSES)
        record_poses(m, r);
    else if (r->batch != 1)
        refuse_batch(m, r);
    else
        record_scene(m, stage, r);
    if (r->loss)
        lt_output(r->loss, "loss");
}
