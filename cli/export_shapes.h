/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar export --mesh`, and -o of a format of Gaussians.
 */
#ifndef CLI_EXPORT_SHAPES_H
#define CLI_EXPORT_SHAPES_H

#include "cli/cli.h"
#include "libtensor/geometry/opacity/opacity.h"

enum { CLI_FRAMES = 256 };

typedef struct {
    const char *folder;             /* of meshes; NULL: none */
    const char *set;                /* the set whose Gaussians are written; NULL: those of a frame */
    int64_t frame[CLI_FRAMES];
    int n_frames;                   /* 0: the first */
    lt_opacity_rule rule;
    double iso;                     /* 0: 0.6 */
    bool of_meshes, of_frames;      /* whether --rule or --iso, --frames was given */
} cli_shapes;

/* cli_shapes_frames, cli_shapes_rule - what the options say, or a usage error */
void cli_shapes_frames(struct argp_state *state, cli_shapes *s, const char *text);
void cli_shapes_rule(struct argp_state *state, cli_shapes *s, const char *text);

/* cli_shapes_format - whether that is one of Gaussians */
bool cli_shapes_format(const char *format);

/* cli_shapes_check - usage errors of what does not go together. out: -o, or NULL; format: as said or by its ending */
void cli_shapes_check(struct argp_state *state, const cli_shapes *s, const char *checkpoint, const char *out,
                      const char *format);

/* cli_export_shapes - of a run's last checkpoint; a line for each mesh, as JSON where it is wanted */
lt_status cli_export_shapes(const cli_shapes *s, const char *checkpoint, const char *hand, const char *out,
                            const char *format, bool json);

#endif
