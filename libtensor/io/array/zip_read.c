/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reading zip archives that nobody vouches for. Nothing is unpacked before the sizes of all entries
 * are known to be possible; nothing is ever written to a path that an archive names.
 */
#include "libtensor/io/array/zip_read.h"

#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"

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
    lt_zip z = { .path = path };
    zip_error_t error;
    zip_int64_t count;
    lt_status st;

    if (lt_kind_of(bytes, n) != LT_KIND_ZIP)            /* nothing is to libzip an archive without entries */
        return lt_refuse(path, bytes, n, "a zip archive");
    zip_error_init(&error);
    z.archive = open_memory(bytes, n, &error);
    if (!z.archive) {
        const bool cut = zip_error_code_zip(&error) == ZIP_ER_NOZIP;        /* its list stands at the end */

        st = lt_error(LT_EFORMAT, "%s: %s: %s", path, cut ? "a zip archive that is cut short; copy or download it again"
                                                          : "a damaged zip archive", zip_error_strerror(&error));
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

lt_status lt_zip_unpack(lt_zip *z, size_t i, uint8_t *out)
{
    const lt_zip_entry *e = &z->entry[i];
    zip_file_t *f = zip_fopen_index(z->archive, i, 0);
    zip_int64_t got;
    uint8_t past;
    lt_status st = LT_OK;

    if (!f)
        return lt_error(LT_EFORMAT, "%s: \"%s\": %s", z->path, e->name, zip_strerror(z->archive));
    got = zip_fread(f, out, e->bytes);
    if (got < 0)
        st = lt_error(LT_EFORMAT, "%s: \"%s\": %s", z->path, e->name, zip_file_strerror(f));
    else if ((size_t)got != e->bytes)
        st = lt_error(LT_EFORMAT, "%s: \"%s\" unpacks to %zu bytes, want %zu", z->path, e->name,
                      (size_t)got, e->bytes);
    else if (zip_fread(f, &past, 1) != 0)       /* the checksum is compared on reaching the end */
        st = lt_error(LT_EFORMAT, "%s: \"%s\": wrong checksum or more data than declared", z->path,
                      e->name);
    zip_fclose(f);
    return st;
}

void lt_zip_close(lt_zip *z)
{
    zip_discard(z->archive);
    z->archive = NULL;
}
