/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What one to four cameras saw, as a folder (docs/formats.md):
 *
 *   recording.json               the cameras
 *   frames.jsonl                 a line for each frame, in the order in which they came
 *   sets.jsonl                   a line for each set of frames that were looked at together; may be missing
 *   CAMERA/000001.jpg, .z16      colour, and depth
 *
 * Cameras: x right, y down, z forward; metres. The world: z up. Seconds are those of the camera's own clock.
 */
#ifndef DATA_RECORDING_RECORDING_H
#define DATA_RECORDING_RECORDING_H

#include "libtensor/geometry/camera.h"
#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { RECORDING_CAMERAS = 4, RECORDING_MOST_FRAMES = 10000000 };

/* ---- cameras ---- */

typedef enum { RECORDING_TABLE, RECORDING_FRONT, RECORDING_SIDE } recording_role;

typedef struct {
    const char *name;               /* also of its folder */
    recording_role role;            /* looks at the table, faces the person, stands at the side */
    int width, height;
    lt_camera K;
    bool placed;                    /* R and t are known: x_world = R x_camera + t */
    double R[9], t[3];
    double depth_scale;             /* metres of a step; 0: it has no depth */
} recording_camera;

typedef struct {
    recording_camera camera[RECORDING_CAMERAS];
    int n;
    double fps;
    bool has_robot;
    double robot[4];                /* the robot's side of the world is where robot[0..2] . x > robot[3] */
    bool synthetic;
} recording_rig;

/* recording_role_name - "table", "front", "side" */
const char *recording_role_name(recording_role role);

/* recording_rig_read - recording.json, or a file of cameras in its form. Errors: LT_EFORMAT with file, camera and key:
 * what is missing, no rotation, two cameras of one name; LT_EIO, LT_ENOMEM.
 * recording_rig_parse - the same of n bytes */
lt_status recording_rig_read(lt_arena *arena, const char *path, recording_rig *out);
lt_status recording_rig_parse(lt_arena *arena, const char *name, const char *text, size_t n, recording_rig *out);

/* recording_rig_write - such a file, atomically */
lt_status recording_rig_write(const char *path, const recording_rig *rig);

/* ---- reading ---- */

typedef struct {
    int camera;
    double t;
    const char *colour, *depth;     /* files within the folder; depth NULL: none */
} recording_frame;

typedef struct { int64_t frame[RECORDING_CAMERAS]; } recording_set;     /* by camera; -1: none of its */

typedef struct {
    const char *root;
    recording_rig rig;
    const recording_frame *frame;
    int64_t n_frames;
    const recording_set *set;       /* NULL: they were never chosen */
    int64_t n_sets;
} recording;

/**
 * recording_open - a folder, into the arena
 *
 * A last line that is cut off, of a recording that was killed, is left out. Errors: those of recording_rig_read;
 * LT_EFORMAT with file and line: no JSON, no such camera, stamps that do not grow, a name that leaves the folder, a set
 * of frames that are not there or are of other cameras; LT_EIO, LT_ENOMEM.
 */
lt_status recording_open(lt_arena *arena, const char *root, recording *out);

/* recording_probe - whether path is such a folder */
bool recording_probe(const char *path);

/* recording_parse_frames, recording_parse_sets - of n bytes; r->rig is there, and for sets the frames are */
lt_status recording_parse_frames(lt_arena *arena, const char *name, const char *text, size_t n, recording *r);
lt_status recording_parse_sets(lt_arena *arena, const char *name, const char *text, size_t n, recording *r);

/* recording_colour, recording_depth - of frame k, in the arena: RGB of 8 bits; one channel of 16 bits. Errors: those of
 * reading; LT_EFORMAT: another size than the camera's */
lt_status recording_colour(const recording *r, int64_t k, lt_arena *arena, lt_image *out);
lt_status recording_depth(const recording *r, int64_t k, lt_arena *arena, lt_image *out);

/* recording_depth_pack, recording_depth_unpack - width x height steps as bytes that the arena owns, and back.
 * LT_EFORMAT: cut off, damaged, of another size; LT_ENOMEM */
lt_status recording_depth_pack(lt_arena *arena, const uint16_t *depth, int width, int height, uint8_t **bytes,
                               size_t *n);
lt_status recording_depth_unpack(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, int width,
                                 int height,
                                 uint16_t *depth);

/* ---- writing ---- */

typedef struct recording_writer recording_writer;

/* What a frame has. colour, or the bytes of a JPEG that is taken as it is; depth: NULL: none */
typedef struct {
    const lt_image *colour;
    const uint8_t *jpeg;
    size_t n_jpeg;
    const uint16_t *depth;
} recording_pictures;

/**
 * recording_create - begin a folder; recording_close after it, also after errors
 *
 * What was recorded is whole on the disk when a call returns. Errors: LT_EINVAL: there is a recording in it; LT_EIO,
 * LT_ENOSPC, LT_ENOMEM.
 */
lt_status recording_create(const char *root, const recording_rig *rig, recording_writer **out);

/* recording_store - the pictures of a camera's frame number k from 1; on any thread */
lt_status recording_store(const recording_writer *w, int camera, int64_t k, const recording_pictures *pictures);

/* recording_add - the line of it; *line: its number, from 0. recording_add_set - the frames of a set, by their lines */
lt_status recording_add(recording_writer *w, int camera, int64_t k, double t, bool depth, int64_t *line);
lt_status recording_add_set(recording_writer *w, const recording_set *set);

/* recording_close - NULL is fine; LT_EIO, LT_ENOSPC: what was written last did not reach the disk */
lt_status recording_close(recording_writer *w);

#ifdef __cplusplus
}
#endif
#endif
