/* SPDX-License-Identifier: Apache-2.0 */
/* Pickles: what Python wrote, what we write, and what nobody should have written. */
#include "libtensor/io/pickle/dense.h"
#include "libtensor/io/pickle/pickle.h"
#include "tests/io/hostile.h"
#include "tests/io/io_vectors.h"
#include "tests/io/resaved_vectors.h"

#include <math.h>

static lt_status read_pickle(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_pvalue *v;

    return lt_pickle_parse(arena, "x.pkl", bytes, n, &v);
}

static const struct {
    const uint8_t *bytes;
    size_t n;
} protocols[] = {
    { pickle_0, sizeof(pickle_0) }, { pickle_1, sizeof(pickle_1) }, { pickle_2, sizeof(pickle_2) },
    { pickle_3, sizeof(pickle_3) }, { pickle_4, sizeof(pickle_4) }, { pickle_5, sizeof(pickle_5) },
};

static double element(const lt_pvalue *d, const char *key, size_t i)
{
    const lt_array *a = lt_parray(lt_pdict_get(d, key));

    ck_assert_msg(a && i < lt_array_count(a), "%s", key);
    return lt_array_get(a, i);
}

static int64_t integer(const lt_pvalue *v)
{
    int64_t x = -1;

    ck_assert(lt_pint(v, &x));
    return x;
}

START_TEST(every_protocol)
{
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *d, *v;
    double x;

    check_ok(lt_pickle_parse(arena, "p", protocols[_i].bytes, protocols[_i].n, &d));
    for (size_t i = 0; i < 6; i++) {
        ck_assert(element(d, "a", i) == (double)i);
        ck_assert(element(d, "f", i) == (double)i);
    }
    ck_assert(lt_pis_none(lt_pdict_get(d, "none")) && lt_pdict_get(d, "none"));
    ck_assert(!lt_pdict_get(d, "absent"));
    ck_assert_int_eq(integer(lt_pdict_get(d, "int")), -5);
    ck_assert_int_eq(integer(lt_pdict_get(d, "long")), (int64_t)1 << 40);
    ck_assert_int_eq(integer(lt_pdict_get(d, "least")), INT64_MIN);
    ck_assert(lt_pfloat(lt_pdict_get(d, "float"), &x) && x == 1e-3);
    ck_assert(lt_pfloat(lt_pdict_get(d, "scalar"), &x) && x == 1.5);
    ck_assert_str_eq(lt_pstr(lt_pdict_get(d, "str")), "\xc3\xa9\xe2\x82\xac");
    v = lt_pdict_get(d, "bytes");
    ck_assert(v->kind == LT_PBYTES && v->n == 3 && memcmp(v->u.text, "\xff\0a", 3) == 0);
    v = lt_pdict_get(d, "tuple");
    ck_assert(v->kind == LT_PTUPLE && v->n == 4 && integer(v->u.item[3]) == 4);
    v = lt_pdict_get(d, "set");
    ck_assert(v->kind == LT_PSET && v->n == 1);
    ck_assert(element(d, "bool", 0) == 1 && element(d, "bool", 1) == 0);
    ck_assert_str_eq(lt_array_text(lt_parray(lt_pdict_get(d, "text")), 1), "\xc3\xa9");
    ck_assert_int_eq(integer(lt_pdict_get(lt_pdict_get(d, "ordered"), "a")), 1);
    ck_assert_int_eq(integer(lt_pdict_get(lt_pdict_get(d, "default"), "b")->u.item[0]), 2);
    ck_assert(lt_pdict_get(d, "true")->kind == LT_PBOOL && integer(lt_pdict_get(d, "true")) == 1);
    ck_assert(lt_array_has_shape(lt_parray(lt_pdict_get(d, "zero")), 2, (int64_t[]){ 0, 3 }));
    lt_arena_free(arena);
}
END_TEST

START_TEST(damage)
{
    check_truncated(read_pickle, protocols[_i].bytes, protocols[_i].n, 0);
    check_flipped(read_pickle, protocols[_i].bytes, protocols[_i].n, 3000);
}
END_TEST

static size_t from_hex(const char *hex, uint8_t *out)
{
    size_t n = 0;
    unsigned x;

    for (; hex[2 * n] && sscanf(hex + 2 * n, "%2x", &x) == 1; n++)
        out[n] = (uint8_t)x;
    return n;
}

/* data.md 6.3: {'k': float32 [1.5, -2.0]} at protocols 2 and 4 */
START_TEST(spec_vectors)
{
    static const char *const hex[] = {
        "80027d710058010000006b7101636e756d70792e636f72652e6d756c746961727261790a5f7265636f6e7374727563740a"
        "7102636e756d70790a6e6461727261790a71034b00857104635f636f646563730a656e636f64650a710558010000006271"
        "0658060000006c6174696e31710786710852710987710a52710b284b014b0285710c636e756d70790a64747970650a710d"
        "58020000006634710e898887710f527110284b0358010000003c71114e4e4e4affffffff4affffffff4b00747112628968"
        "05580a0000000000c3803f000000c3807113680786711452711574711662732e",
        "80049597000000000000007d948c016b948c156e756d70792e636f72652e6d756c74696172726179948c0c5f7265636f6e"
        "7374727563749493948c056e756d7079948c076e6461727261799493944b0085944301629487945294284b014b02859468"
        "058c0564747970659493948c02663494898887945294284b038c013c944e4e4e4affffffff4affffffff4b007494628943"
        "080000c03f000000c094749462732e",
    };

    for (size_t i = 0; i < LT_COUNT(hex); i++) {
        lt_arena *arena = lt_arena_new();
        uint8_t bytes[512];
        const size_t n = from_hex(hex[i], bytes);
        const lt_pvalue *d;

        check_ok(lt_pickle_parse(arena, "spec", bytes, n, &d));
        ck_assert(lt_parray(lt_pdict_get(d, "k"))->type == LT_ELEM_F4);
        ck_assert(element(d, "k", 0) == 1.5 && element(d, "k", 1) == -2);
        check_truncated(read_pickle, bytes, n, 0);
        check_flipped(read_pickle, bytes, n, 3000);
        lt_arena_free(arena);
    }
}
END_TEST

static void check_matrix(const lt_pvalue *d, const char *key)
{
    static const double want[6] = { 0, 1.5, 0, 2, 0, -3 };
    lt_arena *arena = lt_arena_new();
    lt_array a;

    check_ok(lt_pickle_dense(arena, lt_pdict_get(d, key), &a));
    ck_assert_msg(lt_array_has_shape(&a, 2, (int64_t[]){ 2, 3 }), "%s", key);
    for (size_t i = 0; i < 6; i++)
        ck_assert(lt_array_get(&a, i) == want[i]);
    lt_arena_free(arena);
}

static lt_status read_expressions(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_pvalue *d;
    lt_status st = lt_pickle_parse(arena, "x.pkl", bytes, n, &d);

    for (size_t i = 0; !st && d->kind == LT_PDICT && i < d->n; i++) {
        lt_array a;

        st = lt_pickle_dense(arena, d->u.item[2 * i + 1], &a);
        if (st)
            return lt_error_prefix(st, "x.pkl");
    }
    return st;
}

START_TEST(chumpy_and_scipy)
{
    static const double select[8] = { 0, 1, 3, 4, 6, 7, 9, 10 };
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *d;
    lt_array a;

    check_ok(lt_pickle_parse(arena, "e", pickle_expressions, sizeof(pickle_expressions), &d));
    check_ok(lt_pickle_dense(arena, lt_pdict_get(d, "ch"), &a));
    ck_assert(lt_array_has_shape(&a, 3, (int64_t[]){ 2, 2, 3 }) && lt_array_get(&a, 11) == 11);
    check_ok(lt_pickle_dense(arena, lt_pdict_get(d, "select"), &a));
    ck_assert(lt_array_has_shape(&a, 3, (int64_t[]){ 2, 2, 2 }));
    for (size_t i = 0; i < 8; i++)
        ck_assert(lt_array_get(&a, i) == select[i]);
    check_ok(lt_pickle_dense(arena, lt_pdict_get(d, "turned"), &a));
    ck_assert(lt_array_has_shape(&a, 3, (int64_t[]){ 3, 2, 2 }));
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < 4; i++)
            ck_assert(lt_array_get(&a, 4 * k + i) == (double)(3 * i + k));
    check_matrix(d, "csc");
    check_matrix(d, "csr");
    check_matrix(d, "coo");
    check_error(lt_pickle_dense(arena, d, &a), LT_EFORMAT, "no array");
    check_truncated(read_expressions, pickle_expressions, sizeof(pickle_expressions), 0);
    check_flipped(read_expressions, pickle_expressions, sizeof(pickle_expressions), 5000);
    lt_arena_free(arena);
}
END_TEST

static lt_status read_resaved(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    const lt_pvalue *d;
    lt_array a;
    lt_status st = lt_pickle_parse(arena, "x.pkl", bytes, n, &d);

    for (size_t i = 0; !st && d->kind == LT_PDICT && i < d->n; i++)
        if (d->u.item[2 * i + 1]->kind != LT_PDICT)
            st = lt_pickle_dense(arena, d->u.item[2 * i + 1], &a);
    return st ? lt_error_prefix(st, "x.pkl") : LT_OK;
}

/* One matrix in each of SciPy's formats under each of its names, as a numpy.matrix, of objects, in lists; and beside it
 * what nobody needs. */
START_TEST(saved_again)
{
    static const double want[24] = { [1] = 1.5, [6] = 2, [8] = -3, [17] = 0.25, [22] = 7 };
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *d, *beside, *loop;
    lt_array a;

    check_ok(lt_pickle_parse(arena, "r", resaved_pickle, sizeof(resaved_pickle), &d));
    for (size_t i = 0; i + 1 < d->n; i++) {
        const char *key = lt_pstr(d->u.item[2 * i]);

        ck_assert_msg(lt_pickle_dense(arena, d->u.item[2 * i + 1], &a) == LT_OK, "%s: %s", key, lt_last_error());
        ck_assert_msg(lt_array_has_shape(&a, 2, (int64_t[]){ 4, 6 }), "%s", key);
        for (size_t k = 0; k < 24; k++)
            ck_assert_msg(lt_array_get(&a, k) == want[k], "%s[%zu] is %g, want %g", key, k, lt_array_get(&a, k),
                          want[k]);
    }
    beside = lt_pdict_get(d, "beside");
    ck_assert_uint_eq(beside->n, 11);
    check_error(lt_pickle_dense(arena, lt_pdict_get(beside, "unknown"), &a), LT_EFORMAT, "an object of config.Config");
    check_error(lt_pickle_dense(arena, lt_pdict_get(beside, "complex_array"), &a), LT_EFORMAT,
                "an object of numpy.ndarray whose elements are complex numbers, no array of numbers");
    check_error(lt_pickle_dense(arena, lt_pdict_get(beside, "dates"), &a), LT_EFORMAT, "elements are of a type that");
    loop = lt_pdict_get(beside, "loop");                        /* itself is cut out of it */
    ck_assert(lt_pis_none(lt_pdict_get(lt_pdict_get(loop->u.object.state, "child"), "parent")));
    check_truncated(read_resaved, resaved_pickle, sizeof(resaved_pickle), 0);
    check_flipped(read_resaved, resaved_pickle, sizeof(resaved_pickle), 3000);
    lt_arena_free(arena);
}
END_TEST

/* What would run a command in Python is an object of that name here, and its arguments are not kept. */
START_TEST(never_executes)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
    } evil[] = {
        { pickle_evil_0, sizeof(pickle_evil_0) }, { pickle_evil_2, sizeof(pickle_evil_2) },
        { pickle_evil_4, sizeof(pickle_evil_4) },
    };
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *v;

    for (size_t i = 0; i < LT_COUNT(evil); i++) {
        check_ok(lt_pickle_parse(arena, "x.pkl", evil[i].bytes, evil[i].n, &v));
        ck_assert_int_eq(v->kind, LT_POBJECT);
        ck_assert_str_eq(v->u.object.class_name, "posix.system");
        ck_assert(!v->u.object.state && !v->items);
    }
    check_refused(read_pickle, pickle_loop, sizeof(pickle_loop), "contains itself");
    check_ok(lt_pickle_parse(arena, "x.pkl", pickle_objects, sizeof(pickle_objects), &v));
    ck_assert(v->kind == LT_PLIST && v->n == 2 && lt_pis_none(v->u.item[0]) && integer(v->u.item[1]) == 1);
    lt_arena_free(arena);
}
END_TEST

#define RAW(text, reason) { text, sizeof(text) - 1, reason }

START_TEST(refusals)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        RAW(".", "empty stack"), RAW("\x80\x09N.", "protocol 9"),
        RAW("(o.", "an object of no class"), RAW("(N]o.", "calls what is no class"), RAW("ios\nsystem\n.", "no mark"),
        RAW("P1\n.", "names something outside"), RAW("\x82\x01.", "EXT: a class"), RAW("\x97.", "NEXT_BUFFER"),
        RAW("NNR.", "calls what is no class"), RAW("cnumpy\ndtype\nNR.", "calls numpy.dtype with what is no tuple"),
        RAW("N)\x81.", "calls what is no class"), RAW("cnumpy\ndtype\n)R.", "numpy.dtype"),
        RAW("]Nb.", "gives a state"), RAW("NNb.", "gives a state"),
        RAW("cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR.", "never given"),
        RAW("cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntRNb.", "not one"),
        RAW("NNa.", "no list"), RAW("NNNs.", "no dict"), RAW("](NNu.", "no dict"), RAW("}(Nu.", "no value"),
        RAW("}(Ne.", "no list"), RAW("](N\x90.", "no set"), RAW("(Nd.", "no value"), RAW("e.", "no mark"),
        RAW("h\5.", "never stored"), RAW("g99999999999999999999\n.", "no number"), RAW("g-1\n.", "no number"),
        RAW("Nr\xff\xff\xff\x7f.", "beyond any"), RAW("X\xff\xff\xff\xffx", "ends early"),
        RAW("\x8d\xff\xff\xff\xff\xff\xff\xff\xff.", "ends early"),
        RAW("\x8b\xff\xff\xff\xff.", "ends early"), RAW("Ix\n.", "not an integer"), RAW("I-\n.", "not an integer"),
        RAW("IL\n.", "not an integer"), RAW("Fnought\n.", "not a number"),
        RAW("Sx\n.", "without quotes"), RAW("S'\\q'\n.", "escape"), RAW("V\\ud800\n.", "none"),
        RAW("\x85.", "empty stack"), RAW("N(\x86.", "empty stack"), RAW("(0.", "empty stack"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_pickle, cases[i].bytes, cases[i].n, cases[i].reason);
}
END_TEST

START_TEST(small_ones)
{
    static const struct {
        const char *bytes;
        int64_t want;
    } cases[] = {
        { "I01\n.", 1 }, { "I00\n.", 0 }, { "L-12L\n.", -12 }, { "N0I7\n.", 7 }, { "(NN1I7\n.", 7 },
        { "I7\n2\x85.", 7 }, { "I7\np3\n0g3\n.", 7 }, { "\x8a\x01\xff.", -1 },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *v;

        check_ok(lt_pickle_parse(arena, "s", (const uint8_t *)cases[i].bytes, strlen(cases[i].bytes), &v));
        if (v->kind == LT_PTUPLE)
            v = v->u.item[0];
        ck_assert_int_eq(integer(v), cases[i].want);
        lt_arena_free(arena);
    }
}
END_TEST

/* What turns a pickle into a program elsewhere, by every opcode that could: a name, and an object of that name. */
START_TEST(programs)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *name;
    } cases[] = {
        RAW("cposix\nsystem\n(X\2\0\0\0lstR.", "posix.system"), RAW("cnt\nsystem\n.", "nt.system"),
        RAW("csubprocess\nPopen\n(]tR.", "subprocess.Popen"), RAW("(S'ls'\nios\nsystem\n.", "os.system"),
        RAW("(cos\nsystem\nS'ls'\no.", "os.system"), RAW("cos\nsystem\n(S'ls'\nt}(S'a'\nNu\x92.", "os.system"),
        RAW("c__builtin__\nexec\n(S'1'\ntR.", "__builtin__.exec"),
        RAW("cbuiltins\neval\n(S'1'\nt\x81.", "builtins.eval"),
        RAW("cbuiltins\n__import__\n(S'os'\ntR.", "builtins.__import__"),
        RAW("cbuiltins\nopen\n(S'/etc/passwd'\ntR.", "builtins.open"),
        RAW("cbuiltins\ngetattr\n(Nt(Nt0RN\x85R.", "builtins.getattr"),
        RAW("cfunctools\npartial\n(cos\nsystem\ntR(S'ls'\ntR.", "functools.partial"),
        RAW("coperator\nmethodcaller\n(S'x'\ntR.", "operator.methodcaller"),
        RAW("cpickle\nloads\n(C\1.tR.", "pickle.loads"),
        RAW("ctorch\nload\n(S'x'\ntR.", "torch.load"), RAW("cnumpy\nload\n(S'x'\ntR.", "numpy.load"),
        RAW("cnumpy.testing._private.utils\nrunstring\n(NtR.", "numpy.testing._private.utils.runstring"),
        RAW("\x8c\x08" "builtins\x8c\x04" "eval\x93.", "builtins.eval"),
        RAW("\x8c\x05numpy\x8c\x0c" "dtype.__call\x93.", "numpy.dtype.__call"),
        RAW("ccopyreg\n_reconstructor\n(cos\nsystem\nNNtR.", "os.system"), RAW("chumpy\nCh\n.", "humpy.Ch"),
        RAW("cnumpy\nndarray\n)R.", "numpy.ndarray"), RAW("cnumpy\nfloat32\n(I1\ntR.", "numpy.float32"),
        RAW("cbuiltins\ncomplex\n(F1\nF2\ntR.", "builtins.complex"), RAW("cconfig\nConfig\n)\x81}b.", "config.Config"),
        RAW("\x8a\x09" "123456789.", "builtins.int"), RAW("I99999999999999999999\n.", "builtins.int"),
        RAW("L-99999999999999999999L\n.", "builtins.int"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *v;
        char text[160];
        lt_array a;

        check_ok(lt_pickle_parse(arena, "p", (const uint8_t *)cases[i].bytes, cases[i].n, &v));
        ck_assert(v->kind == LT_POBJECT || v->kind == LT_PCLASS);
        ck_assert_str_eq(v->kind == LT_POBJECT ? v->u.object.class_name : v->u.text, cases[i].name);
        if (v->kind == LT_POBJECT) {
            snprintf(text, sizeof(text), "an object of %s, no array of numbers", cases[i].name);
            check_error(lt_pickle_dense(arena, v, &a), LT_EFORMAT, text);
        }
        lt_arena_free(arena);
    }
}
END_TEST

/* Calls of what is known, with what it does not take: refused where they stand. */
START_TEST(bad_calls)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        RAW("NN\x93.", "offset 2: a class whose name is no text"), RAW("]]R.", "offset 2: calls what is no class"),
        RAW("cnumpy\ndtype\n]R.", "offset 14: calls numpy.dtype"),
        RAW("cchumpy.ch\nCh\n)N\x92.", "offset 16: an object made with what is no dict"),
        RAW("cchumpy.ch\nCh\n)\x81}b}b.", "offset 19: gives an object its state twice"),
        RAW("ccopyreg\n_reconstructor\n(NNNtR.", "copyreg._reconstructor with arguments"),
        RAW("ccollections\nOrderedDict\n(](NeetR.", "adds items to what is no list"),
        RAW("ccollections\nOrderedDict\n(](]etR.", "calls dict with arguments"),
        RAW("c_codecs\nencode\n(X\1\0\0\0aX\3\0\0\0hextR.", "calls _codecs.encode with arguments"),
        RAW("cbuiltins\nint\n(I1\nI2\ntR.", "a builtin type with arguments"),
        RAW("cbuiltins\nstr\n(]tR.", "a builtin type with"), RAW("cbuiltins\nbytes\n(NtR.", "calls bytes with"),
        RAW("cbuiltins\nset\n(NtR.", "calls set with"), RAW("cbuiltins\ndict\n(I1\ntR.", "calls dict with"),
        RAW("cnumpy\nndarray\n", "ends early"), RAW("cnumpy", "offset 0: ends early, in a line"),
        RAW("\x83\1\0.", "offset 0: EXT"), RAW("\x84\1\0\0\0.", "offset 0: EXT"),
        RAW("\x98.", "offset 0: READONLY_BUFFER"), RAW("NQ.", "offset 1: BINPERSID"),
        RAW("cnumpy.core.multiarray\nscalar\n(NNtR.", "numpy scalar with arguments"),
        RAW("cnumpy.core.numeric\n_frombuffer\n(NNNNtR.", "numpy _frombuffer with arguments"),
        RAW("\x80", "offset 0: ends early"), RAW("\x95\0\0\0", "offset 0: ends early"), RAW("\xff", "opcode 0xff"),
        RAW("N{", "offset 1: opcode 0x7b is not one that is read"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        check_refused(read_pickle, cases[i].bytes, cases[i].n, cases[i].reason);
        ck_assert_ptr_nonnull(strstr(lt_last_error(), "offset "));
    }
}
END_TEST

START_TEST(other_files)
{
    check_refused(read_pickle, "<html>", 6, "x.pkl: an HTML page in the place of a file, want a pickle of Python");
    check_refused(read_pickle, "version https://git-lfs.github.com/spec/v1\n", 43, "x.pkl: a git-lfs pointer");
    check_refused(read_pickle, "", 0, "x.pkl: an empty file");
    check_refused(read_pickle, "{}", 2, "x.pkl: a JSON file, want a pickle");
    check_refused(read_pickle, "PK\3\4", 4, "x.pkl: a zip archive, want a pickle");
}
END_TEST

/* ---- values by hand ------------------------------------------------------------------------------ */

START_TEST(builtins)
{
    static const struct {
        const char *bytes;
        size_t n;
        lt_pkind kind;
        size_t items;
    } cases[] = {
        { "cbuiltins\nslice\n(I1\nI2\nI3\ntR.", 30, LT_PTUPLE, 3 }, { "cbuiltins\nlist\n)R.", 18, LT_PLIST, 0 },
        { "cbuiltins\nlist\n((I1\nttR.", 24, LT_PLIST, 1 }, { "cbuiltins\ntuple\n(](I1\netR.", 26, LT_PTUPLE, 1 },
        { "cbuiltins\nbytes\n)R.", 19, LT_PBYTES, 0 }, { "cbuiltins\nbytearray\n(U\1atR.", 28, LT_PSTR, 1 },
        { "cbuiltins\nbytearray\n(C\1atR.", 28, LT_PBYTES, 1 },
        { "cbuiltins\nbytearray\n(U\1aU\6latin1tR.", 36, LT_PBYTES, 1 },
        { "cbuiltins\nbytes\n(U\1aU\7latin-1tR.", 33, LT_PBYTES, 1 },
        { "ccollections\nOrderedDict\n(](](U\1aI1\neetR.", 43, LT_PDICT, 1 },
        { "ccollections\ndefaultdict\n(cbuiltins\nlist\ntR.", 45, LT_PDICT, 0 },
        { "cbuiltins\ndict\n(NtR.", 20, LT_PDICT, 0 }, { "cbuiltins\nfrozenset\n)R}b.", 25, LT_PSET, 0 },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *v;
        const lt_status st = lt_pickle_parse(arena, "b", (const uint8_t *)cases[i].bytes, cases[i].n, &v);

        if (i + 1 == LT_COUNT(cases)) {
            ck_assert_ptr_nonnull(strstr(lt_last_error(), "gives a state"));
        } else {
            ck_assert_msg(st == LT_OK, "%zu: %s", i, lt_last_error());
            ck_assert_msg(v->kind == cases[i].kind && v->n == cases[i].items, "%zu", i);
        }
        lt_arena_free(arena);
    }
}
END_TEST

/* Four bytes 0 1 2 3 of a shape, as Python 2 would write the array. */
#define DTYPE "cnumpy\ndtype\n(S'i1'\nI0\nI1\ntR(I3\nS'|'\nNNNI-1\nI-1\nI0\ntb"
#define ARRAY_OF(shape) "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n(" shape \
                        "t" DTYPE "I00\nS'\\x00\\x01\\x02\\x03'\ntb"
#define FOUR ARRAY_OF("I4\n")
#define ARRAY(type, shape, bytes) "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n(" shape \
                        "tcnumpy\ndtype\n(S'" type "'\nI0\nI1\ntR(I3\nS'|'\nNNNI-1\nI-1\nI0\ntbI00\nS'" bytes "'\ntb"
#define THREE ARRAY("i1", "I3\n", "\\x00\\x01\\x02")
#define MINUS ARRAY("i1", "I4\n", "\\xff\\x01\\x02\\x03")
#define DOWN ARRAY("i1", "I4\n", "\\x00\\x02\\x01\\x03")
#define ONE_0 ARRAY("i1", "I1\n", "\\x00")
#define ZERO_ONE ARRAY("i1", "I2\n", "\\x00\\x01")
#define WORDS ARRAY("S1", "I4\n", "abcd")
#define OBJECT(module, name, state) "c" module "\n" name "\n)\x81}(" state "ub"
#define DICT(value) { "}S'v'\n" value "s.", sizeof("}S'v'\n" value "s.") - 1
#define SELECT(state) OBJECT("chumpy.reordering", "Select", "S'a'\n" FOUR state)
#define NEST "cchumpy.ch\nCh\n)\x81}(S'x'\ncchumpy.ch\nCh\n)\x81}(S'x'\ncchumpy.ch\nCh\n)\x81}(S'x'\n" \
             "cchumpy.ch\nCh\n)\x81}(S'x'\n"
#define UNNEST "ubububub"
#define TURN(axes) OBJECT("chumpy.reordering", "transpose", "S'a'\n" ARRAY_OF("I2\nI2\n") "S'axes'\n" axes)
#define SPARSE(kind, state) OBJECT("scipy.sparse." kind, kind "_matrix", state)

START_TEST(dense_by_hand)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        DICT(FOUR), NULL }, DICT("N"), "no array of numbers" }, DICT("]"), "no array of numbers" },
        DICT(OBJECT("chumpy.ch", "Ch", "S'x'\n" FOUR)), NULL }, DICT(OBJECT("chumpy.ch", "Ch", "")), "no array" },
        DICT(SELECT("")), "without an array idxs" }, DICT(SELECT("S'idxs'\n" FOUR)), NULL },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n(I2\nI2\nt")), NULL },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n" FOUR)), "does not fit its elements" },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n(I3\nt")), "does not fit its elements" },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n(I-2\nI-2\nt")), "does not fit its elements" },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n(S'x'\nt")), "does not fit its elements" },
        DICT(OBJECT("chumpy.reordering", "Select", "S'a'\n" ARRAY_OF("I4\nI1\n") "S'idxs'\n" FOUR)), NULL },
        DICT(OBJECT("chumpy.reordering", "Reshape", "S'a'\n" FOUR "S'newshape'\n](I2\nI2\ne")), NULL },
        DICT(OBJECT("chumpy.reordering", "Reshape", "S'a'\n" FOUR)), "does not fit its elements" },
        DICT(TURN("N")), NULL }, DICT(TURN("(I1\nI0\nt")), NULL }, DICT(TURN("(I0\nI0\nt")), "no permutation" },
        DICT(TURN("(I2\nI0\nt")), "no permutation" }, DICT(TURN("(I0\nt")), "other axes than its array" },
        DICT(TURN("I1\n")), "other axes than its array" },
        DICT(SPARSE("csc", "S'data'\n" FOUR)), "lacks _shape" },
        DICT(SPARSE("csr", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" FOUR "S'_shape'\n(I2\nt")), "lacks" },
        DICT(SPARSE("csr", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" ARRAY_OF("I2\nI2\n")
                    "S'_shape'\n(I3\nI4\nt")), "lacks" },
        DICT(SPARSE("csr", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" FOUR "S'_shape'\n(I2\nI4\nt")),
        "indptr that does not fit" },
        DICT(SPARSE("csr", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" FOUR "S'_shape'\n(I3\nI4\nt")),
        "indptr that does not fit" },
        DICT(SPARSE("csc", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" FOUR
                    "S'_shape'\n(I999999\nI999999\nt")), "too large when made dense" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" FOUR "S'_shape'\n(I4\nI4\nt")), NULL },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" FOUR "S'_shape'\n(I4\nI3\nt")),
        "index outside" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" FOUR "S'_shape'\n(I3\nI4\nt")),
        "index outside" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'_shape'\n(I3\nI4\nt")), "lacks" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" FOUR "S'_shape'\n(I4\nI9999999\nt")),
        "lacks _shape" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" THREE "S'col'\n" FOUR "S'_shape'\n(I4\nI4\nt")),
        "rows, columns and data of different lengths" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" THREE "S'_shape'\n(I4\nI4\nt")),
        "rows, columns and data of different lengths" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" MINUS "S'col'\n" FOUR "S'_shape'\n(I4\nI4\nt")),
        "index outside" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'row'\n" FOUR "S'col'\n" MINUS "S'_shape'\n(I4\nI4\nt")),
        "index outside" },
        DICT(SPARSE("coo", "S'data'\n" WORDS "S'row'\n" FOUR "S'col'\n" FOUR "S'_shape'\n(I4\nI4\nt")), "lacks" },
        DICT(SPARSE("csr", "S'data'\n" THREE "S'indices'\n" FOUR "S'indptr'\n" FOUR "S'_shape'\n(I3\nI4\nt")),
        "indptr that does not fit" },
        DICT(SPARSE("csr", "S'data'\n" THREE "S'indices'\n" THREE "S'indptr'\n" FOUR "S'_shape'\n(I3\nI4\nt")), NULL },
        DICT(SPARSE("csr", "S'data'\n" THREE "S'indices'\n" THREE "S'indptr'\n" DOWN "S'_shape'\n(I3\nI4\nt")),
        "indptr that is not ascending" },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'coords'\n(" FOUR FOUR "tS'_shape'\n(I4\nI4\nt")), NULL },
        DICT(SPARSE("coo", "S'data'\n" FOUR "S'coords'\n(" FOUR "tS'_shape'\n(I4\nI4\nt")), "lacks data, rows or" },
        DICT(SPARSE("bsr", "S'data'\n" FOUR "S'indices'\n" FOUR "S'indptr'\n" FOUR "S'_shape'\n(I4\nI4\nt")), "lacks" },
        DICT(SPARSE("bsr", "S'data'\n" ARRAY_OF("I1\nI2\nI2\n") "S'indices'\n" ONE_0 "S'indptr'\n" ZERO_ONE
                    "S'_shape'\n(I2\nI3\nt")), "blocks that do not fit" },
        DICT(SPARSE("bsr", "S'data'\n" ARRAY_OF("I1\nI2\nI2\n") "S'indices'\n" ONE_0 "S'indptr'\n" ZERO_ONE
                    "S'_shape'\n(I2\nI4\nt")), NULL },
        DICT(SPARSE("dia", "S'data'\n" ARRAY_OF("I1\nI4\n") "S'offsets'\n" FOUR "S'_shape'\n(I4\nI4\nt")),
        "diagonals" },
        DICT(SPARSE("dia", "S'data'\n" ARRAY_OF("I4\nI1\n") "S'offsets'\n" MINUS "S'_shape'\n(I4\nI4\nt")), NULL },
        DICT(SPARSE("dia", "S'data'\n" FOUR "S'offsets'\n" FOUR "S'_shape'\n(I4\nI4\nt")), "lacks data or offsets" },
        DICT(SPARSE("lil", "S'rows'\n](](e](I0\neeS'data'\n](](e](I0\nee" "S'_shape'\n(I2\nI1\nt")), NULL },
        DICT(SPARSE("lil", "S'rows'\n](](eeS'data'\n](](ee" "S'_shape'\n(I2\nI1\nt")), "as many lists as" },
        DICT(SPARSE("lil", "S'rows'\n](](I0\neeS'data'\n](](ee" "S'_shape'\n(I1\nI1\nt")), "different lengths" },
        DICT(SPARSE("lil", "S'rows'\n](](I1\neeS'data'\n](](I1\nee" "S'_shape'\n(I1\nI1\nt")), "index outside" },
        DICT(SPARSE("lil", "S'rows'\n](](NeeS'data'\n](](I1\nee" "S'_shape'\n(I1\nI1\nt")), "no number" },
        DICT(SPARSE("lil", "S'rows'\n](](I0\nI0\neeS'data'\n](](I1\nI1\nee" "S'_shape'\n(I1\nI1\nt")),
        "more elements" },
        DICT(SPARSE("lil", "S'rows'\nNS'data'\n](" "eS'_shape'\n(I1\nI1\nt")), "lacks rows or data" },
        DICT(SPARSE("dok", "S'_dict'\n}((I0\nI0\ntI0\nuS'_shape'\n(I1\nI1\nt")), NULL },
        DICT(SPARSE("dok", "S'_dict'\n}((I0\nI1\ntI0\nuS'_shape'\n(I1\nI1\nt")), "index outside" },
        DICT(SPARSE("dok", "S'_dict'\n}((I0\ntI0\nuS'_shape'\n(I1\nI1\nt")), "whose place is none" },
        DICT(SPARSE("dok", "S'_shape'\n(I1\nI1\nt")), "lacks its dict" },
        DICT("](I1\n](I2\nee"), "rows of one length each" }, DICT("](](I1\ne](I2\nI3\nee"), "rows of one length" },
        DICT("](S'x'\ne"), "a list that is no array of numbers" },
        DICT(SELECT("S'idxs'\n" MINUS)), "chumpy Select: index -1 of 4 elements" },
        DICT(SELECT("S'idxs'\n" WORDS)), "without an array idxs" },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n" WORDS)), "does not fit its elements" },
        DICT(SELECT("S'idxs'\n" FOUR "S'preferred_shape'\n(I1\nI1\nI1\nI1\nI1\nI1\nI1\nI1\nI4\nt")), "does not fit" },
        DICT(OBJECT("chumpy.ch", "Ch", "S'x'\n" WORDS)), "no array of numbers" },
        DICT(NEST NEST NEST NEST FOUR UNNEST UNNEST UNNEST UNNEST), NULL },
        DICT(NEST NEST NEST NEST NEST FOUR UNNEST UNNEST UNNEST UNNEST UNNEST), "nested deeper than 16" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *d;
        lt_array a;

        check_ok(lt_pickle_parse(arena, "d", (const uint8_t *)cases[i].bytes, cases[i].n, &d));
        if (cases[i].reason)
            check_error(lt_pickle_dense(arena, lt_pdict_get(d, "v"), &a), LT_EFORMAT, cases[i].reason);
        else
            ck_assert_msg(lt_pickle_dense(arena, lt_pdict_get(d, "v"), &a) == LT_OK && lt_array_get(&a, 0) == 0,
                          "%zu: %s", i, lt_last_error());
        lt_arena_free(arena);
    }
}
END_TEST

/* What a wanted list of numbers was instead. */
START_TEST(other_kinds)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        RAW("N.", "found None"), RAW("\x88.", "found a bool"), RAW("I7\n.", "found an integer"),
        RAW("F7\n.", "found a number"), RAW("U\1a.", "found text"), RAW("C\1a.", "found bytes"),
        RAW("].", "found a list"), RAW(").", "found a tuple"), RAW("\x8f.", "found a set"), RAW("}.", "found a dict"),
        RAW("cchumpy.ch\nCh\n)\x81.", "found an object"), RAW("cnumpy\nndarray\n.", "found a class"),
        RAW(DTYPE ".", "found a dtype"), RAW(FOUR ".", "found (4)"), RAW(ARRAY_OF("I2\nI2\n") ".", "found (2, 2)"),
        RAW("](" FOUR FOUR "e.", "found a list"), RAW("](S'x'\ne.", "found a list"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *v;
        int64_t whole;
        double x;
        float out[3];

        check_ok(lt_pickle_parse(arena, "k", (const uint8_t *)cases[i].bytes, cases[i].n, &v));
        check_error(lt_pfloats(v, "v", out, 3), LT_EFORMAT, cases[i].reason);
        ck_assert(lt_pint(v, &whole) == (v->kind == LT_PBOOL || v->kind == LT_PINT));
        ck_assert(lt_pfloat(v, &x) == (v->kind == LT_PBOOL || v->kind == LT_PINT || v->kind == LT_PFLOAT));
        ck_assert(!lt_pstr(v) == (v->kind != LT_PSTR) && !lt_parray(v) == (v->kind != LT_PARRAY));
        ck_assert(lt_pis_none(v) == (v->kind == LT_PNONE) && !lt_pdict_get(v, "x"));
        lt_arena_free(arena);
    }
    ck_assert(lt_pis_none(NULL) && !lt_pstr(NULL) && !lt_parray(NULL) && !lt_pdict_get(NULL, "x"));
}
END_TEST

/* Arrays of one element are numbers: whole ones of whole types. */
START_TEST(single_elements)
{
    static const struct {
        const char *type, *bytes;
        bool whole;
    } cases[] = { { "f4", "\\x00\\x00\\x80?", false }, { "i4", "\\x01\\x00\\x00\\x00", true },
                  { "f2", "\\x00<", false },
                  { "f8", "\\x00\\x00\\x00\\x00\\x00\\x00\\xf0?", false }, { "u1", "\\x01", true },
                  { "b1", "\\x01", true }, { "S1", "1", false } };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        const lt_pvalue *v;
        char text[512];
        int64_t whole = 0;
        double x = 0;

        snprintf(text, sizeof(text), "cnumpy.core.multiarray\nscalar\n(cnumpy\ndtype\n(S'%s'\nI0\nI1\ntR(I3\nS'<'\n"
                 "NNNI-1\nI-1\nI0\ntbS'%s'\ntR.", cases[i].type, cases[i].bytes);
        check_ok(lt_pickle_parse(arena, "s", (const uint8_t *)text, strlen(text), &v));
        ck_assert_msg(lt_pint(v, &whole) == cases[i].whole && (!cases[i].whole || whole == 1), "%s", cases[i].type);
        ck_assert(lt_pfloat(v, &x) == (cases[i].type[0] != 'S') && (cases[i].type[0] == 'S' || x == 1));
        ck_assert(!lt_pstr(v) == (cases[i].type[0] != 'S'));
        lt_arena_free(arena);
    }
}
END_TEST

/* Two million truths in a byte each, which are one value or two, and half a million indices in three. */
START_TEST(long_lists)
{
    enum { TRUTHS = 2000000, INDICES = 500000 };
    uint8_t *bytes = malloc(TRUTHS + 16), *p = bytes;
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *v;

    p = (uint8_t *)memcpy(p, "](", 2) + 2;
    for (int i = 0; i < TRUTHS; i++)
        *p++ = i % 3 ? 0x88 : 0x89;
    memcpy(p, "e.", 2);
    check_ok(lt_pickle_parse(arena, "truths", bytes, TRUTHS + 4, &v));
    for (size_t i = 0; i < 6; i++)
        ck_assert(v->u.item[i]->kind == LT_PBOOL && integer(v->u.item[i]) == (i % 3 != 0));
    p = bytes + 2;
    for (int i = 0; i < INDICES; i++)
        p = (uint8_t *)memcpy(p, "M\1\1", 3) + 3;
    memcpy(p, "e.", 2);
    check_ok(lt_pickle_parse(arena, "indices", bytes, 3 * INDICES + 4, &v));
    ck_assert(v->n == INDICES && integer(v->u.item[INDICES - 1]) == 257);
    lt_arena_free(arena);
    free(bytes);
}
END_TEST

/* Lists in each other, and marks, ten thousand and four million: no recursion, and a limit. */
START_TEST(deep)
{
    static const size_t sizes[] = { 10000, 4000000 };
    static const char *const reasons[] = { "nested deeper than 64", "asks for more memory" };
    const size_t n = sizes[_i];
    uint8_t *bytes = malloc(2 * n);

    memset(bytes, ']', n);
    memset(bytes + n, 'a', n - 1);
    bytes[2 * n - 1] = '.';
    check_refused(read_pickle, bytes, 2 * n, reasons[_i]);
    memset(bytes, '(', n);
    memset(bytes + n, 't', n - 1);
    check_refused(read_pickle, bytes, 2 * n, reasons[_i]);
    memset(bytes, '(', 2 * n);
    check_refused(read_pickle, bytes, 2 * n, "ends early");
    free(bytes);
}
END_TEST

/* Each list holds the one before twice: 2^60 leaves in 544 bytes. Reading it is linear, and a walk
 * that looks for numbers ends. */
START_TEST(shared)
{
    uint8_t bytes[544] = { ']', 'q', 0 };
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *v;
    size_t n = 3;
    float out[4];

    for (uint8_t i = 0; i < 60; i++) {
        const uint8_t step[] = { '0', '(', 'h', i, 'h', i, 'l', 'q', (uint8_t)(i + 1) };

        memcpy(bytes + n, step, sizeof(step));
        n += sizeof(step);
    }
    bytes[n++] = '.';
    ck_assert_uint_eq(n, sizeof(bytes));
    check_ok(lt_pickle_parse(arena, "shared", bytes, n, &v));
    check_error(lt_pfloats(v, "v", out, 4), LT_EFORMAT, "v: want 4 numbers, found a list");
    lt_arena_free(arena);
}
END_TEST

/* One megabyte of bytes, memoised, then copied into list after list: memory is bounded by the file. */
START_TEST(amplified)
{
    const size_t data = 1 << 20, copies = 20000;
    uint8_t *bytes = malloc(data * 2 + copies * 64), *p = bytes;

    *p++ = '(';
    memset(p, 'N', data);
    p += data;
    p = (uint8_t *)memcpy(p, "lq\0(", 4) + 4;
    for (size_t i = 0; i < copies; i++)
        p = (uint8_t *)memcpy(p, "c__builtin__\nlist\n(h\0tR", 23) + 23;
    p = (uint8_t *)memcpy(p, "l.", 2) + 2;
    check_refused(read_pickle, bytes, (size_t)(p - bytes), "asks for more memory");
    free(bytes);
}
END_TEST

START_TEST(numbers_of_any_shape)
{
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *v;
    float out[5];

    check_ok(lt_pickle_parse(arena, "n", (const uint8_t *)"(](F1\nI2\ne](I01\nF4\net.", 23, &v));
    check_ok(lt_pfloats(v, "box", out, 4));
    ck_assert(out[0] == 1 && out[1] == 2 && out[2] == 1 && out[3] == 4);
    check_error(lt_pfloats(v, "box", out, 3), LT_EFORMAT, "box: want 3 numbers, found a tuple");
    check_error(lt_pfloats(v, "box", out, 5), LT_EFORMAT, "box: want 5 numbers");
    check_error(lt_pfloats(NULL, "box", out, 5), LT_EFORMAT, "box: missing");
    check_ok(lt_pickle_parse(arena, "n", (const uint8_t *)"Finf\n.", 6, &v));
    check_error(lt_pfloats(v, "box", out, 1), LT_EFORMAT, "not finite");
    check_ok(lt_pickle_parse(arena, "n", (const uint8_t *)"N.", 2, &v));
    check_error(lt_pfloats(v, "box", out, 1), LT_EFORMAT, "found None");
    lt_arena_free(arena);
}
END_TEST

START_TEST(written)
{
    static const float K[9] = { 600, 0, 320, 0, 600, 240, 0, 0, 1 };
    static const uint8_t contact[3] = { 1, 0, 1 };
    const lt_pwrite corners[] = {
        { .kind = LT_PW_INT, .integer = 255 }, { .kind = LT_PW_INT, .integer = 256 },
        { .kind = LT_PW_INT, .integer = -1 }, { .kind = LT_PW_INT, .integer = INT64_MIN }, { .kind = LT_PW_LIST },
    };
    const lt_pwrite meta[] = {
        { .key = "camMat", .kind = LT_PW_ARRAY, .array = lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ 3, 3 }, K) },
        { .key = "objName", .kind = LT_PW_STR, .text = "003_cracker_box" },
        { .key = "handPose", .kind = LT_PW_NONE },
        { .key = "depth", .kind = LT_PW_FLOAT, .number = -0.25 },
        { .key = "corners", .kind = LT_PW_LIST, .item = corners, .n_items = LT_COUNT(corners) },
        { .key = "contact", .kind = LT_PW_ARRAY, .array = lt_array_make(LT_ELEM_BOOL, 1, (int64_t[]){ 3 }, contact) },
        { .key = "none", .kind = LT_PW_ARRAY, .array = lt_array_make(LT_ELEM_F8, 2, (int64_t[]){ 0, 3 }, NULL) },
    };
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *d, *list;
    double x;

    check_ok(lt_pickle_write_dict(in_folder("meta.pkl"), meta, LT_COUNT(meta)));
    check_ok(lt_pickle_read(arena, in_folder("meta.pkl"), &d));
    ck_assert_uint_eq(d->n, LT_COUNT(meta));
    ck_assert(lt_parray(lt_pdict_get(d, "camMat"))->type == LT_ELEM_F4 && element(d, "camMat", 5) == 240);
    ck_assert_str_eq(lt_pstr(lt_pdict_get(d, "objName")), "003_cracker_box");
    ck_assert(lt_pis_none(lt_pdict_get(d, "handPose")));
    ck_assert(lt_pfloat(lt_pdict_get(d, "depth"), &x) && x == -0.25);
    list = lt_pdict_get(d, "corners");
    ck_assert_uint_eq(list->n, 5);
    for (size_t i = 0; i < 4; i++)
        ck_assert_int_eq(integer(list->u.item[i]), corners[i].integer);
    ck_assert(lt_parray(lt_pdict_get(d, "contact"))->type == LT_ELEM_BOOL && element(d, "contact", 2) == 1);
    ck_assert(lt_array_has_shape(lt_parray(lt_pdict_get(d, "none")), 2, (int64_t[]){ 0, 3 }));
    check_error(lt_pickle_write_dict(in_folder("no.pkl"), &(lt_pwrite){ .key = "h", .kind = LT_PW_ARRAY,
                .array = lt_array_make(LT_ELEM_BF16, 0, NULL, K) }, 1), LT_EINVAL, "\"h\": an array of bf16");
    ck_assert(!exists(in_folder("no.pkl")));
    lt_arena_free(arena);
}
END_TEST

START_TEST(not_written)
{
    lt_pwrite nest[LT_PICKLE_DEPTH] = { { 0 } };
    const lt_pwrite large[] = {
        { .key = "a", .kind = LT_PW_ARRAY,
          .array = lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ 1 << 20, 1 << 20 }, nest) },
        { .key = "a", .kind = LT_PW_ARRAY, .array = lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ -1 }, nest) },
    };
    const char *path = in_folder("not.pkl");

    for (int i = 0; i < LT_PICKLE_DEPTH; i++)
        nest[i] = (lt_pwrite){ .key = "l", .kind = LT_PW_LIST, .item = nest + i + 1, .n_items = 1 };
    nest[LT_PICKLE_DEPTH - 1].n_items = 0;
    check_error(lt_pickle_write_dict(path, nest, 1), LT_EINVAL, "not.pkl: \"l\": lists nested too deep");
    for (size_t i = 0; i < LT_COUNT(large); i++)
        check_error(lt_pickle_write_dict(path, &large[i], 1), LT_EINVAL, "not.pkl: \"a\": array of over 4 GiB");
    ck_assert(!exists(path));
}
END_TEST

START_TEST(without_memory)
{
    ck_assert_int_gt(check_without_memory(read_pickle, pickle_2, sizeof(pickle_2)), 0);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, every_protocol, 0, LT_COUNT(protocols));
    tcase_add_loop_test(tc, damage, 0, LT_COUNT(protocols));
    tcase_add_test(tc, spec_vectors);
    tcase_add_test(tc, chumpy_and_scipy);
    tcase_add_test(tc, saved_again);
    tcase_add_test(tc, never_executes);
    tcase_add_test(tc, refusals);
    tcase_add_test(tc, other_files);
    tcase_add_test(tc, small_ones);
    tcase_add_test(tc, programs);
    tcase_add_test(tc, bad_calls);
    tcase_add_test(tc, builtins);
    tcase_add_test(tc, dense_by_hand);
    tcase_add_test(tc, other_kinds);
    tcase_add_test(tc, single_elements);
    tcase_add_test(tc, long_lists);
    tcase_add_loop_test(tc, deep, 0, 2);
    tcase_add_test(tc, shared);
    tcase_add_test(tc, amplified);
    tcase_add_test(tc, numbers_of_any_shape);
    tcase_add_test(tc, written);
    tcase_add_test(tc, not_written);
    tcase_add_test(tc, without_memory);
}

int main(void)
{
    return run_suite("pickle", add_tests);
}
