/* SPDX-License-Identifier: Apache-2.0 */
/* The graph: what the image shows, V-PM, articulation, G-PM, one drawing of everything. */
#include "models/hogs/hogs_set.h"

#include "libtensor/ops/splat/gaussians.h"

/* ---- inputs ---------------------------------------------------------------------------------------------- */

lt_tensor *hogs_integers(model_record *r, const char *name, lt_shape shape)
{
    lt_tensor *t = lt_input(r->g, name, LT_I32, shape.rank, shape.dim);

    model_port_add(&r->inputs, name, t);
    return t;
}

static lt_tensor *transform_input(model_record *r, const char *name, int64_t n)
{
    return model_input(r, name, LT_SHAPE(n, 3, 4));
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
        .width = m->config.width, .height = m->config.height, .near_z = HOGS_NEAR, .white = m->config.white,
        .sets = true });

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
    return hogs_integers_of(m, r, "drawn", b, LT_SHAPE(1, points_of(m, stage)));
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

static lt_tensor *object_transform(const hogs_pose *pose)
{
    lt_tensor *const part[] = { lt_reshape(pose->R, LT_SHAPE(3, 3)), lt_reshape(pose->t, LT_SHAPE(3, 1)) };

    return lt_reshape(lt_concat(part, 2, 1), LT_SHAPE(1, 3, 4));
}

static void show_object(const hogs *m, hogs_drawn_set *s, const hogs_pose *pose, lt_tensor *view, lt_tensor *degree)
{
    lt_tensor *transform = object_transform(pose);

    hogs_set_place(s, transform);
    hogs_set_colour(m, s, transform, view, degree);
}

/* ---- stages ---------------------------------------------------------------------------------------------- */

static hogs_pose pose_of(const hogs_pose *all, int b)
{
    return (hogs_pose){ hogs_frame_of(all->R, b, true), hogs_frame_of(all->t, b, true) };
}

/* G-PM alone: the object's Gaussians and the image are as they are. Only those that are drawn are made. */
static void record_poses(const hogs *m, model_record *r)
{
    const hogs_pose initial = initial_pose(r);
    lt_tensor *view = transform_input(r, "view", 1), *degree = hogs_integers(r, "degree", LT_SHAPE(1));
    const hogs_seen seen = hogs_look(m, r, HOGS_POSES);
    const hogs_set_in in = hogs_set_inputs(m, r, true);
    hogs_drawn_set object[HOGS_BATCH];
    hogs_pose refined;
    gpm_out offsets;

    for (int b = 0; b < r->batch; b++) {
        const hogs_pose pose = pose_of(&initial, b);

        object[b] = hogs_set_of(m, r, true, b, &in, &seen, drawn_input(m, r, HOGS_POSES, b));
        show_object(m, &object[b], &pose, view, degree);
    }
    offsets = refine(m, r, HOGS_POSES, object, NULL, &seen.vpm[true]);
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
    const hogs_pose initial = initial_pose(r);
    hogs_pose refined = initial;
    lt_tensor *bones = transform_input(r, "bones", SKIN_FIELD_BONES), *view = transform_input(r, "view", 1);
    lt_tensor *degree = hogs_integers(r, "degree", LT_SHAPE(1)), *transforms;
    const hogs_seen seen = hogs_look(m, r, stage);
    const hogs_set_in hand_in = hogs_set_inputs(m, r, false), object_in = hogs_set_inputs(m, r, true);
    hogs_drawn_set hand = hogs_set_of(m, r, false, 0, &hand_in, &seen, NULL);
    hogs_drawn_set object = hogs_set_of(m, r, true, 0, &object_in, &seen, NULL);
    gpm_out offsets = { 0 };
    hogs_drawn drawn;

    transforms = hogs_bend(m, &hand, bones);
    hogs_set_place(&hand, transforms);
    hogs_set_colour(m, &hand, transforms, view, degree);
    show_object(m, &object, &initial, view, degree);
    if (refines) {
        offsets = refine(m, r, stage, &object, drawn_input(m, r, stage, 0), &seen.vpm[true]);
        refined = refined_pose(&initial, &offsets);
        show_object(m, &object, &refined, view, degree);
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
