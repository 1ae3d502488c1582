/* SPDX-License-Identifier: Apache-2.0 */
/* All numbers of one image as JSON: docs/formats.md, palmar.frame/1. */
#include "pipeline/internal.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <errno.h>
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
        { "pixels", "of the image turned upright, without its lens's distortion; centres are at whole numbers" },
        { "joints", "wrist, then thumb, index, middle, ring, little, each from base to tip" },
        { "theta", "axis-angle of 16 joints in MANO's order (wrist, index, middle, little, ring, thumb), "
                   "the wrist's in camera axes, no mean pose added" },
        { "object", "x_camera = R x_model + t, R by rows" },
        { "K", "fx, fy, cx, cy; distortion, which was taken out: k1, k2, p1, p2, k3, k4, k5, k6 of OpenCV" },
        { "former", "boxes, hand, object and object_box2d_px tell of the first hand alone; palmar.frame/2 will not "
                    "have them" },
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
    double lens[LT_LENS_COEFFICIENTS];
    cJSON *camera;

    put_text(root, "schema", "palmar.frame/1", ok);
    put_text(root, "image", v->path, ok);
    put_number(root, "width_px", v->width, ok);
    put_number(root, "height_px", v->height, ok);
    put_number(root, "exif_orientation", v->orientation, ok);
    put_text(root, "depth", v->depth_path, ok);
    camera = object_in(root, "camera", ok);
    if (!camera)
        return;
    put(camera, "K_px", cJSON_CreateDoubleArray(K, 4), ok);
    put_text(camera, "source", predict_source_name(v->camera_from), ok);
    if (v->lens)
        lt_lens_to_opencv(v->lens, lens);
    put(camera, "distortion", v->lens ? cJSON_CreateDoubleArray(lens, LT_LENS_COEFFICIENTS) : cJSON_CreateNull(), ok);
}

static void put_hand(cJSON *h, const predict_view *v, const predict_result *r, const char *mesh, bool *ok)
{
    put_text(h, "side", v->left ? "left" : "right", ok);
    put_text(h, "position", r->placed ? "solved" : "guessed", ok);
    put(h, "trusted", cJSON_CreateBool(predict_trusted(v, r)), ok);
    put_number(h, "agreement_px", r->agreement_px, ok);
    put_rows(h, "joints3d_m", r->e.joints[0], LT_HAND_KEYPOINTS, 3, ok);
    put_rows(h, "joints2d_px", r->joints2d[0], LT_HAND_KEYPOINTS, 2, ok);
    put_rows(h, "heatmap2d_px", r->heatmap2d[0], LT_HAND_KEYPOINTS, 2, ok);
    put(h, "theta_rad", cJSON_CreateDoubleArray(r->theta, 3 * LT_HAND_JOINTS), ok);
    put(h, "beta", cJSON_CreateFloatArray(r->e.beta, LT_HAND_BETAS), ok);
    put_text(h, "vertices_file", mesh, ok);
}

static void put_object(cJSON *b, const predict_view *v, const predict_result *r, const char *mesh, bool *ok)
{
    put_text(b, "name", v->object ? v->object->name : NULL, ok);
    put_text(b, "mesh_source", v->object ? v->object->origin : NULL, ok);
    put(b, "found", cJSON_CreateBool(r->object_found), ok);
    put(b, "trusted", cJSON_CreateBool(predict_object_trusted(v, r)), ok);
    put(b, "R", r->object_found ? cJSON_CreateDoubleArray(r->e.object.R, 9) : cJSON_CreateNull(), ok);
    put(b, "t_m", r->object_found ? cJSON_CreateDoubleArray(r->e.object.t, 3) : cJSON_CreateNull(), ok);
    put_number(b, "inliers", r->e.object_inliers, ok);
    put_number(b, "confidence", (double)r->e.object_confidence, ok);
    put_text(b, "vertices_file", mesh, ok);
}

static cJSON *list_in(cJSON *to, const char *key, bool *ok)
{
    cJSON *made = cJSON_AddArrayToObject(to, key);

    *ok = *ok && made;
    return made;
}

/* A further object at a list's end; NULL where that is not possible. */
static cJSON *item_in(cJSON *list, bool *ok)
{
    cJSON *made = list ? cJSON_CreateObject() : NULL;

    if (made && cJSON_AddItemToArray(list, made))
        return made;
    cJSON_Delete(made);
    *ok = false;
    return NULL;
}

/* The networks look at a hand and at what it may hold: object i is in hand i. */
static void put_pairs(cJSON *root, const predict_frame *f, const predict_mesh_files *files, bool *ok)
{
    cJSON *hands = list_in(root, "hands", ok), *objects = list_in(root, "objects", ok);

    for (int i = 0; i < f->n && *ok; i++) {
        const predict_view *v = &f->view[i];
        const predict_result *r = &f->result[i];
        cJSON *h = item_in(hands, ok), *b = item_in(objects, ok);

        if (!h || !b)
            return;
        put_box(h, "box", v->hand_box, v->hand_from, ok);
        put_hand(h, v, r, files[i].hand, ok);
        put_number(b, "hand", i, ok);
        put_box(b, "box", v->object_box, v->object_from, ok);
        put_rows(b, "box2d_px", r->control2d[0], LT_BOX_POINTS, 2, ok);
        put_object(b, v, r, files[i].object, ok);
    }
}

static void put_notes(cJSON *root, const predict_notes *notes, bool *ok)
{
    cJSON *list = list_in(root, "notes", ok);

    for (size_t i = 0; i < notes->n && *ok; i++) {
        cJSON *note = item_in(list, ok);

        if (!note)
            return;
        put_text(note, "code", predict_note_name(notes->note[i].code), ok);
        put_text(note, "text", notes->note[i].text, ok);
    }
}

/* What the keys were before there were several hands, for one version more */
static void put_former(cJSON *root, const predict_frame *f, const predict_mesh_files *files, bool *ok)
{
    const predict_view *v = f->view;
    const predict_result *r = f->result;
    cJSON *boxes = object_in(root, "boxes", ok), *hand = object_in(root, "hand", ok), *object;

    if (!boxes || !hand)
        return;
    put_box(boxes, "hand", v->hand_box, v->hand_from, ok);
    put_box(boxes, "object", v->object_box, v->object_from, ok);
    put_hand(hand, v, r, files->hand, ok);
    put_rows(root, "object_box2d_px", r->control2d[0], LT_BOX_POINTS, 2, ok);
    object = v->object ? object_in(root, "object", ok) : NULL;
    if (object)
        put_object(object, v, r, files->object, ok);
    else
        put(root, "object", cJSON_CreateNull(), ok);
}

/* NULL without memory */
static cJSON *record(const predict_frame *f, const predict_mesh_files *files)
{
    cJSON *root = cJSON_CreateObject();
    bool ok = root;

    if (!ok)
        return NULL;
    put_view(root, f->view, &ok);
    put_model(root, f->o, &ok);
    put_pairs(root, f, files, &ok);
    put_notes(root, &f->notes, &ok);
    put_conventions(root, &ok);
    put_former(root, f, files, &ok);
    if (ok)
        return root;
    cJSON_Delete(root);
    return NULL;
}

lt_status predict_write_json(const predict_frame *f, const predict_mesh_files *files, const char *path)
{
    cJSON *root = record(f, files);
    const lt_status st = root ? lt_json_write(path, root) : lt_error(LT_ENOMEM, "%s: no memory", path);

    cJSON_Delete(root);
    return st;
}

lt_status predict_print_json(const predict_frame *f, const predict_mesh_files *files, FILE *to)
{
    cJSON *root = record(f, files);

    if (!root)
        return lt_error(LT_ENOMEM, "%s: no memory", f->input.path);
    lt_json_print(to, root);
    cJSON_Delete(root);
    fputc('\n', to);
    if (fflush(to) || ferror(to))
        return lt_error(lt_errno_status(errno), "standard output: %s", strerror(errno));
    return LT_OK;
}
