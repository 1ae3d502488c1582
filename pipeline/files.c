/* SPDX-License-Identifier: Apache-2.0 */
/* All that is written for one image, and its numbers as JSON. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <string.h>

/* ---- JSON: a value that could not be made is found at the end, by counting ------------------------------ */

static void put(cJSON *to, const char *key, cJSON *value, bool *ok)
{
    if (!value || !cJSON_AddItemToObject(to, key, value)) {
        cJSON_Delete(value);
        *ok = false;
    }
}

static cJSON *object_in(cJSON *to, const char *key, bool *ok)
{
    cJSON *made = cJSON_AddObjectToObject(to, key);

    *ok = *ok && made;
    return made;
}

static void put_text(cJSON *to, const char *key, const char *text, bool *ok)
{
    put(to, key, text ? cJSON_CreateString(text) : cJSON_CreateNull(), ok);
}

static void put_number(cJSON *to, const char *key, double x, bool *ok)
{
    put(to, key, cJSON_CreateNumber(x), ok);
}

/* rows of columns numbers each, as lists in a list */
static void put_rows(cJSON *to, const char *key, const float *x, int rows, int columns, bool *ok)
{
    cJSON *all = cJSON_CreateArray();

    for (int i = 0; i < rows && all; i++) {
        cJSON *row = cJSON_CreateFloatArray(x + columns * i, columns);

        if (!row || !cJSON_AddItemToArray(all, row)) {
            cJSON_Delete(row);
            *ok = false;
        }
    }
    put(to, key, all, ok);
}

/* ---- what there is to say ------------------------------------------------------------------------------- */

static void put_conventions(cJSON *root, bool *ok)
{
    static const char *const says[][2] = {
        { "axes", "camera: x right, y down, z forward" },
        { "units", "metres, radians, pixels; the unit ends the key" },
        { "pixels", "of the image turned upright; centres are at whole numbers" },
        { "joints", "wrist, then thumb, index, middle, ring, little, each from base to tip" },
        { "theta", "axis-angle of 16 joints in MANO's order (wrist, index, middle, little, ring, thumb), "
                   "the wrist's in camera axes, no mean pose added" },
        { "object", "x_camera = R x_model + t, R by rows" },
        { "K", "fx, fy, cx, cy" },
    };
    cJSON *c = object_in(root, "conventions", ok);

    for (size_t i = 0; i < LT_COUNT(says) && c; i++)
        put_text(c, says[i][0], says[i][1], ok);
}

static void put_model(cJSON *root, const predict_options *o, bool *ok)
{
    cJSON *m = object_in(root, "model", ok);

    if (!m)
        return;
    put_text(m, "name", o->m->cls->name, ok);
    put_text(m, "variant", o->m->variant, ok);
    put_text(m, "paper", o->m->cls->paper, ok);
    put_text(m, "checkpoint", o->checkpoint, ok);
    put_text(m, "trained_on", o->trained_on, ok);
    put_text(m, "hand_model", o->hand->synthetic ? "embedded stand-in, not MANO" : "MANO", ok);
}

static void put_box(cJSON *to, const char *key, crop_box b, predict_source from, bool *ok)
{
    const float corner[4] = { b.x0, b.y0, b.x1, b.y1 };
    cJSON *box = object_in(to, key, ok);

    if (!box)
        return;
    put(box, "x0y0x1y1_px", cJSON_CreateFloatArray(corner, 4), ok);
    put_text(box, "source", predict_source_name(from), ok);
}

static void put_view(cJSON *root, const predict_view *v, bool *ok)
{
    const double K[4] = { v->camera.fx, v->camera.fy, v->camera.cx, v->camera.cy };
    cJSON *boxes, *camera;

    put_text(root, "image", v->path, ok);
    put_number(root, "width_px", v->width, ok);
    put_number(root, "height_px", v->height, ok);
    put_number(root, "exif_orientation", v->orientation, ok);
    put(root, "depth", v->depth_path ? cJSON_CreateString(v->depth_path) : cJSON_CreateNull(), ok);
    boxes = object_in(root, "boxes", ok);
    camera = object_in(root, "camera", ok);
    if (!boxes || !camera)
        return;
    put_box(boxes, "hand", v->hand_box, v->hand_from, ok);
    put_box(boxes, "object", v->object_box, v->object_from, ok);
    put(camera, "K_px", cJSON_CreateDoubleArray(K, 4), ok);
    put_text(camera, "source", predict_source_name(v->camera_from), ok);
}

static void put_hand(cJSON *root, const predict_case *s, const char *mesh, bool *ok)
{
    const predict_result *r = s->r;
    cJSON *h = object_in(root, "hand", ok);

    if (!h)
        return;
    put_text(h, "side", s->v->left ? "left" : "right", ok);
    put_text(h, "position", r->placed ? "solved" : "guessed", ok);
    put(h, "trusted", cJSON_CreateBool(predict_trusted(s->v, r)), ok);
    put_number(h, "agreement_px", r->agreement_px, ok);
    put_rows(h, "joints3d_m", r->e.joints[0], LT_HAND_KEYPOINTS, 3, ok);
    put_rows(h, "joints2d_px", r->joints2d[0], LT_HAND_KEYPOINTS, 2, ok);
    put_rows(h, "heatmap2d_px", r->heatmap2d[0], LT_HAND_KEYPOINTS, 2, ok);
    put(h, "theta_rad", cJSON_CreateDoubleArray(r->theta, 3 * LT_HAND_JOINTS), ok);
    put(h, "beta", cJSON_CreateFloatArray(r->e.beta, LT_HAND_BETAS), ok);
    put_text(h, "vertices_file", mesh, ok);
}

static void put_object(cJSON *root, const predict_case *s, const char *mesh, bool *ok)
{
    const predict_result *r = s->r;
    cJSON *b;

    put_rows(root, "object_box2d_px", r->control2d[0], LT_BOX_POINTS, 2, ok);
    if (!s->object) {
        put(root, "object", cJSON_CreateNull(), ok);
        return;
    }
    b = object_in(root, "object", ok);
    if (!b)
        return;
    put_text(b, "name", s->object->name, ok);
    put_text(b, "mesh_source", s->object->origin, ok);
    put(b, "found", cJSON_CreateBool(r->object_found), ok);
    put(b, "R", r->object_found ? cJSON_CreateDoubleArray(r->e.object.R, 9) : cJSON_CreateNull(), ok);
    put(b, "t_m", r->object_found ? cJSON_CreateDoubleArray(r->e.object.t, 3) : cJSON_CreateNull(), ok);
    put_number(b, "inliers", r->e.object_inliers, ok);
    put_number(b, "confidence", (double)r->e.object_confidence, ok);
    put_text(b, "vertices_file", mesh, ok);
}

static lt_status write_json(const predict_case *s, const predict_mesh_files *files, const char *path)
{
    cJSON *root = cJSON_CreateObject();
    bool ok = root;
    lt_status st;

    if (ok) {
        put_view(root, s->v, &ok);
        put_model(root, s->o, &ok);
        put_hand(root, s, files->hand, &ok);
        put_object(root, s, files->object, &ok);
        put_conventions(root, &ok);
    }
    st = ok ? lt_json_write(path, root) : lt_error(LT_ENOMEM, "%s: no memory", path);
    cJSON_Delete(root);
    return st;
}

/* ---- all of it ------------------------------------------------------------------------------------------ */

lt_status predict_write_files(lt_arena *arena, const predict_case *s)
{
    const char *json, *json_path, *png, *png_path;
    predict_mesh_files files;
    lt_mesh hand;
    lt_status st = predict_file_name(arena, s, ".json", &json, &json_path);

    st = st ? st : predict_file_name(arena, s, ".overlay.png", &png, &png_path);
    st = st ? st : predict_hand_mesh(arena, s, &hand);
    st = st ? st : predict_write_overlay(arena, s, &hand, png_path);
    st = st ? st : predict_write_meshes(arena, s, &hand, &files);
    return st ? st : write_json(s, &files, json_path);
}
