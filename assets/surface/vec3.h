/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Points and directions in double precision, for building skins.
 */
#ifndef ASSETS_SURFACE_VEC3_H
#define ASSETS_SURFACE_VEC3_H

#include <math.h>

typedef struct { double x, y, z; } vec3;

static inline vec3 vec(double x, double y, double z) { return (vec3){ x, y, z }; }
static inline vec3 add(vec3 a, vec3 b) { return vec(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline vec3 sub(vec3 a, vec3 b) { return vec(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline vec3 scale(vec3 a, double s) { return vec(a.x * s, a.y * s, a.z * s); }
static inline vec3 madd(vec3 a, vec3 b, double s) { return add(a, scale(b, s)); }
static inline double dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double norm(vec3 a) { return sqrt(dot(a, a)); }
static inline double dist(vec3 a, vec3 b) { return norm(sub(a, b)); }
static inline vec3 mix(vec3 a, vec3 b, double t) { return madd(a, sub(b, a), t); }

static inline vec3 cross(vec3 a, vec3 b)
{
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline vec3 unit(vec3 a)
{
    const double n = norm(a);
    return n > 0 ? scale(a, 1 / n) : a;
}

/* The part of a at right angles to the unit vector n. */
static inline vec3 reject(vec3 a, vec3 n) { return madd(a, n, -dot(a, n)); }

/* a turned by angle about the unit axis n (Rodrigues). */
static inline vec3 turn(vec3 a, vec3 n, double angle)
{
    const double c = cos(angle), s = sin(angle);
    return add(add(scale(a, c), scale(cross(n, a), s)), scale(n, dot(n, a) * (1 - c)));
}

static inline double clamp(double x, double lo, double hi) { return x < lo ? lo : x > hi ? hi : x; }

static inline double smoothstep(double lo, double hi, double x)
{
    const double t = clamp((x - lo) / (hi - lo), 0, 1);
    return t * t * (3 - 2 * t);
}

/* Where on the segment a-b, from 0 to 1, the point nearest to p lies. */
static inline double along(vec3 p, vec3 a, vec3 b)
{
    const vec3 ab = sub(b, a);
    return clamp(dot(sub(p, a), ab) / dot(ab, ab), 0, 1);
}

static inline double segment_distance(vec3 p, vec3 a, vec3 b)
{
    return dist(p, mix(a, b, along(p, a, b)));
}

#endif
