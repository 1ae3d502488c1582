/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes and object names as people type them. */
#include "pipeline/predict.h"

#include "libtensor/io/text/nearest.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>

enum { ID = 4 };                        /* length of "003_" */

/* Four finite numbers with commas between, and nothing else. */
static lt_status parse_four(const char *name, const char *text, double out[4])
{
    const char *p = text;

    for (int i = 0; i < 4; i++) {
        const char *end;

        out[i] = lt_strtod(p, &end);
        if (end == p || *end != (i < 3 ? ',' : '\0') || !isfinite(out[i]) || fabs(out[i]) > 1e6)
            return lt_error(LT_EUSAGE, "%s %s: want x0,y0,x1,y1 in pixels", name, text);
        p = end + 1;
    }
    return LT_OK;
}

lt_status predict_parse_box(const char *name, const char *text, crop_box *out)
{
    double b[4];
    const lt_status st = parse_four(name, text, b);

    if (st)
        return st;
    if (!(b[0] < b[2] && b[1] < b[3]))
        return lt_error(LT_EUSAGE, "%s %s: an empty box; the order is x0,y0,x1,y1: left, top, right, bottom",
                        name, text);
    *out = (crop_box){ (float)b[0], (float)b[1], (float)b[2], (float)b[3] };
    return LT_OK;
}

lt_status predict_parse_format(const char *name, const char *text, predict_format *out)
{
    static const char *const known[] = { [PREDICT_OBJ] = "obj", [PREDICT_PLY] = "ply", [PREDICT_GLB] = "glb" };

    for (size_t i = 0; i < LT_COUNT(known); i++)
        if (!strcmp(text, known[i])) {
            *out = (predict_format)i;
            return LT_OK;
        }
    return lt_error(LT_EUSAGE, "%s %s: want obj, ply or glb", name, text);
}

/* "no object of that name", with the nearest or, when none is near, all of them. */
static lt_status unknown_object(const char *text)
{
    const char *full[YCB_COUNT], *plain[YCB_COUNT];
    char all[1024] = "there are:";

    for (int i = 0; i < YCB_COUNT; i++) {
        full[i] = ycb_find(i + 1)->name;
        plain[i] = full[i] + ID;
        strncat(all, " ", sizeof(all) - strlen(all) - 1);
        strncat(all, plain[i], sizeof(all) - strlen(all) - 1);
    }
    strncat(all, "; or your own, by --models", sizeof(all) - strlen(all) - 1);
    lt_unknown_name(text, lt_nearest_name(text, full, YCB_COUNT) ? full : plain, YCB_COUNT, all, "no such object");
    return LT_EUSAGE;
}

lt_status predict_find_object(const char *text, const ycb_object **out)
{
    const char *name = strncmp(text, "syn_", 4) ? text : text + 4;

    for (int id = 1; id <= YCB_COUNT; id++) {
        const ycb_object *o = ycb_find(id);

        if (!strcmp(name, o->name) || !strcmp(name, o->name + ID)) {
            *out = o;
            return LT_OK;
        }
    }
    return unknown_object(text);
}
