/* SPDX-License-Identifier: Apache-2.0 */
/* recording.json: cameras, and where they stand. */
#include "data/recording/recording.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <string.h>

static const char SCHEMA[] = "palmar.recording/1";
static const char *const roles[] = { "table", "front", "side" };

const char *recording_role_name(recording_role role)
{
    return roles[role];
}

/* ---- reading ---- */

/* A list of n finite numbers */
static lt_status take_numbers(const char *where, const cJSON *from, const char *key, int n, double *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(from, key);
    bool good = cJSON_IsArray(list) && cJSON_GetArraySize(list) == n;

    for (int i = 0; i < n && good; i++) {
        const cJSON *x = cJSON_GetArrayItem(list, i);

        good = cJSON_IsNumber(x) && isfinite(x->valuedouble);
        out[i] = good ? x->valuedouble : 0;
    }
    return good ? LT_OK : lt_error(LT_EFORMAT, "%s: \"%s\": expected a list of %d finite numbers", where, key, n);
}

static lt_status take_number(const char *where, const cJSON *from, const char *key, double lo, double hi, double *out)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(from, key);

    if (!cJSON_IsNumber(x) || !(x->valuedouble >= lo && x->valuedouble <= hi))
        return lt_error(LT_EFORMAT, "%s: \"%s\": expected a number from %g to %g", where, key, lo, hi);
    *out = x->valuedouble;
    return LT_OK;
}

static lt_status take_name(lt_arena *arena, const char *where, const cJSON *from, recording_camera *out)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(from, "name");

    if (!cJSON_IsString(x) || !lt_path_is_inside(x->valuestring) || strchr(x->valuestring, '/') ||
        x->valuestring[0] == '.')
        return lt_error(LT_EFORMAT, "%s: \"name\": expected the name of a folder within the recording", where);
    out->name = lt_arena_strdup(arena, x->valuestring);
    return out->name ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", where);
}

static lt_status take_role(const char *where, const cJSON *from, recording_camera *out)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(from, "role");

    for (size_t i = 0; i < LT_COUNT(roles); i++)
        if (cJSON_IsString(x) && strcmp(x->valuestring, roles[i]) == 0) {
            out->role = (recording_role)i;
            return LT_OK;
        }
    return lt_error(LT_EFORMAT, "%s: \"role\": expected \"table\", \"front\" or \"side\"", where);
}

/* A camera that is not calibrated has neither of the two. */
static lt_status take_place(const char *where, const cJSON *from, recording_camera *out)
{
    lt_status st;

    out->placed = cJSON_HasObjectItem(from, "R_world_cam") || cJSON_HasObjectItem(from, "t_world_cam");
    if (!out->placed)
        return LT_OK;
    st = take_numbers(where, from, "R_world_cam", 9, out->R);
    st = st ? st : take_numbers(where, from, "t_world_cam", 3, out->t);
    if (!st && !lt_mat3_is_rotation(out->R, 1e-3))
        st = lt_error(LT_EFORMAT, "%s: \"R_world_cam\" is no rotation to 1e-3", where);
    return st;
}

static lt_status take_camera(lt_arena *arena, const char *where, const cJSON *from, recording_camera *out)
{
    double K[4], width = 0, height = 0;
    lt_status st = take_name(arena, where, from, out);

    st = st ? st : take_role(where, from, out);
    st = st ? st : take_number(where, from, "width", 16, LT_IMAGE_MAX_SIDE, &width);
    st = st ? st : take_number(where, from, "height", 16, LT_IMAGE_MAX_SIDE, &height);
    st = st ? st : take_numbers(where, from, "K", 4, K);
    st = st ? st : take_number(where, from, "depth_scale", 0, 1, &out->depth_scale);
    st = st ? st : take_place(where, from, out);
    if (!st && !(K[0] > 0 && K[1] > 0))
        st = lt_error(LT_EFORMAT, "%s: \"K\": the focal lengths are %g and %g pixels, expected above 0", where, K[0],
                      K[1]);
    if (!st) {
        out->width = (int)width;
        out->height = (int)height;
        out->K = (lt_camera){ K[0], K[1], K[2], K[3] };
    }
    return st;
}

static lt_status take_cameras(lt_arena *arena, const char *name, const cJSON *file, recording_rig *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(file, "cameras");

    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) < 1 || cJSON_GetArraySize(list) > RECORDING_CAMERAS)
        return lt_error(LT_EFORMAT, "%s: \"cameras\": expected a list of 1 to %d cameras", name, RECORDING_CAMERAS);
    out->n = cJSON_GetArraySize(list);
    for (int c = 0; c < out->n; c++) {
        char where[512];
        lt_status st;

        snprintf(where, sizeof(where), "%s: camera %d", name, c + 1);
        st = take_camera(arena, where, cJSON_GetArrayItem(list, c), &out->camera[c]);
        for (int b = 0; b < c && !st; b++)
            if (strcmp(out->camera[b].name, out->camera[c].name) == 0)
                st = lt_error(LT_EFORMAT, "%s: \"%s\" is the name of camera %d", where, out->camera[c].name, b + 1);
        if (st)
            return st;
    }
    return LT_OK;
}

static lt_status take_rig(lt_arena *arena, const char *name, const cJSON *file, recording_rig *out)
{
    const cJSON *schema = cJSON_GetObjectItemCaseSensitive(file, "schema");
    lt_status st;

    if (!cJSON_IsString(schema) || strcmp(schema->valuestring, SCHEMA) != 0)
        return lt_error(LT_EFORMAT, "%s: \"schema\": expected \"%s\"", name, SCHEMA);
    st = take_number(name, file, "fps", 0.1, 1000, &out->fps);
    st = st ? st : take_cameras(arena, name, file, out);
    out->has_robot = cJSON_HasObjectItem(file, "robot");
    if (!st && out->has_robot)
        st = take_numbers(name, file, "robot", 4, out->robot);
    out->synthetic = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(file, "synthetic"));
    return st;
}

lt_status recording_rig_parse(lt_arena *arena, const char *name, const char *text, size_t n, recording_rig *out)
{
    recording_rig rig = { .n = 0 };
    cJSON *file = NULL;
    lt_status st = lt_json_parse(name, text, n, &file);

    st = st ? st : take_rig(arena, name, file, &rig);
    cJSON_Delete(file);
    if (!st)
        *out = rig;
    return st;
}

lt_status recording_rig_read(lt_arena *arena, const char *path, recording_rig *out)
{
    lt_file f;
    lt_status st = lt_file_load(&f, path, LT_JSON_MAX);

    st = st ? st : recording_rig_parse(arena, path, (const char *)f.bytes, f.n, out);
    lt_file_free(&f);
    return st;
}

/* ---- writing ---- */

static cJSON *camera_json(const recording_camera *c)
{
    const double K[] = { c->K.fx, c->K.fy, c->K.cx, c->K.cy };
    cJSON *out = cJSON_CreateObject();

    cJSON_AddStringToObject(out, "name", c->name);
    cJSON_AddStringToObject(out, "role", roles[c->role]);
    cJSON_AddNumberToObject(out, "width", c->width);
    cJSON_AddNumberToObject(out, "height", c->height);
    cJSON_AddItemToObject(out, "K", cJSON_CreateDoubleArray(K, 4));
    if (c->placed) {
        cJSON_AddItemToObject(out, "R_world_cam", cJSON_CreateDoubleArray(c->R, 9));
        cJSON_AddItemToObject(out, "t_world_cam", cJSON_CreateDoubleArray(c->t, 3));
    }
    cJSON_AddNumberToObject(out, "depth_scale", c->depth_scale);
    return out;
}

lt_status recording_rig_write(const char *path, const recording_rig *rig)
{
    cJSON *file = cJSON_CreateObject(), *cameras;
    lt_status st;

    cJSON_AddStringToObject(file, "schema", SCHEMA);
    cJSON_AddNumberToObject(file, "fps", rig->fps);
    if (rig->synthetic)
        cJSON_AddTrueToObject(file, "synthetic");
    if (rig->has_robot)
        cJSON_AddItemToObject(file, "robot", cJSON_CreateDoubleArray(rig->robot, 4));
    cameras = cJSON_AddArrayToObject(file, "cameras");
    for (int c = 0; c < rig->n; c++)
        cJSON_AddItemToArray(cameras, camera_json(&rig->camera[c]));
    st = file ? lt_json_write(path, file) : lt_error(LT_ENOMEM, "%s: no memory", path);
    cJSON_Delete(file);
    return st;
}
