/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/mot.h"

#include "libtensor/io/file.h"

#include <stdio.h>

static const double SCORED = 0.1;               /* visible share from which on a thing is scored */

lt_status synth_mot_open(synth_mot *m, const char *split, const char *name)
{
    lt_status st;

    *m = (synth_mot){ .split = split };
    snprintf(m->name, sizeof(m->name), "%s", name);
    st = synth_growing_open(&m->gt, "gt.txt");
    if (!st)
        st = synth_growing_open(&m->det, "det.txt");
    return st ? st : synth_growing_open(&m->masks, "masks.txt");
}

void synth_mot_fini(synth_mot *m)
{
    synth_growing_fini(&m->gt);
    synth_growing_fini(&m->det);
    synth_growing_fini(&m->masks);
}

void synth_mot_add_truth(synth_mot *m, int k, const synth_mot_truth *t, int width, int height)
{
    const synth_pixels *b = &t->box;
    const bool scored = t->visible >= SCORED;

    fprintf(m->gt.stream, "%d,%d,%d,%d,%d,%d,%d,1,%.4f\n", k + 1, t->id, b->x0 + 1, b->y0 + 1, b->x1 - b->x0,
            b->y1 - b->y0, scored, t->visible);
    if (scored)
        fprintf(m->masks.stream, "%d %d 2 %d %d %s\n", k + 1, 2000 + t->id, height, width, t->counts);
}

void synth_mot_add_detection(synth_mot *m, int k, const synth_mot_detection *d)
{
    fprintf(m->det.stream, "%d,-1,%.2f,%.2f,%.2f,%.2f,%.4f,-1,-1,-1\n", k + 1, d->x0 + 1, d->y0 + 1, d->x1 - d->x0,
            d->y1 - d->y0, d->score);
}

static lt_status make_folders(const synth_mot *m, const char *root)
{
    static const char *const folder[] = { "gt", "det" };
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", m->name);

    for (int i = 0; !st && i < 2; i++) {
        const char *path = lt_arena_printf(arena, "%s/%s/%s/%s", root, m->split, m->name, folder[i]);
        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", m->name);
    }
    lt_arena_free(arena);
    return st;
}

static lt_status write_as(const synth_mot *m, synth_growing *g, const char *root, const char *name,
                          synth_manifest *manifest)
{
    char within[128];

    snprintf(within, sizeof(within), "%s/%s/%s", m->split, m->name, name);
    return synth_growing_write(g, root, within, manifest);
}

static lt_status write_times(const synth_mot *m, const char *root, const double *time, int frames,
                             synth_manifest *manifest)
{
    synth_growing g;
    const lt_status st = synth_growing_open(&g, "times.csv");

    if (st)
        return st;
    fprintf(g.stream, "frame,time\n");
    for (int k = 0; k < frames; k++)
        fprintf(g.stream, "%d,%.6f\n", k + 1, time[k]);
    return write_as(m, &g, root, "times.csv", manifest);
}

lt_status synth_mot_close(synth_mot *m, const char *root, const char *images, const double *time, int frames, int width,
                          int height, synth_manifest *manifest)
{
    synth_growing info;
    lt_status st = make_folders(m, root);

    if (!st)
        st = write_as(m, &m->gt, root, "gt/gt.txt", manifest);
    if (!st)
        st = write_as(m, &m->masks, root, "gt/masks.txt", manifest);
    if (!st)
        st = write_as(m, &m->det, root, "det/det.txt", manifest);
    if (!st)
        st = write_times(m, root, time, frames, manifest);
    if (!st)
        st = synth_growing_open(&info, "seqinfo.ini");
    if (st)
        return st;
    fprintf(info.stream, "[Sequence]\nname=%s\nimDir=%s\nframeRate=30\nseqLength=%d\nimWidth=%d\nimHeight=%d\n"
            "imExt=.jpg\n", m->name, images, frames, width, height);
    return write_as(m, &info, root, "seqinfo.ini", manifest);
}
