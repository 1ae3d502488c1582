/* SPDX-License-Identifier: Apache-2.0 */
/* YOLO's text files: data.yaml names folders of pictures, each picture has a file of rows beside it. */
#include "data/detection/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/natural.h"
#include "libtensor/io/text/yaml.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *detection_yaml(lt_arena *arena, const char *root)
{
    const char *path = lt_ends_with(root, ".yaml") || lt_ends_with(root, ".yml") ? root
                       : lt_path_join(arena, root, "data.yaml");

    return path && access(path, R_OK) == 0 && !lt_is_folder(path) ? path : NULL;
}

typedef struct {
    lt_arena *arena;
    const char *yaml, *base;        /* what train and val are relative to */
    detection_set *set;
    const char **picture;           /* paths */
    size_t n, room;
} reading;

static lt_status no_memory(const reading *r)
{
    return lt_error(LT_ENOMEM, "%s: no memory", r->yaml);
}

static const lt_yaml *child(const lt_yaml *map, const char *key)
{
    for (const lt_yaml *v = map->kind == LT_YAML_MAP ? map->first : NULL; v; v = v->next)
        if (strcmp(v->key, key) == 0)
            return v;
    return NULL;
}

/* ---- classes ---- */

/* A list of names, or a map from numbers to them */
static lt_status read_names(const reading *r, const lt_yaml *names)
{
    const char **name = lt_arena_array(r->arena, (size_t)names->n + 1, sizeof(*name));
    int i = 0;

    if (!name)
        return no_memory(r);
    for (const lt_yaml *v = names->first; v; v = v->next, i++) {
        char *end = NULL;
        const long at = names->kind == LT_YAML_MAP ? strtol(v->key, &end, 10) : i;

        if ((end && *end) || at < 0 || at >= names->n || name[at])
            return lt_error(LT_EFORMAT, "%s:%d: names: \"%s\" is no number of its own from 0 to %d", r->yaml, v->line,
                            v->key, names->n - 1);
        name[at] = v->text;
    }
    r->set->class_name = name;
    r->set->classes = names->n;
    return LT_OK;
}

static lt_status read_classes(const reading *r, const lt_yaml *root)
{
    const lt_yaml *names = child(root, "names"), *nc = child(root, "nc");
    int n = 0;
    lt_status st;

    if (!names || names->kind == LT_YAML_SCALAR || !names->n)
        return lt_error(LT_EFORMAT, "%s: names: want a list of the classes' names", r->yaml);
    st = read_names(r, names);
    if (st == LT_OK && nc)
        st = lt_yaml_int(nc, 1, 100000, &n);
    if (st == LT_OK && nc && n != names->n)
        return lt_error(LT_EFORMAT, "%s:%d: nc is %d, but there are %d names", r->yaml, nc->line, n, names->n);
    return st;
}

/* ---- pictures ---- */

static bool is_picture(const char *name)
{
    static const char *const ends[] = { ".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff", ".JPG", ".JPEG",
                                        ".PNG" };

    for (size_t i = 0; i < LT_COUNT(ends); i++)
        if (lt_ends_with(name, ends[i]))
            return true;
    return false;
}

static lt_status add_picture(reading *r, const char *path)
{
    r->picture = path ? lt_arena_grow(r->arena, r->picture, r->n, &r->room, sizeof(*r->picture)) : NULL;
    if (!r->picture)
        return no_memory(r);
    r->picture[r->n++] = path;
    return LT_OK;
}

static lt_status add_folder(reading *r, const char *folder)
{
    DIR *dir = opendir(folder);
    const struct dirent *e;
    lt_status st = LT_OK;

    if (!dir)
        return lt_error(lt_errno_status(errno), "%s: %s", folder, strerror(errno));
    while (st == LT_OK && (e = readdir(dir)))
        if (is_picture(e->d_name))
            st = add_picture(r, lt_path_join(r->arena, folder, e->d_name));
    closedir(dir);
    return st;
}

/* A file with a path in each row; "./" stands for its own folder. */
static lt_status add_file(reading *r, const char *path)
{
    const char *folder = lt_path_folder(r->arena, path);
    uint8_t *bytes;
    size_t n;
    lt_status st = lt_read_file(r->arena, path, LT_FILE_MAX, &bytes, &n);
    char *save = NULL;

    if (st)
        return st;
    for (char *row = strtok_r((char *)bytes, "\r\n", &save); row && !st; row = strtok_r(NULL, "\r\n", &save))
        st = add_picture(r, lt_path_join(r->arena, folder, strncmp(row, "./", 2) == 0 ? row + 2 : row));
    return st;
}

/* Relative to base; a "../" in front that leads nowhere is left out. */
static lt_status add_entry(reading *r, const lt_yaml *v)
{
    const char *path = lt_path_join(r->arena, r->base, v->text);

    if (v->kind != LT_YAML_SCALAR || !*v->text)
        return lt_error(LT_EFORMAT, "%s:%d: want a folder, a file with paths, or a list of these", r->yaml, v->line);
    if (path && access(path, F_OK) != 0 && strncmp(v->text, "../", 3) == 0)
        path = lt_path_join(r->arena, r->base, v->text + 3);
    if (!path)
        return no_memory(r);
    if (access(path, F_OK) != 0)
        return lt_error(LT_EIO, "%s:%d: %s: no such folder or file", r->yaml, v->line, path);
    return lt_is_folder(path) ? add_folder(r, path) : add_file(r, path);
}

static lt_status add_entries(reading *r, const lt_yaml *v)
{
    lt_status st = LT_OK;

    if (v->kind == LT_YAML_SCALAR)
        return add_entry(r, v);
    for (v = v->first; v && st == LT_OK; v = v->next)
        st = add_entry(r, v);
    return st;
}

static int by_name(const void *a, const void *b)
{
    return lt_natural_order(*(const char *const *)a, *(const char *const *)b);
}

/* The last /images/ becomes /labels/, and the ending .txt. */
static char *labels_of(lt_arena *arena, const char *picture)
{
    const char *at = NULL, *dot = strrchr(picture, '.');

    for (const char *p = strstr(picture, "/images/"); p; p = strstr(p + 1, "/images/"))
        at = p;
    if (!dot || (at && dot < at))
        dot = picture + strlen(picture);
    if (!at)
        return lt_arena_printf(arena, "%.*s.txt", (int)(dot - picture), picture);
    return lt_arena_printf(arena, "%.*s/labels/%.*s.txt", (int)(at - picture), picture, (int)(dot - at - 8), at + 8);
}

static lt_status read_labels(const reading *r, const char *path, object_list *out)
{
    uint8_t *bytes;
    size_t n;
    lt_status st;

    if (access(path, F_OK) != 0)
        return LT_OK;                   /* no objects */
    st = lt_read_file(r->arena, path, LT_FILE_MAX, &bytes, &n);
    return st ? st : detection_parse_labels(r->arena, path, (char *)bytes, n, r->set->classes, out, &r->set->dropped);
}

/* What cannot be read of an image leaves the image out. */
static lt_status read_pictures(reading *r)
{
    detection_set *s = r->set;
    detection_image *image = lt_arena_array(r->arena, r->n + 1, sizeof(*image));

    if (!image)
        return no_memory(r);
    qsort(r->picture, r->n, sizeof(*r->picture), by_name);
    for (size_t i = 0; i < r->n; i++) {
        const char *labels = labels_of(r->arena, r->picture[i]), *slash = strrchr(r->picture[i], '/');
        object_list objects = { NULL };
        const bool there = access(r->picture[i], R_OK) == 0;
        char line[512];
        lt_status st = !labels ? no_memory(r) : there ? read_labels(r, labels, &objects) : LT_EIO;

        if (st == LT_ENOMEM)
            return st;
        if (st) {
            snprintf(line, sizeof(line), "%s%s", there ? lt_last_error() : r->picture[i],
                     there ? "" : ": no such picture");
            st = detection_fault(r->arena, s, there ? &s->corrupt : &s->missing, line);
            if (st)
                return st;
            continue;
        }
        image[s->count] = (detection_image){ .id = s->count, .path = r->picture[i], .object = objects.list,
                                             .name = slash ? slash + 1 : r->picture[i], .n = (int)objects.n };
        s->count++;
    }
    s->image = image;
    return LT_OK;
}

/* ---- opening ---- */

static const lt_yaml *entry_of(const lt_yaml *root, const char *split)
{
    static const char *const other[] = { "val", "validation", "test" };
    const lt_yaml *v = NULL;

    if (strcmp(split, "train") == 0)
        return child(root, "train");
    for (size_t i = 0; i < LT_COUNT(other) && !v; i++)
        v = child(root, other[i]);
    return v;
}

lt_status detection_yolo_open(lt_arena *arena, const char *root, const char *split, detection_set *out)
{
    reading r = { .arena = arena, .yaml = detection_yaml(arena, root), .set = out };
    const char *folder = lt_path_folder(arena, r.yaml), *path = NULL;
    const lt_yaml *tree, *entry, *given;
    lt_status st = lt_yaml_read(arena, r.yaml, &tree);

    if (st)
        return st;
    out->title = "YOLO";
    out->list = r.yaml;
    given = child(tree, "path");
    if (given && given->kind == LT_YAML_SCALAR && *given->text)
        path = lt_path_join(arena, folder, given->text);
    r.base = path && lt_is_folder(path) ? path : folder;
    entry = entry_of(tree, split);
    if (!entry)
        return lt_error(LT_EFORMAT, "%s: %s: is not there", r.yaml, strcmp(split, "train") == 0 ? "train" : "val");
    st = read_classes(&r, tree);
    if (st == LT_OK)
        st = add_entries(&r, entry);
    return st ? st : read_pictures(&r);
}
