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
        { "people", "joints: 65, 25 of the body and 20 of each hand, left first; pose_rad: axis-angle of SMPL-X's 55 "
                    "joints, the pelvis's in camera axes; pelvis_m, which joints3d_m begins at, is rough" },
        { "object", "x_camera = R x_model + t, R by rows" },
        { "mask", "runs down the columns, as COCO writes them; size: height, width" },
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
    cJSON *m;

    if (!o->m) {
        put(root, "model", cJSON_CreateNull(), ok);
        return;
    }
    m = object_in(root, "model", ok);
    if (!m)
        return;
    put_text(m, "name", o->m->cls->name, ok);
    put_text(m, "variant", o->m->variant, ok);
    put_text(m, "paper", o->m->cls->paper, ok);
    put_text(m, "checkpoint", o->checkpoint, ok);
    put_text(m, "trained_on", o->trained_on, ok);
    put_text(m, "hand_model", o->hand->synthetic ? "embedded stand-in, not MANO" : "MANO", ok);
}

static void put_detector(cJSON *root, const detector *d, bool *ok)
{
    cJSON *to = d ? object_in(root, "detector", ok) : NULL;

    if (!to) {
        put(root, "detector", cJSON_CreateNull(), ok);
        return;
    }
    put_text(to, "name", d->t.m.cls->name, ok);
    put_text(to, "variant", d->t.m.variant, ok);
    put_text(to, "checkpoint", d->t.path, ok);
    put_number(to, "classes", d->n, ok);
}

static void put_body_model(cJSON *root, const body_estimator *e, bool *ok)
{
    cJSON *to = e ? object_in(root, "body_estimator", ok) : NULL;

    if (!to) {
        put(root, "body_estimator", cJSON_CreateNull(), ok);
        return;
    }
    put_text(to, "name", e->t.m.cls->name, ok);
    put_text(to, "variant", e->t.m.variant, ok);
    put_text(to, "checkpoint", e->t.path, ok);
    put_text(to, "body_model", e->body.model->synthetic ? "synthetic stand-in, not SMPL-X" : "SMPL-X", ok);
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

/* What the detector says of it: nothing where d is NULL. */
static void put_detection(cJSON *to, const predict_frame *f, const predict_detection *d, bool *ok)
{
    const double size[2] = { f->scene.height, f->scene.width };
    cJSON *mask;

    if (!d)
        return;
    put_text(to, "class", d->name, ok);
    put_number(to, "score", d->score, ok);
    put(to, "track_id", d->track ? cJSON_CreateNumber((double)d->track) : cJSON_CreateNull(), ok);
    mask = object_in(to, "mask", ok);
    if (!mask)
        return;
    put(mask, "size", cJSON_CreateDoubleArray(size, 2), ok);
    put(mask, "counts", cJSON_CreateString(detection_runs(f->arena, &d->window, f->scene.width, f->scene.height)), ok);
}

static void put_hand(cJSON *h, const predict_view *v, const predict_result *r, const char *mesh, bool *ok)
{
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

static const char *name_of(const predict_view *v)
{
    return v->object ? v->object->name : v->object_seen ? "unknown" : NULL;
}

static void put_object(cJSON *b, const predict_view *v, const predict_result *r, const char *mesh, bool *ok)
{
    put_text(b, "name", name_of(v), ok);
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

/* A hand as it is; without an estimate its side is known from its class alone. */
static void put_whole_hand(cJSON *list, const predict_frame *f, int i, bool *ok)
{
    const predict_view *v = &f->view[i];
    const bool known = (f->has & FRAME_POSES) || (v->hand_seen && v->hand_seen->side != PREDICT_ANY_SIDE);
    cJSON *h = item_in(list, ok);

    if (!h)
        return;
    put_box(h, "box", v->hand_box, v->hand_from, ok);
    put_detection(h, f, v->hand_seen, ok);
    put_text(h, "side", !known ? NULL : v->left ? "left" : "right", ok);
    if (f->has & FRAME_POSES)
        put_hand(h, v, &f->result[i], f->files ? f->files[i].hand : NULL, ok);
}

/* What hand i holds, as its own estimate has it */
static void put_held(cJSON *list, const predict_frame *f, int i, bool *ok)
{
    const predict_view *v = &f->view[i];
    cJSON *b = item_in(list, ok);

    if (!b)
        return;
    put_number(b, "hand", i, ok);
    put_box(b, "box", v->object_box, v->object_from, ok);
    put_detection(b, f, v->object_seen, ok);
    if (!(f->has & FRAME_POSES))
        return;
    put_rows(b, "box2d_px", f->result[i].control2d[0], LT_BOX_POINTS, 2, ok);
    put_object(b, v, &f->result[i], f->files ? f->files[i].object : NULL, ok);
}

/* Seen by the detector, and in no hand */
static void put_apart(cJSON *list, const predict_frame *f, const predict_detection *d, bool *ok)
{
    cJSON *b = item_in(list, ok);

    if (!b)
        return;
    if (d->kind == DETECTED_OBJECT)
        put(b, "hand", cJSON_CreateNull(), ok);
    put_box(b, "box", d->box, PREDICT_DETECTED, ok);
    put_detection(b, f, d, ok);
}

/* A person, with the body that was found */
static void put_person(cJSON *list, const predict_frame *f, const predict_person *p, bool *ok)
{
    const body_estimate *e = &p->body;
    float joints[BODY_NODES][3];
    cJSON *b = item_in(list, ok);

    if (!b)
        return;
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 3; k++)
            joints[i][k] = (float)(e->nodes[i][k] + e->pelvis[k]);
    put_box(b, "box", p->box, p->from, ok);
    put_detection(b, f, p->seen, ok);
    put(b, "pelvis_m", cJSON_CreateDoubleArray(e->pelvis, 3), ok);
    put_rows(b, "joints3d_m", joints[0], BODY_NODES, 3, ok);
    put_rows(b, "joints2d_px", e->nodes2d[0], BODY_NODES, 2, ok);
    put(b, "pose_rad", cJSON_CreateDoubleArray(e->pose[0], 3 * BODY_JOINTS), ok);
    put(b, "shape", cJSON_CreateDoubleArray(e->shape, BODY_SHAPES), ok);
    put(b, "expression", cJSON_CreateDoubleArray(e->expression, BODY_EXPRESSIONS), ok);
}

static bool is_held(const predict_frame *f, const predict_detection *d)
{
    for (int i = 0; i < f->n; i++)
        if (f->view[i].object_seen == d)
            return true;
    return false;
}

/* Objects in the order of the hands that hold them, then the others. A hand that is detected alone has none, unless the
 * user named what it holds. */
static void put_found(cJSON *root, const predict_frame *f, bool *ok)
{
    cJSON *hands = list_in(root, "hands", ok), *objects = list_in(root, "objects", ok);
    cJSON *people = list_in(root, "people", ok);

    for (int i = 0; i < f->n && *ok; i++) {
        put_whole_hand(hands, f, i, ok);
        if (!f->detected || f->view[i].object_seen || f->view[i].object)
            put_held(objects, f, i, ok);
    }
    for (int i = 0; i < f->n_detections && *ok; i++) {
        const predict_detection *d = &f->detection[i];

        if (d->kind == DETECTED_PERSON && !(f->has & FRAME_BODIES))
            put_apart(people, f, d, ok);
        else if (d->kind == DETECTED_OBJECT && !is_held(f, d))
            put_apart(objects, f, d, ok);
    }
    for (int i = 0; i < f->n_people && *ok; i++)
        put_person(people, f, &f->person[i], ok);
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

/* What the keys were before there were several hands, for one version more; null where there is no hand */
static void put_former(cJSON *root, const predict_frame *f, bool *ok)
{
    static const char *const keys[] = { "boxes", "hand", "object_box2d_px", "object" };
    const predict_view *v = f->view;
    const predict_result *r = f->result;
    cJSON *boxes, *hand, *object;

    for (size_t i = 0; i < LT_COUNT(keys) && !(f->n && r); i++)
        put(root, keys[i], cJSON_CreateNull(), ok);
    if (!f->n || !r)
        return;
    boxes = object_in(root, "boxes", ok);
    hand = object_in(root, "hand", ok);
    if (!boxes || !hand)
        return;
    put_box(boxes, "hand", v->hand_box, v->hand_from, ok);
    put_box(boxes, "object", v->object_box, v->object_from, ok);
    put_text(hand, "side", v->left ? "left" : "right", ok);
    put_hand(hand, v, r, f->files ? f->files->hand : NULL, ok);
    put_rows(root, "object_box2d_px", r->control2d[0], LT_BOX_POINTS, 2, ok);
    object = v->object ? object_in(root, "object", ok) : NULL;
    if (object)
        put_object(object, v, r, f->files ? f->files->object : NULL, ok);
    else
        put(root, "object", cJSON_CreateNull(), ok);
}

/* NULL without memory */
static cJSON *record(const predict_frame *f)
{
    cJSON *root = cJSON_CreateObject();
    bool ok = root;

    if (!ok)
        return NULL;
    put_view(root, &f->scene, &ok);
    put_model(root, f->o, &ok);
    put_detector(root, f->o->detector, &ok);
    put_body_model(root, f->o->body, &ok);
    put_found(root, f, &ok);
    put_notes(root, &f->notes, &ok);
    put_conventions(root, &ok);
    put_former(root, f, &ok);
    if (ok)
        return root;
    cJSON_Delete(root);
    return NULL;
}

lt_status predict_write_json(const predict_frame *f, const char *path)
{
    cJSON *root = record(f);
    const lt_status st = root ? lt_json_write(path, root) : lt_error(LT_ENOMEM, "%s: no memory", path);

    cJSON_Delete(root);
    return st;
}

lt_status predict_print_json(const predict_frame *f, FILE *to)
{
    cJSON *root = record(f);

    if (!root)
        return lt_error(LT_ENOMEM, "%s: no memory", f->input.path);
    lt_json_print(to, root);
    cJSON_Delete(root);
    fputc('\n', to);
    if (fflush(to) || ferror(to))
        return lt_error(lt_errno_status(errno), "standard output: %s", strerror(errno));
    return LT_OK;
}
