/* SPDX-License-Identifier: Apache-2.0 */
/* A recording in the making: files of each frame are whole before its line is written. */
#include "data/recording/recording.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { QUALITY = 92 };              /* of a JPEG */

struct recording_writer {
    lt_arena *arena;
    const char *root;
    recording_rig rig;
    FILE *frames, *sets;            /* sets: NULL: none yet */
    int64_t lines;
};

static lt_status open_lines(recording_writer *w, const char *name, FILE **out)
{
    const char *path = lt_path_join(w->arena, w->root, name);

    return path ? lt_append_own(path, out) : lt_error(LT_ENOMEM, "%s: no memory", w->root);
}

static lt_status begin(recording_writer *w)
{
    const char *rig = lt_path_join(w->arena, w->root, "recording.json");
    lt_status st = rig ? lt_make_own_folder(w->root) : lt_error(LT_ENOMEM, "%s: no memory", w->root);

    if (!st && access(rig, F_OK) == 0)
        st = lt_error(LT_EINVAL, "%s: there is a recording in it; another one wants a folder of its own", w->root);
    for (int c = 0; c < w->rig.n && !st; c++) {
        const char *folder = lt_path_join(w->arena, w->root, w->rig.camera[c].name);

        st = folder ? lt_make_own_folder(folder) : lt_error(LT_ENOMEM, "%s: no memory", w->root);
    }
    st = st ? st : open_lines(w, "frames.jsonl", &w->frames);
    return st ? st : recording_rig_write(rig, &w->rig);
}

lt_status recording_create(const char *root, const recording_rig *rig, recording_writer **out)
{
    lt_arena *arena = lt_arena_new();
    recording_writer *w = arena ? lt_arena_alloc(arena, sizeof(*w)) : NULL;
    lt_status st;

    *out = w;
    if (!w) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "%s: no memory", root);
    }
    *w = (recording_writer){ .arena = arena, .root = lt_arena_strdup(arena, root), .rig = *rig };
    for (int c = 0; c < rig->n; c++)
        w->rig.camera[c].name = lt_arena_strdup(arena, rig->camera[c].name);
    st = w->root ? begin(w) : lt_error(LT_ENOMEM, "%s: no memory", root);
    return st;
}

/* ---- frames ---- */

static lt_status store_depth(lt_arena *scratch, const char *path, const recording_camera *c, const uint16_t *depth)
{
    uint8_t *bytes;
    size_t n;
    lt_status st = recording_depth_pack(scratch, depth, c->width, c->height, &bytes, &n);

    return st ? st : lt_write_file(path, bytes, n);
}

lt_status recording_store(const recording_writer *w, int camera, int64_t k, const recording_pictures *p)
{
    const recording_camera *c = &w->rig.camera[camera];
    lt_arena *scratch = lt_arena_new();
    const char *stem = scratch ? lt_arena_printf(scratch, "%s/%s/%06lld", w->root, c->name, (long long)k) : NULL;
    const char *colour = stem ? lt_arena_printf(scratch, "%s.jpg", stem) : NULL;
    const char *depth = stem ? lt_arena_printf(scratch, "%s.z16", stem) : NULL;
    lt_status st = colour && depth ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", w->root);

    if (!st)
        st = p->jpeg ? lt_write_file(colour, p->jpeg, p->n_jpeg) : lt_jpeg_write(colour, p->colour, QUALITY);
    if (!st && p->depth)
        st = store_depth(scratch, depth, c, p->depth);
    lt_arena_free(scratch);
    return st;
}

static lt_status flush(const recording_writer *w, FILE *f)
{
    return fflush(f) == 0 && !ferror(f) ? LT_OK
        : lt_error(errno == ENOSPC ? LT_ENOSPC : LT_EIO, "%s: cannot write: %s", w->root, strerror(errno));
}

/* "key": and the name of a frame's file */
static void put_name(const recording_writer *w, const char *key, int camera, int64_t k, const char *ending)
{
    char name[300];

    snprintf(name, sizeof(name), "%s/%06lld.%s", w->rig.camera[camera].name, (long long)k, ending);
    fprintf(w->frames, ",\"%s\":", key);
    lt_json_print_string(w->frames, name);
}

lt_status recording_add(recording_writer *w, int camera, int64_t k, double t, bool depth, int64_t *line)
{
    char number[LT_JSON_NUMBER];

    fprintf(w->frames, "{\"camera\":%d,\"t\":%s", camera, lt_json_number(t, number));
    put_name(w, "colour", camera, k, "jpg");
    if (depth)
        put_name(w, "depth", camera, k, "z16");
    fputs("}\n", w->frames);
    *line = w->lines++;
    return flush(w, w->frames);
}

lt_status recording_add_set(recording_writer *w, const recording_set *set)
{
    lt_status st = w->sets ? LT_OK : open_lines(w, "sets.jsonl", &w->sets);

    if (st)
        return st;
    for (int c = 0; c < w->rig.n; c++) {
        fputs(c ? "," : "{\"frames\":[", w->sets);
        if (set->frame[c] < 0)
            fputs("null", w->sets);
        else
            fprintf(w->sets, "%lld", (long long)set->frame[c]);
    }
    fputs("]}\n", w->sets);
    return flush(w, w->sets);
}

lt_status recording_close(recording_writer *w)
{
    lt_status st = LT_OK;

    if (!w)
        return LT_OK;
    if (w->frames && fclose(w->frames) != 0)
        st = lt_error(LT_EIO, "%s: %s", w->root, strerror(errno));
    if (w->sets && fclose(w->sets) != 0)
        st = lt_error(LT_EIO, "%s: %s", w->root, strerror(errno));
    lt_arena_free(w->arena);
    return st;
}
