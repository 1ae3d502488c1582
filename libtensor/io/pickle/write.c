/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writing a dict as a pickle of protocol 3: what every Python 3 and NumPy reads. No memo: nothing in
 * such a file is shared.
 */
#include "libtensor/io/pickle/pickle.h"

#include "libtensor/io/atomic_file.h"

#include <stdio.h>
#include <string.h>

/* The element types that are written, by NumPy's code and byte order; NULL for the others. */
static const char *const codes[LT_ELEM_COUNT] = {
    [LT_ELEM_F4] = "f4", [LT_ELEM_F8] = "f8", [LT_ELEM_BOOL] = "b1", [LT_ELEM_I4] = "i4",
    [LT_ELEM_I8] = "i8", [LT_ELEM_U1] = "u1", [LT_ELEM_U2] = "u2", [LT_ELEM_U4] = "u4",
};

static void put_le(FILE *f, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        fputc((int)(x >> (8 * i) & 0xff), f);
}

static void put_text(FILE *f, const char *text)
{
    const size_t n = strlen(text);

    fputc('X', f);                              /* BINUNICODE */
    put_le(f, n, 4);
    fwrite(text, 1, n, f);
}

static void put_int(FILE *f, int64_t x)
{
    if (x >= 0 && x < 256) {
        fputc('K', f);                          /* BININT1 */
        put_le(f, (uint64_t)x, 1);
    } else if (x >= INT32_MIN && x <= INT32_MAX) {
        fputc('J', f);                          /* BININT */
        put_le(f, (uint64_t)x, 4);
    } else {
        fputs("\x8a\x08", f);                   /* LONG1, 8 bytes */
        put_le(f, (uint64_t)x, 8);
    }
}

static void put_float(FILE *f, double x)
{
    uint64_t bits;

    memcpy(&bits, &x, sizeof(bits));
    fputc('G', f);                              /* BINFLOAT: the one big-endian number */
    for (int shift = 56; shift >= 0; shift -= 8)
        fputc((int)(bits >> shift & 0xff), f);
}

/* numpy.dtype(code, False, True), then its state: version, byte order, nothing structured */
static void put_dtype(FILE *f, lt_elem type)
{
    static const uint16_t one = 1;
    const char native = *(const uint8_t *)&one ? '<' : '>';
    const char order[2] = { lt_elem_size(type) > 1 ? native : '|', '\0' };

    fputs("cnumpy\ndtype\n", f);
    put_text(f, codes[type]);
    fputs("\x89\x88\x87R(K\x03", f);
    put_text(f, order);
    fputs("NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xff", f);
    fwrite("K\0tb", 1, 4, f);
}

/* An empty array, then its state: version, shape, dtype, not Fortran, the elements */
static void put_array(FILE *f, const lt_array *a)
{
    const size_t bytes = lt_array_count(a) * lt_elem_size(a->type);

    fputs("cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n", f);
    fwrite("K\0\x85" "C\x01" "b\x87R(K\x01(", 1, 12, f);
    for (int i = 0; i < a->rank; i++)
        put_int(f, a->shape[i]);
    fputc('t', f);
    put_dtype(f, a->type);
    fputs("\x89" "B", f);                       /* BINBYTES */
    put_le(f, bytes, 4);
    if (bytes)
        fwrite(a->data, 1, bytes, f);
    fputs("tb", f);
}

/* Recurses over the caller's own values, whose nesting check_value has bounded. */
static void put_value(FILE *f, const lt_pwrite *v)
{
    switch (v->kind) {
    case LT_PW_NONE:  fputc('N', f); break;
    case LT_PW_INT:   put_int(f, v->integer); break;
    case LT_PW_FLOAT: put_float(f, v->number); break;
    case LT_PW_STR:   put_text(f, v->text); break;
    case LT_PW_ARRAY: put_array(f, &v->array); break;
    case LT_PW_LIST:
        fputs("](", f);
        for (size_t i = 0; i < v->n_items; i++)
            put_value(f, &v->item[i]);
        fputc('e', f);
        break;
    }
}

static lt_status check_value(const char *path, const char *key, const lt_pwrite *v, int depth)
{
    size_t bytes;
    lt_status st = LT_OK;

    if (depth > LT_PICKLE_DEPTH - 2)
        return lt_error(LT_EINVAL, "%s: \"%s\": lists nested too deep", path, key);
    if (v->kind == LT_PW_ARRAY && !codes[v->array.type])
        return lt_error(LT_EINVAL, "%s: \"%s\": an array of %s is not written", path, key,
                        lt_elem_name(v->array.type));
    if (v->kind == LT_PW_ARRAY && (!lt_array_bytes(&v->array, &bytes) || bytes > UINT32_MAX))
        return lt_error(LT_EINVAL, "%s: \"%s\": array of over 4 GiB", path, key);
    for (size_t i = 0; v->kind == LT_PW_LIST && i < v->n_items && !st; i++)
        st = check_value(path, key, &v->item[i], depth + 1);
    return st;
}

lt_status lt_pickle_write_dict(const char *path, const lt_pwrite *value, size_t n)
{
    lt_atomic_file f;
    lt_status st = LT_OK;

    for (size_t i = 0; i < n && !st; i++)
        st = check_value(path, value[i].key, &value[i], 0);
    if (!st)
        st = lt_atomic_open(&f, path);
    if (st)
        return st;
    fputs("\x80\x03}(", f.stream);
    for (size_t i = 0; i < n; i++) {
        put_text(f.stream, value[i].key);
        put_value(f.stream, &value[i]);
    }
    fputs("u.", f.stream);
    return lt_atomic_commit(&f);
}
