/* SPDX-License-Identifier: Apache-2.0 */
/* What the graph is held against.                                                                  [Eq. 18 to 24] */
#include "models/hogs/hogs.h"

#include "libtensor/ops/splat/gaussians.h"

#include <string.h>

enum { COLOURS = 3 * HOGS_IMAGES };             /* of the frame's channels; the masks follow */

static const double W_MASK = 0.1, W_LPIPS = 0.01, W_CONTACT = 20, W_PENETRATION = 10, W_ISO_PLACE = 1,
                    W_ISO_COVARIANCE = 100, W_SKIN = 0.1, W_SKIN_FIRST = 10;

double hogs_skin_weight(hogs_stage stage)
{
    return stage == HOGS_SKIN || stage == HOGS_WARM ? W_SKIN_FIRST : W_SKIN;
}

/* The loss under its name, as it is; its share goes into the sum. */
static void add(model_record *r, const char *name, lt_tensor *loss, double weight)
{
    lt_tensor *share = lt_scale(loss, weight);

    model_port_add(&r->losses, name, lt_output(loss, name));
    r->loss = r->loss ? lt_add(r->loss, share) : share;
}

/* ---- the skinning field ---------------------------------------------------------------------------------- */

void hogs_skin_loss(const hogs *m, double weight, lt_tensor *hand_set, model_record *r)
{
    lt_tensor *points = model_input(r, "skin_points", LT_SHAPE(HOGS_SKIN_POINTS, 3));
    lt_tensor *target = model_input(r, "skin_weights", LT_SHAPE(HOGS_SKIN_POINTS, SKIN_FIELD_BONES));
    const hogs_box box = hogs_set_box(m, hand_set, false);
    lt_tensor *found = skin_field_forward(&m->skin, hogs_in_box(&box, points), hand_set);

    add(r, "skin", skin_field_loss(found, target), weight);
}

/* ---- images ---------------------------------------------------------------------------------------------- */

/* The sum of three means is three times the mean of all. */
static void add_images(const hogs *m, const hogs_drawn *d, model_record *r)
{
    const int64_t H = m->config.height, W = m->config.width;
    lt_tensor *target = model_input(r, "target", LT_SHAPE(HOGS_TARGETS, H, W));
    lt_tensor *boxes = model_input(r, "lpips_boxes", LT_SHAPE(HOGS_IMAGES, 4));
    lt_tensor *colours = lt_slice(d->images, 0, 0, COLOURS), *truth = lt_slice(target, 0, 0, COLOURS);
    const lt_shape three = LT_SHAPE(HOGS_IMAGES, 3, H, W);

    add(r, "rgb", lt_scale(lt_l1_loss(colours, truth, NULL), HOGS_IMAGES), 1);
    add(r, "mask", lt_scale(lt_l1_loss(lt_slice(d->images, 0, COLOURS, HOGS_IMAGES),
                                       lt_slice(target, 0, COLOURS, HOGS_IMAGES), NULL), HOGS_IMAGES), W_MASK);
    add(r, "lpips", lt_sum(lpips_distance(&m->lpips, LPIPS_SYM, lt_reshape(colours, three), lt_reshape(truth, three),
                                          boxes)), W_LPIPS);
}

/* ---- as isometric as possible, and as little changed ----------------------------------------------------- */

/* Distances between neighbours as they are stored, and as they are drawn */
static void add_isometry(const hogs_drawn_set *s, lt_tensor *near, const char *place, const char *covariance,
                         model_record *r)
{
    const gaussian_rows *g = &s->rows;
    lt_tensor *still = lt_splat_covariance(lt_splat_axes(g->log_scale, g->quaternion, hogs_identity(r->g)));

    add(r, place, lt_isometry_loss(g->centre, s->posed, near), W_ISO_PLACE);
    add(r, covariance, lt_isometry_loss(still, lt_splat_covariance(s->axes), near), W_ISO_COVARIANCE);
}

static void add_penalties(const hogs *m, const hogs_drawn_set *s, model_record *r)
{
    static const double of[][3] = {
        [HOGS_NR_DEXYCB] = { 0.1, 1e-3, 1e-3 }, [HOGS_NR_HO3D] = { 1e-3, 1e-4, 1e-4 },
    };
    const double *w = of[m->config.lambda_nr];
    vpm_penalties p;
    lt_tensor *sum;

    if (m->config.lambda_nr == HOGS_NR_NONE || !m->is->geometry)
        return;
    p = vpm_penalties_of(&s->deltas, lt_reshape(s->alive, LT_SHAPE(lt_dim(s->alive, 0))));
    sum = lt_add(lt_add(lt_scale(p.place, w[0]), lt_scale(p.scale, w[1])), lt_scale(p.rotation, w[2]));
    add(r, s->object ? "nr_object" : "nr_hand", sum, 1);
}

void hogs_scene_losses(const hogs *m, hogs_stage stage, const hogs_drawn *d, model_record *r)
{
    const lt_shape near = LT_SHAPE(gaussians_capacity(&m->gaussians), HOGS_NEIGHBOURS);

    add_images(m, d, r);
    hogs_skin_loss(m, hogs_skin_weight(stage), d->hand.set, r);
    add_isometry(&d->hand, hogs_integers(r, "hand_near", near), "iso_hand", "iso_cov_hand", r);
    add_isometry(&d->object, hogs_integers(r, "object_near", near), "iso_object", "iso_cov_object", r);
    add_penalties(m, &d->hand, r);
    add_penalties(m, &d->object, r);
}

/* ---- poses ----------------------------------------------------------------------------------------------- */

static void add_contact(const hogs_pose *refined, model_record *r)
{
    const int64_t B = r->batch;
    lt_tensor *inside = lt_input(r->g, "inside", LT_U8, 2, (int64_t[]){ B, OCCUPANCY_CELLS });
    const contact_in in = {
        .hand = model_input(r, "hand_points", LT_SHAPE(B, HOGS_CONTACT_POINTS, 3)),
        .zone = hogs_integers(r, "zones", LT_SHAPE(B, HOGS_CONTACT_POINTS)),
        .surface = model_input(r, "surface", LT_SHAPE(B, HOGS_SURFACE_POINTS, 3)),
        .inside = inside, .box = model_input(r, "grid", LT_SHAPE(B, 6)), .pose = *refined,
    };
    contact_losses found;

    model_port_add(&r->inputs, "inside", inside);
    found = contact_losses_of(&in);
    add(r, "contact", found.contact, W_CONTACT);
    add(r, "penetration", found.penetration, W_PENETRATION);
}

void hogs_pose_losses(const hogs *m, const gpm_out *offsets, const hogs_pose *initial, const hogs_pose *refined,
                      model_record *r)
{
    const int64_t B = r->batch;
    const gpm_truth truth = {
        .initial = *initial,
        .truth = { model_input(r, "true_rotation", LT_SHAPE(B, 3, 3)),
                   model_input(r, "true_translation", LT_SHAPE(B, 3)) },
        .translation = model_input(r, "offset", LT_SHAPE(B, 3)),
        .corners = model_input(r, "corners", LT_SHAPE(B, HOGS_CORNERS, 3)),
        .weight = model_input(r, "pose_weight", LT_SHAPE(B)),
    };

    add(r, "pose", gpm_pose_losses(offsets, &truth).pose, 1);
    if (m->is->contact)
        add_contact(refined, r);
}
