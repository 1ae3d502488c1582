/* SPDX-License-Identifier: Apache-2.0 */
#include "data/body/set.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <unistd.h>

static lt_status no_memory(const char *root)
{
    return lt_error(LT_ENOMEM, "%s: no memory", root);
}

static int by_number(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;

    return (x > y) - (x < y);
}

static lt_status count_subjects(lt_arena *arena, body_set *set)
{
    int32_t *subject = lt_arena_array(arena, (size_t)set->n, sizeof(*subject));

    if (!subject)
        return no_memory(set->root);
    for (int64_t i = 0; i < set->n; i++)
        subject[i] = set->row[i].subject;
    qsort(subject, (size_t)set->n, sizeof(*subject), by_number);
    for (int64_t i = 0; i < set->n; i++)
        set->subjects += i == 0 || subject[i] != subject[i - 1];
    return LT_OK;
}

static lt_status name_pictures(lt_arena *arena, body_set *set)
{
    set->name = lt_arena_array(arena, (size_t)set->n, sizeof(*set->name));
    for (int64_t i = 0; set->name && i < set->n; i++)
        if (!(set->name[i] = lt_arena_printf(arena, "%s/%06lld.jpg", set->split, (long long)i + 1)))
            return no_memory(set->root);
    return set->name ? LT_OK : no_memory(set->root);
}

static bool is_synthetic(lt_arena *arena, const char *root)
{
    const char *path = lt_path_join(arena, root, "manifest.json");
    cJSON *tree;
    bool synthetic;

    if (!path || access(path, F_OK) != 0 || lt_json_read(path, &tree))
        return false;
    synthetic = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(tree, "synthetic"));
    cJSON_Delete(tree);
    return synthetic;
}

lt_status body_set_open(lt_arena *arena, const char *root, const char *split, body_set *out)
{
    body_set set = { .root = lt_arena_strdup(arena, root), .split = lt_arena_strdup(arena, split) };
    const char *path = lt_arena_printf(arena, "%s/%s.npz", root, split);
    uint8_t *bytes;
    body_row *row;
    size_t n;
    lt_status st = set.root && set.split && path ? lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n) : no_memory(root);

    if (!st)
        st = body_rows_parse(arena, path, bytes, n, &row, &set.n);
    if (!st && !set.n)
        st = lt_error(LT_EFORMAT, "%s: has no rows", path);
    if (st)
        return st;
    set.row = row;
    set.synthetic = is_synthetic(arena, root);
    st = count_subjects(arena, &set);
    if (!st)
        st = name_pictures(arena, &set);
    if (!st)
        *out = set;
    return st;
}

bool body_set_probe(const char *root)
{
    lt_arena *arena = lt_arena_new();
    const char *body = arena ? body_set_body(arena, root) : NULL;
    const char *rows = arena ? lt_path_join(arena, root, "train.npz") : NULL;
    const bool found = body && rows && access(body, F_OK) == 0 && access(rows, F_OK) == 0;

    lt_arena_free(arena);
    return found;
}

const char *body_set_body(lt_arena *arena, const char *root)
{
    return lt_path_join(arena, root, "body.npz");
}

lt_status body_set_picture(const body_set *set, int64_t i, lt_arena *arena, lt_image *out)
{
    const char *path = lt_path_join(arena, set->root, set->name[i]);
    lt_image img;
    lt_status st = path ? lt_image_read(arena, path, &img) : no_memory(set->root);

    if (st)
        return st;
    if (img.width != BODY_PICTURE_WIDTH || img.height != BODY_PICTURE_HEIGHT || img.channels != 3 || img.bits != 8)
        return lt_error(LT_EFORMAT, "%s: is %d x %d with %d channels of %d bits, expected %d x %d with 3 of 8", path,
                        img.width, img.height, img.channels, img.bits, BODY_PICTURE_WIDTH, BODY_PICTURE_HEIGHT);
    *out = img;
    return LT_OK;
}
