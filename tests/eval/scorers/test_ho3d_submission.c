/* SPDX-License-Identifier: Apache-2.0 */
/* pred.json and pred.zip: read back by cJSON and libzip, refused when wrong, never half there. */
#include "eval/scorers/ho3d/submission.h"

#include "libtensor/geometry/hand/model.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

enum { J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, N = 3 };

#define FOLDER "test_submission.tmp"

static float joints[N][J][3], vertices[N][V][3];

static void setup(void)
{
    float *j = joints[0][0], *v = vertices[0][0];

    for (int i = 0; i < N * J * 3; i++)
        j[i] = (float)-sin(i) / 3;
    for (int i = 0; i < N * V * 3; i++)
        v[i] = (float)-cos(i) * 1e-3f;
    vertices[1][5][2] = 1e-9f;
    mkdir(FOLDER, 0777);
}

static int files_left(void)
{
    DIR *d = opendir(FOLDER);
    const struct dirent *e;
    int n = 0;

    while ((e = readdir(d)))
        n += e->d_name[0] != '.';
    closedir(d);
    return n;
}

static void teardown(void)
{
    unlink(FOLDER "/pred.json");
    unlink(FOLDER "/pred.zip");
    ck_assert_int_eq(rmdir(FOLDER), 0);
}

static lt_status write_all(const char *path, int n, int expected)
{
    ho3d_submission *s;

    ck_assert_int_eq(ho3d_submission_open(path, expected, &s), LT_OK);
    for (int i = 0; i < n; i++)
        ck_assert_int_eq(ho3d_submission_add(s, joints[i][0], vertices[i][0]), LT_OK);
    return ho3d_submission_close(s);
}

static void expect_array(const cJSON *list, int points, const float *x)
{
    const cJSON *sample, *point;
    int i = 0;

    ck_assert_int_eq(cJSON_GetArraySize(list), N);
    cJSON_ArrayForEach(sample, list) {
        ck_assert_int_eq(cJSON_GetArraySize(sample), points);
        cJSON_ArrayForEach(point, sample) {
            ck_assert_int_eq(cJSON_GetArraySize(point), 3);
            for (int k = 0; k < 3; k++, i++)
                ck_assert_double_le(fabs(cJSON_GetArrayItem(point, k)->valuedouble - x[i]),
                                    5.1e-7 * fabs(x[i]));
        }
    }
}

static void expect_ours(char *text)
{
    cJSON *root = cJSON_Parse(text);

    ck_assert_ptr_nonnull(root);
    ck_assert_int_eq(cJSON_GetArraySize(root), 2);
    expect_array(cJSON_GetArrayItem(root, 0), J, joints[0][0]);
    expect_array(cJSON_GetArrayItem(root, 1), V, vertices[0][0]);
    cJSON_Delete(root);
    free(text);
}

START_TEST(json)
{
    char *text = calloc(1, 1 << 20);
    FILE *f;

    ck_assert_int_eq(write_all(FOLDER "/pred.json", N, N), LT_OK);
    ck_assert_int_eq(files_left(), 1);
    f = fopen(FOLDER "/pred.json", "r");
    ck_assert_uint_gt(fread(text, 1, (1 << 20) - 1, f), 1000);
    fclose(f);
    expect_ours(text);
}
END_TEST

START_TEST(zipped)
{
    char *text = calloc(1, 1 << 20);
    zip_stat_t info;
    zip_file_t *f;
    zip_t *z;
    int error;

    ck_assert_int_eq(write_all(FOLDER "/pred.zip", N, N), LT_OK);
    ck_assert_int_eq(files_left(), 1);
    z = zip_open(FOLDER "/pred.zip", ZIP_CHECKCONS | ZIP_RDONLY, &error);
    ck_assert_ptr_nonnull(z);
    ck_assert_int_eq(zip_get_num_entries(z, 0), 1);
    ck_assert_int_eq(zip_stat(z, "pred.json", 0, &info), 0);
    ck_assert_uint_lt(info.comp_size, info.size);
    f = zip_fopen(z, "pred.json", 0);
    ck_assert_int_eq(zip_fread(f, text, 1 << 20), (zip_int64_t)info.size);
    ck_assert_int_eq(zip_fclose(f), 0);             /* the checksum too */
    zip_close(z);
    expect_ours(text);
}
END_TEST

START_TEST(wrong_samples)
{
    float bad[J][3];
    ho3d_submission *s;

    memcpy(bad, joints[0], sizeof(bad));
    ck_assert_int_eq(ho3d_submission_open(FOLDER "/pred.json", 0, &s), LT_OK);
    bad[3][1] = NAN;
    ck_assert_int_eq(ho3d_submission_add(s, bad[0], vertices[0][0]), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "sample 0: number 10 of 63 is"));
    for (int i = 0; i < J; i++)
        bad[i][1] = bad[i][2] = .5f;
    ck_assert_int_eq(ho3d_submission_add(s, bad[0], vertices[0][0]), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "flip y and z"));
    ck_assert_int_eq(ho3d_submission_close(s), LT_OK);
    ck_assert_int_eq(files_left(), 1);
}
END_TEST

START_TEST(wrong_count)
{
    const char *path = _i ? FOLDER "/pred.zip" : FOLDER "/pred.json";

    ck_assert_int_eq(write_all(path, N, 11524), LT_EINVAL);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "3 samples, the evaluation list has 11524"));
    ck_assert_int_eq(files_left(), 0);
}
END_TEST

START_TEST(given_up)
{
    ho3d_submission *s;

    ck_assert_int_eq(ho3d_submission_open(FOLDER "/pred.zip", N, &s), LT_OK);
    ck_assert_int_eq(ho3d_submission_add(s, joints[0][0], vertices[0][0]), LT_OK);
    ho3d_submission_abort(s);
    ho3d_submission_abort(NULL);
    ck_assert_int_eq(files_left(), 0);
    ck_assert_int_eq(ho3d_submission_open(FOLDER "/none/pred.zip", N, &s), LT_EIO);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, json);
    tcase_add_test(t, zipped);
    tcase_add_test(t, wrong_samples);
    tcase_add_loop_test(t, wrong_count, 0, 2);
    tcase_add_test(t, given_up);
}

int main(void)
{
    return run_suite("ho3d_submission", add_tests);
}
