/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/hpe_file.h"

#include "eval/scorers/results_file.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* SHORTEST: bytes of a line whose numbers have a digit each */
enum { J = LT_HAND_KEYPOINTS, SHORTEST = 1 + 2 * 3 * J };

static int by_index(const void *a, const void *b)
{
    const int64_t x = ((const hpe_line *)a)->index, y = ((const hpe_line *)b)->index;

    return x < y ? -1 : x > y;
}

/* A coordinate in mm, which is below 10 km. */
static lt_status check_coordinate(const char *path, int64_t line, int k, double x)
{
    if (fabs(x) < 1e7)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s:%lld: joint %d, %c is %g, expected millimetres", path, (long long)line, k / 3,
                    "xyz"[k % 3], x);
}

/* An index and 63 numbers, in mm. */
static lt_status parse_line(const char *path, int64_t number, const char *text, void *row)
{
    hpe_line *out = row;
    const char *end;
    double x = lt_strtod(text, &end);
    int n = 0;

    if (end == text || x != floor(x) || !(x >= 0 && x < 1e15))
        return lt_error(LT_EFORMAT, "%s:%lld: expected the index of a sample first", path, (long long)number);
    out->index = (int64_t)x;
    out->number = number;
    for (end = lt_skip_blanks(end); *end == ',' && n < 3 * J; n++) {
        const char *from = end + 1;
        lt_status st;
        x = lt_strtod(from, &end);
        if (end == from)
            break;
        st = check_coordinate(path, number, n, x);
        if (st)
            return st;
        out->joints[n / 3][n % 3] = (float)(x / 1000);
        end = lt_skip_blanks(end);
    }
    if (n != 3 * J || *end)
        return lt_error(LT_EFORMAT, "%s:%lld: %d numbers after the index, expected %d, all finite", path,
                        (long long)number, n, 3 * J);
    return LT_OK;
}

static const results_format format = {
    .shortest = SHORTEST, .row_size = sizeof(hpe_line), .parse = parse_line, .order = by_index,
};

lt_status hpe_file_read(lt_arena *arena, const char *path, hpe_file *out)
{
    void *rows;
    const lt_status st = results_file_read(arena, path, &format, &rows, &out->n);

    if (st)
        return st;
    out->line = rows;
    for (int64_t i = 1; i < out->n; i++)
        if (out->line[i].index == out->line[i - 1].index)
            return lt_error(LT_EFORMAT, "%s: two lines for sample %lld, expected one", path,
                            (long long)out->line[i].index);
    return LT_OK;
}

const hpe_line *hpe_file_find(const hpe_file *file, int64_t index)
{
    const hpe_line key = { .index = index };

    return bsearch(&key, file->line, (size_t)file->n, sizeof(key), by_index);
}
