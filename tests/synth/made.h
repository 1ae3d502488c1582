/* SPDX-License-Identifier: Apache-2.0 */
/* What holds of every dataset that was made. */
#ifndef TESTS_SYNTH_MADE_H
#define TESTS_SYNTH_MADE_H

#include "libtensor/io/text/json.h"
#include "tests/scratch.h"

#include <cjson/cJSON.h>
#include <zlib.h>

static inline void check_crc(const char *within, const char *want)
{
    uint8_t *bytes;
    size_t size;
    char crc[16];

    check_ok(lt_read_file(arena, at(lt_arena_printf(arena, "data/%s", within)), LT_FILE_MAX, &bytes, &size));
    snprintf(crc, sizeof(crc), "%08lx", crc32_z(0, bytes, size));
    ck_assert_msg(strcmp(crc, want) == 0, "%s: its checksum is %s, the manifest has %s", within, crc, want);
}

/* The folder "data" is as its manifest says; how many files that lists. */
static inline int check_manifest(const char *preset, const char *seed)
{
    cJSON *j;
    const cJSON *file;
    int n = 0;

    check_ok(lt_json_read(at("data/manifest.json"), &j));
    ck_assert(cJSON_IsTrue(cJSON_GetObjectItem(j, "synthetic")));
    ck_assert_str_eq(cJSON_GetObjectItem(j, "preset")->valuestring, preset);
    ck_assert_str_eq(cJSON_GetObjectItem(j, "seed")->valuestring, seed);
    cJSON_ArrayForEach(file, cJSON_GetObjectItem(j, "files_crc32")) {
        check_crc(file->string, file->valuestring);
        n++;
    }
    cJSON_Delete(j);
    return n;
}

#endif
