/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras, objects and masks beside the annotated hands. */
#include "data/check.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Metres from a wrist to the middle of its object, by the median: apart are those of a slip, together what it would
 * make of them. */
static const double APART = 1, TOGETHER = 0.5;

typedef struct { double wrist[3], offset[3], t[3]; } held;      /* the object's middle is offset + t */

typedef struct {
    const dataset *d;
    int64_t n;
    held *object;
    double *room;                   /* n numbers */
} scene;

static void add_object(scene *c, const dataset_sample *s)
{
    const float *m = c->d->objects[s->object].control[20];
    held *h = &c->object[c->n++];
    float A[9];

    dataset_model_to_camera(s, A);
    for (int k = 0; k < 3; k++) {
        h->wrist[k] = s->root[k];
        h->t[k] = s->t[k];
        h->offset[k] = (double)A[3 * k] * m[0] + (double)A[3 * k + 1] * m[1] + (double)A[3 * k + 2] * m[2];
    }
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* The median distance with translations times 10^power, y and z times sign. */
static double apart(const scene *c, int power, int sign)
{
    const double scale = pow(10, power);

    for (int64_t i = 0; i < c->n; i++) {
        const held *h = &c->object[i];
        double middle[3];
        for (int k = 0; k < 3; k++)
            middle[k] = h->offset[k] + scale * (k ? sign : 1) * h->t[k];
        c->room[i] = lt_vec3_distance(middle, h->wrist);
    }
    qsort(c->room, (size_t)c->n, sizeof(*c->room), by_value);
    return c->n ? c->room[c->n / 2] : 0;
}

static void explain_object(const scene *c, slip *out)
{
    static const int powers[] = { 0, -3, -2, -1, 1, 2, 3 };
    char unit[SLIP_UNIT];

    for (size_t i = 0; i < 2 * LT_COUNT(powers); i++) {
        const int power = powers[i / 2], sign = i % 2 ? -1 : 1;
        if (!(apart(c, power, sign) < TOGETHER))
            continue;
        out->code = power ? "unit" : "axes";
        snprintf(out->text, sizeof(out->text), "the objects' translations %s%s%s%s", power ? "are " : "",
                 power ? slip_unit_words(power, false, unit) : "", power && sign < 0 ? ", and " : "", sign > 0 ? "" :
                 c->d->opengl ? "have OpenCV's axes, not OpenGL's" : "have OpenGL's axes, not OpenCV's");
        out->after = apart(c, power, sign);
        return;
    }
}

static void look_at(scene *c, const dataset_sample *s, check_scene *out)
{
    slip camera;

    out->samples++;
    slip_in_camera(&s->camera, s->width, s->height, &camera);
    if (camera.code && !out->odd_cameras++) {
        out->camera = camera;
        out->odd_camera = s->name;
    }
    if ((s->flags & SAMPLE_OBJECT) && (s->flags & SAMPLE_ROOT) && s->object >= 0)
        add_object(c, s);
}

lt_status check_cameras_and_objects(const dataset *d, int64_t n, check_scene *out)
{
    lt_arena *memory = lt_arena_new();
    scene c = { .d = d };

    *out = (check_scene){ 0 };
    n = lt_min_i64(n, d->count);
    c.object = memory ? lt_arena_array(memory, (size_t)n, sizeof(*c.object)) : NULL;
    c.room = memory ? lt_arena_array(memory, (size_t)n, sizeof(*c.room)) : NULL;
    if (!c.object || !c.room) {
        lt_arena_free(memory);
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    }
    for (int64_t i = 0; i < n; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        if (arena && !dataset_annotation(d, i * d->count / n, arena, &s))
            look_at(&c, &s, out);
        lt_arena_free(arena);
    }
    out->objects = c.n;
    out->apart = out->object.before = apart(&c, 0, 1);
    if (out->apart > APART)
        explain_object(&c, &out->object);
    lt_arena_free(memory);
    return LT_OK;
}

/* ---- masks ---- */

/* The joints of a sample that lie in the picture, and those of them that the mask has. */
static void count_joints(const dataset_sample *s, check_masks *out)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double u = s->joints2d[i][0] + 0.5, v = s->joints2d[i][1] + 0.5;
        int x, y;
        if (!(u >= 0 && u < s->width && v >= 0 && v < s->height))
            continue;
        x = (int)(u * s->segments_width / s->width);
        y = (int)(v * s->segments_height / s->height);
        out->joints++;
        out->on_mask += s->segments[(size_t)y * (size_t)s->segments_width + (size_t)x] != 0;
    }
}

lt_status check_masks_on_hands(const dataset *d, int64_t n, check_masks *out)
{
    *out = (check_masks){ 0 };
    n = lt_min_i64(n, d->count);
    for (int64_t i = 0; i < n; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample s;
        if (!arena)
            return lt_error(LT_ENOMEM, "%s: no memory", d->root);
        if (!dataset_read(d, i * d->count / n, SAMPLE_SEGMENTS, arena, &s) && (s.flags & SAMPLE_SEGMENTS) &&
            (s.flags & SAMPLE_JOINTS)) {
            count_joints(&s, out);
            out->masks++;
        }
        lt_arena_free(arena);
    }
    return LT_OK;
}

bool check_masks_good(const check_masks *c)
{
    return 2 * c->on_mask >= c->joints;
}
