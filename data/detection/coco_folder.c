/* SPDX-License-Identifier: Apache-2.0 */
/* A folder of COCO's: annotations/instances_SPLIT.json, pictures in SPLIT/ or images/SPLIT/. */
#include "data/detection/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- where ---- */

static const char *const train_names[] = { "train", "train2017", "train2014", NULL };
static const char *const other_names[] = { "evaluation", "val", "val2017", "val2014", "test", NULL };

const char *detection_coco_list(lt_arena *arena, const char *root, const char *split, const char **name)
{
    const char *const *names = strcmp(split, "train") == 0 ? train_names : other_names;

    for (; *names; names++) {
        const char *path = lt_arena_printf(arena, "%s/annotations/instances_%s.json", root, *names);

        if (path && access(path, R_OK) == 0) {
            *name = *names;
            return path;
        }
    }
    return NULL;
}

static const char *folder_of(lt_arena *arena, const char *root, const char *name)
{
    const char *path = lt_arena_printf(arena, "%s/images/%s", root, name);

    return path && lt_is_folder(path) ? path : lt_arena_printf(arena, "%s/%s", root, name);
}

/* ---- opening ---- */

/* What manifest.json says of a set that `palmar synth` made */
static void read_manifest(lt_arena *arena, const char *root, detection_set *s)
{
    const char *path = lt_path_join(arena, root, "manifest.json");
    const char *preset, *seed;
    cJSON *tree;

    if (!path || access(path, R_OK) != 0 || lt_json_read(path, &tree))
        return;
    preset = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(tree, "preset"));
    seed = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(tree, "seed"));
    s->synthetic = s->synthetic || cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(tree, "synthetic"));
    if (s->synthetic && preset && seed && strcmp(preset, "detect") == 0)
        s->seed = strtoll(seed, NULL, 10);
    cJSON_Delete(tree);
}

/* Images that are not there are left out. */
static lt_status keep_present(lt_arena *arena, detection_set *s)
{
    detection_image *image = (detection_image *)s->image;
    int64_t kept = 0;
    lt_status st = LT_OK;

    for (int64_t i = 0; i < s->count && st == LT_OK; i++) {
        char line[512];

        if (access(image[i].path, R_OK) == 0) {
            image[kept++] = image[i];
            continue;
        }
        snprintf(line, sizeof(line), "%s: no such picture", image[i].path);
        st = detection_fault(arena, s, &s->missing, line);
    }
    s->count = kept;
    return st;
}

lt_status detection_coco_open(lt_arena *arena, const char *root, const char *split, detection_set *out)
{
    const char *name = NULL, *path = detection_coco_list(arena, root, split, &name);
    lt_status st;

    if (!path)
        return lt_error(LT_EIO, "%s: no annotations/instances_%s.json, as COCO has it, and no data.yaml, as YOLO has "
                        "it; make a synthetic set with `palmar synth --preset detect`", root, split);
    st = detection_parse_coco(arena, path, folder_of(arena, root, name), out);
    if (st == LT_OK)
        st = keep_present(arena, out);
    if (st == LT_OK)
        read_manifest(arena, root, out);
    return st;
}
