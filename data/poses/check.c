/* SPDX-License-Identifier: Apache-2.0 */
/* Whether poses are where a camera can have seen a hand hold an object, and which slip it looks like if not. */
#include "data/poses/internal.h"

#include "libtensor/geometry/mat3.h"

static const double NEAR = 0.05, APART = 0.5, FAR = 20, ON_IT = 0.15;      /* metres */
static const double IN_TWENTY = 0.05;

/* Of frames with a hand, with an object, with both: how many there are, and of how many something holds. */
typedef struct {
    int64_t hands, objects, both;
    int64_t behind, apart;              /* not in front of the camera; too far from each other */
    int64_t turned, huge;               /* well behind it; as far as no hand is seen */
    int64_t hand_at_camera, object_at_camera;
} tally;

static void count_place(const double place[3], int64_t *at_camera, tally *c)
{
    c->behind += !(place[2] > NEAR);
    c->turned += place[2] < -NEAR;
    c->huge += lt_vec3_norm(place) > FAR;
    *at_camera += lt_vec3_norm(place) < ON_IT;
}

static tally count(const initial_poses *p)
{
    tally c = { 0 };

    for (size_t i = 0; i < p->n; i++) {
        const initial_pose *q = &p->pose[i];

        c.hands += q->has_hand;
        c.objects += q->has_object;
        if (q->has_hand)
            count_place(q->wrist, &c.hand_at_camera, &c);
        if (q->has_object)
            count_place(q->t, &c.object_at_camera, &c);
        if (q->has_hand && q->has_object) {
            c.both++;
            c.apart += !(lt_vec3_distance(q->wrist, q->t) < APART);
        }
    }
    return c;
}

static const char *likely_slip(const tally *c)
{
    const int64_t places = c->hands + c->objects;

    if (2 * c->huge > places)
        return "they look as if they were in millimetres: \"unit\": \"mm\"";
    if (2 * c->turned > places)
        return "they look as if they had OpenGL's axes: \"axes\": \"opengl\"";
    if (2 * c->hand_at_camera > c->hands && c->hands)
        return "hand.trans looks as if it were counted from the wrist, want the camera's frame";
    if (2 * c->object_at_camera > c->objects && c->objects)
        return "object.t looks as if it were counted from the wrist, want the camera's frame";
    return "want metres in the camera's frame, x right, y down, z forward";
}

lt_status initial_poses_check(const initial_poses *p, const char *path)
{
    const tally c = count(p);

    if (c.behind > IN_TWENTY * (double)(c.hands + c.objects))
        return lt_error(LT_EFORMAT, "%s: %lld of %lld hands and objects are not in front of the camera (z > %g m); %s",
                        path, (long long)c.behind, (long long)(c.hands + c.objects), NEAR, likely_slip(&c));
    if (c.apart > IN_TWENTY * (double)c.both)
        return lt_error(LT_EFORMAT, "%s: hand and object are more than %g m apart in %lld of %lld frames; %s", path,
                        APART, (long long)c.apart, (long long)c.both, likely_slip(&c));
    return LT_OK;
}
