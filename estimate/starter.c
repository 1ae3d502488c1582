/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/starter.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char NONE[] = "has no starter models; scripts/train-starter trains them, and PALMAR_STARTER names a "
                           "folder that has some";

const char *starter_folder(lt_arena *arena, const char *root)
{
    const char *named = getenv("PALMAR_STARTER");

    return named && *named ? lt_arena_strdup(arena, named) : lt_arena_printf(arena, "%s/models/starter", root);
}

static lt_status check_card(const char *path, const cJSON *card)
{
    static const char *const texts[] = { "name", "role", "licence" };

    for (size_t i = 0; i < LT_COUNT(texts); i++)
        if (!cJSON_IsString(cJSON_GetObjectItemCaseSensitive(card, texts[i])))
            return lt_error(LT_EFORMAT, "%s: is no card of a model: \"%s\" is no text", path, texts[i]);
    return LT_OK;
}

/* The card at NAME.json, with where NAME.safetensors is */
static lt_status read_card(lt_arena *arena, const char *path, cJSON *list)
{
    const char *weights = lt_arena_printf(arena, "%.*s.safetensors", (int)(strlen(path) - strlen(".json")), path);
    cJSON *card = NULL;
    struct stat s;
    lt_status st = weights ? lt_json_read(path, &card) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = check_card(path, card);
    if (!st && stat(weights, &s) != 0)
        st = lt_error(LT_EFORMAT, "%s: its weights are not beside it, expected %s", path, weights);
    if (!st && !(cJSON_AddStringToObject(card, "path", weights)
                 && cJSON_AddNumberToObject(card, "bytes", (double)s.st_size) && cJSON_AddItemToArray(list, card)))
        st = lt_error(LT_ENOMEM, "%s: no memory", path);
    if (st)
        cJSON_Delete(card);
    return st;
}

lt_status starter_cards(lt_arena *arena, const char *folder, cJSON **out)
{
    const char *pattern = lt_path_join(arena, folder, "*.json");
    cJSON *list = cJSON_CreateArray();
    lt_status st = pattern && list ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", folder);
    glob_t found = { 0 };

    if (!st && (glob(pattern, 0, NULL, &found) != 0 || found.gl_pathc == 0))     /* sorted by name */
        st = lt_error(LT_EIO, "%s: %s", folder, NONE);
    for (size_t i = 0; !st && i < found.gl_pathc; i++)
        st = read_card(arena, found.gl_pathv[i], list);
    globfree(&found);
    if (st)
        cJSON_Delete(list);
    else
        *out = list;
    return st;
}

lt_status starter_find(lt_arena *arena, const char *folder, const char *role, const char **out)
{
    cJSON *cards = NULL;
    const cJSON *card;
    lt_status st = starter_cards(arena, folder, &cards);

    if (st)
        return st;
    *out = NULL;
    cJSON_ArrayForEach(card, cards) {
        if (!*out && strcmp(cJSON_GetObjectItemCaseSensitive(card, "role")->valuestring, role) == 0)
            *out = lt_arena_strdup(arena, cJSON_GetObjectItemCaseSensitive(card, "path")->valuestring);
    }
    cJSON_Delete(cards);
    return *out ? LT_OK : lt_error(LT_EIO, "%s: %s (none of role \"%s\")", folder, NONE, role);
}
