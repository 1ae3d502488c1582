/* SPDX-License-Identifier: Apache-2.0 */
/* A depth image beside a photograph: which way it lies, its unit, and whether it speaks of the hand that was seen. */
#include "pipeline/internal.h"

#include "libtensor/io/image/image.h"
#include "vision/picture.h"

#include <math.h>

static const double MILLIMETRE = 1e-3;

/* What cameras store: 16 bits of these, in metres (L515: a quarter of a millimetre; YCB-Video: a tenth) */
static const double units[] = { 1e-4, 1.25e-4, 2.5e-4, 5e-4, 1e-3, 1e-2, 1 };

/* Whether the depth image lies as the picture is stored, which it is turned with; else it is upright already. */
static lt_status lies_as_stored(lt_arena *arena, const char *path, const predict_view *v, bool *out)
{
    lt_image img;
    lt_status st;

    *out = true;
    if (v->orientation < 5 || v->width == v->height)
        return LT_OK;
    st = lt_image_read(arena, path, &img);
    if (st)
        return st;
    *out = img.width == v->height && img.height == v->width;
    if (*out || (img.width == v->width && img.height == v->height))
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: image of %d x %d, expected %d x %d as the picture is stored, or %d x %d as it is "
                    "upright", path, img.width, img.height, v->height, v->width, v->width, v->height);
}

lt_status predict_read_depth(lt_arena *arena, const predict_options *o, const char *path, predict_view *v,
                             predict_notes *notes)
{
    const size_t n = (size_t)v->width * (size_t)v->height;
    float *stored, *depth;
    bool turned;
    lt_status st = lies_as_stored(arena, path, v, &turned);
    const int orientation = turned ? v->orientation : 1;
    const int width = orientation < 5 ? v->width : v->height, height = orientation < 5 ? v->height : v->width;

    st = st ? st : picture_read_depth(arena, path, width, height, &stored);
    st = st ? st : lt_arena_try(arena, n * sizeof(*depth), (void **)&depth);
    if (st)
        return st;
    lt_exif_upright(orientation, width, height, sizeof(*depth), stored, depth);
    for (size_t i = 0; i < n && o->depth_scale > 0; i++)
        depth[i] = (float)(depth[i] * o->depth_scale / MILLIMETRE);
    if (orientation != 1)
        predict_note_add(notes, NULL, NOTE_DEPTH_TURNED, "its depth is turned with it, from %d x %d: it is taken to "
                         "lie as the picture is stored", width, height);
    v->depth = depth;
    v->depth_path = path;
    v->depth_scale = o->depth_scale > 0 ? o->depth_scale : MILLIMETRE;
    return LT_OK;
}

/* The unit that comes nearest */
static double nearest_unit(double scale)
{
    double best = units[0];

    for (size_t i = 1; i < LT_COUNT(units); i++)
        if (fabs(log(scale / units[i])) < fabs(log(scale / best)))
            best = units[i];
    return best;
}

typedef struct { double nearest, likely, farthest; } range;

/* How far away a hand can be that fills its box, from a fist to one with its fingers spread; where nobody gave a box,
 * one as large as was seen, if 2D and 3D agree on that. farthest is 0 where nothing tells. */
static range distance_of(const predict_view *v, const predict_result *r)
{
    const double width = (double)(v->hand_box.x1 - v->hand_box.x0), height = (double)(v->hand_box.y1 - v->hand_box.y0);
    const double per_metre = v->camera.fx / fmax(width, height), z = r->solved_m;

    if (v->hand_from != PREDICT_DEFAULT)
        return (range){ 0.06 * per_metre, 0.15 * per_metre, 0.3 * per_metre };
    return predict_trusted(v, r) ? (range){ 0.7 * z, z, 1.4 * z } : (range){ 0 };
}

void predict_note_depth(const predict_view *v, const predict_result *r, predict_notes *notes)
{
    const range of = distance_of(v, r);
    const double unit = nearest_unit(v->depth_scale * of.likely / r->measured_m);

    if (isnan(r->measured_m) || of.farthest == 0 || (r->measured_m > of.nearest && r->measured_m < of.farthest))
        return;
    if (unit == v->depth_scale)
        predict_note_add(notes, v, NOTE_DEPTH_DOUBTFUL, "its depth says that the hand is %.2g m away, the hand's size "
                         "%.2g to %.2g m: is it this picture's?", r->measured_m, of.nearest, of.farthest);
    else
        predict_note_add(notes, v, NOTE_DEPTH_DOUBTFUL, "its depth says that the hand is %.2g m away, the hand's size "
                         "%.2g to %.2g m: in another unit? --depth-scale %g would come nearest", r->measured_m,
                         of.nearest, of.farthest, unit);
}
