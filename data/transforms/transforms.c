/* SPDX-License-Identifier: Apache-2.0 */
/* The json file: frames, and where their pictures are. */
#include "data/transforms/internal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

/* ---- cameras --------------------------------------------------------------------------------------------- */

/* Camera to world, x right, y up, z backward: three rows of four, and a fourth that says nothing */
static lt_status read_matrix(const char *where, const cJSON *frame, transforms_view *v)
{
    const cJSON *rows = cJSON_GetObjectItemCaseSensitive(frame, "transform_matrix");
    double R[9], t[3];

    if (cJSON_GetArraySize(rows) != 3 && cJSON_GetArraySize(rows) != 4)
        return lt_error(LT_EFORMAT, "%s: transform_matrix: found %d rows, want 3 or 4 of 4 numbers", where,
                        cJSON_GetArraySize(rows));
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) {
            const cJSON *row = cJSON_GetArrayItem(rows, i), *x = cJSON_GetArrayItem(row, k);

            if (cJSON_GetArraySize(row) != 4 || !cJSON_IsNumber(x) || !isfinite(x->valuedouble))
                return lt_error(LT_EFORMAT, "%s: transform_matrix: row %d has no 4 finite numbers", where, i + 1);
            if (k < 3)
                R[3 * i + k] = k ? -x->valuedouble : x->valuedouble;
            else
                t[i] = x->valuedouble;
        }
    if (!lt_mat3_is_rotation(R, 1e-3))
        return lt_error(LT_EFORMAT, "%s: transform_matrix: its 3 x 3 is no rotation to 1e-3; cameras are wanted as "
                        "nerfstudio writes them: camera to world, without scale", where);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            v->R_cam_world[3 * i + k] = R[3 * k + i];
    lt_mat3_mulvec(v->R_cam_world, t, v->t_cam_world);
    for (int k = 0; k < 3; k++)
        v->t_cam_world[k] = -v->t_cam_world[k];
    return LT_OK;
}

/* ---- pictures -------------------------------------------------------------------------------------------- */

/* A file that is there, with the ending that it has, or else one that pictures have; NULL: there is none */
static const char *find(lt_arena *arena, const char *folder, const char *name)
{
    static const char *const endings[] = { "", ".png", ".jpg", ".jpeg", ".PNG", ".JPG" };
    const char *stem = lt_path_join(arena, folder, strncmp(name, "./", 2) == 0 ? name + 2 : name);

    for (size_t i = 0; stem && i < LT_COUNT(endings); i++) {
        const char *path = lt_arena_printf(arena, "%s%s", stem, endings[i]);

        if (path && access(path, R_OK) == 0 && !lt_is_folder(path))
            return path;
    }
    return NULL;
}

static lt_status read_path(lt_arena *arena, const char *where, const char *folder, const cJSON *frame, const char *key,
                           const char **name, const char **path)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(frame, key);

    if (!cJSON_IsString(x) || !lt_path_is_inside(x->valuestring))
        return lt_error(LT_EFORMAT, "%s: %s: %s, want a file inside the folder", where, key,
                        cJSON_IsString(x) ? x->valuestring : "no text");
    *name = lt_arena_strdup(arena, x->valuestring);
    *path = find(arena, folder, x->valuestring);
    if (!*name)
        return lt_error(LT_ENOMEM, "%s: no memory", where);
    return *path ? LT_OK : lt_error(LT_EFORMAT, "%s: %s: there is no %s/%s", where, key, folder, x->valuestring);
}

static lt_status read_frame(lt_arena *arena, const char *where, const char *folder, const cJSON *file,
                            const cJSON *frame, transforms_view *v)
{
    const char *mask_name;
    lt_status st = read_path(arena, where, folder, frame, "file_path", &v->name, &v->image);

    if (!st && cJSON_HasObjectItem(frame, "mask_path"))
        st = read_path(arena, where, folder, frame, "mask_path", &mask_name, &v->mask);
    if (!st)
        st = transforms_lens_read(where, file, frame, &v->lens);
    return st ? st : read_matrix(where, frame, v);
}

/* ---- files ----------------------------------------------------------------------------------------------- */

/* The frames of a file behind those that are there already */
static lt_status read_frames(lt_arena *arena, const char *path, const cJSON *file, transforms_set *s)
{
    const cJSON *frames = cJSON_GetObjectItemCaseSensitive(file, "frames"), *frame;
    const char *folder = lt_path_folder(arena, path);
    const int n = cJSON_GetArraySize(frames);
    transforms_view *all;
    int i = s->n;

    if (!cJSON_IsArray(frames) || n < 1 || n > TRANSFORMS_MOST_VIEWS)
        return lt_error(LT_EFORMAT, "%s: \"frames\": found %d, want a list of 1 to %d cameras with images", path, n,
                        TRANSFORMS_MOST_VIEWS);
    all = lt_arena_array(arena, (size_t)(s->n + n), sizeof(*all));
    if (!all || !folder)
        return lt_error(LT_ENOMEM, "%s: no memory for %d views", path, n);
    if (s->n)
        memcpy(all, s->view, (size_t)s->n * sizeof(*all));
    s->view = all;
    cJSON_ArrayForEach(frame, frames) {
        char where[512];
        lt_status st;

        snprintf(where, sizeof(where), "%s: frame %d", path, i - s->n + 1);
        all[i] = (transforms_view){ .name = NULL };
        st = read_frame(arena, where, folder, file, frame, &all[i++]);
        if (st)
            return st;
    }
    s->n = i;
    return LT_OK;
}

static lt_status read_one(lt_arena *arena, const char *path, int holdout, transforms_set *s)
{
    const char *folder = lt_path_folder(arena, path);
    cJSON *file = NULL;
    lt_status st = lt_json_read(path, &file);

    if (!st)
        st = read_frames(arena, path, file, s);
    if (!st && holdout)
        st = transforms_hold_out(file, holdout, s);
    if (!st && folder && !s->n_points)
        st = transforms_points(arena, folder, file, s);
    cJSON_Delete(file);
    return st;
}

/* Two files: all views of the second are held out. */
static lt_status read_two(lt_arena *arena, const char *train, const char *test, transforms_set *s)
{
    lt_status st = read_one(arena, train, 0, s);
    const int first = s->n;

    if (!st)
        st = read_one(arena, test, 0, s);
    for (int i = first; i < s->n && !st; i++)
        s->view[i].held_out = true;
    return st;
}

static lt_status check(transforms_set *s)
{
    int masks = 0;

    for (int i = 0; i < s->n; i++) {
        masks += s->view[i].mask != NULL;
        s->n_held_out += s->view[i].held_out;
    }
    if (masks && masks < s->n)
        return lt_error(LT_EFORMAT, "%s: %d of %d frames have a mask_path: all or none", s->path, masks, s->n);
    if (s->n_held_out == s->n)
        return lt_error(LT_EFORMAT, "%s: all of its %d views are held out: none to learn from", s->path, s->n);
    return LT_OK;
}

static lt_status read_folder(lt_arena *arena, const char *folder, int holdout, transforms_set *s)
{
    static const char *const others[] = { "transforms_test.json", "transforms_val.json" };
    const char *one = lt_path_join(arena, folder, "transforms.json");
    const char *train = lt_path_join(arena, folder, "transforms_train.json");

    if (!one || !train)
        return lt_error(LT_ENOMEM, "%s: no memory", folder);
    s->path = access(one, F_OK) == 0 ? one : train;
    if (s->path == one)
        return read_one(arena, one, holdout, s);
    if (access(train, F_OK) != 0)
        return lt_error(LT_EFORMAT, "%s: has neither transforms.json nor transforms_train.json", folder);
    for (size_t i = 0; i < LT_COUNT(others); i++) {
        const char *test = lt_path_join(arena, folder, others[i]);

        if (test && access(test, F_OK) == 0)
            return read_two(arena, train, test, s);
    }
    return read_one(arena, train, holdout, s);
}

lt_status transforms_open(lt_arena *arena, const char *path, int holdout, transforms_set *out)
{
    transforms_set s = { .path = path };
    lt_status st;

    if (lt_is_folder(path)) {
        const char *manifest = lt_path_join(arena, path, "manifest.json");

        s.synthetic = manifest && access(manifest, F_OK) == 0;
        st = read_folder(arena, path, holdout, &s);
    } else {
        st = read_one(arena, path, holdout, &s);
    }
    if (!st)
        st = check(&s);
    if (!st)
        *out = s;
    return st;
}
