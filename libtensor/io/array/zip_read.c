/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reading zip archives that nobody vouches for. Nothing is unpacked before the sizes of all entries
 * are known to be possible; nothing is ever written to a path that an archive names.
 */
#include "libtensor/io/array/zip_read.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <zip.h>

enum { DEFLATE_RATIO = 1032, DEFLATE_SLACK = 64, MAX_ENTRIES = 1 << 20 };

/* PyTorch calls the folder in its archive as the file was called: "epoch=3 (best).pth". */
static bool name_is_printable(const char *name)
{
    const char *p = name;

    while (*p >= ' ' && *p <= '~')
        p++;
    return *p == '\0';
}

/* A name is a key and no path, as nothing is unpacked: "/model/w" and "w:0" are keys that people have. What would climb
 * out of a folder nobody means. */
static bool name_climbs(const char *name)
{
    for (const char *p = name; (p = strstr(p, "..")) != NULL; p += 2)
        if ((p == name || p[-1] == '/') && (p[2] == '/' || p[2] == '\0'))
            return true;
    return strchr(name, '\\') != NULL;
}

/* NULL, or why the entry cannot be. */
static const char *check_stat(const zip_stat_t *s, size_t archive_bytes)
{
    const zip_uint64_t need = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                              ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;

    if ((s->valid & need) != need)
        return "entry without a name or size";
    if (!*s->name || name_climbs(s->name))
        return "entry whose name is no path inside the archive";
    if (!name_is_printable(s->name))
        return "entry whose name is not made of printable ASCII";
    if (s->encryption_method != ZIP_EM_NONE)
        return "encrypted entry";
    if (s->comp_size > archive_bytes)
        return "entry larger than the archive";
    if (s->comp_method == ZIP_CM_STORE)
        return s->size == s->comp_size ? NULL : "stored entry with two sizes";
    if (s->comp_method != ZIP_CM_DEFLATE)
        return "entry packed in another way than stored or deflate";
    if (s->size > s->comp_size * DEFLATE_RATIO + DEFLATE_SLACK)
        return "entry that claims to unpack to more than deflate can";
    return NULL;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static lt_status check_unique(const lt_zip *z)
{
    const char **name = lt_alloc(z->n * sizeof(*name));
    lt_status st = LT_OK;

    if (!name)
        return lt_error(LT_ENOMEM, "%s: no memory", z->path);
    for (size_t i = 0; i < z->n; i++)
        name[i] = z->entry[i].name;
    qsort(name, z->n, sizeof(*name), by_name);
    for (size_t i = 1; i < z->n && !st; i++)
        if (strcmp(name[i - 1], name[i]) == 0)
            st = lt_error(LT_EFORMAT, "%s: two entries named \"%s\"", z->path, name[i]);
    lt_release(name);
    return st;
}

/* Packed sizes may not add up to more than the archive: entries that share bytes are a bomb. */
static lt_status list_entries(lt_arena *arena, lt_zip *z, size_t archive_bytes)
{
    zip_uint64_t packed = 0, unpacked = 0;

    for (size_t i = 0; i < z->n; i++) {
        const char *wrong;
        zip_stat_t s;

        if (zip_stat_index(z->archive, i, 0, &s) != 0)
            return lt_error(LT_EFORMAT, "%s: entry %zu: %s", z->path, i, zip_strerror(z->archive));
        wrong = check_stat(&s, archive_bytes);
        if (wrong)
            return lt_error(LT_EFORMAT, "%s: entry %zu: %s", z->path, i, wrong);
        packed += s.comp_size;
        unpacked += s.size;
        if (packed > archive_bytes)
            return lt_error(LT_EFORMAT, "%s: entries overlap", z->path);
        if (unpacked > LT_FILE_MAX)
            return lt_error(LT_EFORMAT, "%s: unpacks to more than %zu bytes", z->path, LT_FILE_MAX);
        z->entry[i].bytes = (size_t)s.size;
        z->entry[i].name = lt_arena_strdup(arena, s.name);
        if (!z->entry[i].name)
            return lt_error(LT_ENOMEM, "%s: no memory", z->path);
    }
    return check_unique(z);
}

/* Why libzip refused. errno was 0 before. */
static lt_status refuse_entry(const lt_zip *z, size_t i, const char *why)
{
    return lt_error(lt_decoder_status(errno), "%s: \"%s\": %s", z->path, z->entry[i].name, why);
}

static zip_t *open_memory(const uint8_t *bytes, size_t n, zip_error_t *error)
{
    zip_source_t *source = zip_source_buffer_create(bytes, n, 0, error);
    zip_t *archive = source ? zip_open_from_source(source, ZIP_RDONLY, error) : NULL;

    if (source && !archive)
        zip_source_free(source);
    return archive;
}

lt_status lt_zip_open(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n, lt_zip *out)
{
    const lt_kind kind = lt_kind_of(bytes, n);
    lt_zip z = { .path = path };
    zip_error_t error;
    zip_int64_t count;
    lt_status st;

    if (!lt_kind_is_zip(kind))                          /* nothing is to libzip an archive without entries */
        return lt_refuse(path, bytes, n, "a zip archive");
    zip_error_init(&error);
    errno = 0;
    z.archive = open_memory(bytes, n, &error);
    if (!z.archive) {
        st = errno == ENOMEM ? lt_error(LT_ENOMEM, "%s: no memory", path)
            : zip_error_code_zip(&error) == ZIP_ER_NOZIP
            ? lt_refuse_cut(path, kind, "no list of what it holds at the end of its %zu bytes", n)
            : lt_error(LT_EFORMAT, "%s: a damaged zip archive: %s", path, zip_error_strerror(&error));
        zip_error_fini(&error);
        return st;
    }
    zip_error_fini(&error);
    count = zip_get_num_entries(z.archive, 0);
    z.n = count < 0 || count > MAX_ENTRIES ? 0 : (size_t)count;
    z.entry = lt_arena_array(arena, z.n, sizeof(*z.entry));
    if (count > MAX_ENTRIES)
        st = lt_error(LT_EFORMAT, "%s: more than %d entries", path, MAX_ENTRIES);
    else if (!z.entry)
        st = lt_error(LT_ENOMEM, "%s: no memory for %zu entries", path, z.n);
    else
        st = list_entries(arena, &z, n);
    if (st)
        lt_zip_close(&z);
    else
        *out = z;
    return st;
}

/* How much follows, unpacked and forgotten, though not far beyond what is wanted; -1 where it cannot be unpacked, or
 * the checksum at its end is wrong. */
static zip_int64_t skip(zip_file_t *f, size_t want)
{
    uint8_t block[1 << 14];
    zip_int64_t got = 1, all = 0;

    while (got > 0 && (size_t)all <= want) {
        got = zip_fread(f, block, sizeof(block));
        all += got;
    }
    return got < 0 ? got : all;
}

lt_status lt_zip_look(lt_zip *z, size_t i, uint8_t *out, size_t n)
{
    const lt_zip_entry *e = &z->entry[i];
    const size_t kept = n < e->bytes ? n : e->bytes;
    zip_file_t *f;
    zip_int64_t got, rest;
    lt_status st = LT_OK;

    errno = 0;
    f = zip_fopen_index(z->archive, i, 0);
    if (!f)
        return refuse_entry(z, i, zip_strerror(z->archive));
    got = zip_fread(f, out, kept);
    rest = got == (zip_int64_t)kept ? skip(f, e->bytes - kept) : 0;
    if (got < 0 || (rest < 0 && kept < e->bytes))
        st = refuse_entry(z, i, zip_file_strerror(f));
    else if (rest >= 0 && (size_t)(got + rest) < e->bytes)
        st = lt_error(LT_EFORMAT, "%s: \"%s\" unpacks to %zu bytes, want %zu", z->path, e->name,
                      (size_t)(got + rest), e->bytes);
    else if (rest < 0 || (size_t)(got + rest) > e->bytes)
        st = lt_error(LT_EFORMAT, "%s: \"%s\": wrong checksum or more data than declared", z->path,
                      e->name);
    zip_fclose(f);
    return st;
}

lt_status lt_zip_unpack(lt_zip *z, size_t i, uint8_t *out)
{
    return lt_zip_look(z, i, out, z->entry[i].bytes);
}

void lt_zip_close(lt_zip *z)
{
    zip_discard(z->archive);
    z->archive = NULL;
}
