/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The software renderer of the synthetic data: a scene of meshes, lamps and one camera becomes a
 * photograph, its exact depth, its labels, and the masks of hand and object as if nothing hid them.
 *
 * Lengths are metres. The world may have any axes; the camera looks along its +z with x right and y
 * down. Pixel (u, v) has its centre at u, v: u = fx * x / z + cx. Colours are linear RGB unless sRGB
 * is said. The same scene gives the same bits on any number of threads.
 */
#ifndef SYNTH_RENDER_RENDER_H
#define SYNTH_RENDER_RENDER_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SYNTH_LABEL_BACKGROUND = 0,     /* also arm, sleeve, furniture, clutter */
    SYNTH_LABEL_HAND = 255,         /* 1 .. 254 are objects */
    SYNTH_MAX_LIGHTS = 4,
    SYNTH_MAX_SIDE = 4096,          /* of a frame */
};

/* ---- what is drawn --------------------------------------------------------------------------- */

/* An image made ready to be pasted on a mesh: its mip chain. Repeats outside 0..1. */
typedef struct synth_texture synth_texture;

/**
 * synth_texture_new - a texture from sRGB bytes
 *
 *   rgb      (height, width, 3)      copied; the first row is v = 1, as in OBJ files
 *   returns  lives in the arena; NULL when there is no memory or a size is below 1 or above 8192
 */
synth_texture *synth_texture_new(lt_arena *arena, const uint8_t *rgb, int width, int height);

/* Fills rgb (side, 3), row y of a texture, from a recipe. */
typedef void (*synth_paint_fn)(const void *recipe, int side, int y, uint8_t (*rgb)[3]);

/* synth_texture_later - side x side, painted by synth_texture_paint and not drawn with before; the recipe must
 * live as long as the arena */
synth_texture *synth_texture_later(lt_arena *arena, int side, synth_paint_fn paint, const void *recipe);

/* synth_texture_paint - make a texture ready to be drawn with, unless it is; false without memory */
bool synth_texture_paint(synth_texture *t);

/* How a surface answers light. Zeroed fields mean: black, matt, opaque, no texture. */
typedef struct {
    float albedo[3];                /* multiplies vertex colours and texture */
    float specular;                 /* reflectance seen head on: plastic 0.04, skin 0.028 */
    float shininess;                /* Blinn's exponent: skin 12, plastic 40, metal 150 */
    float metal;                    /* 0..1: how much of the reflection takes the albedo's colour */
    float translucency;             /* 0..1: light creeps around the edge, red farthest: skin 1 */
    float grain;                    /* 0..1: fine spots and furrows of skin */
    synth_texture *texture;         /* needs mesh->uv; NULL: none */
} synth_material;

/* A mesh in the world: x_world = R_world_obj * x_obj + t_world_obj. */
typedef struct {
    const lt_mesh *mesh;            /* borrowed; without normals it is drawn with flat faces */
    double R_world_obj[9], t_world_obj[3];
    /* (n_vertices, 3): where each vertex lies on the undeformed body, so that grain moves with the skin;
     * for a hand its template. NULL: where it lies in the mesh. */
    const float (*rest)[3];
    synth_material material;
    uint8_t label;
    bool moving;                    /* smeared by synth_sensor's motion */
    bool no_shadow;                 /* receives shadows but casts none: tables, walls */
} synth_instance;

/* A round lamp. The light that arrives falls with the square of the distance. */
typedef struct {
    double position[3];             /* world */
    double radius;                  /* of the lamp: how soft its shadows are */
    float color[3];                 /* on a white surface at scene->focus that faces the lamp */
} synth_light;

typedef struct {
    double fx, fy, cx, cy;          /* pixels */
    int width, height;
    double R_cam_world[9], t_cam_world[3];
} synth_camera;

typedef struct {
    const synth_instance *instance;
    int n_instances;
    const synth_light *light;
    int n_lights;                   /* at most SYNTH_MAX_LIGHTS */
    float sky[3], ground[3];        /* ambient light from above and from below */
    float up[3];                    /* world, unit length */
    double focus[3], focus_radius;  /* shadows are cast inside this sphere: hand, object, clutter */
    synth_camera camera;
    uint8_t target;                 /* label of the object that the amodal object mask shows */
} synth_scene;

/* ---- what comes out -------------------------------------------------------------------------- */

/* One picture's planes, each (height, width) row after row, and the renderer's working memory. */
typedef struct {
    int width, height;
    float (*radiance)[3];           /* linear RGB that reached the sensor */
    uint8_t (*rgb)[3];              /* sRGB after synth_sensor_image */
    float *depth;                   /* z of the visible surface at the pixel's centre; 0: nothing */
    uint8_t *label;                 /* of the surface that covers most of the pixel */
    uint8_t *moving;                /* 1 where that surface's instance moves */
    uint8_t *hand_mask;             /* amodal: 255 where the hand alone would be seen, else 0 */
    uint8_t *object_mask;           /* the same for the target object */
    float *hand_depth;              /* z of the hand alone; 0: nothing */
    float *object_depth;
    float (*work[2])[3];            /* between steps */
    struct synth_scratch *scratch;
} synth_frame;

/* synth_frame_new - a frame to render into, as often as you like; NULL when there is no memory or a
 * side is outside 1..SYNTH_MAX_SIDE. One frame serves one thread at a time. synth_frame_free(NULL) is fine. */
synth_frame *synth_frame_new(int width, int height);
void synth_frame_free(synth_frame *frame);

/**
 * synth_render - draw the scene: every plane of the frame but rgb
 *
 * Instances labelled SYNTH_LABEL_HAND make the hand, those labelled scene->target the object. Visible
 * pixels of either are always inside its amodal mask. Triangles with corners that are not finite or
 * without area are left out; those crossing the plane of the camera are cut. Both faces are drawn.
 *
 * Errors: LT_EINVAL when camera and frame differ in size, a focal length is not positive, a face
 * names a vertex that its mesh has not, or there are too many lights; LT_ENOMEM.
 */
lt_status synth_render(const synth_scene *scene, synth_frame *frame);

/* ---- the sensor ------------------------------------------------------------------------------ */

typedef struct {
    float exposure;                 /* multiplies the radiance: 1 shows 1.0 as white */
    float white[3];                 /* white balance gains */
    float gamma;                    /* exponent of contrast on top of sRGB's curve: 1 none */
    float softness;                 /* deviation of the lens blur in pixels: 0 .. 1.5 */
    float vignette;                 /* how much darker the corners are: 0 .. 0.5 */
    float noise;                    /* deviation at mid grey in 8-bit levels */
    float motion[2];                /* path of the moving instances while the shutter is open, px */
    uint64_t seed, stream;          /* of the noise */
} synth_sensor;

/* synth_sensor_random - exposure, white balance, contrast, noise drawn as a set of cameras has them */
synth_sensor synth_sensor_random(uint64_t seed, uint64_t stream);

/* synth_sensor_image - frame->radiance seen by this sensor, into frame->rgb */
void synth_sensor_image(const synth_sensor *sensor, synth_frame *frame);

/**
 * synth_sensor_depth - frame->depth as a stereo depth camera would measure it
 *
 *   far      metres up to which it measures: SYNTH_SENSOR_FAR, that of datasets of hands
 *   out      (height, width)         metres; 0 where there is no measurement
 *
 * Noise of deviation 0.08 z^2 / (f * 55 mm), no answer within 2 pixels of most depth edges, on 1-3 %
 * of the pixels in small holes, and beyond `far`; rounded to step metres (1e-3 DexYCB, 1.25e-4 HO3D).
 */
#define SYNTH_SENSOR_FAR 1.5
void synth_sensor_depth(const synth_frame *frame, double focal, double step, double far, uint64_t seed,
                        uint64_t stream, float *out);

#ifdef __cplusplus
}
#endif
#endif
