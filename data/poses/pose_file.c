/* SPDX-License-Identifier: Apache-2.0 */
/* Which format a file of poses has. */
#define _GNU_SOURCE                     /* memmem */
#include "data/poses/pose_file.h"

#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"

#include <string.h>

static bool text_is(const lt_json_member *m, const char *want)
{
    const size_t n = strlen(want);

    return m->n == n + 2 && m->value[0] == '"' && memcmp(m->value + 1, want, n) == 0;
}

/* HOISDF's file has no header: each of its members is a frame. */
static bool is_hoisdf_frame(const lt_json_member *m)
{
    static const size_t FRAME = 1 << 16;
    const char *key = "\"mano_pose6d\"";

    return m->value[0] == '{' && memmem(m->value, m->n < FRAME ? m->n : FRAME, key, strlen(key));
}

static lt_status of_no_format(const pose_reader *r, const lt_json_member *m)
{
    return lt_error(LT_EFORMAT, "%s: %s%s%.*s, want initial poses: \"format\": \"palmar.poses/1\", what `palmar "
                    "predict --json` prints, or HOISDF's pred_ho_pose.json", r->file.path,
                    m ? m->key : "nothing says what it is", m ? " is " : "", m ? (int)(m->n < 40 ? m->n : 40) : 0,
                    m ? m->value : "");
}

/* By the first member that tells. */
static lt_status find_format(pose_reader *r, const char **out)
{
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = lt_json_object_open(r->file.path, r->file.text, r->file.n, &o);

    while (!st && !(st = lt_json_object_next(&o, r->scratch, &m, &more)) && more) {
        *out = strcmp(m.key, "format") == 0 && text_is(&m, "palmar.poses/1") ? "palmar.poses/1"
             : strcmp(m.key, "schema") == 0 && text_is(&m, "palmar.frame/1") ? "palmar.frame/1"
             : is_hoisdf_frame(&m) ? "HOISDF" : NULL;
        if (*out)
            return LT_OK;
        if (strcmp(m.key, "format") == 0 || strcmp(m.key, "schema") == 0)
            return of_no_format(r, &m);
    }
    return st ? st : of_no_format(r, NULL);
}

lt_status pose_file_parse(pose_text file, pose_text list, pose_record_fn *take, void *ctx, const char **format)
{
    pose_reader r = { .file = file, .take = take, .ctx = ctx, .scratch = lt_arena_new() };
    lt_status st = r.scratch ? find_format(&r, format) : lt_error(LT_ENOMEM, "%s: no memory", file.path);

    if (!st && strcmp(*format, "palmar.poses/1") == 0)
        st = pose_read_palmar(&r);
    else if (!st && strcmp(*format, "palmar.frame/1") == 0)
        st = pose_read_frames(&r);
    else if (!st)
        st = pose_read_hoisdf(&r, list);
    lt_arena_free(r.scratch);
    return st;
}
