/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The part of Python's pickle, protocols 0 to 5, that datasets and hand models are stored in. A file
 * becomes a tree of plain values. Nothing in it is ever executed, imported or looked up.
 *
 * Source: CPython Lib/pickletools.py for the opcodes; NumPy for how it pickles.
 */
#ifndef LT_IO_PICKLE_PICKLE_H
#define LT_IO_PICKLE_PICKLE_H

#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LT_PNONE,
    LT_PBOOL,                       /* integer: 0 or 1 */
    LT_PINT,                        /* integer */
    LT_PFLOAT,                      /* number */
    LT_PSTR,                        /* text, n: UTF-8 from Python 3, raw bytes from Python 2 */
    LT_PBYTES,                      /* text, n */
    LT_PLIST, LT_PTUPLE, LT_PSET,   /* item, n */
    LT_PDICT,                       /* item: key, value, key, value ...; n pairs, in file order */
    LT_PARRAY,                      /* array: numpy.ndarray, and numpy scalars with rank 0 */
    LT_POBJECT,                     /* object: its class, and its state or NULL where it had none; items */
    LT_PCLASS,                      /* text: the dotted name of a class or function, inert */
    LT_PDTYPE,                      /* array: rank 0, type; no data */
    LT_POWN,                        /* text, own: what a reader that is built on this one made of its own */
} lt_pkind;

/* Values may be shared: one list can stand in several places. There are no cycles, and no value is
 * nested deeper than LT_PICKLE_DEPTH, so a consumer may recurse. */
typedef struct lt_pvalue lt_pvalue;
struct lt_pvalue {
    lt_pkind kind;
    uint32_t mark;                  /* the reader's own */
    union {
        size_t n;
        lt_pvalue *items;           /* of an object: the dict or list of what was put into it, or NULL */
        void *own;
    };
    union {
        int64_t integer;
        double number;
        const char *text;           /* n bytes and a NUL; LT_PBYTES has no NUL */
        lt_pvalue **item;
        lt_array *array;
        struct {
            const char *class_name;
            lt_pvalue *state;
        } object;
    } u;
};

enum { LT_PICKLE_DEPTH = 64 };

/**
 * lt_pickle_read - the value of a pickle file
 *
 *   out      owned by the arena; touched only on success
 *
 * The classes that mean something: numpy arrays (also those of subclasses, as numpy.matrix is one), scalars and
 * dtypes; str, int, list, dict, set and their like; OrderedDict and defaultdict (as dicts). An array of Python
 * objects becomes a list, nested as deep as it has dimensions, or of none the object itself. Whatever else a file
 * names becomes an LT_POBJECT that stays closed; so do integers beyond 64 bits, and arrays of complex numbers, of
 * structures and the like. It is an error only to him who wants to read it.
 *
 * Errors: LT_EFORMAT names the file, the byte offset and the reason: cut short, unknown opcode, a size beyond what
 * the file holds, a value inside itself, nesting too deep, over 16 million values. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_pickle_read(lt_arena *arena, const char *path, const lt_pvalue **out);

/* lt_pickle_parse - the same from n bytes in memory, which must live as long as the arena */
LT_API lt_status lt_pickle_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                                 const lt_pvalue **out);

/* lt_pickle_sniff - whether bytes may be a pickle's; protocols 0 and 1 have no first bytes of their own, but begin with
 * a container, a class or None */
LT_API bool lt_pickle_sniff(const uint8_t *bytes, size_t n);

/* lt_pdict_get - the value under a text key, the last one where there are several; NULL when it is
 * not there or d is NULL or no dict */
LT_API const lt_pvalue *lt_pdict_get(const lt_pvalue *d, const char *key);

/* lt_parray - the array; lt_pstr - the text, also of a NumPy text scalar; NULL when v is NULL or another kind */
LT_API const lt_array *lt_parray(const lt_pvalue *v);
LT_API const char *lt_pstr(const lt_pvalue *v);

/* lt_pint, lt_pfloat - a number, also from a bool or an array of one element; false when v is none */
LT_API bool lt_pint(const lt_pvalue *v, int64_t *out);
LT_API bool lt_pfloat(const lt_pvalue *v, double *out);

/* lt_pis_none - v is NULL or Python's None */
LT_API bool lt_pis_none(const lt_pvalue *v);

/* lt_pdescribe - what v is, for an error line: "a list", "(778, 3)", "an object of config.Config"; into out, cut at n
 * bytes; returns out */
LT_API const char *lt_pdescribe(const lt_pvalue *v, char *out, size_t n);

/**
 * lt_pfloats - exactly n finite numbers out of an array of any shape, or out of (nested) lists
 *
 *   what     the name of the value, for the error line
 *
 * So (48), (48, 1) and [[...]] read alike. Errors: LT_EFORMAT: absent or None, another count, no
 * numbers, NaN or infinity.
 */
LT_API lt_status lt_pfloats(const lt_pvalue *v, const char *what, float *out, size_t n);

/* ---- writing: a flat dict, as HO3D's meta files are ---------------------------------------------- */

typedef enum {
    LT_PW_NONE, LT_PW_INT, LT_PW_FLOAT, LT_PW_STR,
    LT_PW_ARRAY,                    /* f4, f8, bool, i4, i8, u1, u2 or u4 */
    LT_PW_LIST,                     /* items are any of these; their keys are not used */
} lt_pwrite_kind;

typedef struct lt_pwrite lt_pwrite;
struct lt_pwrite {
    const char *key;
    lt_pwrite_kind kind;
    int64_t integer;
    double number;
    const char *text;               /* UTF-8 */
    lt_array array;
    const lt_pwrite *item;          /* n_items of them */
    size_t n_items;
};

/**
 * lt_pickle_write_dict - n keyed values as a pickle of protocol 3, atomically
 *
 * Every Python 3 reads it, with any NumPy from 1.0 to 2. Lists may nest LT_PICKLE_DEPTH deep.
 * Errors: LT_EINVAL (an element type not listed above, nesting), and those of lt_atomic_commit.
 */
LT_API lt_status lt_pickle_write_dict(const char *path, const lt_pwrite *value, size_t n);

#ifdef __cplusplus
}
#endif
#endif
