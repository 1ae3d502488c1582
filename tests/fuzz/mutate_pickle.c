/* SPDX-License-Identifier: Apache-2.0 */
/* Mutation of pickles, opcode by opcode: what comes out mostly runs, and does something else. */
#include "tests/fuzz/fuzz.h"

#include <stdlib.h>
#include <string.h>

enum { OPS_MAX = 1024 };

typedef struct {
    uint8_t *bytes;
    size_t n, room;
    size_t start[OPS_MAX + 1];          /* of opcode i; the end of the last one */
    size_t n_ops;
    unsigned random;
    fuzz_bytes_fn *mutate_bytes;
} pickle;

static unsigned pick(pickle *p, size_t n)
{
    p->random = p->random * 1664525u + 1013904223u;
    return n ? (unsigned)((p->random >> 8) % n) : 0;
}

/* How an opcode's argument goes: f digits of it are fixed bytes, c digits a count of that many bytes, l lines. */
static char argument(uint8_t op, int *width)
{
    static const char table[] =
        "\x80" "f1" "\x95" "f8" "J" "f4" "K" "f1" "M" "f2" "G" "f8" "q" "f1" "r" "f4" "h" "f1" "j" "f4"
        "\x82" "f1" "\x83" "f2" "\x84" "f4" "I" "l1" "L" "l1" "F" "l1" "S" "l1" "V" "l1" "p" "l1" "g" "l1"
        "P" "l1" "c" "l2" "i" "l2" "T" "c4" "U" "c1" "X" "c4" "\x8c" "c1" "\x8d" "c8" "B" "c4" "C" "c1"
        "\x8e" "c8" "\x96" "c8" "\x8a" "c1" "\x8b" "c4";

    for (size_t i = 0; table[i]; i += 3) {
        if ((uint8_t)table[i] == op) {
            *width = table[i + 2] - '0';
            return table[i + 1];
        }
    }
    *width = 0;
    return 'f';
}

static uint64_t counted(const uint8_t *p, int width)
{
    uint64_t n = 0;

    for (int i = width - 1; i >= 0; i--)
        n = n << 8 | p[i];
    return n;
}

/* Length of the opcode at p with its argument; left when it does not end. */
static size_t length_of(const uint8_t *p, size_t left)
{
    int width;
    const char kind = argument(*p, &width);
    size_t n = 1;

    if (kind == 'l') {
        for (int lines = 0; n < left && lines < width; n++)
            lines += p[n] == '\n';
        return n;
    }
    n += (size_t)width;
    if (n > left)
        return left;
    if (kind == 'c' && counted(p + 1, width) > left - n)
        return left;
    return kind == 'c' ? n + (size_t)counted(p + 1, width) : n;
}

static void parse(pickle *p)
{
    size_t at = 0;

    for (p->n_ops = 0; at < p->n && p->n_ops < OPS_MAX; p->n_ops++) {
        p->start[p->n_ops] = at;
        at += length_of(p->bytes + at, p->n - at);
    }
    p->start[p->n_ops] = at;
}

/* Bytes [at, at + gone) become n others; nothing happens when there is no room. */
static void replace(pickle *p, size_t at, size_t gone, const uint8_t *with, size_t n)
{
    if (p->n - gone + n > p->room)
        return;
    memmove(p->bytes + at + n, p->bytes + at + gone, p->n - at - gone);
    if (n)
        memcpy(p->bytes + at, with, n);
    p->n = p->n - gone + n;
}

static void some_ops(pickle *p, size_t *begin, size_t *end)
{
    const size_t first = pick(p, p->n_ops), last = first + 1 + pick(p, 1 + pick(p, 12));

    *begin = p->start[first];
    *end = p->start[last < p->n_ops ? last : p->n_ops];
}

/* Take some opcodes away, and put them elsewhere too when there is a place. */
static void move(pickle *p, int keep)
{
    uint8_t copy[512];
    size_t begin, end, to, n;

    some_ops(p, &begin, &end);
    n = end - begin < sizeof(copy) ? end - begin : sizeof(copy);
    memcpy(copy, p->bytes + begin, n);
    to = p->start[pick(p, p->n_ops)];
    if (!keep)
        replace(p, begin, end - begin, NULL, 0);
    replace(p, to < p->n ? to : p->n, 0, copy, n);
}

static void insert(pickle *p)
{
    static const struct {
        const char *bytes;
        size_t n;
    } snippet[] = {
#define OPS(text) { text, sizeof(text) - 1 }
        OPS("N"), OPS("]"), OPS("}"), OPS(")"), OPS("("), OPS("\x8f"), OPS("2"), OPS("0"), OPS("1"), OPS("."),
        OPS("a"), OPS("e"), OPS("s"), OPS("u"), OPS("\x90"), OPS("\x91"), OPS("t"), OPS("l"), OPS("d"), OPS("R"),
        OPS("b"), OPS("\x81"), OPS("\x92"), OPS("\x93"), OPS("Q"), OPS("\x94"), OPS("\x85"), OPS("\x86"),
        OPS("\x87"), OPS("K\0"), OPS("K\1"), OPS("J\xff\xff\xff\x7f"), OPS("J\0\0\0\x80"), OPS("M\xff\xff"),
        OPS("\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f"), OPS("q\0"), OPS("h\0"), OPS("h\1"), OPS("h\2"),
        OPS("cnumpy\nndarray\n"), OPS("cnumpy\ndtype\n"), OPS("cnumpy.core.multiarray\n_reconstruct\n"),
        OPS("cnumpy.core.multiarray\nscalar\n"), OPS("cnumpy.core.numeric\n_frombuffer\n"), OPS("c_codecs\nencode\n"),
        OPS("ccollections\nOrderedDict\n"), OPS("ccopy_reg\n_reconstructor\n"), OPS("c__builtin__\nset\n"),
        OPS("c__builtin__\nslice\n"), OPS("cchumpy.ch\nCh\n"), OPS("cchumpy.reordering\nSelect\n"),
        OPS("cchumpy.reordering\ntranspose\n"), OPS("cscipy.sparse.csc\ncsc_matrix\n"), OPS("cposix\nsystem\n"),
        OPS("ctorch._utils\n_rebuild_tensor_v2\n"), OPS("ctorch._utils\n_rebuild_tensor_v3\n"),
        OPS("ctorch._utils\n_rebuild_parameter\n"), OPS("ctorch\nFloatStorage\n"), OPS("ctorch\nLongStorage\n"),
        OPS("ctorch.storage\nUntypedStorage\n"), OPS("ctorch\nbfloat16\n"), OPS("ctorch\nSize\n"),
        OPS("ctorch.nn.modules.linear\nLinear\n)\x81"), OPS("X\7\0\0\0storage"), OPS("X\1\0\0\0" "0"),
        OPS("X\2\0\0\0f4"), OPS("X\3\0\0\0" "|S1"), OPS("X\1\0\0\0<"), OPS("X\1\0\0\0>"), OPS("X\6\0\0\0latin1"),
        OPS("X\x0b\0\0\0_parameters"), OPS("X\x08\0\0\0_modules"), OPS("X\x0a\0\0\0state_dict"),
#undef OPS
    };
    const unsigned i = pick(p, sizeof(snippet) / sizeof(snippet[0]));

    replace(p, p->start[pick(p, p->n_ops + 1)], 0, (const uint8_t *)snippet[i].bytes, snippet[i].n);
}

/* The argument of one opcode; a count is made right again mostly. */
static void change_argument(pickle *p)
{
    const size_t i = pick(p, p->n_ops), at = p->start[i], end = p->start[i + 1];
    uint8_t text[512];
    int width;
    const char kind = argument(p->bytes[at], &width);
    const size_t head = kind == 'l' ? 1 : 1 + (size_t)width;
    size_t n;

    if (end - at <= head && kind != 'f') {
        return;
    } else if (kind == 'f') {
        for (size_t k = at + 1; k < end; k++)
            p->bytes[k] = (uint8_t)(pick(p, 2) ? pick(p, 256) : (unsigned)(p->bytes[k] + (pick(p, 2) ? 1 : 255)));
        return;
    }
    n = end - at - head < sizeof(text) / 2 ? end - at - head : sizeof(text) / 2;
    memcpy(text, p->bytes + at + head, n);
    n = p->mutate_bytes(text, n, sizeof(text));
    if (kind == 'c' && pick(p, 8))
        for (int k = 0; k < width; k++)
            p->bytes[at + 1 + (size_t)k] = k < 4 ? (uint8_t)(n >> (8 * k)) : 0;
    replace(p, at + head, end - at - head, text, n);
}

size_t fuzz_pickle(uint8_t *bytes, size_t n, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes)
{
    pickle p = { .bytes = bytes, .n = n, .room = room, .random = seed, .mutate_bytes = mutate_bytes };

    for (unsigned rounds = 1 + pick(&p, 4); rounds > 0; rounds--) {
        size_t begin, end;

        parse(&p);
        if (p.n_ops == 0)
            return mutate_bytes(bytes, n, room);
        switch (pick(&p, 8)) {
        case 0: some_ops(&p, &begin, &end); replace(&p, begin, end - begin, NULL, 0); break;
        case 1: move(&p, 0); break;
        case 2: move(&p, 1); break;
        case 3: case 4: insert(&p); break;
        case 5: case 6: change_argument(&p); break;
        default: p.n = mutate_bytes(bytes, p.n, room); break;
        }
    }
    return p.n;
}
