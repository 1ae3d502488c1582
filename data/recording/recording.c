/* SPDX-License-Identifier: Apache-2.0 */
/* A folder that was recorded: which frames there are, which belong together, and their pictures. */
#include "data/recording/recording.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

/* ---- lines ---- */

/* Of a text that is changed: line by line, without what is behind the last newline, which was cut off. */
typedef struct {
    const char *name;
    char *at, *end;
    int64_t number;                 /* of the line returned last, from 1 */
} whole_lines;

static char *next_line(whole_lines *l)
{
    char *line = l->at, *newline = memchr(line, '\n', (size_t)(l->end - line));

    if (!newline)
        return NULL;
    *newline = '\0';
    l->at = newline + 1;
    l->number++;
    return line;
}

static int64_t count_lines(const char *text, size_t n)
{
    int64_t count = 0;

    for (size_t i = 0; i < n; i++)
        count += text[i] == '\n';
    return count;
}

static lt_status too_many(const char *name, int64_t n)
{
    return lt_error(LT_EFORMAT, "%s: %lld lines, expected at most %d", name, (long long)n, RECORDING_MOST_FRAMES);
}

/* What is wrong with a line; of a line that is no JSON the place is told already */
static lt_status bad(const whole_lines *l, const char *what)
{
    return lt_error(LT_EFORMAT, "%s:%lld: %s", l->name, (long long)l->number, what);
}

static lt_status parse_line(const whole_lines *l, const char *line, cJSON **out)
{
    char where[512];

    snprintf(where, sizeof(where), "%s:%lld", l->name, (long long)l->number);
    return lt_json_parse(where, line, strlen(line), out);
}

/* ---- frames ---- */

static const char *file_name(lt_arena *arena, const cJSON *from, const char *key)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(from, key);

    return cJSON_IsString(x) && lt_path_is_inside(x->valuestring) ? lt_arena_strdup(arena, x->valuestring) : NULL;
}

static lt_status take_frame(lt_arena *arena, const whole_lines *l, const cJSON *from, const recording_rig *rig,
                            double last[RECORDING_CAMERAS], recording_frame *out)
{
    const cJSON *camera = cJSON_GetObjectItemCaseSensitive(from, "camera");
    const cJSON *t = cJSON_GetObjectItemCaseSensitive(from, "t");

    if (!cJSON_IsNumber(camera) || camera->valueint < 0 || camera->valueint >= rig->n)
        return bad(l, "\"camera\" is none of recording.json's");
    if (!cJSON_IsNumber(t) || !isfinite(t->valuedouble) || !(t->valuedouble > last[camera->valueint]))
        return bad(l, "\"t\": expected seconds that grow from frame to frame of a camera");
    out->camera = camera->valueint;
    out->t = last[out->camera] = t->valuedouble;
    out->colour = file_name(arena, from, "colour");
    if (!out->colour)
        return bad(l, "\"colour\": expected a file within the folder");
    out->depth = NULL;
    if (!cJSON_HasObjectItem(from, "depth"))
        return LT_OK;
    out->depth = file_name(arena, from, "depth");
    if (!out->depth)
        return bad(l, "\"depth\": expected a file within the folder");
    return rig->camera[out->camera].depth_scale > 0 ? LT_OK : bad(l, "\"depth\" of a camera without depth_scale");
}

lt_status recording_parse_frames(lt_arena *arena, const char *name, char *text, size_t n, recording *r)
{
    whole_lines l = { name, text, text + n, 0 };
    const int64_t most = count_lines(text, n);
    double last[RECORDING_CAMERAS];
    recording_frame *frame = NULL;
    lt_status st = most > RECORDING_MOST_FRAMES ? too_many(name, most) : LT_OK;

    if (!st && !(frame = lt_arena_array(arena, (size_t)most, sizeof(*frame))))
        st = lt_error(LT_ENOMEM, "%s: no memory for %lld frames", name, (long long)most);
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        last[c] = -INFINITY;
    r->n_frames = 0;
    for (char *line; !st && (line = next_line(&l)); r->n_frames++) {
        cJSON *from = NULL;

        st = parse_line(&l, line, &from);
        st = st ? st : take_frame(arena, &l, from, &r->rig, last, &frame[r->n_frames]);
        cJSON_Delete(from);
    }
    r->frame = frame;
    return st;
}

/* ---- sets ---- */

static lt_status take_set(const whole_lines *l, const cJSON *from, const recording *r, recording_set *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(from, "frames");
    int there = 0;

    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != r->rig.n)
        return bad(l, "\"frames\": expected a list with a number or null for each camera");
    for (int c = 0; c < RECORDING_CAMERAS; c++) {
        const cJSON *x = c < r->rig.n ? cJSON_GetArrayItem(list, c) : NULL;

        out->frame[c] = -1;
        if (!x || cJSON_IsNull(x))
            continue;
        if (!cJSON_IsNumber(x) || !(x->valuedouble >= 0 && x->valuedouble < (double)r->n_frames) ||
            r->frame[(int64_t)x->valuedouble].camera != c)
            return bad(l, "\"frames\": a number is no line of frames.jsonl, or of another camera's");
        out->frame[c] = (int64_t)x->valuedouble;
        there++;
    }
    return there ? LT_OK : bad(l, "\"frames\": none");
}

lt_status recording_parse_sets(lt_arena *arena, const char *name, char *text, size_t n, recording *r)
{
    whole_lines l = { name, text, text + n, 0 };
    const int64_t most = count_lines(text, n);
    recording_set *set = NULL;
    lt_status st = most > RECORDING_MOST_FRAMES ? too_many(name, most) : LT_OK;

    if (!st && !(set = lt_arena_array(arena, (size_t)most, sizeof(*set))))
        st = lt_error(LT_ENOMEM, "%s: no memory for %lld sets", name, (long long)most);
    r->n_sets = 0;
    for (char *line; !st && (line = next_line(&l)); r->n_sets++) {
        cJSON *from = NULL;

        st = parse_line(&l, line, &from);
        st = st ? st : take_set(&l, from, r, &set[r->n_sets]);
        cJSON_Delete(from);
    }
    r->set = set;
    return st;
}

/* ---- the folder ---- */

static lt_status parse_file(lt_arena *arena, const char *path, recording *r,
                            lt_status (*parse)(lt_arena *, const char *, char *, size_t, recording *))
{
    lt_file f;
    lt_status st = lt_file_load(&f, path, LT_FILE_MAX);

    st = st ? st : parse(arena, path, (char *)f.bytes, f.n, r);
    lt_file_free(&f);
    return st;
}

lt_status recording_open(lt_arena *arena, const char *root, recording *out)
{
    recording r = { .root = lt_arena_strdup(arena, root) };
    const char *rig = lt_path_join(arena, root, "recording.json"), *frames = lt_path_join(arena, root, "frames.jsonl");
    const char *sets = lt_path_join(arena, root, "sets.jsonl");
    lt_status st = r.root && rig && frames && sets ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", root);

    st = st ? st : recording_rig_read(arena, rig, &r.rig);
    st = st ? st : parse_file(arena, frames, &r, recording_parse_frames);
    if (!st && access(sets, F_OK) == 0)
        st = parse_file(arena, sets, &r, recording_parse_sets);
    if (!st)
        *out = r;
    return st;
}

bool recording_probe(const char *path)
{
    char rig[4096];

    return lt_is_folder(path) && snprintf(rig, sizeof(rig), "%s/recording.json", path) < (int)sizeof(rig) &&
           access(rig, R_OK) == 0;
}

/* ---- pictures ---- */

lt_status recording_colour(const recording *r, int64_t k, lt_arena *arena, lt_image *out)
{
    const recording_frame *f = &r->frame[k];
    const recording_camera *c = &r->rig.camera[f->camera];
    const char *path = lt_path_join(arena, r->root, f->colour);
    lt_image found;
    lt_status st = path ? lt_image_read(arena, path, &found) : lt_error(LT_ENOMEM, "%s: no memory", r->root);

    if (!st && (found.width != c->width || found.height != c->height))
        st = lt_error(LT_EFORMAT, "%s: %d x %d, expected %d x %d as recording.json says", path, found.width,
                      found.height,
                      c->width, c->height);
    return st ? st : lt_image_to_rgb8(arena, &found, out);
}

lt_status recording_depth(const recording *r, int64_t k, lt_arena *arena, lt_image *out)
{
    const recording_frame *f = &r->frame[k];
    const recording_camera *c = &r->rig.camera[f->camera];
    const char *path = lt_path_join(arena, r->root, f->depth);
    lt_image depth;
    lt_file file;
    lt_status st = path ? lt_file_load(&file, path, LT_JSON_MAX) : lt_error(LT_ENOMEM, "%s: no memory", r->root);

    if (!path)
        return st;
    st = st ? st : lt_image_init(arena, c->width, c->height, 1, 16, &depth);
    if (!st)
        st = recording_depth_unpack(file.memory, path, file.bytes, file.n, c->width, c->height, (uint16_t *)depth.data);
    lt_file_free(&file);
    if (!st)
        *out = depth;
    return st;
}
