/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a file is, by its first bytes: the one recogniser behind every reader's refusal.
 */
#ifndef LT_IO_KIND_H
#define LT_IO_KIND_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_KIND_UNKNOWN,
    LT_KIND_EMPTY, LT_KIND_LFS, LT_KIND_HTML,           /* where a download put no file */
    LT_KIND_ZIP, LT_KIND_GZIP, LT_KIND_XZ, LT_KIND_BZIP2, LT_KIND_ZSTD, LT_KIND_7Z, LT_KIND_RAR, LT_KIND_TAR,
    LT_KIND_PICKLE, LT_KIND_TORCH_ZIP, LT_KIND_TORCH_STREAM, LT_KIND_SAFETENSORS, LT_KIND_NPY, LT_KIND_NPZ,
    LT_KIND_HDF5, LT_KIND_MATLAB,
    LT_KIND_PNG, LT_KIND_JPEG, LT_KIND_HEIC, LT_KIND_AVIF, LT_KIND_WEBP, LT_KIND_TIFF, LT_KIND_GIF, LT_KIND_BMP,
    LT_KIND_MP4, LT_KIND_MATROSKA, LT_KIND_AVI,
    LT_KIND_PLY, LT_KIND_GLB, LT_KIND_PDF, LT_KIND_JSON,
    LT_KINDS,
} lt_kind;

/* lt_kind_of - what n bytes, a file's first ones or all of them, are; a few hundred are enough for all kinds */
LT_API lt_kind lt_kind_of(const uint8_t *bytes, size_t n);

/* lt_kind_name - "a zip archive"; "unknown" for LT_KIND_UNKNOWN. lt_kind_hint - what to do with one where it is not
 * read: "unpack it first"; NULL where there is nothing to say. Constants. */
LT_API const char *lt_kind_name(lt_kind kind);
LT_API const char *lt_kind_hint(lt_kind kind);

/* lt_kind_of_file - of a file's first bytes; LT_KIND_UNKNOWN, and no error, where it cannot be read or is no regular
 * file, which is not opened */
LT_API lt_kind lt_kind_of_file(const char *path);

/**
 * lt_refuse - a reader's refusal: LT_EFORMAT, and a line that says what was found and what is wanted
 *
 *   bytes   n of them from the file's beginning, which are not what was wanted
 *   want    "a zip archive"
 *
 * "x.jpg: a HEIC image, want a PNG or JPEG; set the camera to Most Compatible, or convert it to JPEG"
 */
LT_API lt_status lt_refuse(const char *name, const uint8_t *bytes, size_t n, const char *want);

/* lt_refuse_kind - the same where the kind is known */
LT_API lt_status lt_refuse_kind(const char *name, lt_kind kind, const char *want);

/* lt_refuse_cut - the refusal of a file that is of the right kind and ends early: LT_EFORMAT, and "x.npy: a .npy array
 * that is cut short: " with the reason that fmt gives, and what to do. lt_refuse_other - LT_OK, but lt_refuse where the
 * bytes are of a kind, and not of this one nor empty: for readers of text, which has no first bytes of its own */
LT_API lt_status lt_refuse_cut(const char *name, lt_kind kind, const char *fmt, ...) LT_PRINTF(3, 4);
LT_API lt_status lt_refuse_other(const char *name, const uint8_t *bytes, size_t n, lt_kind own, const char *want);

/* lt_kind_is_zip - an archive, whatever it holds */
LT_API bool lt_kind_is_zip(lt_kind kind);

#ifdef __cplusplus
}
#endif
#endif
