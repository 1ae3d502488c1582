/* SPDX-License-Identifier: Apache-2.0 */
#include "data/transforms/internal.h"

#include <math.h>
#include <string.h>

/* Of the frame, else of the file, else 0; false: no finite number */
static bool number(const cJSON *file, const cJSON *frame, const char *key, double *out)
{
    const cJSON *x = cJSON_GetObjectItemCaseSensitive(frame, key);

    x = x ? x : cJSON_GetObjectItemCaseSensitive(file, key);
    *out = x ? x->valuedouble : 0;
    return !x || (cJSON_IsNumber(x) && isfinite(*out));
}

static lt_status check_model(const char *where, const cJSON *file)
{
    static const char *const models[] = { "OPENCV", "PINHOLE", "SIMPLE_PINHOLE" };
    const cJSON *m = cJSON_GetObjectItemCaseSensitive(file, "camera_model");

    if (!m)
        return LT_OK;
    for (size_t i = 0; i < LT_COUNT(models); i++)
        if (cJSON_IsString(m) && strcmp(m->valuestring, models[i]) == 0)
            return LT_OK;
    return lt_error(LT_EFORMAT, "%s: camera_model \"%s\", want OPENCV, PINHOLE or SIMPLE_PINHOLE: undistort the photos "
                    "first (colmap image_undistorter)", where, cJSON_IsString(m) ? m->valuestring : "?");
}

lt_status transforms_lens_read(const char *where, const cJSON *file, const cJSON *frame, transforms_lens *out)
{
    transforms_lens l = { .fl_x = 0 };
    const struct { const char *key; double *to; bool positive; } keys[] = {
        { "fl_x", &l.fl_x, true }, { "fl_y", &l.fl_y, true }, { "cx", &l.cx, false }, { "cy", &l.cy, false },
        { "w", &l.w, true }, { "h", &l.h, true }, { "camera_angle_x", &l.angle_x, true },
        { "camera_angle_y", &l.angle_y, true }, { "k1", &l.lens.k[0], false }, { "k2", &l.lens.k[1], false },
        { "k3", &l.lens.k[2], false }, { "p1", &l.lens.p[0], false }, { "p2", &l.lens.p[1], false },
    };
    const lt_status st = check_model(where, file);

    for (size_t i = 0; i < LT_COUNT(keys) && !st; i++)
        if (!number(file, frame, keys[i].key, keys[i].to) || (keys[i].positive && *keys[i].to < 0))
            return lt_error(LT_EFORMAT, "%s: %s is no %snumber", where, keys[i].key,
                            keys[i].positive ? "positive " : "");
    if (!st && !(l.fl_x > 0) && !(l.angle_x > 0 && l.angle_x < M_PI))
        return lt_error(LT_EFORMAT, "%s: neither fl_x nor camera_angle_x: no focal length", where);
    *out = l;
    return st;
}

static double focal(double angle, double pixels)
{
    return 0.5 * pixels / tan(0.5 * angle);
}

lt_status transforms_camera(const transforms_view *v, int width, int height, lt_camera *out)
{
    const transforms_lens *l = &v->lens;
    const double w = l->w > 0 ? l->w : width, h = l->h > 0 ? l->h : height, scale = width / w;
    const double fx = l->fl_x > 0 ? l->fl_x : focal(l->angle_x, w);
    const double fy = l->fl_y > 0 ? l->fl_y : l->angle_y > 0 && !(l->fl_x > 0) ? focal(l->angle_y, h) : fx;

    if (fabs(scale * h - height) > 1)       /* rows, as sizes of scaled pictures are rounded */
        return lt_error(LT_EFORMAT, "%s: is %d x %d, the cameras' file says %g x %g: another shape", v->image, width,
                        height, w, h);
    *out = (lt_camera){ scale * fx, scale * fy, scale * (l->cx > 0 ? l->cx : 0.5 * w) - 0.5,
                        scale * (l->cy > 0 ? l->cy : 0.5 * h) - 0.5 };
    return LT_OK;
}
