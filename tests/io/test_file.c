/* SPDX-License-Identifier: Apache-2.0 */
/* Files: atomic writing, folders, paths, and reading whole ones. */
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

static int files_in_folder(void)
{
    DIR *dir = opendir(scratch_folder);
    int n = 0;

    while (readdir(dir))
        n++;
    closedir(dir);
    return n - 2;
}

static void check_contents(const char *path, const char *want)
{
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, path, 1000, &bytes, &n));
    ck_assert_str_eq((char *)bytes, want);
    ck_assert_uint_eq(n, strlen(want));
    lt_arena_free(arena);
}

START_TEST(old_until_commit)
{
    const char *path = in_folder("atomic");
    lt_atomic_file f;

    check_ok(lt_write_file(path, "old", 3));
    ck_assert_int_eq(chmod(path, 0640), 0);
    check_ok(lt_atomic_open(&f, path));
    fputs("new", f.stream);
    fflush(f.stream);
    check_contents(path, "old");
    check_ok(lt_atomic_commit(&f));
    check_contents(path, "new");

    struct stat info;
    stat(path, &info);
    ck_assert_int_eq(info.st_mode & 0777, 0640);
    ck_assert_int_eq(files_in_folder(), 1);
    unlink(path);
}
END_TEST

START_TEST(abort_leaves_nothing)
{
    lt_atomic_file f;

    check_ok(lt_atomic_open(&f, in_folder("aborted")));
    fputs("text", f.stream);
    lt_atomic_abort(&f);
    ck_assert_int_eq(files_in_folder(), 0);
    lt_atomic_abort(&f);
}
END_TEST

/* Another process, or a run before, may have left files of the names that we choose. */
START_TEST(unlink_all_leaves_nothing)
{
    lt_atomic_file f[3];

    for (int i = 0; i < 3; i++)
        check_ok(lt_atomic_open(&f[i], in_folder("unlinked")));
    lt_atomic_abort(&f[1]);
    lt_atomic_unlink_all();
    ck_assert_int_ne(access(f[0].temp, F_OK), 0);
    ck_assert_int_ne(access(f[2].temp, F_OK), 0);
    lt_atomic_abort(&f[0]);
    lt_atomic_abort(&f[2]);
}
END_TEST

START_TEST(names_that_are_taken_are_passed_over)
{
    char name[64];
    lt_atomic_file f;

    for (int i = 0; i < 150; i++) {
        snprintf(name, sizeof(name), "taken.%ld-%d.tmp", (long)getpid(), i);
        put_file(in_folder(name), "theirs", 6);
    }
    check_error(lt_atomic_open(&f, in_folder("taken")), LT_EIO, "taken: cannot write: File exists");
    check_ok(lt_write_file(in_folder("taken"), "ours", 4));
    check_contents(in_folder("taken"), "ours");
    for (int i = 0; i < 150; i++) {
        snprintf(name, sizeof(name), "taken.%ld-%d.tmp", (long)getpid(), i);
        check_contents(in_folder(name), "theirs");
        unlink(in_folder(name));
    }
    unlink(in_folder("taken"));
    ck_assert_int_eq(files_in_folder(), 0);
}
END_TEST

START_TEST(a_folder_in_the_way_is_left)
{
    const char *path = in_folder("way");
    lt_atomic_file f;

    check_ok(lt_atomic_open(&f, path));
    fputs("text", f.stream);
    ck_assert_int_eq(mkdir(path, 0700), 0);
    check_error(lt_atomic_commit(&f), LT_EIO, "way: cannot rename the finished file to it");
    ck_assert_int_eq(files_in_folder(), 1);
    ck_assert_int_eq(rmdir(path), 0);
}
END_TEST

START_TEST(a_name_without_a_folder_is_here)
{
    char back[4096];

    ck_assert_ptr_nonnull(getcwd(back, sizeof(back)));
    ck_assert_int_eq(chdir(scratch_folder), 0);
    check_ok(lt_write_file("here", "", 0));
    check_contents("here", "");
    unlink("here");
    ck_assert_int_eq(chdir(back), 0);
}
END_TEST

START_TEST(cannot_open)
{
    lt_atomic_file f;

    check_error(lt_atomic_open(&f, in_folder("missing/name")), LT_EIO, "missing/name: cannot write: No such");
    lt_atomic_abort(&f);
    check_error(lt_write_file(in_folder("missing/name"), "text", 4), LT_EIO, "missing/name: cannot write: No such");
    check_error(lt_atomic_open(&f, scratch_folder), LT_EIO, "not a regular file");
    check_error(lt_atomic_open(&f, "/dev/null"), LT_EIO, "not a regular file");
}
END_TEST

/* In libc's place, to refuse with this error where it is not 0 */
static int chmod_error;

int fchmod(int fd, mode_t mode)
{
    errno = chmod_error;
    return chmod_error ? -1 : (int)syscall(SYS_fchmod, fd, mode);
}

/* Disks without permission bits may refuse them; any other refusal is told by its name. */
START_TEST(bits_that_are_refused)
{
    const char *path = in_folder("bits");

    check_ok(lt_write_file(path, "old", 3));
    chmod_error = EPERM;
    check_ok(lt_write_file(path, "new", 3));
    chmod_error = EROFS;
    check_error(lt_write_file(path, "newer", 5), LT_EIO, "bits: cannot write: Read-only file system");
    chmod_error = 0;
    check_contents(path, "new");
    unlink(path);
    ck_assert_int_eq(files_in_folder(), 0);
}
END_TEST

/* Whoever may write to a folder and not list it cannot sync it, and the file is there all the same. */
START_TEST(a_folder_to_write_to_only)
{
    const uid_t user = geteuid();
    const char *folder = in_folder("drop");
    char back[4096];

    ck_assert_ptr_nonnull(getcwd(back, sizeof(back)));
    ck_assert_int_eq(mkdir(folder, 0300), 0);
    ck_assert(user || chown(folder, 65534, 65534) == 0);
    ck_assert_int_eq(chdir(folder), 0);
    ck_assert(user || seteuid(65534) == 0);
    check_ok(lt_write_file("note", "text", 4));
    check_contents("note", "text");
    unlink("note");
    ck_assert_int_eq(seteuid(user), 0);
    ck_assert_int_eq(chdir(back), 0);
    ck_assert_int_eq(rmdir(folder), 0);
}
END_TEST

/* A limit on file sizes behaves as a full disk does: the write fails, perhaps long before the commit. */
START_TEST(full_disk_keeps_old_file)
{
    const char *path = in_folder("full");
    const struct rlimit limit = { 1 << 16, RLIM_INFINITY };
    const struct rlimit none = { RLIM_INFINITY, RLIM_INFINITY };
    static char block[1 << 15];
    lt_atomic_file f;

    check_ok(lt_write_file(path, "old", 3));
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    check_ok(lt_atomic_open(&f, path));
    for (int i = 0; i < 3; i++)
        fwrite(block, 1, sizeof(block), f.stream);
    fputs("small", f.stream);
    check_error(lt_atomic_commit(&f), LT_ENOSPC, path);
    setrlimit(RLIMIT_FSIZE, &none);
    check_contents(path, "old");
    ck_assert_int_eq(files_in_folder(), 1);
    unlink(path);
}
END_TEST

/* What was not written once is missing, though the disk has room again when the file is finished. */
START_TEST(a_failed_write_is_remembered)
{
    const char *path = in_folder("moment");
    const struct rlimit limit = { 1 << 16, RLIM_INFINITY };
    const struct rlimit none = { RLIM_INFINITY, RLIM_INFINITY };
    static char block[1 << 17];
    lt_atomic_file f;

    check_ok(lt_write_file(path, "old", 3));
    signal(SIGXFSZ, SIG_IGN);
    check_ok(lt_atomic_open(&f, path));
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    ck_assert_uint_lt(fwrite(block, 1, sizeof(block), f.stream), sizeof(block));
    setrlimit(RLIMIT_FSIZE, &none);
    check_error(lt_atomic_commit(&f), LT_EIO, "moment: cannot write: Input/output error");
    check_contents(path, "old");
    ck_assert_int_eq(files_in_folder(), 1);
    unlink(path);
}
END_TEST

START_TEST(dirs)
{
    char longer[400];

    check_ok(lt_make_dirs(in_folder("a/b//c/")));
    check_ok(lt_make_dirs(in_folder("a/b/c")));
    ck_assert(lt_is_folder(in_folder("a/b/c")));
    ck_assert_int_eq(symlink("a", in_folder("link")), 0);
    ck_assert(lt_is_folder(in_folder("link")));
    put_file(in_folder("plain"), "x", 1);
    ck_assert(!lt_is_folder(in_folder("plain")));
    ck_assert(!lt_is_folder(in_folder("absent")));
    check_error(lt_make_dirs(in_folder("plain/d")), LT_EIO, "cannot make folder");
    check_error(lt_make_dirs(in_folder("plain")), LT_EIO, "Not a directory");
    ck_assert_int_eq(symlink("nowhere", in_folder("dangling")), 0);
    ck_assert(!lt_is_folder(in_folder("dangling")));
    check_error(lt_make_dirs(in_folder("dangling")), LT_EIO, "Not a directory");
    snprintf(longer, sizeof(longer), "%s/%0300d", scratch_folder, 0);
    check_error(lt_make_dirs(longer), LT_EIO, "File name too long");
    check_error(lt_make_dirs(""), LT_EINVAL, "folder name of 0 bytes");
}
END_TEST

START_TEST(paths)
{
    static const char *const outside[] = { "", "/etc/passwd", "..", "a/../b", "../a", "a/..", "C:/x", "a\\b" };
    static const char *const inside[] = { "a", "a/b.png", "a..b", ".hidden", "..a/b", ".h/b", "a/.b" };
    lt_arena *arena = lt_arena_new();

    ck_assert_str_eq(lt_path_join(arena, "d", "n"), "d/n");
    ck_assert_str_eq(lt_path_join(arena, "d/", "n"), "d/n");
    ck_assert_str_eq(lt_path_join(arena, "", "n"), "n");
    ck_assert_str_eq(lt_path_join(arena, "d", "/n"), "/n");
    ck_assert_str_eq(lt_path_folder(arena, "a/b/c"), "a/b");
    ck_assert_str_eq(lt_path_folder(arena, "c"), ".");
    ck_assert_str_eq(lt_path_folder(arena, "/c"), "/");
    for (size_t i = 0; i < LT_COUNT(outside); i++)
        ck_assert_msg(!lt_path_is_inside(outside[i]), "%s", outside[i]);
    for (size_t i = 0; i < LT_COUNT(inside); i++)
        ck_assert_msg(lt_path_is_inside(inside[i]), "%s", inside[i]);
    lt_arena_free(arena);
}
END_TEST

START_TEST(only_regular_files)
{
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    size_t n;

    ck_assert_int_eq(mkfifo(in_folder("pipe"), 0600), 0);
    put_file(in_folder("ten"), "0123456789", 10);
    put_file(in_folder("none"), "", 0);
    check_error(lt_read_file(arena, in_folder("pipe"), 10, &bytes, &n), LT_EIO, "not a regular file");
    check_error(lt_read_file(arena, "/dev/zero", 10, &bytes, &n), LT_EIO, "not a regular file");
    check_error(lt_read_file(arena, scratch_folder, 10, &bytes, &n), LT_EIO, "not a regular file");
    check_error(lt_read_file(arena, in_folder("no"), 10, &bytes, &n), LT_EIO, "No such file");
    check_error(lt_read_file(arena, in_folder("ten"), 9, &bytes, &n), LT_EFORMAT, "10 bytes, more than the 9");
    check_ok(lt_read_file(arena, in_folder("ten"), 10, &bytes, &n));
    check_ok(lt_read_file(arena, in_folder("none"), 10, &bytes, &n));
    ck_assert_uint_eq(n, 0);
    lt_arena_free(arena);
}
END_TEST

/* What somebody may have put into a folder that is then written to: links out of it, pipes, devices. */
START_TEST(nothing_is_written_through_links)
{
    const char *outside = in_folder("outside"), *link_to = in_folder("link"), *pipe = in_folder("pipe");
    FILE *f;

    check_ok(lt_write_file(outside, "old", 3));
    ck_assert_int_eq(symlink(outside, link_to), 0);
    ck_assert_int_eq(mkfifo(pipe, 0600), 0);
    check_error(lt_append_own(link_to, &f), LT_EIO, "link: a link to another place, want a file or folder that is");
    check_error(lt_append_own(pipe, &f), LT_EIO, "pipe: a pipe, socket or device");
    check_error(lt_append_own("/dev/null", &f), LT_EIO, "/dev/null: not a regular file");
    check_error(lt_append_own(in_folder("missing/name"), &f), LT_EIO, "missing/name: No such file");
    check_contents(outside, "old");
    check_ok(lt_append_own(outside, &f));
    fputs(", new", f);
    fclose(f);
    check_contents(outside, "old, new");
    unlink(link_to), unlink(pipe), unlink(outside);
}
END_TEST

START_TEST(folders_of_ones_own)
{
    const char *link_to = in_folder("link");

    check_ok(lt_make_own_folder(in_folder("own")));
    check_ok(lt_make_own_folder(in_folder("own")));
    ck_assert_int_eq(symlink(in_folder("own"), link_to), 0);
    check_error(lt_make_own_folder(link_to), LT_EIO, "link: a link to another place");
    ck_assert_int_eq(unlink(link_to), 0);
    ck_assert_int_eq(symlink(in_folder("nowhere"), link_to), 0);
    check_error(lt_make_own_folder(link_to), LT_EIO, "link: a link to another place");
    ck_assert_int_eq(unlink(link_to), 0);
    rmdir(in_folder("own"));
}
END_TEST

/* Of a process that is no more; not of one that lives, nor what only looks like it. */
START_TEST(leftovers_are_swept)
{
    static const char *const stay[] = { "a.tmp", "a.12.tmp", "a-1.tmp", "a.-1.tmp", "a.x-1.tmp", "a.1-.tmp",
        "a.1-2.txt", "a.1-2.tmpx" };
    const pid_t gone = fork();
    char dead[64], film[64], ours[64];

    if (gone == 0)
        _exit(0);
    waitpid(gone, NULL, 0);
    snprintf(dead, sizeof(dead), "config.json.%ld-0.tmp", (long)gone);
    snprintf(ours, sizeof(ours), "config.json.%ld-17.tmp", (long)getpid());
    snprintf(film, sizeof(film), "turn.tmp.%ld-1.tmp.mp4", (long)gone);
    put_file(in_folder(dead), "half", 4);
    put_file(in_folder(film), "half", 4);
    put_file(in_folder(ours), "half", 4);
    for (size_t i = 0; i < LT_COUNT(stay); i++)
        put_file(in_folder(stay[i]), "x", 1);
    lt_atomic_sweep(scratch_folder);
    ck_assert_int_eq(files_in_folder(), 1 + (int)LT_COUNT(stay));
    ck_assert_int_ne(access(in_folder(dead), F_OK), 0);
    ck_assert_int_ne(access(in_folder(film), F_OK), 0);
    ck_assert_int_eq(unlink(in_folder(ours)), 0);
    for (size_t i = 0; i < LT_COUNT(stay); i++)
        unlink(in_folder(stay[i]));
    lt_atomic_sweep(in_folder("missing"));
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, old_until_commit);
    tcase_add_test(tc, abort_leaves_nothing);
    tcase_add_test(tc, unlink_all_leaves_nothing);
    tcase_add_test(tc, names_that_are_taken_are_passed_over);
    tcase_add_test(tc, a_folder_in_the_way_is_left);
    tcase_add_test(tc, a_name_without_a_folder_is_here);
    tcase_add_test(tc, cannot_open);
    tcase_add_test(tc, bits_that_are_refused);
    tcase_add_test(tc, a_folder_to_write_to_only);
    tcase_add_test(tc, full_disk_keeps_old_file);
    tcase_add_test(tc, a_failed_write_is_remembered);
    tcase_add_test(tc, nothing_is_written_through_links);
    tcase_add_test(tc, folders_of_ones_own);
    tcase_add_test(tc, leftovers_are_swept);
    tcase_add_test(tc, dirs);
    tcase_add_test(tc, paths);
    tcase_add_test(tc, only_regular_files);
}

int main(void)
{
    return run_suite("file", add_tests);
}
