/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A skin that is described by a signed distance, made into a mesh of just so many vertices. The embedded hand and the
 * embedded body are built so:
 *
 *   surface_nets       its zero set as a dense mesh, open at one or two planes
 *   surface_open       a hole in it
 *   surface_decimate   edge collapses down to a number of vertices, and of edges around each opening
 *   surface_relax      edge flips and sliding on the skin until triangles are good
 *   surface_regress    joints as weighted means of the skin around them
 *   surface_bend       how the skin gives way at a joint that bends
 *
 * Lengths are millimetres. Functions that make things return LT_ENOMEM, and LT_ENUMERIC where the skin does not allow
 * what is asked for.
 */
#ifndef ASSETS_SURFACE_SURFACE_H
#define ASSETS_SURFACE_SURFACE_H

#include "assets/surface/vec3.h"
#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

enum { SURFACE_LOOPS = 4 };         /* openings are numbered from 1 */

/* A skin. Each function is told ctx. */
typedef struct {
    const char *name;               /* for errors */
    const void *ctx;
    double (*distance)(const void *ctx, vec3 p);        /* negative inside; exact near the skin */
    vec3 (*normal)(const void *ctx, vec3 p);
    vec3 (*snap)(const void *ctx, vec3 p, int loop);    /* the point of the skin, or of an opening's rim, near p */
    double (*spacing)(const void *ctx, vec3 p);         /* how long edges should be at p */
} surface_skin;

typedef struct {
    int n_vertices, n_faces;
    vec3 *vertex;
    int32_t (*face)[3];             /* counter-clockwise from outside */
    uint8_t *loop;                  /* of each vertex: the opening on whose rim it is, 0: none */
} surface_mesh;

/* Points origin + cell (i, j, k). The mesh ends at x = cut[1], and begins at x = cut[0] where low is set; both are
 * planes of the grid, and openings loop[0] and loop[1]. */
typedef struct {
    vec3 origin;
    double cell;
    int n[3];
    bool low;
    double cut[2];
    int loop[2];
} surface_grid;

lt_status surface_nets(lt_arena *arena, const surface_skin *skin, const surface_grid *grid, surface_mesh *out);

/* surface_open - take away all vertices for which inside(ctx, p), and call the rim `loop` */
lt_status surface_open(lt_arena *arena, const surface_skin *skin, bool (*inside)(const void *ctx, vec3 p), int loop,
                       surface_mesh *m);

/* surface_compact - close the gaps that vertices with to[v] < 0 and their faces leave; to becomes the new numbers */
void surface_compact(surface_mesh *m, int32_t *to);

/* surface_decimate - rim[i]: edges around opening 1 + i, 0 for those that there are not */
lt_status surface_decimate(lt_arena *arena, const surface_skin *skin, int n_vertices, const int rim[SURFACE_LOOPS],
                           surface_mesh *m);

/* surface_relax - held: bit i is set where the rim of opening i stays as it is */
lt_status surface_relax(lt_arena *arena, const surface_skin *skin, int rounds, unsigned held, surface_mesh *m);

/* A joint that bends. */
typedef struct {
    int joint;
    vec3 axis;                      /* unit */
    vec3 puff;                      /* added where it is bent by 90 degrees */
    double gain;                    /* how much of what skinning loses is put back */
} surface_hinge;

/* surface_bend - dirs (3, features) of the vertex that is at `from_joint` from the joint and turns with it by `share`,
 * in metres per entry of R - I */
void surface_bend(const surface_hinge *h, vec3 from_joint, double share, float *dirs, int features);

enum { SURFACE_RING = 44 };

/* Vertices from which a joint is regressed. */
typedef struct {
    int n;
    int32_t id[SURFACE_RING];
    double bump[SURFACE_RING], w[SURFACE_RING];
} surface_ring;

/* surface_ring_near - the vertices nearest to p, of those whose cost (or distance, where it is NULL) is least */
void surface_ring_near(const vec3 *vertex, const double *cost, int n_vertices, vec3 p, surface_ring *r);

/**
 * surface_regress - r->w, of which none is negative: nearest to r->bump, with sum 1, so that the ring's mean is the
 * joint, and moves as the joint does
 *
 *   vertex         all of them
 *   motion         (n) of all vertices, in each of the directions in which shapes differ
 *   joint_motion   (n) of the joint
 *   directions     n, at most 10
 *   follow         how much the latter counts, per square millimetre
 */
void surface_regress(const vec3 *vertex, const vec3 *const *motion, vec3 joint, const vec3 *joint_motion,
                     int directions, double follow, surface_ring *r);

#endif
