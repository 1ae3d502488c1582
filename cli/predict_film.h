/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar predict --film`: what a model of Gaussians draws, as a film.
 */
#ifndef CLI_PREDICT_FILM_H
#define CLI_PREDICT_FILM_H

#include "cli/cli.h"

typedef struct {
    const char *path;               /* NULL: none is wanted */
    bool turn;                      /* once around the first frame; else all frames, the truth beside the rendering */
    double fps;                     /* 0: 10, or 30 of what turns */
} cli_film;

/* cli_film_write - data: a folder of frames, or NULL: those that the run is validated on. *frames: of the film. */
lt_status cli_film_write(const cli_film *film, cli_checkpoint *c, const char *hand, const char *data, int64_t *frames);

#endif
