/* SPDX-License-Identifier: Apache-2.0 */
/* What `palmar predict --json` prints: a record a line, palmar.frame/1, of any number of hands and objects. */
#include "data/poses/pose_file.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A hand's place in the order: one that is trusted, then one whose place was solved, then the one that agrees best. */
static double hand_score(const cJSON *hand)
{
    const cJSON *position = cJSON_GetObjectItemCaseSensitive(hand, "position");
    const double px = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(hand, "agreement_px"));
    const bool solved = cJSON_IsString(position) && strcmp(position->valuestring, "solved") == 0;

    return 4 * cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(hand, "trusted")) + 2 * solved +
           (px >= 0 ? 1 / (1 + px) : 0);
}

/* One that is trusted, then the surest; none is below 0 but those that were not found. */
static double object_score(const cJSON *object)
{
    const double sure = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(object, "confidence"));

    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, "found")))
        return -1;
    return 2 * cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, "trusted")) +
           (sure >= 0 ? sure / (1 + sure) : 0);
}

/* Of equals the first; NULL: there is none of at least 0. */
static const cJSON *best_of(const cJSON *list, double (*score)(const cJSON *))
{
    const cJSON *best = NULL;
    double high = -1, of_this;

    for (const cJSON *item = cJSON_IsArray(list) ? list->child : NULL; item; item = item->next) {
        of_this = cJSON_IsObject(item) ? score(item) : -1;
        if (of_this > high && of_this >= 0) {
            best = item;
            high = of_this;
        }
    }
    return best;
}

static lt_status read_hand(const pose_reader *r, const cJSON *hand, pose_record *out)
{
    const cJSON *side = cJSON_GetObjectItemCaseSensitive(hand, "side");
    const cJSON *joints = cJSON_GetObjectItemCaseSensitive(hand, "joints3d_m");
    lt_status st;

    if (!cJSON_IsString(side) || strcmp(side->valuestring, "right") != 0)
        return lt_error(LT_EFORMAT, "%s: the best of hands is not \"right\": initial poses are of right hands alone",
                        r->name);
    st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(hand, "theta_rad"), "theta_rad", 48, out->pose);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(hand, "beta"), "beta", 10, out->beta);
    if (!st)
        st = pose_numbers(r, cJSON_IsArray(joints) ? joints->child : NULL, "joints3d_m[0]", 3, out->wrist);
    out->has_hand = true;
    out->placed = POSE_BY_WRIST;
    return st;
}

static lt_status read_object(const pose_reader *r, const cJSON *object, pose_record *out)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(object, "name");
    lt_status st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(object, "R"), "R", 9, out->R);

    if (!st)
        st = pose_rotation(r, "R", out->R);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(object, "t_m"), "t_m", 3, out->t);
    out->has_object = true;
    out->object_name = cJSON_IsString(name) ? name->valuestring : NULL;
    return st;
}

static lt_status read_record(pose_reader *r, const cJSON *record)
{
    const cJSON *schema = cJSON_GetObjectItemCaseSensitive(record, "schema");
    const cJSON *image = cJSON_GetObjectItemCaseSensitive(record, "image");
    const cJSON *hand = best_of(cJSON_GetObjectItemCaseSensitive(record, "hands"), hand_score);
    const cJSON *object = best_of(cJSON_GetObjectItemCaseSensitive(record, "objects"), object_score);
    pose_record out = { .frame = NULL };
    lt_status st = LT_OK;

    if (!cJSON_IsString(schema) || strcmp(schema->valuestring, "palmar.frame/1") != 0 || !cJSON_IsString(image))
        return lt_error(LT_EFORMAT, "%s: want \"schema\": \"palmar.frame/1\" and an \"image\"", r->name);
    out.frame = image->valuestring;
    if (hand)
        st = read_hand(r, hand, &out);
    if (!st && object)
        st = read_object(r, object, &out);
    return st ? st : r->take(r->ctx, &out);
}

lt_status pose_read_frames(pose_reader *r)
{
    const char *at = r->file.text, *const end = at + r->file.n;
    lt_status st = LT_OK;

    for (long line = 1; !st && at < end; line++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at)), *stop = newline ? newline : end;
        cJSON *record = NULL;

        snprintf(r->name, sizeof(r->name), "%s:%ld", r->file.path, line);
        if (strspn(at, " \t\r") < (size_t)(stop - at)) {
            st = lt_json_parse(r->name, at, (size_t)(stop - at), &record);
            if (!st)
                st = read_record(r, record);
        }
        cJSON_Delete(record);
        at = stop + 1;
    }
    return st;
}
