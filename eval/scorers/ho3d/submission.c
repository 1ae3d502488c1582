/* SPDX-License-Identifier: Apache-2.0 */
/* pred.json and pred.zip, written as the samples come. */
#include "eval/scorers/ho3d/submission.h"

#include "eval/scorers/zip_entry.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, TEXT = 1 << 16, NUMBER = 24 };

struct ho3d_submission {
    lt_atomic_file file;
    FILE *spool;                    /* the vertices so far; has no name any more */
    zip_entry *zip;                 /* NULL for plain JSON */
    int64_t n, n_expected;
    size_t used;
    char text[TEXT];                /* JSON on its way out */
};

static void flush(ho3d_submission *s)
{
    if (s->zip)
        zip_entry_write(s->zip, s->text, s->used);
    else
        fwrite(s->text, 1, s->used, s->file.stream);
    s->used = 0;
}

static void put(ho3d_submission *s, const char *text)
{
    const size_t n = strlen(text);

    if (s->used + n > TEXT)
        flush(s);
    memcpy(s->text + s->used, text, n);
    s->used += n;
}

/* Seven digits, with a point in every locale. */
static void put_number(ho3d_submission *s, float x)
{
    char number[NUMBER];
    char *comma;

    snprintf(number, sizeof(number), "%.7g", (double)x);
    comma = strchr(number, ',');
    if (comma)
        *comma = '.';
    put(s, number);
}

/* [[x,y,z],...], after a comma where it is not the first */
static void put_points(ho3d_submission *s, bool first, int n, const float *x)
{
    put(s, first ? "[" : ",\n[");
    for (int i = 0; i < n; i++) {
        put(s, i ? ",[" : "[");
        put_number(s, x[3 * i]);
        put(s, ",");
        put_number(s, x[3 * i + 1]);
        put(s, ",");
        put_number(s, x[3 * i + 2]);
        put(s, "]");
    }
    put(s, "]");
}

/* A file beside path that goes away by itself. */
static lt_status open_spool(const char *path, FILE **out)
{
    char *name = malloc(strlen(path) + sizeof(".XXXXXX"));
    int fd;

    if (!name)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    strcpy(name, path);
    strcat(name, ".XXXXXX");
    fd = mkstemp(name);
    *out = fd >= 0 ? fdopen(fd, "w+b") : NULL;
    if (fd >= 0)
        unlink(name);
    if (fd >= 0 && !*out)
        close(fd);
    free(name);
    return *out ? LT_OK : lt_error(lt_errno_status(errno), "%s: cannot make a temporary file beside it: %s", path,
                                   strerror(errno));
}

lt_status ho3d_submission_open(const char *path, int64_t n_expected, ho3d_submission **out)
{
    ho3d_submission *s = calloc(1, sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    s->n_expected = n_expected;
    st = lt_atomic_open(&s->file, path);
    if (!st)
        st = open_spool(path, &s->spool);
    if (!st && lt_ends_with(path, ".zip"))
        st = zip_entry_new(s->file.stream, "pred.json", &s->zip);
    if (st) {
        ho3d_submission_abort(s);
        return st;
    }
    put(s, "[[");
    *out = s;
    return LT_OK;
}

static lt_status check(const ho3d_submission *s, const char *what, int n, const float *x)
{
    int behind = 0;

    for (int i = 0; i < 3 * n; i++) {
        if (!isfinite(x[i]))
            return lt_error(LT_EINVAL, "%s: sample %lld: number %d of %d is %g, want a finite one",
                            what, (long long)s->n, i, 3 * n, (double)x[i]);
        behind += i % 3 == 2 && x[i] > 0;
    }
    if (behind == n)
        return lt_error(LT_EINVAL, "%s: sample %lld: all z are positive, HO3D's camera looks "
                        "along -z; flip y and z", what, (long long)s->n);
    return LT_OK;
}

static lt_status spool_failed(const ho3d_submission *s)
{
    return lt_error(lt_errno_status(errno), "%s: temporary file beside it: %s", s->file.path,
                    strerror(errno));
}

lt_status ho3d_submission_add(ho3d_submission *s, const float *joints, const float *vertices)
{
    lt_status st = check(s, "joints", J, joints);

    if (!st)
        st = check(s, "vertices", V, vertices);
    if (st)
        return st;
    put_points(s, s->n == 0, J, joints);
    s->n++;
    return fwrite(vertices, sizeof(float), 3 * V, s->spool) == 3 * V ? LT_OK : spool_failed(s);
}

static lt_status copy_vertices(ho3d_submission *s)
{
    float vertices[3 * V];

    if (fflush(s->spool) || fseek(s->spool, 0, SEEK_SET) != 0)
        return spool_failed(s);
    for (int64_t i = 0; i < s->n; i++) {
        if (fread(vertices, sizeof(float), 3 * V, s->spool) != 3 * V)
            return lt_error(LT_EIO, "%s: cannot read back sample %lld", s->file.path, (long long)i);
        put_points(s, i == 0, V, vertices);
    }
    return LT_OK;
}

static lt_status finish(ho3d_submission *s)
{
    lt_status st;

    if (s->n != s->n_expected)
        return lt_error(LT_EINVAL, "%s: %lld samples, the evaluation list has %lld", s->file.path,
                        (long long)s->n, (long long)s->n_expected);
    put(s, "],\n[");
    st = copy_vertices(s);
    if (st)
        return st;
    put(s, "]]\n");
    flush(s);
    if (s->zip) {
        st = zip_entry_finish(s->zip);
        s->zip = NULL;
    }
    return st;
}

lt_status ho3d_submission_close(ho3d_submission *s)
{
    lt_status st = finish(s);

    if (!st) {
        fclose(s->spool);
        st = lt_atomic_commit(&s->file);
        free(s);
    } else {
        ho3d_submission_abort(s);
    }
    return st;
}

void ho3d_submission_abort(ho3d_submission *s)
{
    if (!s)
        return;
    zip_entry_free(s->zip);
    if (s->spool)
        fclose(s->spool);
    lt_atomic_abort(&s->file);
    free(s);
}
