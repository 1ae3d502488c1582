/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/predict_film.h"

#include "estimate/posed/turntable.h"
#include "libtensor/io/image/film.h"
#include "tasks/tasks.h"

#include <inttypes.h>

enum { TURN_VIEWS = 120 };

static const double FRAMES_FPS = 10, TURN_FPS = 30;

typedef struct {
    const cli_film *film;
    lt_film_writer *to;             /* NULL before the first frame, which says how large it is */
    int width, height;
    int64_t frames;
} filming;

static lt_status put(filming *j, int width, int height, const uint8_t *rgb)
{
    const double fps = j->film->fps > 0 ? j->film->fps : j->film->turn ? TURN_FPS : FRAMES_FPS;
    const lt_image image = { width, height, 3, 8, (uint8_t *)rgb };
    lt_status st = j->to ? LT_OK : lt_film_create(j->film->path, width, height, fps, &j->to);

    if (!st)
        st = lt_film_put(j->to, &image);
    j->frames += !st;
    return st;
}

static lt_status put_turned(void *ctx, const uint8_t *rgb)
{
    filming *j = ctx;

    if (cli_stop_requested())
        return lt_error(LT_ESTOPPED, "stopped");
    return put(j, j->width, j->height, rgb);
}

/* The truth at the left of what was drawn */
static lt_status put_beside(filming *j, const posed_frame *f)
{
    uint8_t *both = lt_alloc(6 * (size_t)f->width * (size_t)f->height);
    lt_status st;

    if (!both)
        return lt_error(LT_ENOMEM, "no memory for a frame of the film");
    posed_beside(f, both);
    st = put(j, 2 * f->width, f->height, both);
    lt_release(both);
    return st;
}

static lt_status take_frame(void *ctx, const posed_frame *f)
{
    filming *j = ctx;

    j->width = f->width;
    j->height = f->height;
    return j->film->turn ? turntable_draw(f, TURN_VIEWS, put_turned, j) : put_beside(j, f);
}

static bool stop(void)
{
    return cli_stop_requested();
}

lt_status cli_film_write(const cli_film *film, cli_checkpoint *c, const char *hand, const char *data, int64_t *frames)
{
    filming j = { .film = film };
    const task_posing p = { .arena = c->arena, .config = &c->config, .checkpoint = c->path, .hand = hand, .data = data,
                            .n_frames = film->turn ? 1 : INT64_MAX, .visit = take_frame, .ctx = &j, .stop = stop };
    lt_status st = c->config.task->pose ? c->config.task->pose(&p)
        : lt_error(LT_EINVAL, "%s: a model of %s, which draws no frames; --film wants one of hogs or splats", c->path,
                   c->config.task->name);

    if (!st && !j.frames)
        st = lt_error(LT_EINVAL, "%s: no frame shows anything", film->path);
    if (st)
        lt_film_abort(j.to);
    else
        st = lt_film_finish(j.to);
    *frames = j.frames;
    return st;
}
