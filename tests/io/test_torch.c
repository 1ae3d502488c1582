/* SPDX-License-Identifier: Apache-2.0 */
/* PyTorch's checkpoints: what it wrote in each of its containers, and what nobody should have written. */
#include "libtensor/io/torch/torch.h"
#include "libtensor/io/torch/weights_file.h"
#include "tests/io/hostile.h"
#include "tests/io/torch_vectors.h"

static lt_status read_torch(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_torch_file f;

    return lt_torch_parse(arena, "x.pth", bytes, n, &f);
}

#define FILE_OF(name, kind) { name, sizeof(name), kind }

static const struct {
    const uint8_t *bytes;
    size_t n;
    lt_torch_container container;
} everything[] = { FILE_OF(torch_zip, LT_TORCH_ZIP), FILE_OF(torch_stream, LT_TORCH_STREAM) };

static const lt_array *find(const lt_torch_file *f, const char *name)
{
    for (size_t i = 0; i < f->n; i++)
        if (strcmp(f->entry[i].name, name) == 0)
            return &f->entry[i].array;
    return NULL;
}

static void check_array(const lt_torch_file *f, const char *name, lt_elem type, int rank, const int64_t *shape,
                        const double *want)
{
    const lt_array *a = find(f, name);

    ck_assert_msg(a != NULL, "%s is not there", name);
    ck_assert_msg(a->type == type && lt_array_has_shape(a, rank, shape), "%s", name);
    for (size_t i = 0; i < lt_array_count(a); i++)
        ck_assert_msg(lt_array_get(a, i) == want[i], "%s[%zu] is %g, want %g", name, i, lt_array_get(a, i), want[i]);
}

#define SHAPE(...) (int)(sizeof((int64_t[]){ __VA_ARGS__ }) / 8), (int64_t[]){ __VA_ARGS__ }
#define VALUES(...) (double[]){ __VA_ARGS__ }

START_TEST(each_type_and_stride)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", everything[_i].bytes, everything[_i].n, &f));
    ck_assert(f.container == everything[_i].container);
    ck_assert_uint_eq(f.n, 17);
    check_array(&f, "float", LT_ELEM_F4, SHAPE(12), VALUES(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
    check_array(&f, "turned", LT_ELEM_F4, SHAPE(3, 2), VALUES(0, 3, 1, 4, 2, 5));
    check_array(&f, "window", LT_ELEM_F4, SHAPE(2, 2), VALUES(4, 5, 6, 7));
    check_array(&f, "every_third", LT_ELEM_F4, SHAPE(4), VALUES(1, 4, 7, 10));
    check_array(&f, "double", LT_ELEM_F8, SHAPE(2), VALUES(1.5, -2));
    check_array(&f, "half", LT_ELEM_F2, SHAPE(4), VALUES(1, -2.5, 0.0999755859375, 65504));
    check_array(&f, "bfloat", LT_ELEM_BF16, SHAPE(3), VALUES(1, -2.5, 0.10009765625));
    check_array(&f, "long", LT_ELEM_I8, SHAPE(2), VALUES(-1, 1099511627776));
    check_array(&f, "int", LT_ELEM_I4, SHAPE(1), VALUES(-7));
    check_array(&f, "short", LT_ELEM_I2, SHAPE(1), VALUES(-300));
    check_array(&f, "char", LT_ELEM_I1, SHAPE(1), VALUES(-5));
    check_array(&f, "byte", LT_ELEM_U1, SHAPE(1), VALUES(200));
    check_array(&f, "bool", LT_ELEM_BOOL, SHAPE(2), VALUES(1, 0));
    check_array(&f, "scalar", LT_ELEM_F4, 0, NULL, VALUES(3.25));
    check_array(&f, "empty", LT_ELEM_F4, SHAPE(0, 4), NULL);
    check_array(&f, "expanded", LT_ELEM_F4, SHAPE(2, 3), VALUES(2, 2, 2, 3, 3, 3));
    check_array(&f, "parameter", LT_ELEM_F4, SHAPE(1), VALUES(9));
    lt_arena_free(arena);
}
END_TEST

/* torch_zip with another name for its "archive/" */
static lt_status read_renamed(lt_arena *arena, const char *name, lt_torch_file *out)
{
    static const char old[] = "archive/";
    const size_t n = sizeof(old) - 1;
    uint8_t *bytes = lt_arena_alloc(arena, sizeof(torch_zip));

    ck_assert_uint_eq(strlen(name), n);
    memcpy(bytes, torch_zip, sizeof(torch_zip));
    for (size_t i = 0; i + n <= sizeof(torch_zip); i++)
        if (!memcmp(bytes + i, old, n))
            memcpy(bytes + i, name, n);
    return lt_torch_parse(arena, "x.pth", bytes, sizeof(torch_zip), out);
}

/* PyTorch calls the folder in the archive as the file was called: "e=3 (1).pth" */
START_TEST(names_of_folders)
{
    static const char *const yes[] = { "e=3 (1)/", "/rchive/", "C:chive/", "..ch.../" };
    static const char *const no[] = { "arc\tive/", "arc\177ive/", "arc\nive/", "arch\303\244e/" };
    static const char *const outside[] = { "../hive/", "a/../ve/", "./ar/../", "arc\\ive/" };
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    for (size_t i = 0; i < LT_COUNT(yes); i++) {
        check_ok(read_renamed(arena, yes[i], &f));
        check_array(&f, "turned", LT_ELEM_F4, SHAPE(3, 2), VALUES(0, 3, 1, 4, 2, 5));
    }
    for (size_t i = 0; i < LT_COUNT(no); i++)
        check_error(read_renamed(arena, no[i], &f), LT_EFORMAT, "entry whose name is not made of printable");
    for (size_t i = 0; i < LT_COUNT(outside); i++)
        check_error(read_renamed(arena, outside[i], &f), LT_EFORMAT, "entry whose name is no path inside");
    lt_arena_free(arena);
}
END_TEST

START_TEST(before_0_1_10)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", torch_tar, sizeof(torch_tar), &f));
    ck_assert(f.container == LT_TORCH_TAR);
    ck_assert_uint_eq(f.n, 3);
    check_array(&f, "x", LT_ELEM_F4, SHAPE(3, 2), VALUES(0, 3, 1, 4, 2, 5));
    check_array(&f, "y", LT_ELEM_I8, SHAPE(2), VALUES(7, 8));
    check_array(&f, "z", LT_ELEM_F4, SHAPE(2), VALUES(3, 4));
    lt_arena_free(arena);
}
END_TEST

START_TEST(state_dict_within)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;
    double x;

    check_ok(lt_torch_parse(arena, "x.pth", torch_wrapped, sizeof(torch_wrapped), &f));
    ck_assert_uint_eq(f.n, 4);
    check_array(&f, "state_dict.module.fc.weight", LT_ELEM_F4, SHAPE(1, 2), VALUES(1, 2));
    ck_assert_str_eq(f.entry[0].name + f.within[0], "module.fc.weight");
    check_array(&f, "best", LT_ELEM_F4, 0, NULL, VALUES(0.5));
    check_array(&f, "np", LT_ELEM_F8, 0, NULL, VALUES(2.5));
    check_array(&f, "optimizer.state.0.step", LT_ELEM_F4, 0, NULL, VALUES(1));
    ck_assert(lt_pfloat(lt_pdict_get(f.value, "best"), &x) && x == 0.5);
    ck_assert_str_eq(lt_pdict_get(f.value, "args")->u.object.class_name, "argparse.Namespace");
    lt_arena_free(arena);
}
END_TEST

/* A pickled module, as YOLOv8's files are: names as state_dict() gives them, what is not kept left out. */
START_TEST(whole_module)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
    } files[] = { { torch_module, sizeof(torch_module) }, { torch_module_stream, sizeof(torch_module_stream) } };
    static const char *const names[] = {
        "model.0.conv.weight", "model.0.bn.weight", "model.0.bn.bias", "model.0.bn.running_mean",
        "model.0.bn.running_var", "model.0.bn.num_batches_tracked",
    };
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pt", files[_i].bytes, files[_i].n, &f));
    ck_assert_uint_eq(f.n, LT_COUNT(names));
    for (size_t i = 0; i < f.n; i++) {
        ck_assert_str_eq(f.entry[i].name, names[i]);
        ck_assert_uint_eq(f.within[i], strlen("model."));
    }
    check_array(&f, "model.0.conv.weight", LT_ELEM_F2, SHAPE(2, 1, 1, 1), VALUES(0.5, 0.5));
    check_array(&f, "model.0.bn.running_var", LT_ELEM_F2, SHAPE(2), VALUES(1, 1));
    check_array(&f, "model.0.bn.num_batches_tracked", LT_ELEM_I8, 0, NULL, VALUES(0));
    lt_arena_free(arena);
}
END_TEST

START_TEST(big_endian)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pth", torch_other_order, sizeof(torch_other_order), &f));
    check_array(&f, "x", LT_ELEM_F4, SHAPE(2), VALUES(1.5, -2));
    check_array(&f, "n", LT_ELEM_I8, SHAPE(1), VALUES(258));
    lt_arena_free(arena);
}
END_TEST

START_TEST(from_a_file)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    put_file(in_folder("x.pth"), torch_zip, sizeof(torch_zip));
    check_ok(lt_torch_read(arena, in_folder("x.pth"), &f));
    ck_assert_uint_eq(f.n, 17);
    check_error(lt_torch_read(arena, in_folder("none.pth"), &f), LT_EIO, "No such file");
    lt_arena_free(arena);
}
END_TEST

/* What people have in the place of weights: none of it is a safetensors file with a strange length. */
START_TEST(no_weights)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
#define CASE(text, reason) { text, sizeof(text) - 1, reason }
        CASE("", "w.pth: an empty file, want safetensors, .npz or a checkpoint of PyTorch; did its download fail?"),
        CASE("\n <!DOCTYPE html><html>", "w.pth: an HTML page"),
        CASE("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n", "w.pth: a git-lfs pointer"),
        CASE("\x80\4\x95\x0b\0\0\0\0\0\0\0}.", "w.pth: a plain pickle"), CASE("\x80\2}.", "w.pth: a plain pickle"),
        CASE("\x80\2\0\0\0\0\0\0{}", "a safetensors file that is cut short: header of 640 bytes in a file of 10"),
        CASE("<html", "w.pth: an HTML page"), CASE("<htm", "not a safetensors file"),
#undef CASE
    };
    lt_arena *arena = lt_arena_new();
    lt_weights_file w;

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        put_file(in_folder("w.pth"), cases[i].bytes, cases[i].n);
        check_error(lt_weights_read(arena, in_folder("w.pth"), &w), LT_EFORMAT, cases[i].reason);
    }
    lt_arena_free(arena);
}
END_TEST

START_TEST(damage)
{
    static const struct {
        const uint8_t *bytes;
        size_t n, spare;
    } files[] = {
        { torch_zip, sizeof(torch_zip), 0 }, { torch_stream, sizeof(torch_stream), 0 },
        { torch_wrapped, sizeof(torch_wrapped), 0 }, { torch_module, sizeof(torch_module), 0 },
        { torch_module_stream, sizeof(torch_module_stream), 0 }, { torch_other_order, sizeof(torch_other_order), 0 },
        { torch_tar, sizeof(torch_tar), 1024 },         /* zeros up to a tape's block */
    };

    check_truncated(read_torch, files[_i].bytes, files[_i].n, files[_i].spare);
    check_flipped(read_torch, files[_i].bytes, files[_i].n, 10000);
}
END_TEST

/* The tensors of a program's modules, as state_dict() would call them */
START_TEST(torch_script_program)
{
    lt_arena *arena = lt_arena_new();
    lt_torch_file f;

    check_ok(lt_torch_parse(arena, "x.pt", torch_script, sizeof(torch_script), &f));
    ck_assert_int_eq(f.n, 2);
    ck_assert_str_eq(f.entry[0].name, "weight");
    ck_assert_str_eq(f.entry[1].name, "bias");
    ck_assert(lt_array_has_shape(&f.entry[0].array, 2, (int64_t[]){ 1, 1 }));
    lt_arena_free(arena);
}
END_TEST

START_TEST(not_read)
{
    check_refused(read_torch, torch_bomb, sizeof(torch_bomb), "ask for more memory than a file of 747 bytes");
    check_refused(read_torch, "PK\3\4", 4, "x.pth: a zip archive that is cut short");
    check_refused(read_torch, "\x80\2K\1.", 5, "x.pth: a pickle of Python, want a checkpoint of PyTorch");
    check_refused(read_torch, "no", 2, "x.pth: not a checkpoint of PyTorch");
    check_refused(read_torch, "", 0, "x.pth: an empty file");
    check_refused(read_torch, "<html>", 6, "x.pth: an HTML page");
}
END_TEST

/* Of what is not read the file says so, and the rest of it is as good as ever. */
START_TEST(left_closed)
{
    static const struct {
        const uint8_t *bytes;
        size_t n;
        const char *reason;
    } files[] = {
        { torch_sparse, sizeof(torch_sparse), "a tensor of a kind that is not read: sparse_tensor" },
        { torch_complex, sizeof(torch_complex), "torch.ComplexFloatStorage, whose elements are not read" },
    };
    lt_arena *arena = lt_arena_new();

    for (size_t i = 0; i < LT_COUNT(files); i++) {
        lt_torch_file f;

        check_ok(lt_torch_parse(arena, "x.pth", files[i].bytes, files[i].n, &f));
        ck_assert_uint_eq(f.n, 0);
        ck_assert_uint_eq(f.n_refused, 1);
        ck_assert_str_eq(f.refused[0].name, "x");
        ck_assert_str_eq(f.refused[0].reason, files[i].reason);
    }
    lt_arena_free(arena);
}
END_TEST

/* ---- streams that nobody should have written ------------------------------------------------------ */

#define MAGIC "\x80\2\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19."
#define HEAD MAGIC "\x80\2M\xe9\3." "\x80\2}."
#define STORAGE(cls, count) "(X\7\0\0\0storagectorch\n" cls "\nX\1\0\0\0kX\3\0\0\0cpu" count "tQ"
#define REBUILD(storage, rest) "ctorch._utils\n_rebuild_tensor_v2\n(" storage rest "\x89}tR"
#define ONE(storage, rest) "\x80\2" REBUILD(storage, rest) "."
#define KEYS "\x80\2](X\1\0\0\0ke."
#define FOUR "\4\0\0\0\0\0\0\0" "aaaabbbbccccdddd"
#define F4_4 STORAGE("FloatStorage", "K\4")
#define VIEW(view) "(X\7\0\0\0storagectorch\nFloatStorage\nX\1\0\0\0kX\3\0\0\0cpuK\4" view "tQ"
#define V3(cls, count, dtype) "\x80\2ctorch._utils\n_rebuild_tensor_v3\n(" STORAGE(cls, count) \
                              "K\0K\4\x85K\1\x85\x89}" dtype "tR."
#define MARKED(neg) "\x80\2ctorch._utils\n_rebuild_tensor_v2\n(" F4_4 "K\0K\4\x85K\1\x85\x89}}X\3\0\0\0neg" neg "stR."
#define SIXTEEN "\x10\0\0\0\0\0\0\0" "aaaabbbbccccdddd"
#define RAW(text, reason) { text, sizeof(text) - 1, reason }

START_TEST(streams)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") KEYS FOUR, NULL),
        /* a view, an untyped storage, a parameter, one with attributes, what says where and how large */
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\1K\2t"), "K\0K\2\x85K\1\x85") KEYS FOUR, NULL),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\3K\2t"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vNK\2t"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD ONE(VIEW("K\1"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\1K\2t"), "K\0K\3\x85K\1\x85"), "beyond its storage of 2 elements"),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\1t"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\1Nt"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD ONE(VIEW("(X\1\0\0\0vK\5K\0t"), "K\0K\2\x85K\1\x85"), "a view beyond its storage"),
        RAW(HEAD V3("UntypedStorage", "K\x10", "ctorch\nfloat32\n") KEYS SIXTEEN, NULL),
        RAW(HEAD V3("FloatStorage", "K\4", "ctorch\nfloat32\n") KEYS FOUR, NULL),
        RAW(HEAD V3("UntypedStorage", "K\x0f", "ctorch\nfloat32\n"), "over a storage of 15 bytes"),
        RAW(HEAD V3("FloatStorage", "K\4", "ctorch\nint32\n"), "a tensor of i4 over a storage"),
        RAW(HEAD V3("FloatStorage", "K\4", "ctorch\ncomplex64\n") KEYS FOUR, NULL),
        RAW(HEAD V3("FloatStorage", "K\4", "N"), "not made of a storage"),
        RAW(HEAD "\x80\2ctorch._utils\n_rebuild_parameter\n(" REBUILD(F4_4, "K\0K\4\x85K\1\x85") "\x88}tR." KEYS FOUR,
            NULL),
        RAW(HEAD "\x80\2ctorch._tensor\n_rebuild_from_type_v2\n(ctorch._utils\n_rebuild_tensor_v2\nctorch.nn."
            "parameter\nParameter\n(" F4_4 "K\0K\4\x85K\1\x85\x89}t}tR." KEYS FOUR, NULL),
        RAW(HEAD "\x80\2ctorch._tensor\n_rebuild_from_type_v2\n(ctorch\nSize\nctorch.nn.parameter\nParameter\n)}tR.",
            "not made of a storage"),
        RAW(HEAD "\x80\2}(X\1\0\0\0dctorch\ndevice\n(X\3\0\0\0cputRX\1\0\0\0sctorch\nSize\n)\x85R"
            "X\1\0\0\0octypes\nSimpleNamespace\n)\x81}bX\1\0\0\0pcpathlib\nPosixPath\n(X\1\0\0\0xtR"
            "K\7" REBUILD(F4_4, "K\0K\4\x85K\1\x85") "X\1\0\0\0mcaddict\nDict\n)\x81(K\1K\2uK\1K\2s](K\1ea(K\1eu."
            KEYS FOUR, NULL),
        /* what training leaves beside the weights: when, the last losses, a generator's state and a seed */
        RAW(HEAD "\x80\2}(X\1\0\0\0tcdatetime\ndatetime\n(C\1\7cdatetime\ntimezone\n(cdatetime\ntimedelta\n(K\0tRtRtR"
            "X\1\0\0\0dcdatetime\ndate\n(C\1\7tRX\1\0\0\0ocdatetime\ntime\n(C\1\7tRX\1\0\0\0qccollections\ndeque\n"
            "()K\7tR(K\1K\2eX\1\0\0\0s\x8a\x09\1\0\0\0\0\0\0\x80\0X\1\0\0\0b\x8b\x10\0\0\0" "0123456789abcdef\x8a\x09"
            "\1\0\0\0\0\0\0\x80\0K\1u." "\x80\2].", NULL),
        RAW(HEAD "\x80\2cdatetime\nsys\n(tR." "\x80\2].", NULL),
        RAW(HEAD MARKED("\x89") KEYS FOUR, NULL),
        RAW(HEAD MARKED("\x88") KEYS FOUR, NULL),
        RAW(MAGIC "\x80\2M\xea\3.", "version 1002, want 1001"),
        /* what would run elsewhere stays closed, and what nobody knows */
        RAW(HEAD "\x80\2cposix\nsystem\n(X\2\0\0\0lstR." "\x80\2].", NULL),
        RAW(HEAD "\x80\2cbuiltins\neval\n." "\x80\2].", NULL),
        RAW(HEAD "\x80\2ctorch.hub\nload\n(tR(K\1K\2u." "\x80\2].", NULL),
        RAW(HEAD "\x80\2c__main__\nNet\n)\x81}b." "\x80\2].", NULL),
        RAW(HEAD "\x80\2cfunctools\npartial\ncx\nf\n\x85R)R." "\x80\2].", NULL),
        RAW(HEAD ONE(STORAGE("ComplexFloatStorage", "K\2"), "K\0K\2\x85K\1\x85") KEYS
            "\2\0\0\0\0\0\0\0" "aaaabbbbccccdddd", NULL),
        RAW(HEAD ONE(STORAGE("QInt8Storage", "K\4"), "K\0K\4\x85K\1\x85") KEYS "\4\0\0\0\0\0\0\0" "aaaa", NULL),
        RAW(HEAD "\x80\2X\1\0\0\0aQ.", "names something outside the file"),
        RAW(HEAD "\x80\2(X\7\0\0\0storageNNNNtQ.", "without class, key and size"),
        RAW(HEAD ONE("(X\7\0\0\0storagectorch\nFloatStorage\nK\1X\3\0\0\0cpuK\4tQ", "K\0K\4\x85K\1\x85"),
            "class, key and size"),
        RAW(HEAD ONE("(X\7\0\0\0storagecpathlib\nPosixPath\nX\1\0\0\0kX\3\0\0\0cpuK\4tQ", "K\0K\4\x85K\1\x85"),
            "a storage of pathlib.PosixPath, whose elements are not read"),
        RAW(HEAD ONE(STORAGE("NextYearsStorage", "K\4"), "K\0K\4\x85K\1\x85"), "whose elements are not read"),
        RAW(HEAD ONE(STORAGE("FloatStorage", "J\xff\xff\xff\xff"), "K\0K\4\x85K\1\x85"), "class, key and size"),
        RAW(HEAD ONE(F4_4, "K\0K\5\x85K\1\x85"), "an element beyond its storage of 4 elements"),
        RAW(HEAD ONE(F4_4, "K\1K\4\x85K\1\x85"), "an element beyond its storage"),
        RAW(HEAD ONE(F4_4, "K\4K\1\x85K\1\x85"), "an element beyond its storage"),
        RAW(HEAD ONE(F4_4, "K\0K\2\x85K\4\x85"), "an element beyond its storage"),
        RAW(HEAD ONE(F4_4, "J\xff\xff\xff\xffK\4\x85K\1\x85"), "without offset"),
        RAW(HEAD ONE(F4_4, "K\0J\xff\xff\xff\xff\x85K\1\x85"), "negative size"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85J\xff\xff\xff\xff\x85"), "negative size or stride"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85)"), "size and stride for each"),
        RAW(HEAD ONE(F4_4, "K\0NN"), "without offset, and a size"),
        RAW(HEAD ONE(F4_4, "K\0(K\1K\1K\1K\1K\1K\1K\1K\1K\1t(K\1K\1K\1K\1K\1K\1K\1K\1K\1t"), "at most 8"),
        RAW(HEAD ONE(F4_4, "K\0\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f\x85"
                           "\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f\x85"),
            "overflow"),
        RAW(HEAD ONE(F4_4, "\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7fK\4\x85\x8a\x08\0\0\0\0\0\0\0\x40\x85"),
            "strides that overflow"),
        RAW(HEAD ONE("N", "K\0K\4\x85K\1\x85"), "not made of a storage"),
        RAW(HEAD ONE("ctypes\nSimpleNamespace\n)\x81", "K\0K\4\x85K\1\x85"), "not made of a storage"),
        RAW(HEAD "\x80\2ctorch._utils\n_rebuild_tensor_v3\n(NK\0K\4\x85K\1\x85\x89}ctorch\nfloat32\ntR.",
            "not made of a storage"),
        RAW(HEAD "\x80\2ctorch._utils\n_rebuild_parameter\n)R.", "not made of a storage"),
        RAW(HEAD "\x80\2ctorch._tensor\n_rebuild_from_type_v2\n(NNNtR.", "not made of a storage"),
        RAW(HEAD "\x80\2ctorch._tensor\n_rebuild_from_type_v2\n(ctorch._utils\n_rebuild_tensor_v2\nNNNtR.",
            "not made of a storage"),
        RAW(HEAD "\x80\2ctorch\nSize\n)R.", "torch.Size"),
        RAW(HEAD "\x80\2ctorch._utils\n_rebuild_parameter\n(Nt R.", "opcode 0x20"),
        RAW(HEAD "\x80\2ctorch._utils\n_rebuild_parameter\n(NtR.", "not made of a storage"),
        RAW(HEAD "\x80\2ctorch\nSize\n(NtR.", "torch.Size"),
        RAW(HEAD "\x80\2ctorch._tensor\n_rebuild_from_type_v2\n(NNNNtR.", "not made of a storage"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85"), "ends early"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") "\x80\2].", "storage \"k\" is not in the file"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") "\x80\2N.", "no list of storages"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") "\x80\2](Ne.", "key is no text"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") "\x80\2](X\1\0\0\0qe.", "which nothing mentions"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") "\x80\2](X\1\0\0\0kq\1h\1e." FOUR FOUR,
            "storage \"k\" is listed twice"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") KEYS "\5\0\0\0\0\0\0\0" "aaaabbbbccccddddeeee",
            "has 5 elements, its mention at 111 says 4"),
        RAW(HEAD ONE(F4_4, "K\0K\4\x85K\1\x85") KEYS "\4\0\0\0\0\0\0\0" "aaaabbbbccccddd", "does not fit"),
        /* 2.2 GB promised by some hundred bytes */
        RAW(HEAD ONE(STORAGE("FloatStorage", "J\0\x5b\xc8\x20"), "K\0J\0\x5b\xc8\x20\x85K\1\x85") KEYS
            "\0\x5b\xc8\x20\0\0\0\0", "of 550001408 f4 does not fit"),
        /* the same bytes a thousand times over */
        RAW(HEAD ONE(F4_4, "K\0M\xff\xffM\xff\xff\x86K\0K\0\x86") KEYS FOUR, "ask for more memory"),
        RAW(HEAD "\x80\2(" REBUILD(F4_4, "K\0)" ")") REBUILD(STORAGE("IntStorage", "K\4"), "K\0))") "t." KEYS FOUR,
            "two types or sizes"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        if (cases[i].reason)
            check_refused(read_torch, cases[i].bytes, cases[i].n, cases[i].reason);
        else
            ck_assert_msg(attempt(read_torch, (const uint8_t *)cases[i].bytes, cases[i].n) == LT_OK, "%s",
                          lt_last_error());
    }
}
END_TEST

#define TENSOR REBUILD(F4_4, "K\0K\4\x85K\1\x85")
#define MODULE(state) "ctorch.nn.modules.linear\nLinear\n)\x81}(" state "ub"

START_TEST(names)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *names[4];
    } cases[] = {
#define NAMES(value, ...) \
        { HEAD "\x80\2" value "." KEYS FOUR, sizeof(HEAD "\x80\2" value "." KEYS FOUR) - 1, { __VA_ARGS__ } }
        NAMES("}(K\1}(X\1\0\0\0a" TENSOR "uX\1\0\0\0x" TENSOR "N" TENSOR "u", "1.a", "x"),
        NAMES("}(X\5\0\0\0modelNX\3\0\0\0ema}(X\1\0\0\0b" TENSOR "uX\1\0\0\0x" TENSOR "u", "ema.b", "x"),
        NAMES("}(X\5\0\0\0modelK\5X\3\0\0\0net}(X\1\0\0\0bK\1uX\1\0\0\0x" TENSOR "u", "x"),
        NAMES("}(X\5\0\0\0model}(X\x0a\0\0\0state_dict}(X\1\0\0\0b" TENSOR "uuu", "model.state_dict.b"),
        /* dicts of other classes: filled, made of one, with one among their attributes */
        NAMES("}(X\1\0\0\0eceasydict\nEasyDict\n)\x81(X\1\0\0\0b" TENSOR "uX\1\0\0\0fcflax\nFrozenDict\n}(X\1\0\0\0b"
              TENSOR "u\x85RX\1\0\0\0gcmy\nEma\n)\x81}(X\1\0\0\0s}(X\1\0\0\0b" TENSOR "uubu", "e.b", "f.b", "g.s.b"),
        NAMES(MODULE("X\x0b\0\0\0_parameters}(X\1\0\0\0w" TENSOR "X\1\0\0\0nNuX\x08\0\0\0_modules}(X\1\0\0\0m"
                     MODULE("X\x08\0\0\0_buffers}(X\1\0\0\0s" TENSOR "uX\x08\0\0\0_modulesN") "u"), "w", "m.s"),
        NAMES("](" TENSOR "K\1}(X\1\0\0\0b" TENSOR "ue", "0", "2.b"),
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        lt_arena *arena = lt_arena_new();
        lt_torch_file f;
        size_t n = 0;

        check_ok(lt_torch_parse(arena, "x.pth", (const uint8_t *)cases[i].bytes, cases[i].n, &f));
        for (; cases[i].names[n]; n++)
            ck_assert_msg(n < f.n && strcmp(f.entry[n].name, cases[i].names[n]) == 0, "%zu: %s", i, cases[i].names[n]);
        ck_assert_msg(f.n == n, "%zu: %zu names", i, f.n);
        lt_arena_free(arena);
    }
}
END_TEST

static size_t put_pairs(uint8_t *p, int n, const char *pair)
{
    const size_t each = strlen(pair);

    for (int i = 0; i < n; i++)
        memcpy(p + (size_t)i * each, pair, each);
    return (size_t)n * each;
}

static size_t put(uint8_t *p, const char *text, size_t n)
{
    memcpy(p, text, n);
    return n;
}

/* Small files that ask for a step for each pair of their items: a dict of dicts of one dict, buffers looked up among
 * the names of those that are not kept, tensors with one dict of marks. */
START_TEST(shared_dicts)
{
    enum { N = 6000 };
    uint8_t *bytes = malloc(1 << 17);
    size_t n;

#define PUT(text) (n += put(bytes + n, text, sizeof(text) - 1))
    n = 0;
    PUT(HEAD "\x80\2X\0\0\0\0q\1}q\2(");
    n += put_pairs(bytes + n, N, "h\1K\1");
    PUT("u0}q\3(");
    n += put_pairs(bytes + n, N, "h\1h\2");
    PUT("u.\x80\2].");
    check_refused(read_torch, bytes, n, "values to look through");

    n = 0;
    PUT(HEAD "\x80\2" REBUILD(F4_4, "K\0K\4\x85K\1\x85") "q\1X\1\0\0\0aq\2X\1\0\0\0bq\3ctorch.nn\nM\n)\x81}("
        "X\x08\0\0\0_modules}X\x08\0\0\0_buffers}(");
    n += put_pairs(bytes + n, N, "h\2h\1");
    PUT("uX\x1b\0\0\0_non_persistent_buffers_setc__builtin__\nset\n](");
    n += put_pairs(bytes + n, N, "h\3");
    PUT("e\x85Rub." KEYS FOUR);
    check_refused(read_torch, bytes, n, "values to look through");

    n = 0;
    PUT(HEAD "\x80\2X\0\0\0\0q\1}q\2(");
    n += put_pairs(bytes + n, 17, "h\1K\1");
    PUT("uctorch._utils\n_rebuild_tensor_v2\n(" F4_4 "K\0K\4\x85K\1\x85\x89}h\2tR." KEYS FOUR);
    check_refused(read_torch, bytes, n, "a tensor with 17 marks, want at most 16");
#undef PUT
    free(bytes);
}
END_TEST

/* Modules that share modules that share modules: a walk of 2^60 steps, refused after a million. */
START_TEST(shared_modules)
{
    uint8_t bytes[4096] = HEAD "\x80\2ccollections\nOrderedDict\n)Rq\1";
    size_t n = sizeof(HEAD "\x80\2ccollections\nOrderedDict\n)Rq\1") - 1;
    static const char level[] = "}(X\1\0\0\0ah\1X\1\0\0\0bh\1uq\1";

    for (int i = 0; i < 60; i++, n += sizeof(level) - 1)
        memcpy(bytes + n, level, sizeof(level) - 1);
    memcpy(bytes + n, "." "\x80\2].", 5);
    check_refused(read_torch, bytes, n + 5, "more");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, each_type_and_stride, 0, LT_COUNT(everything));
    tcase_add_test(tc, names_of_folders);
    tcase_add_test(tc, before_0_1_10);
    tcase_add_test(tc, state_dict_within);
    tcase_add_loop_test(tc, whole_module, 0, 2);
    tcase_add_test(tc, big_endian);
    tcase_add_test(tc, from_a_file);
    tcase_add_test(tc, no_weights);
    tcase_add_loop_test(tc, damage, 0, 7);
    tcase_add_test(tc, torch_script_program);
    tcase_add_test(tc, not_read);
    tcase_add_test(tc, left_closed);
    tcase_add_test(tc, streams);
    tcase_add_test(tc, names);
    tcase_add_test(tc, shared_dicts);
    tcase_add_test(tc, shared_modules);
}

int main(void)
{
    return run_suite("torch", add_tests);
}
