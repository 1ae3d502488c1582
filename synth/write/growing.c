/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/growing.h"

#include <stdlib.h>

lt_status synth_growing_open(synth_growing *g, const char *what)
{
    *g = (synth_growing){ 0 };
    g->stream = open_memstream(&g->text, &g->size);
    return g->stream ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for %s", what);
}

void synth_growing_fini(synth_growing *g)
{
    if (g->stream)
        fclose(g->stream);
    free(g->text);
    *g = (synth_growing){ 0 };
}

lt_status synth_growing_write(synth_growing *g, const char *root, const char *within, synth_manifest *manifest)
{
    lt_status st = fclose(g->stream) ? lt_error(LT_ENOMEM, "%s: no memory", within) : LT_OK;

    g->stream = NULL;
    if (!st)
        st = synth_manifest_text(manifest, root, within, g->text);
    synth_growing_fini(g);
    return st;
}
