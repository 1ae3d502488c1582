/* SPDX-License-Identifier: Apache-2.0 */
/* What was assumed of an image, said once for all images that it holds for. */
#include "pipeline/internal.h"

#include <string.h>

enum { TURN, HAND, OBJECT, CAMERA };

static const char *const otherwise[PREDICT_ASSUMPTIONS] = {
    [TURN] = "upright as it is stored", [HAND] = "its hand box is listed", [OBJECT] = "its object box is listed",
    [CAMERA] = "the camera is given",
};

/* text: the assumption; "": there is none to make. Whether it was said. */
static bool say(const predict_options *o, const predict_view *v, predict_assumed *said, int kind, const char *text)
{
    if (!strcmp(said->last[kind], text))
        return false;
    predict_say(o, "%s: %s", v->path, *text ? text : otherwise[kind]);
    snprintf(said->last[kind], sizeof(said->last[kind]), "%s", text);
    return true;
}

static bool say_turn(const predict_options *o, const predict_view *v, predict_assumed *said)
{
    char text[PREDICT_ASSUMPTION_TEXT] = "";

    if (v->orientation != 1)
        snprintf(text, sizeof(text), "turned upright (orientation %d of EXIF's), now %d x %d", v->orientation, v->width,
                 v->height);
    return say(o, v, said, TURN, text);
}

/* which: "hand"; instead: what was taken where nobody gave one */
static bool say_box(const predict_options *o, const predict_view *v, predict_assumed *said, int kind,
                    predict_source from, const char *which, const char *instead)
{
    char text[PREDICT_ASSUMPTION_TEXT] = "";

    if (o->boxes && from == PREDICT_DEFAULT)
        snprintf(text, sizeof(text), "no %s box in %s: took %s", which, o->boxes, instead);
    else if (o->boxes && from == PREDICT_GIVEN)
        snprintf(text, sizeof(text), "no %s box in %s: took --%s-box", which, o->boxes, which);
    else if (from == PREDICT_DEFAULT)
        snprintf(text, sizeof(text), "no --%s-box: took %s", which, instead);
    return say(o, v, said, kind, text);
}

static bool say_hand(const predict_options *o, const predict_view *v, predict_assumed *said)
{
    const crop_box b = v->hand_box;
    char middle[128];

    snprintf(middle, sizeof(middle), "the middle of the image, %.0f,%.0f,%.0f,%.0f", (double)b.x0, (double)b.y0,
             (double)b.x1, (double)b.y1);
    return say_box(o, v, said, HAND, v->hand_from, "hand", middle);
}

/* Without numbers: they follow the hand's, which moves. */
static bool say_object(const predict_options *o, const predict_view *v, predict_assumed *said)
{
    return say_box(o, v, said, OBJECT, v->object_from, "object", "the hand's box grown 1.3 times");
}

static bool say_camera(const predict_options *o, const predict_view *v, predict_assumed *said)
{
    char text[PREDICT_ASSUMPTION_TEXT] = "";

    if (v->camera_from == PREDICT_EXIF)
        snprintf(text, sizeof(text), "no --K: focal length %.0f px from EXIF; right unless the image was cut",
                 v->camera.fx);
    else if (v->camera_from == PREDICT_DEFAULT)
        snprintf(text, sizeof(text), "no --K: assumed a focal length of %.0f px (1.2 times the longer side), so "
                 "distances are rough", v->camera.fx);
    return say(o, v, said, CAMERA, text);
}

void predict_say_assumed(const predict_options *o, const predict_view *v, predict_assumed *said)
{
    bool any = say_turn(o, v, said);

    any = say_hand(o, v, said) || any;
    any = say_object(o, v, said) || any;
    any = say_camera(o, v, said) || any;
    if (any && said->many && !said->explained)
        predict_say(o, "what was assumed is said again where it changes");
    said->explained = said->explained || any;
}
