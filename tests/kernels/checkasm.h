/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the kernel test share: arrays between guard words, and comparing. */
#ifndef TESTS_KERNELS_CHECKASM_H
#define TESTS_KERNELS_CHECKASM_H

#include "libtensor/base/arena.h"
#include "libtensor/kernels/kernels.h"

#include <stdio.h>
#include <stdlib.h>

/* Arrays of floats with guard words on both sides, which free_array looks at. */
float *guarded_array(size_t n);                     /* contents: a pattern that is NaN */
float *random_array(size_t n, uint64_t stream);     /* in [-1, 1), the same every time */
float *zero_array(size_t n);
void free_array(float *a);

/* expect_bits - equal bits (any NaN equals any NaN); expect_near - |got - want| <= bound */
void expect_bits(const float *got, const float *want, size_t n, const char *fmt, ...) LT_PRINTF(4, 5);
void expect_near(double got, double want, double bound, const char *what, const char *name, size_t i);

/* same_as_before - the first caller with this name leaves a checksum of the bits, later ones must have
 * the same: on every instruction set and number of threads */
void same_as_before(const float *got, size_t n, const char *fmt, ...) LT_PRINTF(3, 4);

/* plainly: also against plain loops, which are slow */
void check_gemms(bool plainly);
void check_convs(bool plainly);
void check_convs_on_tiles(bool plainly);
void check_blocks(bool plainly);
void check_tiles(bool plainly);
void check_int8(bool plainly);
void check_entries(const lt_kernels *k, const lt_kernels *generic);
void check_attention(const lt_kernels *k, const lt_kernels *generic);
void check_samples(const lt_kernels *k, const lt_kernels *generic);
void check_points(const lt_kernels *k, const lt_kernels *generic);
void check_skin(const lt_kernels *k, const lt_kernels *generic);
void check_splat(const lt_kernels *k, const lt_kernels *generic);
void check_accuracy(const lt_kernels *k);
void bench(void);

#endif
