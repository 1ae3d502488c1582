/* SPDX-License-Identifier: Apache-2.0 */
/* What a camera may be, and which of these a source is. */
#include "pipeline/watch/camera.h"

#include "libtensor/base/clock.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/film.h"
#include "libtensor/io/text/natural.h"
#include "pipeline/internal.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const double FPS = 30;       /* where nothing is said */

void watch_camera_close(watch_camera *c)
{
    if (c->kind && c->kind->close)
        c->kind->close(c->state);
    *c = (watch_camera){ .kind = NULL };
}

lt_status watch_camera_next(watch_camera *c, const recording_camera *camera, lt_arena *arena, watch_picture *out,
                            bool *more)
{
    lt_status st = LT_OK;

    *more = true;
    if (c->has_first)
        *out = c->first;
    else
        st = c->kind->next(c->state, arena, out, more);
    c->has_first = false;
    if (!st && *more && (out->rgb.width != camera->width || out->rgb.height != camera->height))
        st = lt_error(LT_EFORMAT, "%s: a picture of %d x %d, expected %d x %d as its camera has them", c->source,
                      out->rgb.width, out->rgb.height, camera->width, camera->height);
    return st;
}

static lt_status no_memory(const char *source)
{
    return lt_error(LT_ENOMEM, "%s: no memory", source);
}

/* ---- one camera of a recording ---- */

typedef struct {
    const recording *r;
    int camera;
    int64_t at;                     /* line of frames.jsonl */
} recorded;

static lt_status recorded_next(void *state, lt_arena *arena, watch_picture *out, bool *more)
{
    recorded *s = state;
    const recording *r = s->r;
    lt_image depth;
    lt_status st;

    while (s->at < r->n_frames && r->frame[s->at].camera != s->camera)
        s->at++;
    *more = s->at < r->n_frames;
    if (!*more)
        return LT_OK;
    *out = (watch_picture){ .t = r->frame[s->at].t, .line = s->at };
    st = recording_colour(r, s->at, arena, &out->rgb);
    if (!st && r->frame[s->at].depth) {
        st = recording_depth(r, s->at, arena, &depth);
        out->depth = st ? NULL : (const uint16_t *)depth.data;
    }
    s->at++;
    return st;
}

static const watch_camera_kind recorded_kind = { .next = recorded_next };

lt_status watch_recording_camera(lt_arena *arena, const recording *r, int camera, watch_camera *out)
{
    recorded *s = lt_arena_alloc(arena, sizeof(*s));

    if (!s)
        return no_memory(r->root);
    *s = (recorded){ .r = r, .camera = camera };
    *out = (watch_camera){ .kind = &recorded_kind, .state = s, .source = r->rig.camera[camera].name };
    return LT_OK;
}

/* ---- films, and cameras, which are films without an end ---- */

typedef struct {
    lt_film *film;
    double fps;
    int64_t frame;
} filmed;

static lt_status filmed_next(void *state, lt_arena *arena, watch_picture *out, bool *more)
{
    filmed *s = state;

    *out = (watch_picture){ .t = (double)s->frame / s->fps, .line = -1 };
    s->frame++;
    return lt_film_next(s->film, arena, &out->rgb, more);
}

static void filmed_close(void *state)
{
    filmed *s = state;

    lt_film_close(s->film);
    s->film = NULL;
}

static const watch_camera_kind filmed_kind = { .next = filmed_next, .close = filmed_close };

static lt_status open_film(lt_arena *arena, const char *path, watch_camera *out)
{
    filmed *s = lt_arena_alloc(arena, sizeof(*s));
    lt_status st = s ? lt_film_open(path, &s->film) : no_memory(path);

    if (st)
        return st;
    s->fps = lt_film_fps(s->film) > 0 ? lt_film_fps(s->film) : FPS;
    *out = (watch_camera){ .kind = &filmed_kind, .state = s, .source = path };
    return LT_OK;
}

/* ---- folders of images ---- */

typedef struct {
    const char *folder, **name;
    size_t n, room, at;
} images;

static int by_name(const void *a, const void *b)
{
    return lt_natural_order(*(const char *const *)a, *(const char *const *)b);
}

static lt_status images_next(void *state, lt_arena *arena, watch_picture *out, bool *more)
{
    images *s = state;
    const char *path = s->at < s->n ? lt_path_join(arena, s->folder, s->name[s->at]) : NULL;
    lt_image image;
    lt_status st;

    *more = s->at < s->n;
    if (!*more)
        return LT_OK;
    *out = (watch_picture){ .t = (double)s->at / FPS, .line = -1 };
    s->at++;
    st = path ? lt_image_read(arena, path, &image) : no_memory(s->folder);
    return st ? st : lt_image_to_rgb8(arena, &image, &out->rgb);
}

static const watch_camera_kind images_kind = { .next = images_next };

static bool is_image(const char *name)
{
    static const char *const endings[] = { ".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG" };

    for (size_t i = 0; i < LT_COUNT(endings); i++)
        if (lt_ends_with(name, endings[i]))
            return true;
    return false;
}

static lt_status open_images(lt_arena *arena, const char *folder, watch_camera *out)
{
    images *s = lt_arena_alloc(arena, sizeof(*s));
    DIR *d = s ? opendir(folder) : NULL;
    lt_status st = s ? LT_OK : no_memory(folder);

    if (!st && !d)
        st = lt_error(LT_EIO, "%s: %s", folder, strerror(errno));
    for (const struct dirent *e; !st && (e = readdir(d)); ) {
        if (!is_image(e->d_name))
            continue;
        s->name = lt_arena_grow(arena, s->name, s->n, &s->room, sizeof(*s->name));
        if (!s->name || !(s->name[s->n++] = lt_arena_strdup(arena, e->d_name)))
            st = no_memory(folder);
    }
    if (d)
        closedir(d);
    if (!st && !s->n)
        st = lt_error(LT_EINVAL, "%s: neither a recording nor a folder with images (.jpg, .png)", folder);
    if (st)
        return st;
    qsort(s->name, s->n, sizeof(*s->name), by_name);
    s->folder = folder;
    *out = (watch_camera){ .kind = &images_kind, .state = s, .source = folder };
    return LT_OK;
}

/* ---- cameras ---- */

/* Frames come when they come: their stamps are this machine's. */
typedef struct {
    lt_film *film;
    double began;
} device;

static lt_status device_next(void *state, lt_arena *arena, watch_picture *out, bool *more)
{
    device *s = state;
    const lt_status st = lt_film_next(s->film, arena, &out->rgb, more);
    const lt_image rgb = out->rgb;

    *out = (watch_picture){ .t = lt_clock() - s->began, .rgb = rgb, .line = -1 };
    if (!st && !*more)
        return lt_error(LT_EIO, "the camera gives no more pictures: was it unplugged?");
    return st;
}

static void device_close(void *state)
{
    device *s = state;

    lt_film_close(s->film);
    s->film = NULL;
}

static const watch_camera_kind device_kind = { .next = device_next, .close = device_close };

static lt_status open_device(lt_arena *arena, const char *source, int number, watch_camera *out)
{
    device *s = lt_arena_alloc(arena, sizeof(*s));
    lt_status st = s ? lt_film_open_camera(number, &s->film) : no_memory(source);

    if (st)
        return st;
    s->began = lt_clock();
    *out = (watch_camera){ .kind = &device_kind, .state = s, .source = source, .live = true };
    return LT_OK;
}

/* "0", "/dev/video0"; -1: it is none */
static int device_number(const char *source)
{
    static const char folder[] = "/dev/video";
    const char *digits = strncmp(source, folder, strlen(folder)) == 0 ? source + strlen(folder) : source;
    const size_t n = strlen(digits);

    for (size_t i = 0; i < n; i++)
        if (!isdigit((unsigned char)digits[i]))
            return -1;
    return n > 0 && n < 4 ? atoi(digits) : -1;
}

/* ---- any of them ---- */

static lt_status open_source(lt_arena *arena, const char *source, watch_camera *out)
{
    const int number = device_number(source);

    if (number >= 0)
        return open_device(arena, source, number, out);
    return lt_is_folder(source) ? open_images(arena, source, out) : open_film(arena, source, out);
}

/* A camera of which nothing is said: it is as its first picture is, and faces the person if it is the first. */
static lt_status guess_camera(lt_arena *arena, int number, watch_camera *c, recording_camera *out)
{
    bool more;
    lt_status st = c->kind->next(c->state, arena, &c->first, &more);

    if (!st && !more)
        st = lt_error(LT_EFORMAT, "%s: there is no picture in it", c->source);
    if (st)
        return st;
    c->has_first = !c->live;            /* a live one's is old by the time that others are open */
    *out = (recording_camera){
        .name = lt_arena_printf(arena, "camera%d", number + 1), .role = number == 0 ? RECORDING_FRONT : RECORDING_TABLE,
        .width = c->first.rgb.width, .height = c->first.rgb.height,
        .K = predict_assumed_camera(0, c->first.rgb.width, c->first.rgb.height),
    };
    return out->name ? LT_OK : no_memory(c->source);
}

lt_status watch_cameras_open(lt_arena *arena, const char *const *sources, int n, recording_rig *rig, watch_camera *out)
{
    const bool calibrated = rig->n > 0;
    lt_status st = LT_OK;

    if (n < 1 || n > RECORDING_CAMERAS)
        return lt_error(LT_EUSAGE, "watch: %d sources, want 1 to %d", n, RECORDING_CAMERAS);
    if (calibrated && rig->n != n)
        return lt_error(LT_EINVAL, "--calibration: %d cameras for %d sources", rig->n, n);
    for (int c = 0; c < n && !st; c++) {
        if (recording_probe(sources[c]))
            return lt_error(LT_EUSAGE, "%s: a recording goes alone: it has all its cameras", sources[c]);
        st = open_source(arena, sources[c], &out[c]);
        if (!st && !calibrated)
            st = guess_camera(arena, c, &out[c], &rig->camera[c]);
    }
    rig->n = n;
    if (!(rig->fps > 0))
        rig->fps = FPS;
    return st;
}
