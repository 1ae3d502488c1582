/* SPDX-License-Identifier: Apache-2.0 */
/* Finds and loads the module, and keeps it. */
#include "libtensor/io/opencv.h"

#include "libtensor/io/codec.h"
#include "libtensor/io/opencv_module.h"

#include <dlfcn.h>
#include <libgen.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static lt_opencv_fn decode;                     /* NULL: there is none */

static bool load(const char *folder, const char *within)
{
    char path[2 * PATH_MAX];
    void *module, *symbol;

    snprintf(path, sizeof(path), "%s%s/%s", folder, within, LT_OPENCV_MODULE);
    module = access(path, R_OK) == 0 ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
    symbol = module ? dlsym(module, LT_OPENCV_SYMBOL) : NULL;
    if (symbol)
        memcpy(&decode, &symbol, sizeof(decode));
    return symbol != NULL;
}

/* Where the environment says; beside the program in a build folder; where it was installed. */
static void find_module(void)
{
    const char *named = getenv("PALMAR_MODULES");
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof(self) - 1);

    if (named && load(named, ""))
        return;
    self[n > 0 ? n : 0] = '\0';
    if (n > 0 && load(dirname(self), "/.libs"))
        return;
    load(PALMAR_LIBDIR, "");
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
    if (!decode)
        return lt_error(LT_EFORMAT, "%s: neither PNG nor JPEG; other formats need a build with OpenCV", name);
    if (decode(bytes, n, make_room, &r, error))
        return r.status ? r.status : lt_error(LT_EFORMAT, "%s: %s", name, error);
    *out = r.img;
    return LT_OK;
}
