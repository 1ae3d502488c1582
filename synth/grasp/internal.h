/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The stages of sampling a grasp, in order. Private to this folder.
 *
 *   grip       where an object can be taken, and from which sides
 *   hand       the hand as 21 joint angles and a wrist pose: skin, pads, spheres along the bones
 *   place      a candidate: the wrist before a grip, the fingers closed on it
 *   refine     the candidate moved until pads touch and nothing penetrates
 *   accept     whether it would hold
 *
 * Object frame, metres, radians. Fingers in joint order: index, middle, little, ring, thumb.
 */
#ifndef SYNTH_GRASP_INTERNAL_H
#define SYNTH_GRASP_INTERNAL_H

#include "libtensor/base/rng.h"
#include "synth/grasp/grasp.h"
#include "synth/grasp/sdf.h"

enum { FINGERS = 5, THUMB = 4, ANGLES = 21, SPHERES = 57, MAX_GRIPS = 6, MAX_WEIGHTS = 6 };

/* ---- grips ---------------------------------------------------------------------------------------- */

/* A box to close the hand on: half sizes along its axes (rows, unit), and from where it can be reached. */
typedef struct {
    const char *kind;
    double centre[3], axis[3][3], half[3];
    unsigned approach, thumb;       /* bits 0..5: the palm, the thumb's side may face +x -x +y -y +z -z of
                                     * the box */
    double pivot[3], turn;          /* may be turned about the line along z through pivot, radians either way */
    double chance;
} grip;

/* grasp_grips - the n grips of an object, in its frame */
lt_status grasp_grips(lt_arena *scratch, int id, grip out[MAX_GRIPS], int *n);

/* ---- the hand ------------------------------------------------------------------------------------- */

/* One angle: about which axis (at rest) which joint turns, and how far. A joint's angles follow each other
 * in the order in which their rotations multiply. */
typedef struct { int joint; double axis[3], lo, hi; } hand_angle;

typedef struct { int joint; double at[3], radius; } hand_sphere;    /* at: at rest, on the bone's line */

typedef struct {
    double q[ANGLES];
    double R[9], t[3];              /* of the wrist: x_obj = R * (x_rest - J0) + t */
} hand_state;

typedef struct {
    const lt_hand_model *model;
    double J[LT_HAND_JOINTS][3];                        /* joints at rest */
    double beta[LT_HAND_BETAS];
    double rest[LT_HAND_VERTICES][3];                   /* the shaped skin */
    double area[LT_HAND_VERTICES];                      /* a third of the faces around */
    uint8_t n_weights[LT_HAND_VERTICES];
    uint8_t weight_joint[LT_HAND_VERTICES][MAX_WEIGHTS];
    double weight[LT_HAND_VERTICES][MAX_WEIGHTS];
    int8_t pad[LT_HAND_VERTICES];                       /* 3 * finger + phalanx, 15: palm, -1: not a pad */
    uint8_t part[LT_HAND_VERTICES];                     /* of synth_hand_parts */
    int8_t finger[LT_HAND_VERTICES];                    /* whose skin it is; -1: the palm's */
    hand_angle angle[ANGLES];
    hand_sphere sphere[SPHERES];
} grasp_hand;

/* First of a finger's angles: spread, three flexions; the thumb has twist before its spread. */
static inline int finger_angle(int finger) { return 4 * finger; }

/* The hand posed: frames of the joints, and for each angle the axis about which it now turns. */
typedef struct {
    double R[LT_HAND_JOINTS][9], t[LT_HAND_JOINTS][3];
    double axis[ANGLES][3];
} hand_frames;

/* grasp_axis_turn - the rotation by angle about a unit axis. The bits are part of a seed's grasps: those of
 * lt_rot_from_axis_angle are others. */
void grasp_axis_turn(const double a[3], double angle, double R[9]);

void grasp_hand_init(grasp_hand *h, const lt_hand_model *model, const double *beta);
void grasp_hand_frames(const grasp_hand *h, const hand_state *s, hand_frames *f);

/* grasp_hand_correct - rest plus the pose correctives of s: what skinning then poses */
void grasp_hand_correct(const grasp_hand *h, const hand_state *s, double (*rest)[3]);

/* grasp_hand_skin - skin vertex v of rest */
void grasp_hand_skin(const grasp_hand *h, const hand_frames *f, const double (*rest)[3], int v, double out[3]);

void grasp_hand_sphere(const grasp_hand *h, const hand_frames *f, int i, double out[3]);

/* grasp_hand_pose - axis-angle and translation as lt_hand_pose takes them */
void grasp_hand_pose(const grasp_hand *h, const hand_state *s, double pose[48], double trans[3]);

/* ---- stages --------------------------------------------------------------------------------------- */

struct synth_grasp_ctx {
    int object_id;
    synth_sdf sdf;
    double lowest, centre[3], radius;       /* of the object */
    grasp_hand hand;
    grip grips[MAX_GRIPS];
    int n_grips;
};

/* How much the refinement wants from each pad; palm last. */
typedef struct { double pad[16]; } grasp_wish;

/* grasp_place - a candidate and its wishes; false when the grip does not fit into the hand */
bool grasp_place(const synth_grasp_ctx *ctx, lt_rng *rng, hand_state *s, grasp_wish *wish, const char **kind);

void grasp_refine(const synth_grasp_ctx *ctx, const grasp_wish *wish, hand_state *s);

typedef enum { HOLDS, NO_CONTACT, TOO_DEEP, NO_BALANCE, CROSSED } grasp_verdict;

/* grasp_judge - fills out but for kind */
grasp_verdict grasp_judge(const synth_grasp_ctx *ctx, const hand_state *s, synth_grasp *out);

#endif
