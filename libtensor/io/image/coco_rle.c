/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/image/coco_rle.h"

#include <string.h>

enum { FIRST = 48, BITS = 5, MORE = 32, SIGN = 16, DIGITS_MAX = 7 };

/* A number in groups of five bits, the lowest first; a group's sixth bit says that more follow, and the last
 * one's fifth that it is negative. */
static char *put(char *p, int64_t x)
{
    for (;;) {
        const int bits = (int)(x & 31);

        x >>= BITS;
        if ((bits & SIGN) ? x == -1 : x == 0) {
            *p++ = (char)(FIRST + bits);
            return p;
        }
        *p++ = (char)(FIRST + (bits | MORE));
    }
}

static bool take(const char **p, int64_t *out)
{
    int64_t x = 0;
    int bits = 0;

    for (int i = 0; i < DIGITS_MAX; i++, (*p)++) {
        bits = (unsigned char)**p - FIRST;
        if (bits < 0 || bits >= 2 * MORE)
            return false;
        x |= (int64_t)(bits & 31) << (BITS * i);
        if (bits & MORE)
            continue;
        if (bits & SIGN)
            x -= (int64_t)1 << (BITS * (i + 1));
        (*p)++;
        *out = x;
        return true;
    }
    return false;
}

/* The runs of the mask, down its columns; at most one more than there are cells. */
static size_t find_runs(const uint8_t *mask, int height, int width, int64_t *run)
{
    size_t n = 0;
    bool now = false;

    run[0] = 0;
    for (int x = 0; x < width; x++) {
        for (int y = 0; y < height; y++) {
            const bool cell = mask[(size_t)y * (size_t)width + (size_t)x] != 0;

            if (cell != now)
                run[++n] = 0;
            now = cell;
            run[n]++;
        }
    }
    return n + 1;
}

const char *lt_rle_of_runs(lt_arena *arena, const int64_t *run, size_t n)
{
    char *text = lt_arena_array(arena, n + 1, DIGITS_MAX), *p = text;

    for (size_t i = 0; p && i < n; i++)             /* from the fourth on, less the one two before */
        p = put(p, i > 2 ? run[i] - run[i - 2] : run[i]);
    if (p)
        *p = '\0';
    return text;
}

const char *lt_rle_encode(lt_arena *arena, const uint8_t *mask, int height, int width)
{
    const size_t cells = (size_t)height * (size_t)width;
    int64_t *run = lt_alloc((cells + 1) * sizeof(*run));
    const char *text;

    if (!run)
        return NULL;
    text = lt_rle_of_runs(arena, run, find_runs(mask, height, width, run));
    lt_release(run);
    return text;
}

lt_status lt_rle_decode(const char *text, int height, int width, uint8_t *mask)
{
    const int64_t cells = (int64_t)height * width;
    int64_t run[2] = { 0, 0 }, at = 0;              /* the last run of zeros, of ones */
    const char *p = text;

    for (int i = 0; *p; i++) {
        int64_t x;

        if (!take(&p, &x))
            return lt_error(LT_EFORMAT, "mask: character %zu is none of a run's", (size_t)(p - text));
        run[i % 2] = i > 2 ? x + run[i % 2] : x;
        if (run[i % 2] < 0 || run[i % 2] > cells - at)
            return lt_error(LT_EFORMAT, "mask: run %d of %lld cells does not fit into %d x %d", i,
                            (long long)run[i % 2], height, width);
        for (int64_t end = at + run[i % 2]; at < end; at++)
            mask[at % height * width + at / height] = (uint8_t)(i % 2);
    }
    if (at != cells)
        return lt_error(LT_EFORMAT, "mask: runs of %lld cells, want %d x %d", (long long)at, height, width);
    return LT_OK;
}
