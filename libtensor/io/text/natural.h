/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The order of names that hold numbers: frame2 before frame10.
 */
#ifndef LT_IO_TEXT_NATURAL_H
#define LT_IO_TEXT_NATURAL_H

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_natural_order - below, at or above 0: a comes before b, is b, comes after b
 *
 * Runs of the digits 0 to 9 compare as whole numbers of any length, everything else byte by byte. Names that differ
 * in leading zeros alone compare as text, so that only equal names are equal. No sign, point or exponent is part of a
 * number: "clip-2" comes before "clip-10".
 */
int lt_natural_order(const char *a, const char *b);

#ifdef __cplusplus
}
#endif
#endif
