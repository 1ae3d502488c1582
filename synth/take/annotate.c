/* SPDX-License-Identifier: Apache-2.0 */
/* Turns the stage's truth into a camera's, and measures contact and visibility. */
#include "synth/take/annotate.h"

#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

static const double TOUCH = 0.004, FLESH = 0.015;       /* metres */

static void annotate_hand(const synth_stage *s, const synth_camera *c, const synth_moment *m,
                          const synth_posed_hand *world, synth_picture *out)
{
    double R[9], wrist[3];

    lt_mat3_mul(c->R_cam_world, m->R_hand, R);
    lt_rot_to_axis_angle(R, out->pose);
    memcpy(out->pose + 3, m->fingers, sizeof(m->fingers));
    lt_rigid_apply(c->R_cam_world, c->t_cam_world, m->wrist, wrist);
    lt_vec3_sub(wrist, s->subject->rest_wrist, out->trans);
    memcpy(out->rest_wrist, s->subject->rest_wrist, sizeof(out->rest_wrist));
    memcpy(out->beta, s->subject->beta, sizeof(out->beta));
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        lt_rigid_apply(c->R_cam_world, c->t_cam_world, world->keypoints[i], out->joints[i]);
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        lt_rigid_apply(c->R_cam_world, c->t_cam_world, world->vertices[i], out->vertices[i]);
}

/* Each hand vertex against the object's surface, worked out in the model's frame. */
void synth_annotate_contact(const synth_stage *s, synth_picture *out)
{
    double back[9];

    lt_mat3_transpose(out->R, back);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double d[3], p[3], q[3];
        lt_mesh_hit hit;
        lt_vec3_sub(out->vertices[i], out->t, d);
        lt_mat3_mulvec(back, d, p);
        hit = lt_mesh_closest(s->prop->index, p);
        lt_rigid_apply(out->R, out->t, hit.point, q);
        for (int k = 0; k < 3; k++)
            out->contact.nearest[i][k] = (float)q[k];
        out->contact.distance[i] = (float)hit.distance;
        out->contact.contact[i] = hit.distance <= TOUCH;
        out->contact.inside[i] = hit.distance < 0.05 && lt_mesh_inside(s->prop->index, p);
    }
}

void synth_annotate(const synth_stage *s, int camera, int k, const synth_posed_hand *world,
                    synth_picture *out)
{
    const synth_camera *c = &s->camera[synth_stage_view(s, camera, k)];
    const synth_moment *m = &s->sequence.moment[s->kept[k]];

    out->width = c->width;
    out->height = c->height;
    out->camera = (lt_camera){ c->fx, c->fy, c->cx, c->cy };
    out->n_cameras = s->n_cameras;
    out->object = s->prop->name;
    out->object_id = s->prop->id;
    out->box = s->prop->box;
    lt_mat3_mul(c->R_cam_world, m->R_obj, out->R);
    lt_rigid_apply(c->R_cam_world, c->t_cam_world, m->t_obj, out->t);
    annotate_hand(s, c, m, world, out);
}

/* ---- what can be seen ---- */

/* The pixel a joint falls on, or -1 outside the picture. */
static int pixel_of(const synth_picture *p, int joint)
{
    double uv[2];
    long x, y;

    if (!lt_camera_project(&p->camera, p->joints[joint], uv))
        return -1;
    x = lrint(fmax(-1, fmin(p->width, uv[0])));
    y = lrint(fmax(-1, fmin(p->height, uv[1])));
    return x < 0 || x >= p->width || y < 0 || y >= p->height ? -1 : (int)(y * p->width + x);
}

static void look_at_joints(const synth_picture *p, const synth_frame *frame, synth_visibility *out)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const int at = pixel_of(p, i);
        const double z = p->joints[i][2];
        bool behind_object, behind;
        if (at < 0)
            continue;
        behind_object = frame->object_depth[at] > 0 && frame->object_depth[at] < z;
        behind = frame->depth[at] > 0 && frame->depth[at] < z - FLESH;
        out->inside++;
        out->hidden_by_object += behind_object;
        out->hidden += behind_object || behind;
    }
}

/* The share of mask where label is seen; 1 when there is no mask. pixels: how many these are. */
static double visible_share(const synth_frame *frame, const uint8_t *mask, uint8_t label, int64_t *pixels)
{
    int64_t all = 0, seen = 0;

    for (int64_t i = 0; i < (int64_t)frame->width * frame->height; i++) {
        all += mask[i] != 0;
        seen += mask[i] != 0 && frame->label[i] == label;
    }
    *pixels = seen;
    return all ? (double)seen / (double)all : 1;
}

void synth_look(const synth_picture *p, const synth_frame *frame, synth_phase phase,
                const uint8_t part[LT_HAND_VERTICES], synth_visibility *out)
{
    static const int last[5] = { 15, 3, 6, 12, 9 };      /* thumb, index, middle, ring, little */
    int64_t hand, object;

    *out = (synth_visibility){ .phase = phase };
    look_at_joints(p, frame, out);
    out->hand_visible = visible_share(frame, frame->hand_mask, SYNTH_LABEL_HAND, &hand);
    out->object_visible = visible_share(frame, frame->object_mask, (uint8_t)p->object_id, &object);
    out->both = hand > 0 && object > 0;
    for (int f = 0; f < 5; f++)
        out->tip[f] = INFINITY;
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        out->contact |= p->contact.contact[i];
        out->inside_object |= p->contact.inside[i];
        for (int f = 0; f < 5; f++)
            if (part[i] == last[f])
                out->tip[f] = fmin(out->tip[f], p->contact.distance[i]);
    }
}
