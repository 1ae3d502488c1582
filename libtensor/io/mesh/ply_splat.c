/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PLY: 3D Gaussians, one vertex each.
 *
 * Source: graphdeco-inria/gaussian-splatting scene/gaussian_model.py (save_ply, construct_list_of_attributes).
 */
#include "libtensor/io/mesh/ply.h"

#include "libtensor/io/atomic_file.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum { FLOATS = sizeof(lt_splat) / sizeof(float), REST = 45, REST_PER_COLOUR = 15 };

/* Runs of properties as they follow each other in a file: "name0", "name1" ... or the names themselves. */
static const struct {
    const char *const *names, *stem;
    int n;
    bool needed;
} runs[] = {
    { (const char *const[]){ "x", "y", "z" }, NULL, 3, true },
    { (const char *const[]){ "nx", "ny", "nz" }, NULL, 3, false },
    { NULL, "f_dc_", 3, true },
    { NULL, "f_rest_", REST, false },
    { (const char *const[]){ "opacity" }, NULL, 1, true },
    { NULL, "scale_", 3, true },
    { NULL, "rot_", 4, true },
};

static const char *name_of(size_t run, int i, char out[32])
{
    if (runs[run].names)
        return runs[run].names[i];
    snprintf(out, 32, "%s%d", runs[run].stem, i);
    return out;
}

/* One column into a float of every splat. */
static lt_status take_column(const lt_ply *p, const lt_ply_property *column, size_t at, lt_splat *splat, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const float x = (float)lt_array_get(&column->values, i);

        if (!isfinite(x))
            return lt_error(LT_EFORMAT, "%s: %s of Gaussian %zu is not finite", p->path, column->name, i);
        ((float *)&splat[i])[at] = x;
    }
    return LT_OK;
}

/* A colour's numbers of a lower degree are fewer, and the next colour's follow at once. */
static size_t rest_place(int i, int n_rest)
{
    const int per_colour = n_rest / 3;

    return (size_t)(i / per_colour * REST_PER_COLOUR + i % per_colour);
}

static int count_rest(const lt_ply *p)
{
    char name[32];
    int n = 0;

    while (n < REST && lt_ply_find(p, "vertex", name_of(3, n, name), NULL))
        n++;
    return n;
}

static lt_status take_run(const lt_ply *p, size_t run, size_t at, int n_rest, lt_splat *splat, size_t n)
{
    const bool rest = runs[run].n == REST;
    const int count = rest ? n_rest : runs[run].n;
    lt_status st = LT_OK;

    for (int i = 0; !st && i < count; i++) {
        char name[32];
        const lt_ply_property *column = lt_ply_find(p, "vertex", name_of(run, i, name), NULL);

        if (column && !column->is_list)
            st = take_column(p, column, at + (rest ? rest_place(i, n_rest) : (size_t)i), splat, n);
        else if (column || runs[run].needed)
            st = lt_error(LT_EFORMAT, "%s: Gaussians without a number \"%s\"", p->path, name_of(run, i, name));
    }
    return st;
}

lt_status lt_ply_splats(lt_arena *arena, const lt_ply *p, lt_splat **out, size_t *n)
{
    const int n_rest = count_rest(p);
    lt_splat *splat;
    size_t count = 0, at = 0;
    lt_status st = LT_OK;

    if (!lt_ply_find(p, "vertex", "x", &count))
        return lt_error(LT_EFORMAT, "%s: Gaussians without a number \"x\"", p->path);
    if (n_rest != 0 && n_rest != 9 && n_rest != 24 && n_rest != REST)
        return lt_error(LT_EFORMAT, "%s: %d numbers f_rest, want 0, 9, 24 or 45", p->path, n_rest);
    splat = lt_arena_array(arena, count, sizeof(*splat));
    if (!splat)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu Gaussians", p->path, count);
    for (size_t run = 0; !st && run < LT_COUNT(runs); at += (size_t)runs[run++].n)
        st = take_run(p, run, at, n_rest, splat, count);
    if (st)
        return st;
    *out = splat;
    *n = count;
    return LT_OK;
}

static void put_float(FILE *f, float x)
{
    uint32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    for (int i = 0; i < 4; i++)
        fputc((int)(bits >> (8 * i) & 255), f);
}

lt_status lt_ply_write_splats(const char *path, const char *frame, const lt_splat *splat, size_t n)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    fprintf(f.stream, "ply\nformat binary_little_endian 1.0\ncomment SplatRenderMode: default\ncomment frame: %s\n"
            "element vertex %zu\n", frame, n);
    for (size_t run = 0; run < LT_COUNT(runs); run++) {
        char name[32];

        for (int i = 0; i < runs[run].n; i++)
            fprintf(f.stream, "property float %s\n", name_of(run, i, name));
    }
    fputs("end_header\n", f.stream);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < FLOATS; k++)
            put_float(f.stream, ((const float *)&splat[i])[k]);
    return lt_atomic_commit(&f);
}
