/* SPDX-License-Identifier: Apache-2.0 */
/* Folders of sequences, and what seqinfo.ini and times.csv say of one. */
#include "data/mot/mot.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/natural.h"
#include "libtensor/io/text/number.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static lt_status no_memory(const char *path)
{
    return lt_error(LT_ENOMEM, "%s: no memory", path);
}

/* ---- seqinfo.ini ---- */

typedef struct { double fps, frames, width, height; } info_numbers;

static char *trimmed(char *text)
{
    size_t n;

    text += strspn(text, " \t\r");
    n = strlen(text);
    while (n && strchr(" \t\r", text[n - 1]))
        text[--n] = '\0';
    return text;
}

static lt_status take_number(const char *path, size_t line, const char *key, const char *text, double hi, double *out)
{
    const char *end;

    *out = lt_strtod(text, &end);
    if (end == text || *end || !(*out > 0 && *out <= hi))
        return lt_error(LT_EFORMAT, "%s:%zu: %s is \"%.20s\", expected a number above 0, at most %g", path, line, key,
                        text, hi);
    return LT_OK;
}

static lt_status take_pair(lt_arena *arena, const char *path, size_t line, const char *key, const char *value,
                           info_numbers *n, mot_sequence *out)
{
    const struct { const char *key; double hi, *to; } numbers[] = {
        { "frameRate", 1e6, &n->fps }, { "seqLength", MOT_MAX_FRAMES, &n->frames }, { "imWidth", 65536, &n->width },
        { "imHeight", 65536, &n->height },
    };
    const struct { const char *key, **to; } texts[] = { { "imDir", &out->images }, { "imExt", &out->extension } };

    for (size_t i = 0; i < LT_COUNT(numbers); i++)
        if (strcasecmp(key, numbers[i].key) == 0)
            return take_number(path, line, numbers[i].key, value, numbers[i].hi, numbers[i].to);
    for (size_t i = 0; i < LT_COUNT(texts); i++)
        if (strcasecmp(key, texts[i].key) == 0 && !(*texts[i].to = lt_arena_strdup(arena, value)))
            return no_memory(path);
    return LT_OK;
}

lt_status mot_parse_info(lt_arena *arena, const char *path, char *text, size_t n, mot_sequence *out)
{
    info_numbers of = { NAN, NAN, NAN, NAN };
    lt_text_lines lines;
    lt_status st = LT_OK;

    if (memchr(text, 0, n))
        return lt_error(LT_EFORMAT, "%s: has a NUL character: no seqinfo.ini", path);
    lines = lt_lines_of(text, n);
    out->images = "img1";
    out->extension = ".jpg";
    for (char *line = lt_next_line(&lines); line && !st; line = lt_next_line(&lines)) {
        char *equals = strchr(line, '=');

        if (!equals)
            continue;               /* its section's name, or a comment */
        *equals = '\0';
        st = take_pair(arena, path, lines.number, trimmed(line), trimmed(equals + 1), &of, out);
    }
    if (st)
        return st;
    if (isnan(of.fps) || isnan(of.frames) || isnan(of.width) || isnan(of.height))
        return lt_error(LT_EFORMAT, "%s: lacks %s", path, isnan(of.fps) ? "frameRate" : isnan(of.frames) ? "seqLength"
                        : isnan(of.width) ? "imWidth" : "imHeight");
    out->fps = of.fps;
    out->frames = (int64_t)of.frames;
    out->width = (int)of.width;
    out->height = (int)of.height;
    return out->frames ? LT_OK : lt_error(LT_EFORMAT, "%s: seqLength is %g, expected a whole number", path, of.frames);
}

/* ---- times.csv: "frame,time", then a row for each frame ---- */

static lt_status parse_times(const char *path, char *text, size_t n, int64_t frames, double *time)
{
    lt_text_lines lines;
    int64_t k = 0;

    if (memchr(text, 0, n))
        return lt_error(LT_EFORMAT, "%s: has a NUL character: no file of times", path);
    lines = lt_lines_of(text, n);
    for (const char *line = lt_next_line(&lines); line; line = lt_next_line(&lines)) {
        const char *comma = strchr(line, ','), *end;

        if (lines.number == 1 || !*lt_skip_blanks(line))
            continue;
        if (k == frames)
            return lt_error(LT_EFORMAT, "%s:%zu: more than the %lld frames of seqinfo.ini", path, lines.number,
                            (long long)frames);
        time[k] = comma ? lt_strtod(comma + 1, &end) : NAN;
        if (!comma || end == comma + 1 || *lt_skip_blanks(end) || !isfinite(time[k]) ||
            lt_strtod(line, &end) != (double)k + 1)
            return lt_error(LT_EFORMAT, "%s:%zu: \"%.30s\", expected frame %lld and its seconds", path, lines.number,
                            line, (long long)k + 1);
        k++;
    }
    return k == frames ? LT_OK : lt_error(LT_EFORMAT, "%s: has %lld frames, seqinfo.ini %lld", path, (long long)k,
                                          (long long)frames);
}

static lt_status read_times(lt_arena *arena, mot_sequence *s)
{
    const char *path = lt_path_join(arena, s->folder, "times.csv");
    double *time = lt_arena_array(arena, (size_t)s->frames, sizeof(*time));
    lt_file f;
    lt_status st;

    if (!path || !time)
        return no_memory(s->folder);
    s->time = time;
    if (access(path, F_OK) != 0) {
        for (int64_t k = 0; k < s->frames; k++)
            time[k] = (double)k / s->fps;
        return LT_OK;
    }
    st = lt_file_load(&f, path, LT_FILE_MAX);
    if (!st)
        st = parse_times(path, (char *)f.bytes, f.n, s->frames, time);
    lt_file_free(&f);
    return st;
}

/* ---- a sequence ---- */

/* The folder's own name, without slashes behind it */
static const char *name_of(lt_arena *arena, const char *folder)
{
    size_t n = strlen(folder), from;

    while (n && folder[n - 1] == '/')
        n--;
    for (from = n; from && folder[from - 1] != '/'; from--)
        ;
    return lt_arena_printf(arena, "%.*s", (int)(n - from), folder + from);
}

static const char *file_if_there(lt_arena *arena, const char *folder, const char *name)
{
    const char *path = lt_path_join(arena, folder, name);

    return path && access(path, F_OK) == 0 ? path : NULL;
}

lt_status mot_sequence_open(lt_arena *arena, const char *folder, mot_sequence *out)
{
    const char *info = lt_path_join(arena, folder, "seqinfo.ini");
    mot_sequence s = { .folder = lt_arena_strdup(arena, folder), .name = name_of(arena, folder) };
    uint8_t *text;
    size_t n;
    lt_status st;

    if (!info || !s.folder || !s.name)
        return no_memory(folder);
    st = lt_read_file(arena, info, LT_FILE_MAX, &text, &n);
    if (!st)
        st = mot_parse_info(arena, info, (char *)text, n, &s);
    if (!st)
        st = read_times(arena, &s);
    if (st)
        return st;
    s.images = lt_path_join(arena, folder, s.images);
    s.truth = file_if_there(arena, folder, "gt/gt.txt");
    s.detections = file_if_there(arena, folder, "det/det.txt");
    if (!s.images)
        return no_memory(folder);
    *out = s;
    return LT_OK;
}

const char *mot_picture(lt_arena *arena, const mot_sequence *s, int64_t k)
{
    return lt_arena_printf(arena, "%s/%06lld%s", s->images, (long long)k + 1, s->extension);
}

/* ---- splits ---- */

static bool is_sequence(const char *folder)
{
    char path[4096];

    return snprintf(path, sizeof(path), "%s/seqinfo.ini", folder) < (int)sizeof(path) && access(path, F_OK) == 0;
}

static int by_name(const void *a, const void *b)
{
    return lt_natural_order(((const mot_sequence *)a)->name, ((const mot_sequence *)b)->name);
}

typedef struct {
    lt_arena *arena;
    mot_sequence *list;
    size_t n, room;
} sequences;

static lt_status add(sequences *to, const char *folder)
{
    to->list = lt_arena_grow(to->arena, to->list, to->n, &to->room, sizeof(*to->list));
    if (!to->list)
        return no_memory(folder);
    return mot_sequence_open(to->arena, folder, &to->list[to->n++]);
}

static lt_status add_folder(sequences *to, const char *root)
{
    DIR *dir = opendir(root);
    const struct dirent *e;
    lt_status st = LT_OK;

    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s", root, strerror(errno));
    while (!st && (e = readdir(dir))) {
        const char *folder = *e->d_name == '.' ? NULL : lt_path_join(to->arena, root, e->d_name);

        if (folder && is_sequence(folder))
            st = add(to, folder);
    }
    closedir(dir);
    return st;
}

/* What manifest.json says of a set that `palmar synth` made */
static bool is_synthetic(lt_arena *arena, const char *root)
{
    const char *path = file_if_there(arena, root, "manifest.json");
    cJSON *tree = NULL;
    bool synthetic;

    if (!path || lt_json_read(path, &tree))
        return false;
    synthetic = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(tree, "synthetic"));
    cJSON_Delete(tree);
    return synthetic;
}

lt_status mot_open(lt_arena *arena, const char *root, const char *split, mot_set *out)
{
    const char *folder = lt_path_join(arena, root, split);
    sequences all = { .arena = arena };
    lt_status st;

    if (!folder)
        return no_memory(root);
    if (!lt_is_folder(folder))
        folder = root;
    st = is_sequence(folder) ? add(&all, folder) : add_folder(&all, folder);
    if (st)
        return st;
    if (!all.n)
        return lt_error(LT_EIO, "%s: no sequences: no folder in it has a seqinfo.ini, as MOTChallenge has it", folder);
    qsort(all.list, all.n, sizeof(*all.list), by_name);
    *out = (mot_set){ .root = root, .sequence = all.list, .n = (int)all.n,
                      .synthetic = is_synthetic(arena, root) };
    return mot_read_looks(arena, root, &out->looks);
}

bool mot_probe(const char *root)
{
    static const char *const within[] = { ".", "train", "evaluation", "test" };
    bool found = is_sequence(root);

    for (size_t i = 0; i < LT_COUNT(within) && !found; i++) {
        lt_arena *arena = lt_arena_new();
        const char *folder = arena ? lt_path_join(arena, root, within[i]) : NULL;
        DIR *dir = folder ? opendir(folder) : NULL;
        const struct dirent *e;

        while (dir && !found && (e = readdir(dir)))
            found = *e->d_name != '.' && is_sequence(lt_path_join(arena, folder, e->d_name));
        if (dir)
            closedir(dir);
        lt_arena_free(arena);
    }
    return found;
}
