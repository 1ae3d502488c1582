/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays by name, in whatever people keep them: the same numbers out of each, and what nobody asks for is no matter. */
#include "assets/keyed_arrays.h"

#include "libtensor/io/array/npy.h"
#include "libtensor/io/array/safetensors.h"
#include "tests/io/resaved_vectors.h"
#include "tests/io/torch_vectors.h"
#include "tests/suite.h"

static const double matrix[24] = { [1] = 1.5, [6] = 2, [8] = -3, [17] = 0.25, [22] = 7 };
static const int64_t shape[2] = { 4, 6 };

static void check_matrix(const keyed *k, const char *key)
{
    lt_array a;

    ck_assert(keyed_has(k, key));
    check_ok(keyed_get(k, key, 2, shape, &a));
    for (size_t i = 0; i < 24; i++)
        ck_assert_msg(lt_array_get(&a, i) == matrix[i], "%s[%zu]", key, i);
}

/* numpy.savez(**dict): those that are no arrays are pickled, each by itself */
START_TEST(savez_of_a_dict)
{
    lt_arena *arena = lt_arena_new();
    const lt_pvalue *v;
    lt_array a;
    keyed k;

    put_file(in_folder("hand.pkl"), resaved_npz, sizeof(resaved_npz));          /* by its bytes, not by its name */
    check_ok(keyed_open(arena, in_folder("hand.pkl"), &k));
    check_matrix(&k, "plain");
    check_matrix(&k, "sparse");
    check_matrix(&k, "objects");
    check_ok(keyed_value(&k, "config", &v));
    ck_assert_str_eq(v->u.object.class_name, "config.Config");
    check_error(keyed_get(&k, "config", 2, shape, &a), LT_EFORMAT, "\"config\": an object of config.Config, no array");
    check_error(keyed_get(&k, "complex", 2, shape, &a), LT_EFORMAT, "\"complex\": elements are complex numbers");
    check_error(keyed_get(&k, "absent", 2, shape, &a), LT_EFORMAT, "no array \"absent\"");
    check_error(keyed_get(&k, "plain", 2, (int64_t[]){ 4, 5 }, &a), LT_EFORMAT, "\"plain\": shape (4, 6), want (4, 5)");
    check_error(keyed_get(&k, "sparse", 1, shape, &a), LT_EFORMAT, "\"sparse\": shape (4, 6), want (4)");
    ck_assert_ptr_null(keyed_text(&k, "plain"));
    lt_arena_free(arena);
}
END_TEST

/* numpy.save of a dict */
START_TEST(save_of_a_dict)
{
    static const float numbers[3] = { 1, 2, 3 };
    const lt_array plain = lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ 3 }, numbers);
    lt_arena *arena = lt_arena_new();
    keyed k;

    put_file(in_folder("hand.npy"), resaved_npy, sizeof(resaved_npy));
    check_ok(keyed_open(arena, in_folder("hand.npy"), &k));
    check_matrix(&k, "plain");
    check_matrix(&k, "sparse");
    ck_assert_str_eq(keyed_text(&k, "name"), "x");
    put_file(in_folder("hand.npy"), resaved_npy, sizeof(resaved_npy) / 2);
    check_error(keyed_open(arena, in_folder("hand.npy"), &k), LT_EFORMAT, "cut short");
    lt_arena_free(arena);
    arena = lt_arena_new();
    check_ok(lt_npy_write(in_folder("plain.npy"), &plain));
    check_error(keyed_open(arena, in_folder("plain.npy"), &k), LT_EFORMAT, "a .npy array, want one of a dict of");
    lt_arena_free(arena);
}
END_TEST

START_TEST(other_kinds)
{
    float data[24] = { 0 };
    const lt_named_array list[] = { { "plain", lt_array_make(LT_ELEM_F4, 2, shape, data) } };
    lt_arena *arena = lt_arena_new();
    lt_array a;
    keyed k;

    for (size_t i = 0; i < 24; i++)
        data[i] = (float)matrix[i];
    check_ok(lt_safetensors_write(in_folder("hand.npz"), list, 1, NULL, 0));
    check_ok(keyed_open(arena, in_folder("hand.npz"), &k));
    check_matrix(&k, "plain");
    put_file(in_folder("hand.pkl"), resaved_pickle, sizeof(resaved_pickle));
    check_ok(keyed_open(arena, in_folder("hand.pkl"), &k));
    check_matrix(&k, "numpy_matrix");
    check_matrix(&k, "dok_array");
    put_file(in_folder("hand.pkl"), torch_zip, sizeof(torch_zip));
    check_ok(keyed_open(arena, in_folder("hand.pkl"), &k));
    check_ok(keyed_get(&k, "turned", 2, (int64_t[]){ 3, 2 }, &a));
    ck_assert(lt_array_get(&a, 1) == 3);
    put_file(in_folder("hand.pkl"), "\x89PNG\r\n\x1a\n", 8);
    check_error(keyed_open(arena, in_folder("hand.pkl"), &k), LT_EFORMAT,
                "a PNG image, want an .npz, a pickle or other arrays by name");
    put_file(in_folder("hand.pkl"), "# hands\n", 8);
    check_error(keyed_open(arena, in_folder("hand.pkl"), &k), LT_EFORMAT, "not an .npz, a pickle or");
    lt_arena_free(arena);
}
END_TEST

/* An array that is not wanted in this shape is not unpacked: 64 MB of zeros in 64 KB take none of it. */
START_TEST(bombs_stay_packed)
{
    enum { N = 1 << 24 };
    float *zeros = calloc(N, sizeof(*zeros));
    const lt_named_array list[] = { { "v_template", lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ N }, zeros) } };
    lt_arena *arena = lt_arena_new();
    lt_array a;
    keyed k;

    ck_assert_ptr_nonnull(zeros);
    check_ok(lt_npz_write(in_folder("bomb.npz"), list, 1, true));
    free(zeros);
    check_ok(keyed_open(arena, in_folder("bomb.npz"), &k));
    check_error(keyed_get(&k, "v_template", 2, (int64_t[]){ 778, 3 }, &a), LT_EFORMAT,
                "shape (16777216), want (778, 3)");
    ck_assert_uint_lt(lt_arena_bytes(arena), 4 << 20);
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, savez_of_a_dict);
    tcase_add_test(tc, save_of_a_dict);
    tcase_add_test(tc, other_kinds);
    tcase_add_test(tc, bombs_stay_packed);
}

int main(void)
{
    return run_suite("keyed_arrays", add_tests);
}
