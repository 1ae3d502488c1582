/* SPDX-License-Identifier: Apache-2.0 */
/* TensorBoard's event files, read back record by record with a checksum of the test's own. */
#include "libtensor/io/events.h"
#include "libtensor/io/file.h"
#include "libtensor/io/protobuf.h"
#include "tests/suite.h"

#include <dirent.h>
#include <math.h>
#include <time.h>

/* RFC 3720, section B.4 */
START_TEST(checksums)
{
    uint8_t bytes[32] = { 0 };

    ck_assert_uint_eq(lt_crc32c(bytes, 32), 0x8a9136aa);
    memset(bytes, 0xff, 32);
    ck_assert_uint_eq(lt_crc32c(bytes, 32), 0x62a8ab43);
    for (int i = 0; i < 32; i++)
        bytes[i] = (uint8_t)i;
    ck_assert_uint_eq(lt_crc32c(bytes, 32), 0x46dd794e);
    ck_assert_uint_eq(lt_crc32c("123456789", 9), 0xe3069283);
    ck_assert_uint_eq(lt_crc32c("", 0), 0);
}
END_TEST

typedef struct {
    double time, value[4];
    int64_t step;
    char version[32], tag[4][32];
    int n;
    bool starts;
} seen;

static uint32_t word(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* crc, from the masked one of the file: the inverse of the format's formula */
static uint32_t unmasked(uint32_t masked)
{
    const uint32_t turned = masked - 0xa282ead8;

    return turned >> 17 | turned << 15;
}

static void text_of(pb_span s, char *out)
{
    ck_assert_uint_lt(pb_size(s), 32);
    memcpy(out, s.at, pb_size(s));
    out[pb_size(s)] = '\0';
}

static void see_value(pb_span m, seen *e)
{
    pb_field f;

    while (m.at < m.end) {
        ck_assert_ptr_null(pb_next(&m, &f));
        if (f.number == 1)
            text_of(f.body, e->tag[e->n]);
        if (f.number == 2) {
            const uint32_t bits = (uint32_t)f.value;
            float x;

            ck_assert_int_eq(f.wire, PB_FIXED32);
            memcpy(&x, &bits, 4);
            e->value[e->n] = (double)x;
        }
    }
    e->n++;
}

static void see_event(pb_span m, seen *e)
{
    pb_field f;

    while (m.at < m.end) {
        ck_assert_ptr_null(pb_next(&m, &f));
        switch (f.number) {
        case 1: memcpy(&e->time, &f.value, 8); break;
        case 2: e->step = (int64_t)f.value; break;
        case 3: text_of(f.body, e->version); break;
        case 5:
            for (pb_span s = f.body; s.at < s.end; ) {
                ck_assert_ptr_null(pb_next(&s, &f));
                ck_assert_int_eq(f.number, 1);
                see_value(f.body, e);
            }
            break;
        case 7: e->starts = pb_size(f.body) == 2 && f.body.at[0] == 8 && f.body.at[1] == 1; break;
        default: ck_abort_msg("field %d", f.number);
        }
    }
}

static int see_file(const char *folder, seen *list, int room)
{
    DIR *d = opendir(folder);
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    int count = 0;
    size_t n;

    for (struct dirent *e; (e = readdir(d)); ) {
        if (!strstr(e->d_name, ".tfevents."))
            continue;
        check_ok(lt_read_file(arena, lt_path_join(arena, folder, e->d_name), LT_FILE_MAX, &bytes, &n));
        for (size_t at = 0; at < n; count++) {
            const size_t length = word(bytes + at);

            ck_assert_uint_eq(word(bytes + at + 4), 0);
            ck_assert_uint_eq(unmasked(word(bytes + at + 8)), lt_crc32c(bytes + at, 8));
            ck_assert_uint_eq(unmasked(word(bytes + at + 12 + length)), lt_crc32c(bytes + at + 12, length));
            ck_assert_int_lt(count, room);
            memset(&list[count], 0, sizeof(*list));
            see_event((pb_span){ bytes + at + 12, bytes + at + 12 + length }, &list[count]);
            at += length + 16;
        }
    }
    closedir(d);
    lt_arena_free(arena);
    return count;
}

START_TEST(scalars)
{
    lt_arena *arena = lt_arena_new();
    seen list[8];
    FILE *f;
    int n;

    check_ok(lt_make_dirs(in_folder("tb")));
    check_ok(lt_events_open(arena, in_folder("tb"), 0, &f));
    lt_events_scalars(f, 1, (lt_event_scalar[]){ { "loss", 0.25 }, { "parts/a", NAN }, { "lr", 1e-4 } }, 3);
    lt_events_scalars(f, 300, (lt_event_scalar[]){ { "loss", -2 } }, 1);
    ck_assert_int_eq(ferror(f), 0);
    fclose(f);
    n = see_file(in_folder("tb"), list, 8);
    ck_assert_int_eq(n, 4);
    ck_assert_str_eq(list[0].version, "brain.Event:2");
    ck_assert_double_eq_tol(list[0].time, (double)time(NULL), 60);
    ck_assert(list[1].starts);
    ck_assert_int_eq(list[1].step, 1);
    ck_assert_int_eq(list[2].n, 2);
    ck_assert_str_eq(list[2].tag[0], "loss");
    ck_assert_double_eq(list[2].value[0], 0.25);
    ck_assert_str_eq(list[2].tag[1], "lr");
    ck_assert_double_eq(list[2].value[1], (double)1e-4f);
    ck_assert_int_eq(list[3].step, 300);
    ck_assert_double_eq(list[3].value[0], -2);
    lt_arena_free(arena);
}
END_TEST

/* A run that goes on from step 4: TensorBoard forgets what came after. */
START_TEST(going_on)
{
    lt_arena *arena = lt_arena_new();
    seen list[8];
    int n, starts = 0;
    FILE *f;

    check_ok(lt_make_dirs(in_folder("again")));
    for (int64_t step = 0; step < 8; step += 4) {
        check_ok(lt_events_open(arena, in_folder("again"), step, &f));
        lt_events_scalars(f, step + 1, &(lt_event_scalar){ "loss", 1 }, 1);
        fclose(f);
    }
    n = see_file(in_folder("again"), list, 8);
    for (int i = 0; i < n; i++)
        starts += list[i].starts && (list[i].step == 1 || list[i].step == 5);
    ck_assert_int_eq(starts, 2);
    check_error(lt_events_open(arena, in_folder("none"), 0, &f), LT_EIO, "none/events.out.tfevents.");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, checksums);
    tcase_add_test(tc, scalars);
    tcase_add_test(tc, going_on);
}

int main(void)
{
    return run_suite("events", add_tests);
}
