/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pickle reader's stack machine, as its parts see it: pickle.c and scalar.c have the opcodes,
 * stack.c what they work with, call.c the classes, NumPy's in numpy.c; check.c looks over
 * the result.
 *
 * The first failure is kept in status and stops the machine after the opcode at hand. Until then every
 * helper returns something that can be used, None if need be, so opcodes need no checks between lines.
 */
#ifndef LT_IO_PICKLE_MACHINE_H
#define LT_IO_PICKLE_MACHINE_H

#include "libtensor/io/pickle/pickle.h"

typedef struct lt_pmachine lt_pmachine;

/* One known name, and the value that calling it with a tuple gives. */
typedef struct {
    const char *module, *name;
    lt_pvalue *(*call)(lt_pmachine *m, const lt_pvalue *args);
} lt_pm_class;

/* What a format that is built on pickles adds to Python's and NumPy's own classes. */
typedef struct {
    const lt_pm_class *classes;
    size_t n;
    lt_pvalue *(*persistent)(lt_pmachine *m, const lt_pvalue *id);      /* meaning of PERSID */
} lt_pm_dialect;

struct lt_pmachine {
    lt_arena *arena;
    const char *name;                   /* of the file */
    const uint8_t *bytes;
    size_t n, pos, op_start;            /* input; next byte; the opcode at hand */
    size_t file_bytes;                  /* of the file that the input is of, for the budget's error line */
    const lt_pm_dialect *dialect;       /* NULL: plain */
    void *context;                      /* the dialect's */
    lt_pvalue **stack, **memo;
    size_t *mark;                       /* stack heights */
    size_t n_stack, stack_room, n_mark, mark_room, memo_room;
    size_t n_memoized;                  /* MEMOIZE counts by itself */
    char *pool;                         /* small things, packed tighter than the arena does */
    size_t pool_left;
    size_t n_values, spent, budget;     /* bytes made of the file's, and how many may be */
    lt_pvalue *none, *empty, *result;   /* None, the empty tuple; what STOP left */
    lt_pvalue **small_int;              /* those below LT_PM_SMALL_INTS that were met */
    lt_pvalue *truth[2];                /* False and True, where they were met */
    lt_status status;
};

enum { LT_PM_SMALL_INTS = 256 };        /* how many integers from 0 on are shared */

typedef void (*lt_pm_opcode)(lt_pmachine *m);

/* lt_pm_scalar - what opcode `code` does where it is of scalar.c; else NULL */
lt_pm_opcode lt_pm_scalar(uint8_t code);

/**
 * lt_pm_take       - the next n bytes; NULL after a failure
 * lt_pm_take_uint  - the next n <= 8 bytes as a little-endian number
 * lt_pm_take_line  - text up to a newline, which is skipped; NULL after a failure
 * lt_pm_parse_int  - a decimal integer that fills n characters up to an optional L
 */
const uint8_t *lt_pm_take(lt_pmachine *m, uint64_t n);
uint64_t lt_pm_take_uint(lt_pmachine *m, int n);
const char *lt_pm_take_line(lt_pmachine *m, size_t *n);
bool lt_pm_parse_int(const char *text, size_t n, int64_t *out);

/**
 * lt_pm_push      - onto the stack
 * lt_pm_top       - what is on it, down to the last mark
 * lt_pm_pop       - the same, and it is gone
 * lt_pm_floor     - how low the stack may be popped
 * lt_pm_mark      - set a mark there
 * lt_pm_pop_mark  - all *n values above the last mark, which goes; still in memory until the next push
 * lt_pm_memo_put  - remember the top
 * lt_pm_memo_get  - push what was remembered
 */
void lt_pm_push(lt_pmachine *m, lt_pvalue *v);
lt_pvalue *lt_pm_top(lt_pmachine *m);
lt_pvalue *lt_pm_pop(lt_pmachine *m);
size_t lt_pm_floor(const lt_pmachine *m);
void lt_pm_mark(lt_pmachine *m);
lt_pvalue **lt_pm_pop_mark(lt_pmachine *m, size_t *n);
void lt_pm_memo_put(lt_pmachine *m, uint64_t index);
void lt_pm_memo_get(lt_pmachine *m, uint64_t index);

/* lt_pm_budget - the bytes of memory that values out of a file of so many bytes may take */
size_t lt_pm_budget(size_t file_bytes);

/*
 * lt_pm_run - the value of the pickle at pos; pos is behind it then
 *
 * The caller has set arena, name, bytes, n, pos, file_bytes, budget, and dialect and context if there are
 * any, and everything else to 0. The machine needs no freeing.
 */
lt_status lt_pm_run(lt_pmachine *m, const lt_pvalue **out);

/* lt_pm_fail - the first reason counts; the line has file, offset and reason */
void lt_pm_fail(lt_pmachine *m, const char *fmt, ...) LT_PRINTF(2, 3);

/* lt_pm_no_memory - the same for memory that the system refused */
void lt_pm_no_memory(lt_pmachine *m);

/* lt_pm_spend - account for bytes of memory; false, and a failure, when the file asks for too much */
bool lt_pm_spend(lt_pmachine *m, size_t bytes);

/* lt_pm_value - a new value of that kind; lt_pm_text - the same with a copy of n bytes and a NUL */
lt_pvalue *lt_pm_value(lt_pmachine *m, lt_pkind kind);
lt_pvalue *lt_pm_text(lt_pmachine *m, lt_pkind kind, const char *text, size_t n);

/* lt_pm_alloc - memory for small things, aligned to 8 bytes; NULL after a failure */
void *lt_pm_alloc(lt_pmachine *m, size_t bytes);

/* lt_pm_items - a new list, tuple or set of n items, which are copied; a dict: 2 * n of them */
lt_pvalue *lt_pm_items(lt_pmachine *m, lt_pkind kind, lt_pvalue *const *item, size_t n);

/* lt_pm_extend - append count items to a list, set or dict; to a dict an even number of them */
void lt_pm_extend(lt_pmachine *m, lt_pvalue *to, lt_pvalue *const *item, size_t count);

/* lt_pm_global - what a module and a name stand for; lt_pm_call, lt_pm_build - the meaning of REDUCE, which NEWOBJ
 * shares, and of BUILD; lt_pm_object - an object that stays closed */
lt_pvalue *lt_pm_global(lt_pmachine *m, const char *module, size_t n_module, const char *name,
                        size_t n_name);
lt_pvalue *lt_pm_call(lt_pmachine *m, lt_pvalue *callee, lt_pvalue *args);
void lt_pm_build(lt_pmachine *m, lt_pvalue *object, lt_pvalue *state);
lt_pvalue *lt_pm_object(lt_pmachine *m, const char *class_name);

/* lt_pm_bad_args - a failure: name is called with arguments that it does not take; lt_pm_is_text - v is this text */
lt_pvalue *lt_pm_bad_args(lt_pmachine *m, const char *name);
bool lt_pm_is_text(const lt_pvalue *v, const char *want);

/**
 * lt_pm_numpy_dtype        - dtype("f4", align, copy); its byte order comes with lt_pm_build_dtype
 * lt_pm_numpy_reconstruct  - _reconstruct(ndarray, (0,), "b"): an array whose elements come with lt_pm_build_array
 * lt_pm_numpy_frombuffer   - _frombuffer(bytes, dtype, shape, "C" or "F"): an array of protocol 5
 * lt_pm_numpy_scalar       - scalar(dtype, bytes): an array of rank 0
 */
lt_pvalue *lt_pm_numpy_dtype(lt_pmachine *m, const lt_pvalue *args);
lt_pvalue *lt_pm_numpy_reconstruct(lt_pmachine *m, const lt_pvalue *args);
lt_pvalue *lt_pm_numpy_frombuffer(lt_pmachine *m, const lt_pvalue *args);
lt_pvalue *lt_pm_numpy_scalar(lt_pmachine *m, const lt_pvalue *args);
void lt_pm_build_dtype(lt_pmachine *m, lt_pvalue *v, const lt_pvalue *state);
void lt_pm_build_array(lt_pmachine *m, lt_pvalue *v, const lt_pvalue *state);

/* lt_pm_check - result has no cycle, is not too deep, and every array in it was given its elements. What is so within
 * an object is cut off there: nobody needs it. */
void lt_pm_check(lt_pmachine *m);

#endif
