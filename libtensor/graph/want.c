/* SPDX-License-Identifier: Apache-2.0 */
/* What shape rules ask of their inputs. */
#include "libtensor/graph/op.h"

lt_status lt_want_rank(lt_call *c, int i, const char *what, int rank)
{
    char text[LT_SHAPE_TEXT];

    if (!c->in[i])
        return lt_fail(c, "%s is missing", what);
    if (c->in[i]->shape.rank != rank)
        return lt_fail(c, "%s is %s, want %d dimensions", what, lt_shape_text(&c->in[i]->shape, text), rank);
    return LT_OK;
}

lt_status lt_want_shape(lt_call *c, int i, const char *what, lt_shape want)
{
    char found[LT_SHAPE_TEXT], wanted[LT_SHAPE_TEXT];

    if (!c->in[i])
        return lt_fail(c, "%s is missing", what);
    if (!lt_same_shape(&c->in[i]->shape, &want))
        return lt_fail(c, "%s is %s, want %s", what, lt_shape_text(&c->in[i]->shape, found),
                       lt_shape_text(&want, wanted));
    return LT_OK;
}
