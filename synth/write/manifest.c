/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps the list of files, and writes it. */
#include "synth/write/manifest.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

lt_status synth_manifest_add(synth_manifest *m, const synth_file *file, int n)
{
    for (int i = 0; i < n; i++) {
        synth_file *longer = lt_arena_grow(m->arena, m->file, (size_t)m->n, &m->room, sizeof(*longer));

        if (!longer)
            return lt_error(LT_ENOMEM, "synth: no memory for a list of %lld files", (long long)m->n + 1);
        m->file = longer;
        m->file[m->n++] = file[i];
    }
    return LT_OK;
}

lt_status synth_manifest_file(synth_manifest *m, const char *root, const char *within)
{
    synth_file file;
    const lt_status st = synth_describe_file(root, within, &file);

    return st ? st : synth_manifest_add(m, &file, 1);
}

lt_status synth_manifest_text(synth_manifest *m, const char *root, const char *within, const char *text)
{
    lt_arena *scratch = lt_arena_new();
    const char *full = scratch ? lt_path_join(scratch, root, within) : NULL;
    const lt_status st = full ? lt_write_file(full, text, strlen(text))
                              : lt_error(LT_ENOMEM, "%s: no memory", within);

    lt_arena_free(scratch);
    return st ? st : synth_manifest_file(m, root, within);
}

static void add_crc(cJSON *to, const char *name, uint32_t crc)
{
    char text[16];

    snprintf(text, sizeof(text), "%08" PRIx32, crc);
    cJSON_AddStringToObject(to, name, text);
}

static uint32_t crc_of_hand(const lt_hand_model *h)
{
    uLong crc = crc32_z(0, (const Bytef *)h->v_template, sizeof(h->v_template));

    crc = crc32_z(crc, (const Bytef *)h->shapedirs, sizeof(h->shapedirs));
    crc = crc32_z(crc, (const Bytef *)h->posedirs, sizeof(h->posedirs));
    crc = crc32_z(crc, (const Bytef *)h->J_regressor, sizeof(h->J_regressor));
    return (uint32_t)crc32_z(crc, (const Bytef *)h->weights, sizeof(h->weights));
}

static void add_options(cJSON *j, const synth_manifest *m, const synth_options *o)
{
    char seed[24];

    snprintf(seed, sizeof(seed), "%" PRIu64, o->seed);          /* may not fit a JSON number */
    cJSON_AddBoolToObject(j, "synthetic", true);
    cJSON_AddStringToObject(j, "made_by", "palmar synth");
    cJSON_AddStringToObject(j, "layout", m->layout);
    cJSON_AddStringToObject(j, "axes", m->axes);
    cJSON_AddStringToObject(j, "preset", synth_preset_name(o->preset));
    cJSON_AddStringToObject(j, "seed", seed);
    cJSON_AddNumberToObject(j, "frames", o->frames);
    cJSON_AddBoolToObject(j, "alias_ycb", o->alias_ycb);
    if (o->preset == SYNTH_HOGS) {
        cJSON_AddStringToObject(j, "light", o->still_light ? "fixed" : "varied");
        cJSON_AddBoolToObject(j, "jitter", o->jitter);
    }
    if (o->preset == SYNTH_DETECT && o->near > 0)
        cJSON_AddNumberToObject(j, "near", o->near);
    if (o->preset == SYNTH_ACTIONS || o->preset == SYNTH_WORLD)
        cJSON_AddNumberToObject(j, "difficulty", o->difficulty);
    if (o->coco || o->bop)
        cJSON_AddStringToObject(j, "export", o->coco && o->bop ? "coco,bop" : o->coco ? "coco" : "bop");
    if (o->preset != SYNTH_ACTIONS && o->preset >= SYNTH_HOGS) {
        const double size[2] = { m->width, m->height };
        cJSON_AddItemToObject(j, "size", cJSON_CreateDoubleArray(size, 2));
    }
}

lt_status synth_manifest_write(const synth_manifest *m, const synth_options *o, const lt_hand_model *hand)
{
    char *path = lt_path_join(m->arena, o->out, "manifest.json");
    cJSON *j = cJSON_CreateObject(), *files;
    lt_status st;

    add_options(j, m, o);
    if (hand)
        add_crc(j, "hand_crc32", crc_of_hand(hand));
    files = cJSON_AddObjectToObject(j, "files_crc32");
    for (int64_t i = 0; i < m->n; i++)
        add_crc(files, m->file[i].path, m->file[i].crc);
    st = path && files ? lt_json_write(path, j) : lt_error(LT_ENOMEM, "%s: no memory", o->out);
    cJSON_Delete(j);
    return st;
}
