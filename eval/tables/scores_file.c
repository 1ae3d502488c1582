/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/tables/scores_file.h"

#include "libtensor/base/arena.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>

lt_status scores_file_write(const char *folder, cJSON *scores)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_path_join(arena, folder, "scores.json") : NULL;
    const lt_status st = path && scores ? lt_json_write(path, scores)
                                        : lt_error(LT_ENOMEM, "no memory to write the scores");

    cJSON_Delete(scores);
    lt_arena_free(arena);
    return st;
}

lt_status scores_table_open(const char *folder, lt_atomic_file *f)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_path_join(arena, folder, "table.md") : NULL;
    const lt_status st = path ? lt_atomic_open(f, path) : lt_error(LT_ENOMEM, "no memory to write the scores");

    lt_arena_free(arena);
    return st;
}
