/* SPDX-License-Identifier: Apache-2.0 */
/* detect: hands, objects and people wherever they are in the picture, where no list of boxes says it. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

#include <strings.h>

static const float CENTRE = 0.5f;       /* a detector's first pixel covers 0 to 1, here its middle is at 0 */

static predict_kind kind_of(const char *name, predict_side *side)
{
    *side = !strcasecmp(name, "left_hand") ? PREDICT_LEFT : !strcasecmp(name, "right_hand") ? PREDICT_RIGHT
                                                                                            : PREDICT_ANY_SIDE;
    if (*side != PREDICT_ANY_SIDE || !strcasecmp(name, "hand"))
        return DETECTED_HAND;
    return !strcasecmp(name, "person") ? DETECTED_PERSON : DETECTED_OBJECT;
}

static lt_status open_detector(const predict_options *o, void **state)
{
    const detector *d = o->detector;
    predict_side side;
    bool hands = false;

    for (int c = 0; c < d->n; c++)
        hands = hands || kind_of(d->name[c], &side) == DETECTED_HAND;
    if (!hands)
        predict_say(o, "%s: none of its %d classes is called hand, left_hand or right_hand, so it finds no hands",
                    d->t.path, d->n);
    *state = o->detector;
    return LT_OK;
}

static predict_detection detection_of(const detector *d, const detect_found *from)
{
    const float *b = from->box;
    predict_detection to = {
        .cls = from->cls, .name = d->name[from->cls], .score = from->score, .window = from->window,
        .box = { b[0] - CENTRE, b[1] - CENTRE, b[2] - CENTRE, b[3] - CENTRE },
    };

    to.kind = kind_of(to.name, &to.side);
    return to;
}

/* A box that is cut off to nothing at the picture's edge is none. */
static lt_status run(void *state, predict_frame *f)
{
    const predict_view *v = &f->scene;
    detection_rules rules = detection_rules_shown;
    detect_found *found;
    int n;
    lt_status st;

    f->detected = !f->input.n_boxes;
    if (!f->detected)
        return LT_OK;
    if (f->film && f->o->track == TRACK_BYTE)
        rules.score = tracker_defaults.low_conf;
    st = detector_run(state, v->rgb, v->width, v->height, &rules, f->arena, &found, &n);
    f->detection = st ? NULL : lt_arena_array(f->arena, (size_t)n, sizeof(*f->detection));
    if (st || !f->detection)
        return st ? lt_error_prefix(st, "%s", v->path) : lt_error(LT_ENOMEM, "%s: no memory", v->path);
    for (int i = 0; i < n; i++) {
        predict_detection *d = &f->detection[f->n_detections];

        *d = detection_of(state, &found[i]);
        f->n_detections += !predict_check_inside(v, d->name, d->box);
    }
    return LT_OK;
}

const stage detect_stage = {
    .name = "detect", .needs = FRAME_SCENE, .gives = FRAME_DETECTIONS, .open = open_detector, .run = run,
};
