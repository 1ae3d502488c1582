/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hot loops: one table of functions, filled once for the instruction set in use.
 *
 * What holds for every entry, unless it says otherwise:
 *   - Raw pointers, sizes and strides (in elements). No tensor, no allocation, no thread: the caller
 *     cuts the work, and must cut it by the problem, never by the number of threads.
 *   - Any alignment; n = 0 is legal and touches nothing; nothing is read or written past the end.
 *   - y may be exactly x (in place); otherwise outputs do not overlap inputs.
 *   - The same bits on every instruction set, and for every way of aligning or cutting the arrays of
 *     an element-wise entry. A fused multiply-add is a fused multiply-add in generic C as well.
 *   - NaN in gives NaN out; infinities give the limit.
 *   - `_grad` entries add into dx (a tensor may have two readers); dy is the gradient of y.
 *
 * lt_real is float, or double in the test-only build, which has the generic kernels and libm's
 * functions in place of the polynomials.
 */
#ifndef LT_KERNELS_KERNELS_H
#define LT_KERNELS_KERNELS_H

#include "libtensor/base/common.h"
#include "libtensor/base/cpu.h"
#include "libtensor/base/status.h"
#include "libtensor/kernels/splat_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What may follow a convolution, a product or a normalisation in the same pass. */
typedef enum {
    LT_ACT_NONE,
    LT_ACT_RELU,
    LT_ACT_LEAKY_RELU,          /* param: slope */
    LT_ACT_SILU,
    LT_ACT_ELU,
    LT_ACT_GELU,                /* exact, not by tanh */
    LT_ACT_QUICK_GELU,
    LT_ACT_SIGMOID,
    LT_ACT_TANH,
} lt_act_kind;

typedef struct {
    lt_act_kind kind;
    lt_real param;
} lt_act;

/* c = act(c + row_bias[i] + col_bias[j] + residual[i][j]), each part optional (NULL), in this order. */
typedef struct {
    const lt_real *row_bias, *col_bias, *residual;
    int64_t ld_residual;        /* elements between rows of residual */
    lt_act act;
} lt_epilogue;

/* One step of Adam or AdamW [Kingma and Ba 2015; Loshchilov and Hutter 2019]. */
typedef struct {
    lt_real lr, beta1, beta2, eps;
    lt_real l2;                 /* added to the gradient, times w (Adam) */
    lt_real decay;              /* w -= lr * decay * w before the step (AdamW) */
    lt_real correct1, correct2; /* 1 - beta1^t, 1 - beta2^t */
    lt_real grad_scale;         /* multiplies the gradient first: clipping; 1 for none */
} lt_adam_step;

typedef struct {
    lt_real lr, momentum, l2, grad_scale;   /* as above */
    bool nesterov;
} lt_sgd_step;

/* Element i is dropped where draw i of the stream (lt_rng_u32) is less than below, and else times scale. */
typedef struct {
    uint64_t seed, stream;
    uint32_t below;
    lt_real scale;
} lt_masking;

/* How a convolution reads its maps. Position q is row q / grid_w and column q % grid_w of a grid; row r,
 * column s at tap t reads x[channel][r * step_h + tap[t].dy][s * step_w + tap[t].dx], 0 outside. */
typedef struct { int dy, dx; } lt_tap;

typedef struct {
    const lt_real *x;           /* (channels, h, w) */
    int64_t h, w, grid_w;
    int step_h, step_w;
    int taps;
    const lt_tap *tap;
} lt_conv_image;

/* How a depthwise convolution goes over one map: by strips of `high` rows of the result. Unless `window` says that
 * the kernel may read the map itself, what a strip sees of the padded map, `reach` rows for each of its own, is
 * dealt to step x step phases, where rows lie `pitch` apart and tap t, in the order (kx, ky), is offset[t] from each
 * element; its weight is weight[t]. */
enum { LT_DEPTHWISE_TAPS = 121, LT_DEPTHWISE_STRIP = 6144, LT_DEPTHWISE_LANES = 16 };

typedef struct {
    int64_t h, w, out_h, out_w;
    int step, pad_h, pad_w;     /* step 1 or 2 */
    int window;                 /* 3 or 5: a square window that size, dilation 1; or 0 */
    int64_t maps;               /* that a result sums over: 1, but with a window */
    int64_t reach, high, pitch, phase;
    int taps;
    int weight[LT_DEPTHWISE_TAPS];
    int64_t offset[LT_DEPTHWISE_TAPS];
} lt_depthwise;

/* An activation behind an op, as the op's gradient meets it. Leaky relu: where its result y is not above 0, dy counts
 * `slope` times; without y it stood behind affine(x, a, b), whose result has the same sign. Silu stood there, too. */
typedef struct {
    const lt_real *y;
    lt_real slope, a, b;
    bool silu;
} lt_behind;

/* What came through that activation: its gradient, where it may be dy, and silu's result. NULL: nobody wants it. */
typedef struct { lt_real *dz, *silu; } lt_through;

/* Some vertices of a mesh beside each other: the joints that move any of them, and how much */
enum { LT_SKIN_GROUP = 16, LT_SKIN_FRAME = 12 };
typedef struct {
    int n;
    const int *joint;                           /* (n) */
    const lt_real (*weight)[LT_SKIN_GROUP];     /* (n) */
} lt_skin_group;

/* One grid of a hash grid: a place in [0, 1] is in cell x scale + 0.5, rounded down. Corners have `entries` entries: a
 * power of two that they are hashed to, or, in their order with x first, side * side * side of them and some more. */
typedef struct {
    lt_real scale;
    uint32_t side, entries;
    bool hashed;
} lt_hash_level;

enum { LT_POINTS = 16 };        /* planes of points are multiples of it long */

/* What attention reads of a head, each packed in the order that the instruction set's kernels want: queries, keys and
 * values, or for gradients these and the gradients of results. Rows may be packed in parts of LT_ATTEND_UNIT. */
typedef enum { LT_ATTEND_Q, LT_ATTEND_K, LT_ATTEND_V, LT_ATTEND_DY } lt_attend_part;
enum { LT_ATTEND_UNIT = 96 };

/* packed: elements of n packed rows, d long; pack: s times n rows of x, ld apart, d long. So many queries, and for
 * gradients keys, are done at once. */
typedef struct {
    int queries, keys;
    int64_t (*packed)(lt_attend_part part, int64_t n, int64_t d);
    void (*pack)(lt_attend_part part, lt_real *out, const lt_real *x, int64_t ld, int64_t n, int64_t d, lt_real s);
} lt_attend_packing;

/* What some queries and some keys of a head give to its gradients; see attend_grad. */
typedef struct {
    int64_t d, ld;                      /* channels; elements between rows of q, k, dy, dq, dk, dv */
    int64_t rows, keys;
    const lt_real *packed_q, *packed_k, *packed_v, *packed_dy;  /* q multiplied as attend had it */
    const lt_real *q, *k, *dy;          /* by row */
    const lt_real *stats;               /* of the queries, as attend left them */
    const lt_real *mean;                /* sum over channels of dy y, for each query */
    lt_real scale;                      /* what q was multiplied with, without log2(e) */
    lt_real *dq, *dk, *dv;              /* each may be NULL */
} lt_attend_grad;

/* Attention of one head: y_i = sum over j of softmax_j(q_i . k_j) v_j */
typedef struct {
    lt_attend_packing packing, grad_packing;

    /* attend: the results of `rows` queries, ld apart. q was packed times log2(e), as scores are powers of two in here;
     * k and v are all keys (at least 1) and values, packed. stats[2 * rows], not for NULL: the largest score and
     * 1 / the sum of 2^(score - largest). As with softmax a NaN or +inf among a row's scores, or nothing but -inf,
     * makes its result NaN. The exponentials are within 3 ulp. Each sum is one chain of multiply-adds, with LT_ISA_AMX
     * in wide heads within 1e-6 of the terms' sizes from that.
     * attend_grad: adds to dq, dk and dv what g's queries and keys give, after making the scores again. */
    void (*attend)(lt_real *y, int64_t ld, lt_real *stats, const lt_real *q, const lt_real *k,
                   const lt_real *v, int64_t rows, int64_t keys, int64_t d);
    void (*attend_grad)(const lt_attend_grad *g);
} lt_attention_kernels;

/* Channels of a head from which on a tile's sums are long enough to pay */
enum { LT_WIDE_HEAD = 32 };

/* Rows that are weighed sums of rows of a map: row r sums weight[t * stride + r] times the d numbers at
 * x + at[t * stride + r] * ldx over t < taps, in their order. */
typedef struct {
    const lt_real *x;
    int64_t ldx, d, rows, taps, stride;
    const int32_t *at;
    const lt_real *weight;
} lt_samples;

enum { LT_SOFTMAX_COLUMNS = 256 };      /* the most columns of softmax_down */

/* A size x size window (3, 5 or 7) on lines of a map that bring their zeros along: at row r, column q of image
 * i its tap (ky, kx) is x[i * image + (r * step + ky) * line + q * step + kx]. */
typedef struct {
    const lt_real *x;
    int64_t image, line;
    int64_t images, rows, cols;
    int step, size;
} lt_window;

/* 3 x 3 windows: that of row r, column l starts at w[r * row + l * col], where row or col is 9, and is turned by half a
 * circle when flip. */
typedef struct {
    const lt_real *w;
    int64_t row, col;
    bool flip;
} lt_windows;

/* How a tensor is read as 8-bit integers: x is about scale * q, where q is x / scale rounded to the nearest, even where
 * it stands between two, and cut off at -127 and 127, or at 0 and 255 where x is never negative. A NaN is cut
 * off below. */
typedef struct {
    lt_real scale;              /* finite, > 0 */
    bool has_negative;
} lt_int8_range;

/* What makes numbers of a product of bytes: row i of gemm_bytes, column j of gemm_bytes_plain, starts from the 32-bit
 * integer in start, 0 for NULL, and its sum times scale is the result. */
typedef struct {
    const lt_real *start, *scale;
} lt_bytes;

/* Maps in blocks of channels: (n, ceil(c / LT_BLOCK), h, w, LT_BLOCK). In the lanes behind the last channel stands what
 * an activation makes of 0; weights there are 0. */
enum { LT_BLOCK = 16 };

/* One panel of a product over such maps: C[lines * rows, n] = (add ? C : 0) + A B. Columns of A come in segments of
 * `each`, the last one of `last`: column l of segment s and row i of a line is a[segment[s] + i * step + l], and
 * lines are `line` elements apart. step and each are LT_BLOCK, or step is 2 for plain maps. Row i, column j of C is
 * c[j / LT_BLOCK * plane + i * LT_BLOCK + j % LT_BLOCK] of a line, and lines are c_line elements apart. */
typedef struct {
    const lt_real *a;
    int64_t rows, step, lines, line;
    const int64_t *segment;
    int64_t segments, each, last;
    const lt_real *b;           /* a panel of pack_b, n <= nr columns of it, a multiple of LT_BLOCK or of nr */
    int64_t n;
    lt_real *c;
    int64_t plane, c_line;
    bool add;
} lt_blocks;

/* Cache lines to fetch meanwhile, so many in each row */
typedef struct { const lt_real *at; int64_t row, rows, lines; } lt_fetch;

/* A product on AMX's tiles: C[lines * rows, n] = (add ? C : 0) + A B. Columns of A come in segments of LT_TILES_SIDE,
 * each number as three bfloat16s (amx/tiles.h): what row i of a line has of segment s are the LT_TILES_ROW elements at
 * a[segment[s] + i * LT_TILES_ROW], and lines are `line` elements apart. LT_TILES_SIDE rows are read at a time, also
 * behind the last one. */
enum { LT_TILES_SIDE = 32, LT_TILES_ROW = 3 * LT_TILES_SIDE / 2, LT_TILES_BLOCK = LT_TILES_SIDE * LT_TILES_ROW };
typedef struct {
    const lt_real *a;
    int64_t rows, lines, line;
    const int64_t *segment;
    int64_t segments;
    const lt_real *b;           /* panels of tiles_right, of LT_TILES_SIDE columns each, b_panel elements apart */
    int64_t b_panel, n;
    lt_real *c;                 /* row i of a line, column j: c[i * c_row + j / LT_BLOCK * plane + j % LT_BLOCK] */
    int64_t c_row, c_line, plane;
    bool add;
    lt_fetch fetch;             /* what is written later */
} lt_tiles;

/* A depthwise convolution over one block of a map; the window is 3 or 5 wide and high, and goes by 1 or 2. Rows of x
 * have the padding's zeros at their sides, and so `wide` positions; x begins with row `first` of the map's h. */
typedef struct {
    int64_t h, wide, first, out_w;
    int size, step, pad;
} lt_blocks_window;

/* What follows it */
typedef struct {
    const lt_real *bias;        /* (LT_BLOCK) or NULL */
    const lt_real *residual;    /* as y, or NULL */
    lt_act act;
    double *sum;                /* (LT_BLOCK) each channel's results are added to, position by position; or NULL */
} lt_blocks_tail;

/* Columns that are weighed sums of columns: output j is the sum over k < taps, in their order, of weight[k * ld + j]
 * times input base[j / LT_COLUMNS] + at[k * ld + j], but where at is below 0. ld: n rounded up to whole LT_COLUMNS */
enum { LT_COLUMNS = 16 };
typedef struct {
    int64_t n, taps;
    const int32_t *base, *at;
    const lt_real *weight;
    bool near;                  /* at is always below 2 * LT_COLUMNS */
} lt_columns;

/* Rows of LT_BLOCK numbers are told by rows of x: row r by links first[r] .. first[r + 1] - 1, link k by what begins at
 * x[from[k]]. */
typedef struct {
    const int32_t *first;
    const int64_t *from;
    const lt_real *weight;          /* of a link */
    const lt_real *scale, *shift;   /* (LT_BLOCK) each, or NULL: of sums */
    bool relu;                      /* of what comes of that; NaN stays NaN */
} lt_links;

enum { LT_PACK_K = 256 };       /* the most rows of B, and columns of A, that are packed at once */

typedef struct lt_kernels {
    lt_isa isa;

    /* ---- element-wise, i in [0, n) ---------------------------------------------------------- */
    void (*add)(lt_real *y, const lt_real *a, const lt_real *b, size_t n);
    void (*sub)(lt_real *y, const lt_real *a, const lt_real *b, size_t n);
    void (*mul)(lt_real *y, const lt_real *a, const lt_real *b, size_t n);
    void (*scale)(lt_real *y, const lt_real *x, lt_real s, size_t n);           /* y = s x */
    void (*add_to)(lt_real *y, const lt_real *x, size_t n);                     /* y += x */
    /* add_lines: y[r * ld_y + i] += x[r * ld_x + i] for r < rows, i < n */
    void (*add_lines)(lt_real *y, int64_t ld_y, const lt_real *x, int64_t ld_x, int64_t rows, int64_t n);
    void (*axpy)(lt_real *y, lt_real s, const lt_real *x, size_t n);            /* y = fma(s, x, y) */
    void (*mul_to)(lt_real *y, const lt_real *a, const lt_real *b, size_t n);   /* y = fma(a, b, y) */

    /* axpy_in: y[i] = fma(s, x[i * step], y[i]);  axpy_out: y[i * step] = fma(s, x[i], y[i * step]),
     * where what lies between the first and the last of these may be written as it was. */
    void (*axpy_in)(lt_real *y, lt_real s, const lt_real *x, int64_t step, size_t n);
    void (*axpy_out)(lt_real *y, int64_t step, lt_real s, const lt_real *x, size_t n);

    /* Activations. exp is within 2 ulp of the exact value, sigmoid, silu, quick_gelu and tanh 3 ulp
     * (where the first three are below 1e-36 in size they may be anything as small), gelu
     * 2e-7 * max(|x|, 1e-3) absolute, and 0 or x from |x| = 5.65 on. */
    void (*relu)(lt_real *y, const lt_real *x, size_t n);               /* NaN stays NaN */
    void (*leaky_relu)(lt_real *y, const lt_real *x, lt_real slope, size_t n);
    void (*silu)(lt_real *y, const lt_real *x, size_t n);               /* x / (1 + exp(-x)) */
    void (*elu)(lt_real *y, const lt_real *x, size_t n);                /* exp(x) - 1, x < 0 */
    void (*gelu)(lt_real *y, const lt_real *x, size_t n);       /* x Phi(x), Phi(x) = (1 + erf(x / sqrt 2)) / 2 */
    void (*quick_gelu)(lt_real *y, const lt_real *x, size_t n);         /* x / (1 + exp(-1.702 x)) */
    void (*sigmoid)(lt_real *y, const lt_real *x, size_t n);
    void (*tanh)(lt_real *y, const lt_real *x, size_t n);
    void (*exp)(lt_real *y, const lt_real *x, size_t n);

    /* dx += dy * y'(x). The first five want the input x, sigmoid_grad and tanh_grad the output y;
     * exp's gradient is mul_to(dx, dy, y, n). At 0 leaky_relu takes its slope. */
    void (*leaky_relu_grad)(lt_real *dx, const lt_real *dy, const lt_real *x, lt_real slope, size_t n);
    void (*silu_grad)(lt_real *dx, const lt_real *dy, const lt_real *x, size_t n);
    void (*elu_grad)(lt_real *dx, const lt_real *dy, const lt_real *x, size_t n);
    void (*gelu_grad)(lt_real *dx, const lt_real *dy, const lt_real *x, size_t n);
    void (*quick_gelu_grad)(lt_real *dx, const lt_real *dy, const lt_real *x, size_t n);
    void (*sigmoid_grad)(lt_real *dx, const lt_real *dy, const lt_real *y, size_t n);
    void (*tanh_grad)(lt_real *dx, const lt_real *dy, const lt_real *y, size_t n);

    /* affine: y = act(fma(a, x, b) + residual) with one a and b, as a channel of an NCHW map has them;
     * residual may be NULL;
     * affine_grad: dx = or += s dy + t x + u, the way a batch norm's gradient reaches its input. behind may be NULL,
     * and dx may be dy where it does not add. */
    void (*affine)(lt_real *y, const lt_real *x, lt_real a, lt_real b, const lt_real *residual, lt_act act, size_t n);
    void (*affine_grad)(lt_real *dx, const lt_real *dy, const lt_behind *behind, const lt_real *x, lt_real s, lt_real t,
                        lt_real u, bool add, size_t n);

    /* ---- reductions: 16 running sums in double, element i in sum i % 16, then a fixed tree ----- */
    double (*sum)(const lt_real *x, size_t n);
    double (*sumsq)(const lt_real *x, size_t n);
    double (*dot)(const lt_real *a, const lt_real *b, size_t n);
    double (*dot_step)(const lt_real *a, const lt_real *b, int64_t step, size_t n); /* a[i] b[i step] */

    /* Of `runs` runs of n elements that start `step` apart, as a channel's are in an NCHW map; element i of
     * each in sum i % 16. moments: the sums of x and of x^2; grad_moments: of dy and of dy * (x - mean),
     * where behind, with y for the first run, may be NULL. What came through it goes where `to` says, which may be
     * NULL, in runs like those of dy. */
    void (*moments)(double out[2], const lt_real *x, int64_t step, int64_t runs, size_t n);
    void (*grad_moments)(double out[2], const lt_through *to, const lt_real *dy, const lt_behind *behind,
                         const lt_real *x, double mean, int64_t step, int64_t runs, size_t n);

    /* ---- one row ------------------------------------------------------------------------------ */
    /* softmax: y = exp(x - max) / sum; all NaN when x has a NaN, or +inf, or nothing but -inf.
     * softmax_grad: dx += y * (dy - sum(dy * y)) */
    void (*softmax)(lt_real *y, const lt_real *x, size_t n);
    void (*softmax_grad)(lt_real *dx, const lt_real *dy, const lt_real *y, size_t n);

    /* layer_norm: of each of `rows` rows of n, y = (x - mean) * rstd * gamma + beta, with the biased variance; mean and
     * rstd are written to stats[2 * row] when it is not NULL. gamma, beta may be NULL (1, 0). y may not be x.
     * layer_norm_grad: adds to dx, and the row's share to dgamma[n] and dbeta[n]; each may be NULL. */
    void (*layer_norm)(lt_real *y, lt_real *stats, const lt_real *x, const lt_real *gamma, const lt_real *beta,
                       double eps, size_t rows, size_t n);
    void (*layer_norm_grad)(lt_real *dx, lt_real *dgamma, lt_real *dbeta, const lt_real *dy,
                            const lt_real *x, const lt_real *gamma, const lt_real *stats, size_t n);

    /* ---- attention: heads below LT_WIDE_HEAD channels, then the others; see lt_attention_of ---------- */
    lt_attention_kernels attention[2];

    /* ---- rows and columns: y and x do not overlap --------------------------------------------------- */
    /* skin: n vertices, LT_SKIN_GROUP to a group, under the joints' frames, each a matrix A (3, 3) and then s (3). x
     * has groups of [3][LT_SKIN_GROUP], and y[3 * i + a] becomes A x + s, with the sums over its group's joints of
     * weight * frame in their order. Its A goes to t[r * ld + i], r < 9. y or t may be NULL; of x and t there are whole
     * groups. */
    void (*skin)(lt_real *y, lt_real *t, int64_t ld, const lt_real *x, const lt_skin_group *groups, int64_t n,
                 const lt_real (*frame)[LT_SKIN_FRAME]);

    /* Of points that are planes of their x, y and z, ld apart, where ld is a multiple of LT_POINTS and whatever is no
     * point is NaN; p is a place, and squared distances are fma(dz, dz, fma(dy, dy, dx dx)).
     * farthest_point: d[i] = the smaller of d[i] and the squared distance of point i, for i < ld; returns where the
     * largest d is, the first of equal ones. No d is NaN;
     * nearest_point: returns the first of the nearest points, 0 for none, and its squared distance, infinite for none;
     * points_within: index = the first `room` points, in their order, whose squared distance is at most r2; returns how
     * many there are. */
    int64_t (*farthest_point)(lt_real *d, const lt_real *x, int64_t ld, const lt_real p[3]);
    int64_t (*nearest_point)(lt_real *least, const lt_real *x, int64_t ld, const lt_real p[3]);
    int64_t (*points_within)(int32_t *index, int64_t room, const lt_real *x, int64_t ld, const lt_real p[3],
                             lt_real r2);

    /* take_from: y[i] = x[at[i]] - from, i < n; where at is below 0, -from */
    void (*take_from)(lt_real *y, const lt_real *x, const int32_t *at, lt_real from, size_t n);

    /* largest_of_rows: y[r] = the largest of row r of n, its first place to where[r] unless that is NULL; the first NaN
     * wins. n at least 1. */
    void (*largest_of_rows)(lt_real *y, int32_t *where, const lt_real *x, int64_t n, int64_t rows);

    /* link_rows: row r of y = the sum over its links, in their order, of weight[k] x[from[k] + j], and what follows;
     * link_products: sums[k * LT_BLOCK + j] = fma(x[from[k] + j], y[r * LT_BLOCK + j], itself) for each link k of r */
    void (*link_rows)(lt_real *y, const lt_real *x, const lt_links *l, int64_t rows);
    void (*link_products)(lt_real *sums, const lt_real *x, const lt_real *y, const lt_links *l, int64_t rows);

    /* combine: y[i] = or += the sum over k < count of w[k] * x[k * ld + i], i < n, in the order of k;
     * combine_columns: n rows of y = or += what c says of rows of x, of which 2 * LT_COLUMNS from each base on are
     * there;
     * turn: y[j * ld_y + i] = or += x[i * ld_x + j] for i < rows, j < cols */
    void (*combine)(lt_real *y, const lt_real *x, int64_t ld, const lt_real *w, int64_t count, size_t n,
                    bool add);
    void (*combine_columns)(lt_real *y, int64_t ld_y, const lt_real *x, int64_t ld_x, int64_t n, const lt_columns *c,
                            bool add);
    void (*turn)(lt_real *y, int64_t ld_y, const lt_real *x, int64_t ld_x, int64_t rows, int64_t cols,
                 bool add);

    /* ---- bilinear samples of an h x w map, zero outside it ------------------------------------------ */
    /* corners: sample i < n at column x[i], row y[i], where a cell's centre is a whole number, reads four
     * cells: this one, its right neighbour, the one below, and that one's. at[c * stride + i] is the cell's number,
     * always on the map, weight[c * stride + i] what it weighs: 0 outside, NaN for a place that is NaN.
     * corners_grad: value[i] = the sample of a map that has g[c * stride + i] in these cells; dx, dy: its
     * derivatives (=, not +=), from the right where there is a kink.
     * sample: the rows that s says;  sample_spread: dx at them += weight * dy, by row, then by tap, dx ldx apart;
     * sample_dots: g[t * stride + r] += the dot product of row r of dy and tap t's row of x.
     * softmax_down: y = softmax over k < rows of y[k * stride + i], for each i < n <= LT_SOFTMAX_COLUMNS;
     * rows at least 1. */
    void (*corners)(int32_t *at, lt_real *weight, int64_t stride, const lt_real *x, const lt_real *y,
                    int64_t h, int64_t w, size_t n);
    void (*corners_grad)(lt_real *dx, lt_real *dy, lt_real *value, int64_t stride, const lt_real *g,
                         const lt_real *x, const lt_real *y, int64_t h, int64_t w, size_t n);
    void (*sample)(lt_real *y, int64_t ldy, const lt_samples *s);
    void (*sample_spread)(lt_real *dx, const lt_real *dy, int64_t ldy, const lt_samples *s);
    void (*sample_dots)(lt_real *g, const lt_real *dy, int64_t ldy, const lt_samples *s);
    void (*softmax_down)(lt_real *y, int64_t stride, int64_t rows, size_t n);

    /* hash_corners: at[c * stride + i] and weight[c * stride + i], c < 8, are the entries of the corners around place i
     * of x (n, 3), cut off at 0 and 1, and what they weigh. Bit 0 of c goes along x. */
    void (*hash_corners)(int32_t *at, lt_real *weight, int64_t stride, const lt_real *x, const lt_hash_level *l,
                         size_t n);

    /* ---- one plane ---------------------------------------------------------------------------- */
    /* maxpool: a k x k window every `step` positions, `pad` (< k) of nothing around the h x w plane;
     * y and where have out_h * out_w elements; where[i] is the place of the first maximum in x
     * (a NaN wins); NULL when nobody asks. Every window must reach the plane. maxpool_block: the same of a block of
     * LT_BLOCK planes, (h, w, LT_BLOCK), without places. maxpool_grad: dx[where[i]] += dy[i], in order. */
    void (*maxpool)(lt_real *y, int32_t *where, const lt_real *x, int h, int w, int k, int step,
                    int pad, int out_h, int out_w);
    void (*maxpool_block)(lt_real *y, const lt_real *x, int h, int w, int k, int step, int pad, int out_h, int out_w);
    void (*maxpool_grad)(lt_real *dx, const lt_real *dy, const int32_t *where, size_t n_out);

    /* ---- optimisers: w, the running means m and v, in place ------------------------------------- */
    void (*adam)(lt_real *w, lt_real *m, lt_real *v, const lt_real *g, const lt_adam_step *p, size_t n);
    void (*sgd)(lt_real *w, lt_real *m, const lt_real *g, const lt_sgd_step *p, size_t n);

    /* dropout: y = x masked, or y += x masked; x begins with element at, a multiple of 4. With relu, which may be NULL,
     * the mask is `slope` times as large where relu->y is not above 0. */
    void (*dropout)(lt_real *y, const lt_real *x, const lt_masking *d, const lt_behind *relu, int64_t at, size_t n,
                    bool add);

    /* ---- the matrix product, for libtensor/kernels/gemm/gemm.c and conv.c ----------------------------- */
    /* A tile is at most mr rows of nr columns. Packed A: m rows cut into ceil(m / mr) panels of equal
     * height to one row (panel p starts at row p * m / panels), each stored [k][height]. Packed B:
     * panels of nr columns, each stored [k][nr], the last padded with zeros.
     * Element (i, j) of the source stands at i * row + j * col. */
    int mr, nr;
    void (*pack_a)(lt_real *out, const lt_real *a, int64_t row, int64_t col, int64_t m, int64_t k);
    void (*pack_b)(lt_real *out, const lt_real *b, int64_t row, int64_t col, int64_t k, int64_t n);

    /* scale_panels: out = row l of packed B times s[l], for k rows of n columns; out may be b */
    void (*scale_panels)(lt_real *out, const lt_real *b, const lt_real *s, int64_t k, int64_t n);

    /* gemm_block: C[m, n] = (add ? C : 0) + A B for packed A and panels of B that stand `panel` elements
     * apart, and then what e says, where it is not NULL: the same as epilogue, but in registers. Each
     * element is one chain of fused multiply-adds in the order of k, so blocking over k changes no bit. */
    void (*gemm_block)(lt_real *c, int64_t ldc, const lt_real *a, const lt_real *b, int64_t panel,
                       int64_t m, int64_t n, int64_t k, bool add, const lt_epilogue *e);
    void (*epilogue)(lt_real *c, int64_t ldc, int64_t m, int64_t n, const lt_epilogue *e);

    /* gemm_plain: the same with an A that is not packed: element (i, l) is a[i * lda + l] */
    void (*gemm_plain)(lt_real *c, int64_t ldc, const lt_real *a, int64_t lda, const lt_real *b, int64_t panel,
                       int64_t m, int64_t n, int64_t k, bool add, const lt_epilogue *e);

    /* gemm_columns: the same with one panel of B, n <= nr, and an A that is not packed: element (i, l) is
     * a[l * lda + i]. What e says may be a col_bias and an activation. */
    void (*gemm_columns)(lt_real *c, int64_t ldc, const lt_real *a, int64_t lda, const lt_real *b, int64_t m,
                         int64_t n, int64_t k, bool add, const lt_epilogue *e);

    /* ---- products of 8-bit integers; not in the double build, where these are NULL --------------------------- */
    /* Four bytes that follow each other in k make a word, which is packed and moved about as if it were an element.
     * gemm_bytes: A has signed bytes, B unsigned ones. k counts words. Sums are
     * exact modulo 2^32; until the last k they are left in C as integers, from where add goes on. With e the
     * sum is complete: C = sum * scale, and then what e says. gemm_bytes_plain: an A as in gemm_plain with unsigned
     * bytes, a B with signed ones. */
    void (*gemm_bytes)(lt_real *c, int64_t ldc, const lt_real *a, const lt_real *b, int64_t panel, int64_t m, int64_t n,
                       int64_t k, bool add, const lt_bytes *q, const lt_epilogue *e);
    void (*gemm_bytes_plain)(lt_real *c, int64_t ldc, const lt_real *a, int64_t lda, const lt_real *b, int64_t panel,
                             int64_t m, int64_t n, int64_t k, bool add, const lt_bytes *q, const lt_epilogue *e);

    /* bytes_of_planes: words[i] for i < n from element i of up to four planes, `plane` apart, the others 0, each
     * multiplied with its gate first unless that is NULL;
     * bytes_of_panels: the panels of pack_b for n columns, whose row i are the words of planes 4 i and on, of `planes`
     * planes. gate has a number for each; bytes are 128 more where r has a sign, but zeros behind the last column;
     * bytes_of_row: n bytes of a row in their order, 128 more where r has a sign, and zeros up to whole words;
     * bytes_raise: 128 more for each byte of n words, modulo 256. */
    void (*bytes_of_planes)(lt_real *words, const lt_real *x, int64_t plane, int planes, const lt_real *gate,
                            const lt_int8_range *r, size_t n);
    void (*bytes_of_panels)(lt_real *out, const lt_real *x, int64_t plane, int64_t planes, const lt_real *gate,
                            const lt_int8_range *r, int64_t n);
    void (*bytes_of_row)(lt_real *words, const lt_real *x, const lt_int8_range *r, size_t n);
    void (*bytes_raise)(lt_real *words, size_t n);

    /* pack_image: the panels of pack_b for rows [k0, k0 + k) and columns [n0, n0 + n) of the matrix
     * whose row is (channel, tap) and whose column is a position;
     * pack_image_t: the same for its transpose: k positions from k0, n (channel, tap) from n0;
     * image_rows: those n as rows of k positions, ld apart; up to 15 elements past the end of each are
     * written, before the next one is. */
    void (*pack_image)(lt_real *out, const lt_conv_image *g, int64_t k0, int64_t k, int64_t n0, int64_t n);
    void (*pack_image_t)(lt_real *out, const lt_conv_image *g, int64_t k0, int64_t k, int64_t n0, int64_t n);
    void (*image_rows)(lt_real *out, int64_t ld, const lt_conv_image *g, int64_t k0, int64_t k, int64_t n0,
                       int64_t n);

    /* window_sums: C[taps, n] = (add ? C : 0) + the sum over g's positions of its taps times a row of B, one
     * panel of pack_b with a row for each position, in the order of images, rows, columns. n is at most nr,
     * and rounded up to whole vectors. */
    void (*window_sums)(lt_real *c, int64_t ldc, const lt_window *g, const lt_real *b, int64_t n, bool add);

    /* depthwise: `count` results, result i of its own maps x (i, maps, h, w) under windows w (i, maps, taps):
     * y (i, out_h, out_w), then what e says, whose row_bias has a number for each. Each y is one chain of multiply-adds
     * over (map, kx, ky), the padding's zeros included or not. total[i], unless NULL, becomes the sum of y[i]: by
     * strips, each as sum has it. */
    void (*depthwise)(lt_real *y, double *total, const lt_real *x, const lt_real *w, const lt_depthwise *d,
                      const lt_epilogue *e, int64_t count);

    /* depthwise_up: the gradient of one map whose square window goes by steps of 2, with a border of half its size:
     * dx (h, w) = (add ? dx : 0) + one chain of multiply-adds over (ky, kx) */
    void (*depthwise_up)(lt_real *dx, const lt_real *dy, const lt_real *w, const lt_depthwise *d, bool add);

    /* depthwise_weights: sums[t * LT_DEPTHWISE_LANES + column % LT_DEPTHWISE_LANES] += dy times what tap t sees
     * of x: one chain of multiply-adds down the rows of each column, and these in double; without a square window a
     * chain for each strip, by rows. next_x and next_dy are the maps that a later call reads. */
    void (*depthwise_weights)(double *sums, const lt_real *x, const lt_real *dy, const lt_depthwise *d,
                              const lt_real *next_x, const lt_real *next_dy);

    /* ---- Winograd F(2x2, 3x3), for libtensor/kernels/conv/winograd2.c: LT_BLOCK channels in lanes ------------- */
    /* wino2_input: place p of B^T d B to out[p * place], where d[4 y + x] is row y, column x of the tile;
     * wino2_output: A^T m A, n channels of m[p * place], to y[2 row + column], which may be the same;
     * wino2_windows: as wino_windows, for 16 places */
    void (*wino2_input)(lt_real *out, int64_t place, const lt_real *const d[16]);
    void (*wino2_output)(lt_real *const y[4], const lt_real *m, int64_t place, int64_t n);
    void (*wino2_windows)(lt_real *out, int64_t place, int64_t ld, const lt_windows *g, int64_t rows, int64_t k);

    /* ---- Winograd F(4x4, 3x3), for libtensor/kernels/conv/winograd.c ----------------------------------- */
    /* Lines of tiles are read and written by whole vectors: 64 elements more than n tiles have.
     * wino_deal: q[j * phase + t] = line[4 t + j], j < 6;  wino_gather: line[4 t + j] = r[j * phase + t],
     * j < 4. Tiles of wino_input and wino_output come in multiples of 16.
     * wino_input: element (i, j) of tile t is q[(i % 4 * 6 + j) * phase + i / 4 * below + t]; place (i, j)
     * of B^T d B goes to out[(6 i + j) * place] in column n0 + t of panels of nr columns.
     * wino_output: place (i, j) is m[(6 i + j) * place + t]; element (i, j) goes to r[(4 i + j) * phase + t].
     * wino_windows: row r, column l of G g G^T to out[p * place + l * ld + r] for its 36 places p, r < rows <= ld,
     * l < k; between columns come zeros. ld is at most nr. */
    void (*wino_deal)(lt_real *q, int64_t phase, const lt_real *line, int64_t n);
    void (*wino_input)(lt_real *out, int64_t place, int64_t panel, int64_t n0, const lt_real *q,
                       int64_t phase, int64_t below, int64_t n);
    void (*wino_output)(lt_real *r, int64_t phase, const lt_real *m, int64_t place, int64_t n);
    void (*wino_gather)(lt_real *line, const lt_real *r, int64_t phase, int64_t n);
    void (*wino_windows)(lt_real *out, int64_t place, int64_t ld, const lt_windows *g, int64_t rows, int64_t k);

    /* ---- maps in blocks of channels, for libtensor/kernels/blocks/conv.c --------------------------------- */
    /* gemm_blocks: what g says; with e the sums are complete and what it says follows: a col_bias of whole
     * panels, a residual that lies as C does, an activation.
     * finish_block: y = act(y + bias + residual) for n positions, bias and residual NULL or not;
     * sum_block: adds each channel's sum over n positions to out, one after the other;
     * depthwise_block: rows [from, to) of the map y, whose weights are w[(ky * size + kx) * LT_BLOCK + channel], each a
     * chain over (ky, kx), and what t says. */
    void (*gemm_blocks)(const lt_blocks *g, const lt_epilogue *e);
    void (*finish_block)(lt_real *y, const lt_real *bias, const lt_real *residual, lt_act act, int64_t n);
    void (*sum_block)(double out[LT_BLOCK], const lt_real *x, int64_t n);
    void (*depthwise_block)(lt_real *y, const lt_real *x, const lt_real *w, const lt_blocks_window *d, int64_t from,
                            int64_t to, const lt_blocks_tail *t);

    /* wino_block_input, wino_block_output: as wino2_input and wino2_output, for tiles of 6 x 6 and 4 x 4 */
    void (*wino_block_input)(lt_real *out, int64_t place, const lt_real *const d[36]);
    void (*wino_block_output)(lt_real *const y[16], const lt_real *m, int64_t place);
    /* The transposes, for the weights' gradient. wino_block_grad: place p of A d A^T, of 4 x 4 places, lane l to
     * out[p * place + l / nr * panel + l % nr]; wino_block_windows: element t of G^T m G to out[t * LT_BLOCK] */
    void (*wino_block_grad)(lt_real *out, int64_t place, int64_t panel, const lt_real *const d[16]);
    void (*wino_block_windows)(lt_real *out, const lt_real *m, int64_t place);

    /* ---- Winograd F(4, 5) down columns, for libtensor/kernels/blocks/tall.c ---------------------------- */
    /* tall_input: B^T d for n positions of LT_BLOCK channels beside each other, place p to out[p * place]; d: eight
     * rows, NULL for zeros. tall_output: A^T m for them, place p of m[p * place], to four rows, NULL: not wanted. */
    void (*tall_input)(lt_real *out, int64_t place, const lt_real *const d[8], int64_t n);
    void (*tall_output)(lt_real *const y[4], const lt_real *m, int64_t place, int64_t n);

    /* ---- products on AMX's tiles, for gemm/tiles.c, blocks/tiles.c and gemm/product_tiles.c; NULL elsewhere */
    /* gemm_tiles: what g says. Each element is within 1e-6 of the terms' sizes from the sum.
     * tiles_left: n rows of one segment, at x + i * row: cols elements, from the 17th on at x + half, times those of
     * gate, unless NULL;
     * tiles_left_turned: the same from the transpose of those, k rows of n columns, at most LT_TILES_SIDE of them; rows
     * are made up to a multiple of LT_TILES_SIDE;
     * tiles_right: k rows of n columns, ld elements apart, in panels of LT_TILES_SIDE columns, `panel` elements apart,
     * of blocks of LT_TILES_BLOCK elements for LT_TILES_SIDE rows each; zeros for what is not there. */
    void (*gemm_tiles)(const lt_tiles *g);
    void (*tiles_left)(lt_real *out, const lt_real *x, int64_t half, int64_t row, int64_t cols, int64_t n,
                       const lt_real *gate);
    void (*tiles_left_turned)(lt_real *out, const lt_real *x, int64_t ld, int64_t k, int64_t n);
    void (*tiles_right)(lt_real *out, int64_t panel, const lt_real *b, int64_t ld, int64_t k, int64_t n);

    /* ---- Gaussians, for libtensor/ops/splat/raster.c ------------------------------------------------------- */
    lt_splat_kernels splat;

    /* fma_loop: rounds of independent fused multiply-adds on registers; returns how many single
     * operations (two per multiply-add and lane) were done. *sink keeps the compiler honest. */
    double (*fma_loop)(int64_t rounds, lt_real *sink);
} lt_kernels;

/* lt_k - the table in use. Valid after lt_kernels_init. */
LT_API extern const lt_kernels *lt_k;

/* lt_attention_of - what attention with heads of d channels is done with */
static inline const lt_attention_kernels *lt_attention_of(const lt_kernels *k, int64_t d)
{
    return &k->attention[d >= LT_WIDE_HEAD];
}

/**
 * lt_kernels_init - choose the table once: the best this CPU can do, or what PALMAR_ISA names
 *
 * Later calls return the first call's result. Before the first call lt_k is the generic table.
 * Errors: PALMAR_ISA is no known name, or an instruction set that this CPU or this build has not.
 */
LT_API lt_status lt_kernels_init(void);

/**
 * lt_kernels_get - fill *k with the table of one instruction set; for tests, from any thread
 *
 * Errors: this CPU or this build has not that instruction set.
 */
LT_API lt_status lt_kernels_get(lt_isa isa, lt_kernels *k);

/* lt_kernels_without_vnni - the products of bytes as a CPU without VNNI has them; for tests */
LT_API void lt_kernels_without_vnni(lt_kernels *k);

/**
 * lt_kernels_use - make *k the table in use until the next call; NULL: back to lt_kernels_init's
 *
 * For tests and benchmarks. *k must outlive its use, and nothing may be running.
 */
LT_API void lt_kernels_use(const lt_kernels *k);

/**
 * lt_fma_peak_gflops - multiply-adds on registers, all threads, for about `ms` milliseconds
 *
 * Returns 1e9 operations per second (a multiply-add counts two): the bound to hold speeds against,
 * and a reading of how busy the machine is with other things.
 */
LT_API double lt_fma_peak_gflops(double ms);

#ifdef __cplusplus
}
#endif
#endif
