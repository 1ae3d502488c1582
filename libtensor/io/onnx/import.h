/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: how one ONNX operator becomes ops of ours. import.c walks over a model and knows values by
 * name; rules.c, numbers.c, shapes.c, reduce.c and layers.c have a rule for each operator; call.c what rules ask of
 * the node; arith.c and along.c the ops that only an import needs.
 */
#ifndef LT_IO_ONNX_IMPORT_H
#define LT_IO_ONNX_IMPORT_H

#include "libtensor/io/onnx/onnx.h"

/* A value: a tensor of the graph; or whole numbers that are known while recording, shapes and indices */
typedef struct {
    const char *name;               /* NULL: an empty place of the table */
    lt_tensor *t;
    bool whole;                     /* t holds whole numbers, as reals */
    const int64_t *ints;            /* when t is NULL */
    lt_shape shape;                 /* of ints */
    const lt_onnx_tensor *constant; /* of reals, not a tensor yet */
} onnx_value;

enum { ONNX_MAX_IN = LT_MAX_IN, ONNX_MAX_OUT = 16 };
enum { ONNX_MAX_SIZE = 1 << 20 };       /* of a window, a map, a range: larger is not meant */
enum { ONNX_MAX_LISTED = 4 * ONNX_MAX_SIZE };

/* One node being recorded. The first mistake is kept, later calls do no harm. */
typedef struct {
    lt_arena *arena;
    lt_graph *g;
    int64_t opset;                  /* whose defaults count */
    const lt_onnx_node *node;
    onnx_value *in[ONNX_MAX_IN];    /* NULL: left out */
    int n_in;
    int64_t *listed;                /* numbers that this node and those before it have made of known ones */
    onnx_value out;                 /* for a rule to fill: t, or ints and shape, or constant; a cast also whole */
    lt_tensor *more[ONNX_MAX_OUT];  /* results behind it, of a rule that makes several */
    lt_status status;
} onnx_call;

typedef struct {
    const char *op;
    int min_in, max_in;
    const char *attrs;              /* names that the rule understands, each between blanks; name=value: need not be
                                     * read, since it may say this and nothing else */
    void (*record)(onnx_call *c);
    unsigned is;                    /* ONNX_WHOLE ... */
} onnx_rule;

/* Of whole numbers it makes whole numbers, which import.c marks; it may have several results. */
enum { ONNX_WHOLE = 1, ONNX_MANY = 2 };

/* Ends with a NULL op */
extern const onnx_rule onnx_number_rules[], onnx_shape_rules[], onnx_reduce_rules[], onnx_layer_rules[];

/* onnx_rule_find - the rule for an operator, or NULL */
const onnx_rule *onnx_rule_find(const char *op);

/* onnx_fail - this node cannot be recorded; why, for one line */
void onnx_fail(onnx_call *c, const char *fmt, ...) LT_PRINTF(2, 3);

/* onnx_status - what a graph says of the node that was recorded last */
lt_status onnx_status(const lt_graph *g, const lt_onnx_node *n);

/* onnx_no_memory - nor can it, but the file is not to blame */
void onnx_no_memory(onnx_call *c);

/* onnx_value_of - a constant of the file as a value: whole numbers are known from now on */
lt_status onnx_value_of(lt_arena *arena, const lt_onnx_tensor *t, onnx_value *out);

/* onnx_has - input i was not left out. onnx_tensor - it as a tensor of reals, NULL when it was left out; onnx_ints - as
 * whole numbers known now, n of them; onnx_shape - the shape of either; onnx_either - as a tensor, whole numbers too */
bool onnx_has(const onnx_call *c, int i);
lt_tensor *onnx_tensor(onnx_call *c, int i);
lt_tensor *onnx_either(onnx_call *c, int i);
const int64_t *onnx_ints(onnx_call *c, int i, int *n);
lt_shape onnx_shape(const onnx_call *c, int i);

/* onnx_charge - account for n numbers that the node makes of known ones; false, and a failure, when all nodes' are more
 * than ONNX_MAX_LISTED. onnx_list - room for n of them, or NULL */
bool onnx_charge(onnx_call *c, int64_t n);
int64_t *onnx_list(onnx_call *c, int64_t n);

/* onnx_reals - the whole numbers of input i, known now, as a constant of this shape, which has as many elements */
lt_tensor *onnx_reals(onnx_call *c, int i, lt_shape shape);

/* onnx_axis - the attribute "axis", counted from the front, of input 0 */
int onnx_axis(onnx_call *c, int64_t fallback);

/* onnx_axes - which of so many dimensions are meant, a bit for each: by the attribute "axes" of older sets, or by input
 * i, with which it was replaced; 0 when neither is there. Axes below 0 count from the end. */
unsigned onnx_axes(onnx_call *c, int i, int rank);

/* onnx_is_known - input i is there, as whole numbers; onnx_all_known - all inputs are; onnx_all_whole - all are whole
 * numbers, known or not */
bool onnx_is_known(const onnx_call *c, int i);
bool onnx_all_known(const onnx_call *c);
bool onnx_all_whole(const onnx_call *c);

/* onnx_stretched - the shape in which two meet, by NumPy's broadcasting. onnx_met - which element of s meets element
 * `at` of such a shape. onnx_fold - the result is fn of the inputs'
 * elements, all known now, which meet that way */
lt_shape onnx_stretched(onnx_call *c, lt_shape a, lt_shape b);
int64_t onnx_met(const lt_shape *s, const lt_shape *out, int64_t at);
void onnx_fold(onnx_call *c, int64_t (*fn)(onnx_call *c, const int64_t *x));

/* The node's attributes, or a fallback. onnx_attr_int is within lo .. hi; onnx_attr_equal - n equal numbers
 * within lo .. hi, as one; onnx_attr_is - a text attribute, fallback when missing, says this */
int onnx_attr_int(onnx_call *c, const char *name, int64_t fallback, int64_t lo, int64_t hi);
int onnx_attr_equal(onnx_call *c, const char *name, int n, int64_t fallback, int64_t lo, int64_t hi);
double onnx_attr_float(onnx_call *c, const char *name, double fallback);
bool onnx_attr_is(onnx_call *c, const char *name, const char *fallback, const char *value);
const int64_t *onnx_attr_ints(onnx_call *c, const char *name, int *n);      /* NULL when missing */
const lt_onnx_attr *onnx_attr(const onnx_call *c, const char *name);

/* ---- ops that only an import needs: no gradient, plain loops -------------------------------------------------- */

lt_tensor *onnx_erf(lt_tensor *x);
lt_tensor *onnx_sqrt(lt_tensor *x);
lt_tensor *onnx_trunc(lt_tensor *x);
lt_tensor *onnx_hard_sigmoid(lt_tensor *x, double alpha, double beta);
lt_tensor *onnx_div(lt_tensor *a, lt_tensor *b);        /* with broadcasting, as those that follow */
lt_tensor *onnx_max(lt_tensor *a, lt_tensor *b);
lt_tensor *onnx_min(lt_tensor *a, lt_tensor *b);
lt_tensor *onnx_pow(lt_tensor *a, lt_tensor *b);
lt_tensor *onnx_equal(lt_tensor *a, lt_tensor *b);      /* 1 or 0 */
lt_tensor *onnx_select(lt_tensor *at, lt_tensor *x, lt_tensor *y);      /* x where at is not 0; all of one shape */
lt_tensor *onnx_sum(lt_tensor *x, int axis);            /* over axis, which stays as 1 */

/* onnx_expand - stretched to this shape, which it fits */
lt_tensor *onnx_expand(lt_tensor *x, lt_shape shape);

/* onnx_pad - of one dimension or more, with so many elements before and behind along each dimension, fewer when below
 * 0: of this value, of the border, or of what lies inside the border, mirrored */
typedef enum { ONNX_PAD_VALUE, ONNX_PAD_EDGE, ONNX_PAD_REFLECT } onnx_pad_mode;
lt_tensor *onnx_pad(lt_tensor *x, const int64_t *before, const int64_t *behind, onnx_pad_mode mode, double value);

/* onnx_gather - elements of axis; index is of LT_I32 and within it */
lt_tensor *onnx_gather(lt_tensor *x, lt_tensor *index, int axis);

#endif
