/* SPDX-License-Identifier: Apache-2.0 */
/* The ground-truth files of HO3D's evaluation: a gigabyte of text becomes one array. */
#include "data/ho3d/ho3d.h"

#include "data/ho3d/points.h"

static lt_status read_frames(ho3d_points *file, const char *path, int64_t n, int points, float *out)
{
    const size_t size = 3 * (size_t)points;
    float last[3 * 778];
    int64_t frame = 0;

    for (bool more = true;; frame++) {
        const lt_status st = ho3d_points_next(file, frame < n ? out + size * (size_t)frame : last, &more);
        if (st)
            return st;
        if (!more)
            break;
        if (frame == n)
            return lt_error(LT_EFORMAT,
                            "%s: frame %lld, point 0: found one more frame, expected the end: evaluation.txt "
                            "lists no more", path, (long long)frame);
    }
    if (frame != n)
        return lt_error(LT_EFORMAT, "%s: has %lld frames, evaluation.txt lists %lld", path, (long long)frame,
                        (long long)n);
    return LT_OK;
}

lt_status ho3d_read_truth(lt_arena *arena, const char *path, int64_t n, int points, float **out)
{
    ho3d_points *file;
    float *x;
    lt_status st = ho3d_points_open(path, &points, 1, &file);

    if (st)
        return st;
    st = lt_arena_try(arena, (size_t)n * (size_t)points * 3 * sizeof(float), (void **)&x);
    if (!st)
        st = read_frames(file, path, n, points, x);
    ho3d_points_close(file);
    if (!st)
        *out = x;
    return st;
}
