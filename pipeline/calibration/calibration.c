/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras as numbers; files of JSON and YAML are in calibration_tree.c. */
#include "pipeline/calibration/calibration.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/number.h"
#include "libtensor/io/text/yaml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_NUMBERS = 16 };
#define MOST_BYTES LT_YAML_MAX
#define BETWEEN " \t\r\n,;[](){}"
#define WANT "want fx,fy,cx,cy in pixels, the nine numbers of a matrix, or a file of either, JSON or YAML"

/* Numbers with blanks, commas and brackets between, comments aside; their count, or -1 where there is anything else.
 * More than there is room for are counted. */
static int parse_numbers(const char *p, double out[MOST_NUMBERS])
{
    int n = 0;

    for (p += strspn(p, BETWEEN); *p; p += strspn(p, BETWEEN)) {
        const char *end;
        double x;

        if (*p == '#' || *p == '%') {
            p += strcspn(p, "\n");
            continue;
        }
        x = lt_strtod(p, &end);
        if (end == p || !strchr(BETWEEN, *end) || !isfinite(x) || fabs(x) > 1e6)
            return -1;
        if (n < MOST_NUMBERS)
            out[n] = x;
        n++;
        p = end;
    }
    return n;
}

static lt_status set_camera(const char *name, lt_camera c, double skew, calibration *out)
{
    if (!(c.fx >= 1 && c.fy >= 1))              /* less is said in shares of the width */
        return lt_error(LT_EFORMAT, "%s: focal lengths must be at least 1 pixel; the order is fx,fy,cx,cy", name);
    out->camera = c;
    out->skew = skew;
    return LT_OK;
}

lt_status calibration_set_matrix(const char *name, const double m[9], calibration *out)
{
    const bool turned = m[2] == 0 && m[5] == 0 && (m[6] != 0 || m[7] != 0);     /* MATLAB's and Open3D's */
    double k[9];

    for (int i = 0; i < 9; i++)
        k[i] = m[turned ? 3 * (i % 3) + i / 3 : i] / (m[8] != 0 ? m[8] : 1);    /* known but for a scale */
    if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
        return lt_error(LT_EFORMAT, "%s: no camera matrix: want fx 0 cx, 0 fy cy, 0 0 1 by rows", name);
    return set_camera(name, (lt_camera){ k[0], k[4], k[2], k[5] }, k[1], out);
}

/* What is around a 3 x 3 matrix in one of `columns` and as many rows, or one less */
static bool is_identity_around(const double *x, int n, int columns)
{
    for (int i = 0; i < n; i++) {
        const int row = i / columns, column = i % columns;

        if ((row == 3 || column == 3) && x[i] != (row == column ? 1 : 0))
            return false;
    }
    return true;
}

static lt_status from_numbers(const char *name, const double *x, int n, calibration *out)
{
    const double *row = x;
    double m[9];

    if (n == 4)
        return set_camera(name, (lt_camera){ x[0], x[1], x[2], x[3] }, 0, out);
    if (n == 9)
        return calibration_set_matrix(name, x, out);
    if ((n != 12 && n != 16) || !is_identity_around(x, n, 4))
        return lt_error(LT_EFORMAT, "%s: %d numbers%s; " WANT, name, n, n == 12 || n == 16 ? ", a projection" : "");
    for (int i = 0; i < 9; i++)
        m[i] = row[i / 3 * 4 + i % 3];
    return calibration_set_matrix(name, m, out);
}

lt_status calibration_parse(lt_arena *scratch, const char *name, const uint8_t *bytes, size_t n, calibration *out)
{
    const lt_kind kind = lt_kind_of(bytes, n);
    const char *text = (const char *)bytes;
    double x[MOST_NUMBERS];
    const lt_yaml *root;
    calibration c = { .width = 0 };
    int count;
    lt_status st;

    if (memchr(bytes, 0, n) || (kind != LT_KIND_UNKNOWN && kind != LT_KIND_JSON))
        return lt_refuse(name, bytes, n, "a camera's numbers, JSON or YAML");
    if (text[strspn(text, " \t\r\n")] == '<')
        return lt_error(LT_EFORMAT, "%s: XML, want JSON or YAML; OpenCV writes that to a name that ends in .yml", name);
    count = parse_numbers(text, x);
    if (count >= 0) {
        st = from_numbers(name, x, count, &c);
    } else if (!strchr(text, ':')) {
        return lt_error(LT_EFORMAT, "%s: " WANT, name);
    } else {
        st = lt_yaml_parse(scratch, name, bytes, n, &root);
        st = st ? st : calibration_from_tree(root, &c);
    }
    if (!st)
        *out = c;
    return st;
}

static lt_status read_file(const char *path, calibration *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, MOST_BYTES);

    st = st ? st : calibration_parse(file.memory, path, file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}

lt_status calibration_read(const char *name, const char *text, calibration *out)
{
    double x[MOST_NUMBERS];
    const int n = parse_numbers(text, x);
    calibration c = { .width = 0 };
    char where[256];
    struct stat info;
    lt_status st;

    if (n < 0 && stat(text, &info) == 0)
        return read_file(text, out);
    if (n < 0)
        return lt_error(LT_EUSAGE, "%s %s: no numbers, and no such file; " WANT, name, text);
    snprintf(where, sizeof(where), "%s %s", name, text);
    st = from_numbers(where, x, n, &c);
    if (!st)
        *out = c;
    return st ? LT_EUSAGE : LT_OK;
}

lt_status calibration_parse_lens(const char *name, const char *text, lt_lens *out)
{
    double x[MOST_NUMBERS];
    const int n = parse_numbers(text, x);

    if (n < 0 || n > MOST_NUMBERS)
        return lt_error(LT_EUSAGE, "%s %s: want k1,k2,p1,p2[,k3[,k4,k5,k6]], as OpenCV has them", name, text);
    return lt_lens_from_opencv(x, n, out) ? lt_error_prefix(LT_EUSAGE, "%s %s", name, text) : LT_OK;
}
