/* SPDX-License-Identifier: Apache-2.0 */
#include "data/ho3d/points_text.h"

#include "libtensor/base/arena.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

struct points_text {
    const char *path;               /* the caller's, for error lines while it is being opened */
    char *name;
    FILE *file;
    zip_t *archive;
    zip_file_t *entry;
    char note[512];
    bool begun;
};

/* ---- archives ---- */

/* What macOS packs beside each file. */
static bool is_resource_fork(const char *entry, const char *base)
{
    return !strncmp(entry, "__MACOSX/", 9) || !strncmp(base, "._", 2);
}

static const char *base_of(const char *entry)
{
    const char *slash = strrchr(entry, '/');

    return slash ? slash + 1 : entry;
}

typedef struct { int n; const char *first, *second; zip_uint64_t at; } entries;

/* Those called name, or where name is NULL those that end in .json. */
static entries find_entries(zip_t *archive, const char *name)
{
    const zip_int64_t n = zip_get_num_entries(archive, 0);
    entries e = { 0 };

    for (zip_int64_t i = 0; i < n; i++) {
        const char *entry = zip_get_name(archive, (zip_uint64_t)i, 0), *base = entry ? base_of(entry) : "";
        if (!entry || is_resource_fork(entry, base) || (name ? strcmp(base, name) != 0 : !lt_ends_with(base, ".json")))
            continue;
        if (!e.n++) {
            e.first = entry;
            e.at = (zip_uint64_t)i;
        } else {
            e.second = entry;
        }
    }
    return e;
}

static lt_status choose_entry(points_text *t, zip_uint64_t *out)
{
    const zip_int64_t top = zip_name_locate(t->archive, "pred.json", 0);
    entries e;

    if (top >= 0) {
        *out = (zip_uint64_t)top;
        return LT_OK;
    }
    e = find_entries(t->archive, "pred.json");
    if (!e.n)
        e = find_entries(t->archive, NULL);
    if (!e.n)
        return lt_error(LT_EFORMAT, "%s: no JSON file in this archive, expected pred.json in it", t->path);
    if (e.n > 1)
        return lt_error(LT_EFORMAT, "%s: found %.100s and %.100s in it, expected pred.json at the top: zip -j", t->path,
                        e.first, e.second);
    snprintf(t->note, sizeof(t->note), "found %.200s in it, which is read; HO3D's server wants pred.json at the top of "
             "the archive: zip -j", e.first);
    *out = e.at;
    return LT_OK;
}

/* Why libzip refused. errno was 0 before. */
static lt_status refuse_archive(const char *path, const char *why)
{
    return lt_error(lt_decoder_status(errno), "%s: %s", path, why);
}

static lt_status open_archive(points_text *t)
{
    int why = 0;
    zip_uint64_t at = 0;
    lt_status st;

    errno = 0;
    t->archive = zip_open(t->path, ZIP_RDONLY | ZIP_CHECKCONS, &why);
    if (!t->archive)                                    /* an archive's list stands at its end */
        return refuse_archive(t->path, why == ZIP_ER_NOZIP ? "a zip archive that is cut short; copy or download it "
                                                             "again" : "a damaged zip archive");
    st = choose_entry(t, &at);
    if (st)
        return st;
    errno = 0;
    t->entry = zip_fopen_index(t->archive, at, 0);
    return t->entry ? LT_OK : refuse_archive(t->path, zip_strerror(t->archive));
}

/* ---- files ---- */

static lt_status open_file(points_text *t)
{
    const int fd = open(t->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;

    t->file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!t->file || fstat(fd, &info) != 0) {
        if (fd >= 0 && !t->file)
            close(fd);
        return lt_error(lt_errno_status(errno), "%s: %s", t->path, strerror(errno));
    }
    return S_ISREG(info.st_mode) ? LT_OK : lt_error(LT_EIO, "%s: not a regular file", t->path);
}

/* What is no JSON may be anything that the scanner would not have a name for. */
static lt_status open_text(points_text *t)
{
    uint8_t head[512];
    size_t n;
    lt_kind kind;
    lt_status st = open_file(t);

    if (st)
        return st;
    n = fread(head, 1, sizeof(head), t->file);
    kind = lt_kind_of(head, n);
    if (kind == LT_KIND_ZIP)
        return open_archive(t);
    if (kind && kind != LT_KIND_JSON)
        return lt_refuse(t->path, head, n, "HO3D's points in JSON, or an archive of them");
    rewind(t->file);
    return LT_OK;
}

lt_status points_text_open(const char *path, points_text **out)
{
    points_text *t = lt_alloc(sizeof(*t));
    lt_status st;

    if (!t)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    t->path = path;
    st = open_text(t);
    t->path = NULL;
    t->name = st ? NULL : strdup(path);
    if (!st && !t->name)
        st = lt_error(LT_ENOMEM, "%s: no memory", path);
    if (st)
        points_text_close(t);
    else
        *out = t;
    return st;
}

static lt_status read_some(points_text *t, char *bytes, size_t room, size_t *n)
{
    zip_int64_t got;

    *n = 0;
    if (!t->entry) {
        *n = fread(bytes, 1, room, t->file);
        return *n || !ferror(t->file) ? LT_OK : lt_error(lt_errno_status(errno), "%s: %s", t->name, strerror(errno));
    }
    errno = 0;
    got = zip_fread(t->entry, bytes, room);
    if (got < 0)
        return refuse_archive(t->name, zip_file_strerror(t->entry));
    *n = (size_t)got;
    return LT_OK;
}

lt_status points_text_read(points_text *t, char *bytes, size_t room, size_t *n)
{
    const lt_status st = read_some(t, bytes, room, n);

    if (!st && !t->begun && *n >= 3 && !memcmp(bytes, "\xef\xbb\xbf", 3))
        memset(bytes, ' ', 3);
    t->begun = true;
    return st;
}

const char *points_text_note(const points_text *t)
{
    return *t->note ? t->note : NULL;
}

void points_text_close(points_text *t)
{
    if (!t)
        return;
    if (t->entry)
        zip_fclose(t->entry);
    if (t->archive)
        zip_discard(t->archive);
    if (t->file)
        fclose(t->file);
    free(t->name);
    lt_release(t);
}
