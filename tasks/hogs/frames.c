/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/frames.h"

#include "data/hand_pose.h"
#include "data/kind.h"
#include "vision/crop.h"
#include "vision/silhouette.h"

#include <math.h>
#include <string.h>

static const double ENLARGE = 1.2;              /* the crop's side, of the longer side of what is seen */
static const double JITTER = 0.3;               /* of a channel's factor */
enum { LOOKED_AT = 5 };                         /* frames of a sequence that are searched for a mask */

/* ---- batches --------------------------------------------------------------------------------------------- */

static void *batch_new(const void *ctx, int capacity)
{
    const hogs_source *s = ctx;
    const hogs *m = hogs_of(s->m);
    const size_t S = (size_t)m->sizes.crop, pixels = (size_t)m->config.width * (size_t)m->config.height;
    lt_arena *arena = lt_arena_new();
    hogs_batch *b = arena ? lt_arena_alloc(arena, sizeof(*b)) : NULL;
    bool ok = b != NULL;

    if (ok) {
        *b = (hogs_batch){ .capacity = capacity, .memory = arena,
                           .frame = lt_arena_array(arena, (size_t)capacity, sizeof(*b->frame)) };
        ok = b->frame != NULL;
    }
    for (int i = 0; ok && i < capacity; i++) {
        hogs_frame *f = &b->frame[i];

        f->image = lt_arena_array(arena, 3 * S * S, sizeof(float));
        f->target = lt_arena_array(arena, HOGS_TARGETS * pixels, sizeof(float));
        f->segments = lt_arena_array(arena, pixels, 1);
        ok = f->image && f->target && f->segments;
    }
    if (ok)
        return b;
    lt_arena_free(arena);
    return NULL;
}

static void batch_free(void *batch)
{
    hogs_batch *b = batch;

    if (b)
        lt_arena_free(b->memory);
}

static void start(void *batch, int count)
{
    ((hogs_batch *)batch)->count = count;
}

static void skip(void *batch, int slot, int64_t index)
{
    hogs_frame *f = &((hogs_batch *)batch)->frame[slot];

    f->there = false;
    f->index = index;
}

static const char *name(const void *ctx, int64_t index)
{
    const hogs_source *s = ctx;

    return dataset_name(s->data, s->index[index]);
}

/* ---- poses and sets -------------------------------------------------------------------------------------- */

static void take_initial(const initial_pose *p, hogs_poses *out)
{
    initial_pose_rotations(p, out->rotation);
    for (int k = 0; k < 3; k++) {
        out->root[k] = (float)p->wrist[k];
        out->t[k] = (float)p->t[k];
    }
    for (int k = 0; k < 9; k++)
        out->R[k] = (float)p->R[k];
}

static lt_status find_sets(const hogs_source *s, const dataset_sample *sample, hogs_frame *f)
{
    const hogs *m = hogs_of(s->m);
    const int subject = s->data->kind->subject(sample->name);

    if (sample->flags & SAMPLE_MIRRORED)
        return lt_error(LT_EINVAL, "%s: a left hand, and HOGS's hands are right ones", sample->name);
    if (sample->object < 0)
        return lt_error(LT_EINVAL, "%s: no object is known of it", sample->name);
    f->data_object = sample->object;
    f->subject = hogs_find_set(m, false, subject);
    f->object = hogs_find_set(m, true, s->data->objects[sample->object].ycb_id);
    if (f->subject < 0)
        return lt_error(LT_EINVAL, "%s: subject %d has no set of Gaussians: no such hand was trained", sample->name,
                        subject);
    if (f->object < 0)
        return lt_error(LT_EINVAL, "%s: object %s has no set of Gaussians: it was not trained", sample->name,
                        s->data->objects[sample->object].name);
    return LT_OK;
}

static void take_truth(const dataset_sample *s, hogs_frame *f)
{
    memcpy(f->truth.rotation, s->rotation, sizeof(f->truth.rotation));
    memcpy(f->truth.root, s->root, sizeof(f->truth.root));
    memcpy(f->truth.R, s->R, sizeof(f->truth.R));
    memcpy(f->truth.t, s->t, sizeof(f->truth.t));
    f->hand_known = s->flags & SAMPLE_HAND_POSE;
    f->vertices = s->flags & SAMPLE_VERTICES ? s->vertices : NULL;
    f->known = (s->flags & SAMPLE_OBJECT) && (s->flags & SAMPLE_ROOT);
}

/* ---- masks ----------------------------------------------------------------------------------------------- */

static lt_status check_size(const hogs *m, const dataset_sample *s)
{
    if (s->width == m->config.width && s->height == m->config.height)
        return LT_OK;
    return lt_error(LT_EINVAL, "%s: %d x %d pixels, expected %d x %d as the model draws them; frames of one run are of "
                    "one size", s->name, s->width, s->height, m->config.width, m->config.height);
}

/* Masks may be stored at a fraction of the image's size. */
static lt_status masks_of_data(const dataset_sample *s, uint8_t *out)
{
    if (!(s->flags & SAMPLE_SEGMENTS))
        return lt_error(LT_EINVAL, "%s: there is no mask of hand and object; data.masks=initial takes their "
                        "silhouettes under the initial poses", s->name);
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const int from_x = (int)((int64_t)x * s->segments_width / s->width);
            const int from_y = (int)((int64_t)y * s->segments_height / s->height);

            out[(int64_t)y * s->width + x] = s->segments[(int64_t)from_y * s->segments_width + from_x];
        }
    return LT_OK;
}

/* The hand's mesh as the initial pose has it, at its place in the camera */
static lt_status posed_hand(lt_arena *arena, const hogs_source *s, const hogs_frame *f, lt_mesh *out)
{
    double (*vertex)[3] = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*vertex));
    const hogs *m = hogs_of(s->m);
    float beta[LT_HAND_BETAS];

    *out = (lt_mesh){ .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES, .face = (int32_t (*)[3])s->hand->faces,
                      .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*out->vertex)) };
    if (!vertex || !out->vertex)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    hogs_beta(m, f->subject, beta);
    hand_pose_at(s->hand, f->initial.rotation[0], beta, f->initial.root, vertex);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)vertex[i][k];
    return LT_OK;
}

/* What is nearer hides the other. */
static lt_status masks_of_poses(lt_arena *arena, const hogs_source *s, const hogs_frame *f, int width, int height,
                                uint8_t *out)
{
    static const float I[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, O[3] = { 0 };
    const int64_t n = (int64_t)width * height;
    float *hand = lt_arena_array(arena, (size_t)n, sizeof(*hand)), *object = lt_arena_array(arena, (size_t)n,
                                                                                            sizeof(*object));
    lt_mesh mesh;
    lt_status st = hand && object ? posed_hand(arena, s, f, &mesh) : lt_error(LT_ENOMEM, "no memory for masks");

    if (!st)
        st = silhouette_depth(&mesh, I, O, &f->camera, hand, width, height, arena);
    if (!st)
        st = silhouette_depth(&s->data->objects[f->data_object].mesh, f->initial.R, f->initial.t, &f->camera, object,
                              width, height, arena);
    for (int64_t i = 0; i < n && !st; i++)
        out[i] = hand[i] > 0 && (object[i] <= 0 || hand[i] < object[i]) ? SEGMENT_HAND
                 : object[i] > 0 ? SEGMENT_OBJECT : 0;
    return st;
}

/* ---- images ---------------------------------------------------------------------------------------------- */

static bool in_image(int image, uint8_t segment)
{
    return image == 0 ? segment != 0 : segment == (image == 1 ? SEGMENT_HAND : SEGMENT_OBJECT);
}

static void mask_box(const uint8_t *segments, int image, int width, int height, float box[4])
{
    int x0 = width, y0 = height, x1 = 0, y1 = 0;

    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            if (!in_image(image, segments[(int64_t)y * width + x]))
                continue;
            x0 = x < x0 ? x : x0, x1 = x >= x1 ? x + 1 : x1;
            y0 = y < y0 ? y : y0, y1 = y + 1;
        }
    for (int k = 0; k < 4; k++)
        box[k] = x1 ? (float)(int[]){ x0, y0, x1, y1 }[k] : 0;
}

/* C_gt of joint, hand and object, outside of the masks as the background is; then the masks */
static void fill_target(const hogs *m, const uint8_t *rgb, hogs_frame *f)
{
    const int64_t n = (int64_t)m->config.width * m->config.height;

    for (int image = 0; image < HOGS_IMAGES; image++) {
        float *out = f->target + 3 * image * n, *mask = f->target + (9 + image) * n;

        for (int64_t i = 0; i < n; i++) {
            mask[i] = in_image(image, f->segments[i]);
            for (int c = 0; c < 3; c++)
                out[c * n + i] = mask[i] > 0 ? (float)rgb[3 * i + c] / 255 : (float)m->config.white;
        }
        mask_box(f->segments, image, m->config.width, m->config.height, f->box[image]);
    }
}

static void jitter(const hogs_source *s, uint64_t epoch, int64_t index, uint8_t *rgb, int64_t n)
{
    lt_rng rng = lt_rng_make(s->seed, lt_rng_mix(s->training ? epoch + 1 : 0, (uint64_t)index));
    double factor[3];

    for (int c = 0; c < 3; c++)
        factor[c] = lt_rng_range(&rng, 1 - JITTER, 1 + JITTER);
    for (int64_t i = 0; i < 3 * n; i++)
        rgb[i] = (uint8_t)lround(fmin(255, factor[i % 3] * rgb[i]));
}

static void cut_out(const hogs *m, const uint8_t *rgb, const float b[4], double crop[6], float *image)
{
    const double w = (double)(b[2] - b[0]), h = (double)(b[3] - b[1]);
    const crop_window window = { .cx = (double)(b[0] + b[2]) / 2, .cy = (double)(b[1] + b[3]) / 2,
                                 .side = ENLARGE * fmax(w, h) };

    crop_affine(window, m->sizes.crop, crop);
    crop_warp(crop, rgb, m->config.width, m->config.height, NULL, image, m->sizes.crop, true);
}

/* Image, masks and crop of a frame whose sets and initial poses are known */
static lt_status fill_image(const hogs_source *s, uint64_t epoch, const dataset_sample *sample, lt_arena *scratch,
                            hogs_frame *f)
{
    const hogs *m = hogs_of(s->m);
    const int64_t n = (int64_t)sample->width * sample->height;
    uint8_t *rgb = lt_arena_array(scratch, (size_t)n, 3);
    lt_status st = rgb ? check_size(m, sample) : lt_error(LT_ENOMEM, "%s: no memory", sample->name);

    if (!st)
        st = s->masks == HOGS_MASKS_DATA ? masks_of_data(sample, f->segments)
            : masks_of_poses(scratch, s, f, sample->width, sample->height, f->segments);
    if (st)
        return st;
    memcpy(rgb, sample->rgb, (size_t)(3 * n));
    if (s->jitter)
        jitter(s, epoch, f->index, rgb, n);
    fill_target(m, rgb, f);
    f->there = f->box[0][2] > 0;
    if (f->there)
        cut_out(m, rgb, f->box[0], f->crop, f->image);
    return LT_OK;
}

/* Another frame's crop instead of its own */
static lt_status show_other(const hogs_source *s, int64_t index, lt_arena *scratch, hogs_frame *f)
{
    const hogs *m = hogs_of(s->m);
    uint8_t *segments = lt_arena_array(scratch, (size_t)m->config.width, (size_t)m->config.height);
    dataset_sample other;
    float box[4];
    double crop[6];
    lt_status st = segments ? dataset_read(s->shown, index, SAMPLE_SEGMENTS, scratch, &other)
                            : lt_error(LT_ENOMEM, "no memory for a frame");

    if (!st)
        st = check_size(m, &other);
    if (!st)
        st = masks_of_data(&other, segments);
    if (st)
        return st;
    mask_box(segments, 0, other.width, other.height, box);
    f->there = box[2] > 0;
    if (f->there)
        cut_out(m, other.rgb, box, crop, f->image);
    return LT_OK;
}

static lt_status fill(const void *ctx, uint64_t epoch, int64_t at, lt_arena *scratch, void *batch, int slot)
{
    const hogs_source *s = ctx;
    const int64_t index = s->index[at];
    hogs_frame *f = &((hogs_batch *)batch)->frame[slot];
    dataset_sample sample;
    lt_status st = dataset_read(s->data, index, SAMPLE_SEGMENTS, scratch, &sample);

    f->there = false;
    f->index = index;
    f->number = at;
    f->draw = lt_rng_mix(epoch, (uint64_t)index);
    if (!st)
        st = find_sets(s, &sample, f);
    if (st)
        return st;
    f->camera = sample.camera;
    take_initial(initial_poses_at(s->poses, index), &f->initial);
    take_truth(&sample, f);
    st = fill_image(s, epoch, &sample, scratch, f);
    if (st || !s->show_as || !f->there)
        return st;
    f->there = s->show_as[at] >= 0;
    return f->there ? show_other(s, s->show_as[at], scratch, f) : LT_OK;
}

loader_source hogs_frames_loader(const hogs_source *s)
{
    return (loader_source){
        .ctx = s, .count = s->count, .name = name, .batch_new = batch_new, .batch_free = batch_free, .start = start,
        .fill = fill, .skip = skip,
    };
}

/* ---- which frames ---------------------------------------------------------------------------------------- */

lt_status hogs_frames_of(lt_arena *arena, const dataset *data, const initial_poses *poses, const int64_t **index,
                         int64_t *count)
{
    int64_t *out = lt_arena_array(arena, (size_t)data->count, sizeof(*out)), n = 0;

    if (!out)
        return lt_error(LT_ENOMEM, "%s: no memory for %lld frames", data->root, (long long)data->count);
    for (int64_t i = 0; i < data->count; i++) {
        const initial_pose *p = initial_poses_at(poses, i);

        if (p && p->has_hand && p->has_object)
            out[n++] = i;
    }
    *index = out;
    *count = n;
    return n ? LT_OK : lt_error(LT_EINVAL, "%s: no frame of %s has initial poses of hand and object", data->root,
                                data->split);
}

static size_t sequence_length(const char *frame)
{
    const char *slash = strrchr(frame, '/');

    return slash ? (size_t)(slash - frame) : 0;
}

/* Of n frames from at on, whether one of some shows anything. */
static lt_status check_sequence(const hogs_source *s, int64_t at, int64_t n, lt_arena *arena)
{
    const char *first = dataset_name(s->data, s->index[at]);

    for (int k = 0; k < LOOKED_AT; k++) {
        dataset_sample sample;
        const int64_t index = s->index[at + k * n / LOOKED_AT];
        const lt_status st = dataset_read(s->data, index, SAMPLE_SEGMENTS, arena, &sample);
        const int64_t cells = st ? 0 : (int64_t)sample.segments_width * sample.segments_height;

        if (st)
            return LT_OK;                       /* the loader's affair */
        if (!(sample.flags & SAMPLE_SEGMENTS))
            return lt_error(LT_EINVAL, "%s: there is no mask of hand and object in %s; data.masks=initial takes their "
                            "silhouettes under the initial poses", sample.name, s->data->root);
        for (int64_t i = 0; i < cells; i++)
            if (sample.segments[i])
                return LT_OK;
    }
    return lt_error(LT_EINVAL, "%s: masks of sequence %.*s are empty in all of %d frames that were looked at; leave it "
                    "out, or take data.masks=initial", s->data->root, (int)sequence_length(first), first, LOOKED_AT);
}

lt_status hogs_frames_check(const hogs_source *s)
{
    lt_status st = LT_OK;

    for (int64_t at = 0, n; at < s->count && !st && s->masks == HOGS_MASKS_DATA; at += n) {
        const char *first = dataset_name(s->data, s->index[at]);
        const size_t length = sequence_length(first);
        lt_arena *arena = lt_arena_new();

        for (n = 1; at + n < s->count; n++) {
            const char *next = dataset_name(s->data, s->index[at + n]);

            if (sequence_length(next) != length || strncmp(next, first, length) != 0)
                break;
        }
        st = arena ? check_sequence(s, at, n, arena) : lt_error(LT_ENOMEM, "%s: no memory", s->data->root);
        lt_arena_free(arena);
    }
    return st;
}
