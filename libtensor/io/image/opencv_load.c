/* SPDX-License-Identifier: Apache-2.0 */
/* Finds and loads the module, keeps it, and asks it. */
#include "libtensor/io/image/opencv.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/codec.h"
#include "libtensor/io/image/exif.h"
#include "libtensor/io/image/film.h"
#include "libtensor/io/image/film_head.h"
#include "libtensor/io/image/opencv_module.h"
#include "libtensor/io/module.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const lt_opencv *opencv;                 /* NULL: there is none */

static void find_module(void)
{
    opencv = lt_module_symbol(LT_OPENCV_MODULE, LT_OPENCV_SYMBOL);
}

typedef struct {
    lt_arena *arena;
    const char *name;
    lt_image img;
    lt_status status;
} request;

static uint8_t *make_room(void *ctx, int width, int height, int channels, int bits)
{
    request *r = ctx;

    r->status = lt_image_check(r->name, (uint64_t)width, (uint64_t)height);
    if (!r->status)
        r->status = lt_image_init(r->arena, width, height, channels, bits, &r->img);
    return r->status ? NULL : r->img.data;
}

lt_status lt_opencv_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out)
{
    request r = { .arena = arena, .name = name };
    char error[256];

    pthread_once(&once, find_module);
    if (!opencv)
        return lt_error(LT_EFORMAT, "%s: neither PNG nor JPEG; other formats need a build with OpenCV%s", name,
                        LT_MODULE_HINT);
    if (opencv->decode(bytes, n, make_room, &r, error))
        return r.status ? r.status : lt_error(LT_EFORMAT, "%s: %s", name, error);
    *out = r.img;
    return LT_OK;
}

/* ---- films ----------------------------------------------------------------------------------------------- */

struct lt_film {
    void *film;
    char *path;
    double fps, frames;
    int orientation;
};

static lt_status check_file(const char *path)
{
    struct stat info;

    if (access(path, R_OK) != 0 || stat(path, &info) != 0)
        return lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    return S_ISREG(info.st_mode) ? LT_OK : lt_error(LT_EIO, "%s: not a regular file", path);
}

static lt_status open_film(lt_film *f)
{
    const lt_film_head head = lt_film_head_read(f->path);
    char error[256];

    f->orientation = head.orientation;
    f->film = opencv->film_open(f->path, &f->fps, &f->frames, error);
    if (!f->film && head.want_bytes)
        return lt_error(LT_EFORMAT, "%s: %s: it is cut off, and would have %jd bytes; copy or download it again",
                        f->path, error, (intmax_t)head.want_bytes);
    return f->film ? LT_OK : lt_error(LT_EFORMAT, "%s: %s", f->path, error);
}

/* A film without its reader */
static lt_status new_film(const char *path, lt_film **out)
{
    lt_film *f;

    pthread_once(&once, find_module);
    if (!opencv)
        return lt_error(LT_EFORMAT, "%s: films need a build with OpenCV%s; or make images of it first", path,
                        LT_MODULE_HINT);
    f = lt_alloc(sizeof(*f));
    if (f)
        *f = (lt_film){ .path = strdup(path), .orientation = 1 };
    if (f && f->path) {
        *out = f;
        return LT_OK;
    }
    lt_release(f);
    return lt_error(LT_ENOMEM, "%s: no memory", path);
}

lt_status lt_film_open(const char *path, lt_film **out)
{
    lt_film *f;
    lt_status st = check_file(path);

    st = st ? st : new_film(path, &f);
    if (st)
        return st;
    st = open_film(f);
    if (st)
        lt_film_close(f);
    else
        *out = f;
    return st;
}

lt_status lt_film_open_camera(int number, lt_film **out)
{
    char path[32], error[256];
    lt_film *f;
    lt_status st;

    snprintf(path, sizeof(path), "/dev/video%d", number);
    st = new_film(path, &f);
    if (st)
        return st;
    f->film = opencv->camera_open(number, error);
    if (!f->film) {
        lt_film_close(f);
        return lt_error(LT_EIO, "%s: %s", path, error);
    }
    *out = f;
    return LT_OK;
}

void lt_film_close(lt_film *film)
{
    if (!film)
        return;
    if (film->film)
        opencv->film_close(film->film);
    free(film->path);
    lt_release(film);
}

double lt_film_fps(const lt_film *film)
{
    return film->fps > 0 && film->fps < 1e4 ? film->fps : 0;
}

int64_t lt_film_frames(const lt_film *film)
{
    return film->frames > 0 && film->frames < 1e9 ? (int64_t)film->frames : 0;
}

int lt_film_orientation(const lt_film *film)
{
    return film->orientation;
}

/* The stored frame turned, in the arena beside it */
static lt_status turn_frame(const lt_film *film, lt_arena *arena, lt_image *frame)
{
    const bool across = film->orientation >= 5;
    lt_image turned;
    lt_status st = lt_image_init(arena, across ? frame->height : frame->width, across ? frame->width : frame->height,
                                 frame->channels, frame->bits, &turned);

    if (st)
        return lt_error_prefix(st, "%s", film->path);
    lt_exif_upright(film->orientation, frame->width, frame->height, 3, frame->data, turned.data);
    *frame = turned;
    return LT_OK;
}

lt_status lt_film_next(lt_film *film, lt_arena *arena, lt_image *out, bool *more)
{
    request r = { .arena = arena, .name = film->path };
    char error[256];
    lt_status st = LT_OK;

    *more = opencv->film_next(film->film, make_room, &r, error) == 0;
    if (*more && film->orientation != 1)
        st = turn_frame(film, arena, &r.img);
    if (*more && !st)
        *out = r.img;
    if (*more)
        return st;
    return r.status ? r.status : error[0] ? lt_error(LT_EFORMAT, "%s: %s", film->path, error) : LT_OK;
}

/* ---- films to write ---------------------------------------------------------------------------------------- */

struct lt_film_writer {
    void *film;
    lt_atomic_file file;            /* which OpenCV writes by its name */
    int width, height;
};

lt_status lt_film_create(const char *path, int width, int height, double fps, lt_film_writer **out)
{
    lt_film_writer *f;
    char error[256];
    lt_status st;

    pthread_once(&once, find_module);
    if (!opencv)
        return lt_error(LT_EFORMAT, "%s: films need a build with OpenCV%s", path, LT_MODULE_HINT);
    f = lt_alloc(sizeof(*f));
    if (!f)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    *f = (lt_film_writer){ .width = width, .height = height };
    st = lt_atomic_open_named(&f->file, path);
    if (!st && !(f->film = opencv->film_create(f->file.temp, width, height, fps, error)))
        st = lt_error(LT_EIO, "%s: %s", path, error);
    if (st)
        lt_film_abort(f);
    else
        *out = f;
    return st;
}

lt_status lt_film_put(lt_film_writer *f, const lt_image *frame)
{
    char error[256];

    if (frame->width != f->width || frame->height != f->height || frame->channels != 3 || frame->bits != 8)
        return lt_error(LT_EINVAL, "%s: a frame of %d x %d pixels, want %d x %d, RGB of 8 bits", f->file.path,
                        frame->width, frame->height, f->width, f->height);
    return opencv->film_put(f->film, f->width, f->height, frame->data, error) == 0
        ? LT_OK : lt_error(LT_EIO, "%s: %s", f->file.path, error);
}

lt_status lt_film_finish(lt_film_writer *f)
{
    lt_status st;

    opencv->film_finish(f->film);
    st = lt_atomic_commit(&f->file);
    lt_release(f);
    return st;
}

void lt_film_abort(lt_film_writer *f)
{
    if (!f)
        return;
    if (f->film)
        opencv->film_finish(f->film);
    lt_atomic_abort(&f->file);
    lt_release(f);
}
