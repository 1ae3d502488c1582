/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/truth.h"

#include "libtensor/geometry/camera.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/number.h"

#include <stdio.h>

static lt_status open_one(lt_atomic_file *f, const char *root, const char *name)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_path_join(arena, root, name) : NULL;
    const lt_status st = path ? lt_atomic_open(f, path) : lt_error(LT_ENOMEM, "%s: no memory", name);

    lt_arena_free(arena);
    return st;
}

lt_status synth_truth_open(synth_truth *t, const char *root)
{
    lt_status st;

    *t = (synth_truth){ 0 };
    st = open_one(&t->xyz, root, "evaluation_xyz.json");
    if (st)
        return st;
    st = open_one(&t->verts, root, "evaluation_verts.json");
    if (st)
        lt_atomic_abort(&t->xyz);
    t->open = !st;
    return st;
}

/* "[[x, y, z], ...]" in OpenGL's axes, after a bracket or a comma. */
static void add_points(FILE *f, const double (*p)[3], int n, bool first)
{
    char text[3][LT_NUMBER_TEXT];

    fputs(first ? "[" : ",\n", f);
    for (int i = 0; i < n; i++) {
        double x[3] = { p[i][0], p[i][1], p[i][2] };

        lt_flip_yz(x);
        for (int k = 0; k < 3; k++)
            lt_print_float((float)x[k], text[k]);
        fprintf(f, "%s[%s,%s,%s]", i ? "," : "[", text[0], text[1], text[2]);
    }
    fputs("]", f);
}

void synth_truth_add(synth_truth *t, const double joints[LT_HAND_KEYPOINTS][3],
                     const double vertices[LT_HAND_VERTICES][3])
{
    add_points(t->xyz.stream, joints, LT_HAND_KEYPOINTS, t->count == 0);
    add_points(t->verts.stream, vertices, LT_HAND_VERTICES, t->count == 0);
    t->count++;
}

lt_status synth_truth_commit(synth_truth *t)
{
    lt_status st;

    fputs(t->count ? "]\n" : "[]\n", t->xyz.stream);
    fputs(t->count ? "]\n" : "[]\n", t->verts.stream);
    t->open = false;
    st = lt_atomic_commit(&t->xyz);
    if (st) {
        lt_atomic_abort(&t->verts);
        return st;
    }
    return lt_atomic_commit(&t->verts);
}

void synth_truth_abort(synth_truth *t)
{
    if (!t->open)
        return;
    lt_atomic_abort(&t->xyz);
    lt_atomic_abort(&t->verts);
    t->open = false;
}
