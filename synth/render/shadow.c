/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "synth/render/shadow.h"
#include "synth/render/small.h"

#include <string.h>

enum { SEARCH_TAPS = 8, FILTER_TAPS = 12, TURNS = 64 };

static const float MAX_TEXELS = 28;             /* below two blocks: coarse covers every tap */

/* Points of a disc, evenly spread in area for every prefix (a golden-angle spiral, shuffled). */
static const float disc[FILTER_TAPS][2] = {
    { 0.2041f, 0.0000f }, { -0.2607f, 0.2388f }, { 0.0399f, -0.4547f }, { 0.3286f, 0.4286f },
    { -0.6030f, -0.1067f }, { 0.5714f, -0.3636f }, { -0.1912f, 0.7109f }, { -0.3637f, -0.7018f },
    { 0.7879f, 0.2882f }, { -0.8232f, 0.3399f }, { 0.3959f, -0.8477f }, { 0.2881f, 0.9357f },
};

static float turns[TURNS][2];                   /* cosine and sine */

__attribute__((constructor)) static void make_turns(void)
{
    for (int i = 0; i < TURNS; i++) {
        turns[i][0] = (float)cos(2 * M_PI * i / TURNS);
        turns[i][1] = (float)sin(2 * M_PI * i / TURNS);
    }
}

bool shadow_init(shadow_map *map)
{
    map->inv_z = lt_alloc(sizeof(*map->inv_z) * SHADOW_SIDE);
    map->coarse = lt_alloc(sizeof(*map->coarse) * SHADOW_BLOCKS);
    return map->inv_z && map->coarse;
}

void shadow_fini(shadow_map *map)
{
    lt_release(map->inv_z);
    lt_release(map->coarse);
}

/* The lamp looks at the focus; its picture just holds the sphere in which shadows are cast. */
static void aim(shadow_map *map, const synth_scene *scene, const synth_light *light)
{
    raster_view *v = &map->view;
    double *x = v->R, *y = v->R + 3, *z = v->R + 6, distance, tangent;

    lt_vec3_sub(scene->focus, light->position, z);
    distance = lt_vec3_unit(z);
    z[2] = distance > 0 ? z[2] : 1;
    distance = fmax(distance, 1.2 * scene->focus_radius);
    x[0] = fabs(z[0]) < 0.9;
    x[1] = 1 - x[0];
    x[2] = 0;
    lt_vec3_cross(z, x, y);
    lt_vec3_unit(y);
    lt_vec3_cross(y, z, x);
    tangent = scene->focus_radius / sqrt(pow(distance, 2) - pow(scene->focus_radius, 2));
    v->fx = v->fy = SHADOW_SIDE / 2 / tangent;
    v->cx = v->cy = (SHADOW_SIDE - 1) / 2.0;
    v->width = v->height = SHADOW_SIDE;
    lt_mat3_mulvec(v->R, light->position, v->t);
    for (int i = 0; i < 3; i++) {
        v->t[i] = -v->t[i];
        map->R[i] = (v4){ (float)v->R[i], (float)v->R[3 + i], (float)v->R[6 + i], 0 };
        map->t[i] = (float)v->t[i];
    }
    map->focal = (float)v->fx;
    map->lamp_radius = (float)light->radius;
    map->texel = (float)(distance / v->fx);
}

typedef struct {
    shadow_map *map;
    const raster_list *list;
} draw_job;

static void draw_tile(void *ctx, int64_t tile)
{
    const draw_job *job = ctx;
    const raster_list *l = job->list;
    const int tx = (int)tile % l->tiles_x, ty = (int)tile / l->tiles_x;
    float inv_z[TILE * TILE];

    memset(inv_z, 0, sizeof(inv_z));
    for (uint32_t i = l->tile_start[tile]; i < l->tile_start[tile + 1]; i++)
        raster_draw(&l->triangle[l->tile_item[i]], tx, ty, 0, inv_z, NULL);
    for (int y = 0; y < TILE; y++)
        memcpy(&job->map->inv_z[ty * TILE + y][tx * TILE], inv_z + y * TILE, TILE * sizeof(*inv_z));
}

static float block_max(const shadow_map *map, int bx, int by)
{
    float best = 0;

    for (int y = 0; y < SHADOW_BLOCK; y++)
        for (int x = 0; x < SHADOW_BLOCK; x++) {
            const float z = map->inv_z[by * SHADOW_BLOCK + y][bx * SHADOW_BLOCK + x];

            best = z > best ? z : best;
        }
    return best;
}

static void make_coarse(shadow_map *map)
{
    float block[SHADOW_BLOCKS][SHADOW_BLOCKS];

    for (int y = 0; y < SHADOW_BLOCKS; y++)
        for (int x = 0; x < SHADOW_BLOCKS; x++)
            block[y][x] = block_max(map, x, y);
    for (int y = 0; y < SHADOW_BLOCKS; y++)
        for (int x = 0; x < SHADOW_BLOCKS; x++) {
            float best = 0;

            for (int v = y > 2 ? y - 2 : 0; v <= y + 2 && v < SHADOW_BLOCKS; v++)
                for (int u = x > 2 ? x - 2 : 0; u <= x + 2 && u < SHADOW_BLOCKS; u++)
                    best = block[v][u] > best ? block[v][u] : best;
            map->coarse[y][x] = best;
        }
}

lt_status shadow_draw(shadow_map *map, raster_list *list, const synth_scene *scene,
                      const synth_light *light)
{
    draw_job job = { map, list };
    lt_status st;

    aim(map, scene, light);
    st = raster_collect(list, scene, &map->view, true);
    if (st)
        return st;
    lt_parallel_for((int64_t)list->tiles_x * list->tiles_y, draw_tile, &job);
    make_coarse(map);
    return LT_OK;
}

/* 1/z of the nearest caster at a texel; 0, so no caster, outside the map */
static float caster(const shadow_map *map, float x, float y)
{
    const int ix = (int)(x + 0.5f), iy = (int)(y + 0.5f);

    if ((unsigned)ix >= SHADOW_SIDE || (unsigned)iy >= SHADOW_SIDE)
        return 0;
    return map->inv_z[iy][ix];
}

typedef struct { float x, y, inv_z, cos, sin; } receiver;

/* Mean 1/z of what stands between the lamp and r within radius texels, and on how many of SEARCH_TAPS; 0
 * when nothing does. */
static float find_blockers(const shadow_map *map, const receiver *r, float radius, int *blocked)
{
    float sum = 0;
    int n = 0;

    for (int i = 0; i < SEARCH_TAPS; i++) {
        const float *d = disc[i + FILTER_TAPS - SEARCH_TAPS];
        const float c = caster(map, r->x + radius * (r->cos * d[0] - r->sin * d[1]),
                               r->y + radius * (r->sin * d[0] + r->cos * d[1]));

        if (c > r->inv_z) {
            sum += c;
            n++;
        }
    }
    *blocked = n;
    return n ? sum / (float)n : caster(map, r->x, r->y) > r->inv_z ? caster(map, r->x, r->y) : 0;
}

static float filter(const shadow_map *map, const receiver *r, float radius)
{
    int lit = 0;

    for (int i = 0; i < FILTER_TAPS; i++) {
        const float *d = disc[i];

        lit += caster(map, r->x + radius * (r->cos * d[0] - r->sin * d[1]),
                      r->y + radius * (r->sin * d[0] + r->cos * d[1])) <= r->inv_z;
    }
    return (float)lit / FILTER_TAPS;
}

float shadow_at(const shadow_map *map, v4 p, v4 n, float spin)
{
    const v4 q = p + v4_all(1.5f * map->texel + 4e-4f) * n;     /* off the surface, or it shades itself */
    const v4 v = map->t + map->R[0] * v4_all(q[0]) + map->R[1] * v4_all(q[1]) + map->R[2] * v4_all(q[2]);
    const float *turn = turns[(int)(spin * TURNS) % TURNS];
    float nearest, blocker, penumbra, reach;
    int blocked;
    receiver r;

    if (v[2] < 0.05f)
        return 1;
    r.inv_z = 1 / v[2];
    r.x = map->focal * v[0] * r.inv_z + (SHADOW_SIDE - 1) / 2.0f;
    r.y = map->focal * v[1] * r.inv_z + (SHADOW_SIDE - 1) / 2.0f;
    if (!(r.x >= 0 && r.y >= 0 && r.x < SHADOW_SIDE && r.y < SHADOW_SIDE))
        return 1;
    nearest = map->coarse[(int)r.y / SHADOW_BLOCK][(int)r.x / SHADOW_BLOCK];
    if (nearest <= r.inv_z)
        return 1;
    r.cos = turn[0];
    r.sin = turn[1];
    reach = map->lamp_radius * map->focal * (nearest - r.inv_z);
    blocker = find_blockers(map, &r, within(reach, 1.5f, MAX_TEXELS), &blocked);
    if (blocker == 0 || blocked == SEARCH_TAPS)         /* all, and more widely than the penumbra */
        return blocker == 0;
    penumbra = map->lamp_radius * map->focal * (blocker - r.inv_z);
    return filter(map, &r, within(penumbra, 1.2f, MAX_TEXELS));
}
