/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A run: cast and props, the takes, and what a dataset has besides its frames.
 */
#include "synth/generate.h"

#include "assets/ycb/objects.h"
#include "libtensor/io/file.h"
#include "synth/actions/actions.h"
#include "synth/body/set.h"
#include "synth/detect/detect.h"
#include "synth/film.h"
#include "synth/preset.h"
#include "synth/track/track.h"
#include "synth/turntable/turntable.h"
#include "synth/workplace/workplace.h"
#include "synth/write/model.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const synth_layout_ops *const layouts[] = {
    [SYNTH_HO3D] = &synth_layout_ho3d, [SYNTH_DEXYCB] = &synth_layout_dexycb,
};

/* ---- preparing ---- */

/* One that was stopped has a folder that is made first, and no manifest, which is written last. */
static bool is_unfinished(const char *path)
{
    static const char *const first[] = { "models", "annotations", "train", "body.npy", "images", "masks" };
    char folder[4096], manifest[4096];
    bool begun = false;

    for (size_t i = 0; i < LT_COUNT(first); i++) {
        snprintf(folder, sizeof(folder), "%s/%s", path, first[i]);
        begun = begun || lt_is_folder(folder);
    }
    snprintf(manifest, sizeof(manifest), "%s/manifest.json", path);
    return begun && access(manifest, F_OK) != 0;
}

static lt_status need_empty_folder(const char *path)
{
    DIR *d = opendir(path);
    struct dirent *e;
    lt_status st = LT_OK;

    if (!d && errno == ENOENT)
        return lt_make_dirs(path);
    if (!d)
        return lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    if (is_unfinished(path))
        st = lt_error(LT_EINVAL, "%s: holds a dataset that was not finished; remove it, and it is made anew", path);
    while (!st && (e = readdir(d)))
        if (strcmp(e->d_name, ".") && strcmp(e->d_name, ".."))
            st = lt_error(LT_EINVAL, "%s: is not empty (it holds %s); a dataset wants a folder of its own",
                          path, e->d_name);
    closedir(d);
    return st;
}

static lt_status make_cast(synth_run *r)
{
    lt_status st = r->layout->plan(r->session.opt, &r->session.cast);
    synth_subject *subject;

    if (!st)
        st = synth_hand_new(r->session.arena, SYNTH_HAND_MANO_LIKE, &r->session.hand);
    if (st)
        return st;
    synth_hand_parts(r->session.hand, r->part);
    for (int i = 0; i < r->session.cast.n_takes; i++)
        r->total += r->session.cast.take[i].frames * r->session.cast.n_cameras;
    subject = lt_arena_array(r->session.arena, (size_t)r->session.cast.n_subjects, sizeof(*subject));
    r->prop = lt_arena_array(r->session.arena, (size_t)r->session.cast.n_objects, sizeof(*r->prop));
    if (!subject || !r->prop)
        return lt_error(LT_ENOMEM, "synth: no memory for the cast");
    for (int i = 0; i < r->session.cast.n_subjects; i++)
        synth_subject_draw(r->session.hand, r->session.opt->seed, i, &subject[i]);
    r->session.subject = subject;
    return LT_OK;
}

static lt_status make_props(synth_run *r)
{
    for (int i = 0; i < r->session.cast.n_objects; i++) {
        synth_prop *p = &r->prop[i];
        synth_file file[4];
        lt_status st = synth_report(r, "objects");
        if (!st)
            st = synth_prop_new(r->session.arena, r->session.cast.object[i], r->session.opt->alias_ycb, p);
        if (!st)
            st = synth_write_model(r->session.opt->out, p->name, &p->mesh, (const uint8_t (*)[3])p->rgb,
                                   SYNTH_TEXTURE, p->points, SYNTH_POINTS, file);
        if (!st)
            st = synth_manifest_add(&r->session.manifest, file, 4);
        if (st)
            return st;
    }
    return LT_OK;
}

/* Props in the mirror, where a take has a left hand. */
static lt_status mirror_props(synth_run *r)
{
    const int n = r->session.cast.n_objects;
    bool left = false;

    for (int i = 0; i < r->session.cast.n_takes; i++)
        left = left || r->session.cast.take[i].left;
    if (!left)
        return LT_OK;
    r->mirrored = lt_arena_array(r->session.arena, (size_t)n, sizeof(*r->mirrored));
    if (!r->mirrored)
        return lt_error(LT_ENOMEM, "synth: no memory for the cast");
    for (int i = 0; i < n; i++) {
        lt_status st = synth_report(r, "mirrored objects");
        if (!st)
            st = synth_prop_mirror(r->session.arena, &r->prop[i], &r->mirrored[i]);
        if (st)
            return st;
    }
    return LT_OK;
}

/* ---- the run ---- */

/* The layout's last files; then the figures, and the manifest last of all. */
static lt_status finish(synth_run *r, synth_figure figure[SYNTH_FIGURES], int *n)
{
    synth_session *s = &r->session;
    lt_status st = r->layout->close(s);

    if (!st && s->cast.hogs)
        st = synth_hogs_close(&r->hogs, s, &r->stats);
    *n = synth_stats_figures(&r->stats, figure);
    return st ? st : synth_finish(&s->manifest, s->opt, s->hand,
                                  &(synth_result){ "frames", r->stats.n, figure, *n, false });
}

static void clean_up(synth_run *r)
{
    r->layout->abort(&r->session);
    synth_hogs_fini(&r->hogs);
    lt_arena_free(r->session.arena);
}

lt_status synth_parse_layout(const char *name, synth_layout *out)
{
    for (size_t i = 0; i < LT_COUNT(layouts); i++)
        if (!strcmp(name, layouts[i]->name)) {
            *out = (synth_layout)i;
            return LT_OK;
        }
    return lt_error(LT_EINVAL, "no layout \"%s\": ho3d or dexycb", name);
}

/* A dataset of takes, in one of the layouts. */
static lt_status generate_takes(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    synth_run r = { .session = { .opt = options, .arena = lt_arena_new() },
                    .layout = layouts[options->layout] };
    lt_status st;

    if (!r.session.arena)
        return lt_error(LT_ENOMEM, "synth: no memory");
    r.session.manifest.arena = r.stats.arena = r.session.arena;
    r.session.manifest.layout = options->png ? r.layout->title_png : r.layout->title;
    r.session.manifest.axes = r.layout->axes;
    st = make_cast(&r);
    if (!st) {
        r.session.manifest.width = SYNTH_WIDTH / r.session.cast.shrink;
        r.session.manifest.height = SYNTH_HEIGHT / r.session.cast.shrink;
    }
    if (!st)
        st = need_empty_folder(options->out);
    if (!st)
        st = make_props(&r);
    if (!st)
        st = mirror_props(&r);
    if (!st)
        st = r.layout->open(&r.session);
    if (!st && r.session.cast.hogs)
        st = synth_hogs_open(&r.hogs);
    if (!st)
        st = synth_film_takes(&r);
    if (!st)
        st = finish(&r, figures, n);
    clean_up(&r);
    return st;
}

lt_status synth_generate(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    static lt_status (*const without_takes[])(const synth_options *, synth_figure *, int *) = {
        [SYNTH_DETECT] = synth_detect, [SYNTH_TRACK] = synth_track, [SYNTH_ACTIONS] = synth_actions,
        [SYNTH_BODY] = synth_body_set,
        [SYNTH_TURNTABLE] = synth_turntable, [SYNTH_WORLD] = synth_workplace,
    };
    synth_figure unwanted[SYNTH_FIGURES];
    int count;
    lt_status st;

    figures = figures ? figures : unwanted;
    n = n ? n : &count;
    if (!without_takes[options->preset])
        return generate_takes(options, figures, n);
    st = need_empty_folder(options->out);
    return st ? st : without_takes[options->preset](options, figures, n);
}
