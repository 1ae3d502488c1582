/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An op's tests as plain data, read by two programs: test_ops (float: values, messages, instruction sets,
 * threads) and palmar-gradcheck (double: gradients).
 */
#ifndef TESTS_OPS_SUITE_H
#define TESTS_OPS_SUITE_H

#include "libtensor/base/rng.h"
#include "libtensor/ops/ops.h"

enum { OP_INPUTS = 6 };

typedef enum {
    OP_NONE,                        /* left out: build gets NULL */
    OP_VALUE,                       /* has a gradient */
    OP_CONSTANT,                    /* boxes, weights of samples, targets: no gradient */
} op_role;

typedef struct {
    op_role role;
    lt_shape shape;
} op_input;

#define S(...) { OP_VALUE, LT_SHAPE(__VA_ARGS__) }
#define C(...) { OP_CONSTANT, LT_SHAPE(__VA_ARGS__) }
#define NUMBER { OP_VALUE, { 0, { 0 } } }

typedef lt_tensor *(*op_build_fn)(lt_tensor **in);
typedef struct op_case op_case;

/* Values of one input, away from the op's kinks. */
typedef void (*op_fill_fn)(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r);

struct op_case {
    const char *name;               /* of its arrays in tests/vectors/ops: name.in0, name.out0, ... */
    op_build_fn build;
    op_input in[OP_INPUTS];
    op_fill_fn fill;                /* NULL: fill_clear_of_zero */
    bool no_vectors;                /* nothing to compare values with: large, or random */
    bool together;                  /* one gradient alone is another function's: batch_norm without it measures none */
};

typedef struct {
    op_build_fn build;
    op_input in[OP_INPUTS];
    const char *message;            /* without the place at its end */
} op_bad_case;

typedef struct {
    const char *name;
    const op_case *cases;
    int n_cases;
    const op_bad_case *bad;
    int n_bad;
    void (*vary)(op_case *c, lt_rng *r);        /* give c, a copy of cases[0], other shapes; or NULL */
    double value_tol, grad_tol;     /* of the tensor's largest magnitude; 0: 1e-6 */
    bool random;                    /* training and inference differ by intent */
} op_suite;

#define CASES(c) .cases = (c), .n_cases = (int)LT_COUNT(c)
#define BAD(b) .bad = (b), .n_bad = (int)LT_COUNT(b)

/* fill_clear_of_zero - 0.1 <= |x| < 1, the default; fill_positive - 0.5 <= x < 1.5;
 * fill_apart - all different, 0.01 from each other: for a maximum */
void fill_clear_of_zero(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r);
void fill_positive(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r);
void fill_apart(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r);

/* vary_first - in[0] gets one to four dimensions of any size; vary_map - (B, C, H, W) */
void vary_first(op_case *c, lt_rng *r);
void vary_map(op_case *c, lt_rng *r);

/* pick - lo .. hi */
int64_t pick(lt_rng *r, int lo, int hi);

/* All suites: suites.h names them. */
extern const op_suite *const op_suites[];
extern const int n_op_suites;

#endif
