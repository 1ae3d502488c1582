/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a right hand holds an object: grasps sampled from templates, closed finger by finger on the object's
 * distance field, refined, and kept only if they would hold.
 */
#ifndef SYNTH_GRASP_GRASP_H
#define SYNTH_GRASP_GRASP_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mesh/mesh.h"
#include "synth/grasp/sdf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One object, one hand shape. Read-only once made: any number of threads may sample from it. */
typedef struct synth_grasp_ctx synth_grasp_ctx;

/* All in the object's frame, metres and radians; fingers in the order thumb, index, middle, ring, little. */
typedef struct {
    const char *kind;               /* "wrap", "pinch", ...: the template's name */
    double pose[48];                /* axis-angle of the 16 joints, MANO order; the first turns the wrist */
    double trans[3];                /* as lt_hand_pose takes it: vertices come out in the object's frame */
    bool contact[5];                /* the finger has a vertex within 4 mm of the object */
    double penetration;             /* of the deepest vertex */
    double mean_penetration;        /* of the vertices that penetrate; 0 when none does */
    double volume;                  /* shared by hand and object, cubic metres */
    double lowest;                  /* of the hand, above the object's lowest point; below 0 it cannot be
                                     * taken up from a table this way */
} synth_grasp;

/* Why candidates were turned down, and how many were not. */
typedef struct {
    int64_t tried, accepted;
    int64_t no_contact;             /* fewer than three fingers, or no thumb */
    int64_t too_deep;
    int64_t no_balance;             /* no forces inside the friction cones hold the object still */
    int64_t crossed;                /* a finger through another */
} synth_grasp_stats;

/**
 * synth_grasp_ctx_new - prepare to grasp an object
 *
 *   object   synth_object_new's mesh, in its model frame; not kept
 *   sdf      the distance to it, whose values outlive the context; NULL: sampled here
 *   hand     a right hand; outlives the context
 *   beta     (10) the hand's shape; NULL: zeros
 *   out      lives in the arena
 *
 * Errors: LT_EINVAL for an unknown id, a left hand, or a mesh that synth_sdf_new refuses; LT_ENOMEM.
 */
lt_status synth_grasp_ctx_new(lt_arena *arena, int id, const lt_mesh *object, const synth_sdf *sdf,
                              const lt_hand_model *hand, const double *beta, synth_grasp_ctx **out);

/* synth_grasp_ctx_mirror - the context's object becomes its mirror image, x -> -x, of which mesh and distance
 * were given to synth_grasp_ctx_new: right hands then hold it as left hands hold the object */
void synth_grasp_ctx_mirror(synth_grasp_ctx *ctx);

/**
 * synth_grasp_sample - one accepted grasp
 *
 * A function of (ctx, seed) alone. Tries up to 64 candidates; stats, when not NULL, is added to.
 *
 * Errors: LT_ENUMERIC when every candidate is turned down; the line says how many for which reason.
 */
lt_status synth_grasp_sample(const synth_grasp_ctx *ctx, uint64_t seed, synth_grasp_stats *stats,
                             synth_grasp *out);

/* synth_grasp_clear - loosen g until no vertex of the hand is nearer to the object than margin, metres; false where
 * that takes too long. What g says of contact is what it was. */
bool synth_grasp_clear(const synth_grasp_ctx *ctx, double margin, synth_grasp *g);

#ifdef __cplusplus
}
#endif
#endif
