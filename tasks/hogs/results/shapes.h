/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Gaussians outside of graphs: those of a frame as they are drawn, those of a set in its canonical place; for files,
 * and for surfaces.
 */
#ifndef TASKS_HOGS_RESULTS_SHAPES_H
#define TASKS_HOGS_RESULTS_SHAPES_H

#include "estimate/compiled.h"
#include "libtensor/geometry/opacity/opacity.h"
#include "libtensor/io/mesh/ply.h"
#include "models/hogs/hogs.h"

/* hogs_posed_splats - what a graph that draws has drawn, in arena memory, n[0] of the hand and behind them n[1] of the
 * object: in the camera's frame, with one colour each. What is hardly seen is left out. LT_ENOMEM */
lt_status hogs_posed_splats(lt_arena *arena, const compiled *c, lt_splat **out, size_t n[2]);

/* hogs_set_name - "hand-01", "object-05" in arena memory: by subject, by YCB number; NULL without memory */
const char *hogs_set_name(lt_arena *arena, const hogs *m, int set);

/* hogs_posed_mesh - the surface of the hand or of the object that was drawn, in the camera's frame, coloured as it is
 * shown, by whole 255ths. Errors: those of lt_opacity_mesh. */
lt_status hogs_posed_mesh(lt_arena *arena, const compiled *c, bool object, lt_opacity_rule rule, double iso,
                          lt_mesh *out);

/* hogs_linear_colours - a surface's, from how displays have them to how glTF wants them */
void hogs_linear_colours(lt_mesh *m);

#endif
