/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MOTChallenge: films in which things keep their identities. A sequence is a folder with seqinfo.ini, pictures,
 * gt/gt.txt and det/det.txt; a file of results has a row for each box of each frame.
 *
 * In the files frames and the corners of boxes count from 1; here both count from 0.
 */
#ifndef DATA_MOT_MOT_H
#define DATA_MOT_MOT_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { MOT_PEDESTRIAN = 1, MOT_CLASSES = 13, MOT_MAX_FRAMES = 1000000, MOT_MAX_ID = 1000000000 };

/* ---- rows ---- */

typedef enum {
    MOT_TRUTH,                      /* frame, id, left, top, width, height, flag, class, visible; MOT15's ends x, y,
                                     * z */
    MOT_DETECTIONS,                 /* frame, -1, left, top, width, height, score, and what is not looked at */
    MOT_RESULTS,                    /* frame, id, left, top, width, height, score, the same; the score may be missing */
} mot_kind;

typedef struct {
    int64_t id;                     /* -1 of detections */
    double box[4];                  /* x0 y0 x1 y1, edges */
    double score;                   /* 1 of the truth */
    int cls;                        /* of the truth; else MOT_PEDESTRIAN */
    bool scored;                    /* the truth's flag; else true */
    double visible;                 /* share, of the truth; else 1 */
} mot_box;

typedef struct {
    const mot_box *box;             /* in the file's order */
    int n;
} mot_frame;

/**
 * mot_read - a file's boxes by frame
 *
 *   frames   of the sequence
 *   out      (frames) in the arena
 *
 * Columns are separated by commas, with blanks or without; empty lines are passed over. Errors, with file and line: too
 * few or too many columns, what is no finite number, a frame outside the sequence, a class of the truth that is none;
 * LT_EIO, LT_ENOMEM.
 */
lt_status mot_read(lt_arena *arena, const char *path, mot_kind kind, int64_t frames, mot_frame **out);

/* mot_parse - the same from n characters and a NUL; the text is changed */
lt_status mot_parse(lt_arena *arena, const char *path, char *text, size_t n, mot_kind kind, int64_t frames,
                    mot_frame **out);

/* mot_write - a file of results. Errors: those of lt_atomic_open and lt_atomic_commit */
lt_status mot_write(const char *path, const mot_frame *frame, int64_t frames);

/* ---- who looks like whom ---- */

/* Twins have one look: shape or clothes of one are the other's. */
typedef struct { int64_t id, look, hand[2]; } mot_person;

typedef struct {
    const mot_person *person;
    int n;
} mot_looks;

/* mot_read_looks - identities.csv of a set that `palmar synth` made, into the arena; of another set nobody. Errors,
 * with file and line: another heading, what is no whole number; LT_EIO, LT_ENOMEM. mot_parse_looks - the same from n
 * characters and a NUL; the text is changed */
lt_status mot_read_looks(lt_arena *arena, const char *root, mot_looks *out);
lt_status mot_parse_looks(lt_arena *arena, const char *path, char *text, size_t n, mot_looks *out);

/* mot_look - of an identity in the sequence of a name, "hall-01_person": a number that twins, and their hands, share */
int64_t mot_look(const mot_looks *looks, const char *name, int64_t id);

/* ---- sequences ---- */

typedef struct {
    const char *folder, *name;      /* where it is; the folder's name, which files of results have */
    const char *images, *extension; /* the folder of its pictures; ".jpg" */
    double fps;
    int64_t frames;
    int width, height;
    const double *time;             /* (frames) seconds, of times.csv, else by fps */
    const char *truth, *detections; /* files; NULL: it has none */
} mot_sequence;

/* mot_sequence_open - the sequence in a folder, into the arena. Errors: no seqinfo.ini, or one that lacks a number,
 * with its line; a times.csv that does not tell each frame's time */
lt_status mot_sequence_open(lt_arena *arena, const char *folder, mot_sequence *out);

/* mot_parse_info - what seqinfo.ini says, from n characters and a NUL, into out; the text is changed. LT_EFORMAT */
lt_status mot_parse_info(lt_arena *arena, const char *path, char *text, size_t n, mot_sequence *out);

/* mot_picture - the file of frame k, in the arena; NULL without memory */
const char *mot_picture(lt_arena *arena, const mot_sequence *s, int64_t k);

/* A split's sequences, by name */
typedef struct {
    const char *root;
    const mot_sequence *sequence;
    int n;
    bool synthetic;
    mot_looks looks;
} mot_set;

/**
 * mot_open - the sequences of a split
 *
 *   root     a folder with the split's folder in it, or that has sequences itself, or that is one
 *   split    "train" or "evaluation"
 *
 * Errors: a folder without sequences; those of mot_sequence_open and mot_read_looks.
 */
lt_status mot_open(lt_arena *arena, const char *root, const char *split, mot_set *out);

/* mot_probe - whether root is such a folder */
bool mot_probe(const char *root);

#ifdef __cplusplus
}
#endif
#endif
