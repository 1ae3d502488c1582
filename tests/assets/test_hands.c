/* SPDX-License-Identifier: Apache-2.0 */
/* Which hands a run gets: named, found beside, in a folder, from the environment, embedded, mirrored. */
#include "assets/hand/hand.h"
#include "assets/hand_file.h"
#include "assets/hands.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

/* Files of a folder: a right hand that says it is MANO's, and its mirror image with the released sign. */
static void write_hands(const char *folder, bool right, bool left)
{
    lt_arena *arena = lt_arena_new();
    lt_hand_model *r, *l = lt_arena_alloc(arena, sizeof(*l));
    char path[256];

    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &r));
    r->synthetic = false;
    synth_hand_mirror(r, l);
    hand_left_shape(l, HAND_LEFT_FIX_X);
    check_ok(lt_make_dirs(folder));
    snprintf(path, sizeof(path), "%s/MANO_RIGHT.pkl", folder);
    if (right)
        check_ok(hand_file_write(path, r));
    snprintf(path, sizeof(path), "%s/MANO_LEFT.pkl", folder);
    if (left)
        check_ok(hand_file_write(path, l));
    lt_arena_free(arena);
}

static void open_path(lt_arena *arena, const char *folder, const char *name, hands *out)
{
    char path[256];

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    check_ok(hands_open(arena, path, out));
}

START_TEST(pairs)
{
    lt_arena *arena = lt_arena_new();
    lt_hand_model *r;
    hands h;

    unsetenv("PALMAR_HAND");
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &r));
    write_hands(in_folder("both"), true, true);
    write_hands(in_folder("r"), true, false);
    write_hands(in_folder("l"), false, true);
    open_path(arena, in_folder("both"), "MANO_RIGHT.pkl", &h);
    ck_assert(h.left && h.left->left && !h.right->left && !hands_are_embedded(&h));
    ck_assert(hand_left_is_flipped(h.left, h.right));
    open_path(arena, in_folder("both"), "MANO_LEFT.pkl", &h);
    ck_assert(h.left && h.left->left && !h.right->left);
    open_path(arena, in_folder("both"), "", &h);
    ck_assert(h.left && h.left->left && !h.right->left);
    open_path(arena, in_folder("r"), "MANO_RIGHT.pkl", &h);
    ck_assert(!h.left && !h.right->left);
    open_path(arena, in_folder("l"), "MANO_LEFT.pkl", &h);
    ck_assert(h.left && !h.right->left);
    ck_assert(memcmp(h.right->v_template, r->v_template, sizeof(r->v_template)) == 0);
    ck_assert(memcmp(h.right->shapedirs, r->shapedirs, sizeof(r->shapedirs)) == 0);
    ck_assert(memcmp(h.right->posedirs, r->posedirs, sizeof(r->posedirs)) == 0);
    ck_assert(memcmp(h.right->faces, r->faces, sizeof(r->faces)) == 0);
    lt_arena_free(arena);
}
END_TEST

START_TEST(without_a_path)
{
    lt_arena *arena = lt_arena_new();
    hands h;

    unsetenv("PALMAR_HAND");
    check_ok(hands_open(arena, NULL, &h));
    ck_assert(hands_are_embedded(&h) && h.right->synthetic && !h.left);
    ck_assert_str_eq(h.name, "embedded synthetic hand");
    ck_assert_ptr_nonnull(strstr(hands_note(), "MANO_RIGHT.pkl"));
    ck_assert_ptr_nonnull(strstr(hands_note(), "https://mano.is.tue.mpg.de"));
    write_hands(in_folder("env"), true, false);
    setenv("PALMAR_HAND", in_folder("env"), 1);
    check_ok(hands_open(arena, "", &h));
    ck_assert(!hands_are_embedded(&h) && !h.right->synthetic);
    ck_assert_ptr_nonnull(strstr(h.path, in_folder("env")));
    check_ok(hands_open(arena, "embedded", &h));
    ck_assert(hands_are_embedded(&h) && h.right->synthetic);
    setenv("PALMAR_HAND", "/none/MANO_RIGHT.pkl", 1);
    check_error(hands_open(arena, NULL, &h), LT_EIO, "/none/MANO_RIGHT.pkl: no such file; MANO_RIGHT.pkl and");
    check_error(hands_open(arena, NULL, &h), LT_EIO, "without it the embedded hand is used");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, pairs);
    tcase_add_test(tc, without_a_path);
}

int main(void)
{
    return run_suite("hands", add_tests);
}
