/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finding the image that an OBJ file's material library names. Names in files are only followed inside
 * the file's own folder.
 */
#include "libtensor/io/mesh/obj_texture.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/lines.h"

#include <string.h>

enum { LIBRARY_BYTES_MAX = 1 << 20 };

/* A copy of the rest of a line without blanks at its end. */
static char *trimmed(lt_arena *scratch, const char *rest)
{
    char *copy = lt_arena_strdup(scratch, rest);
    size_t n = copy ? strlen(copy) : 0;

    while (n > 0 && strchr(" \t\r", copy[n - 1]))
        copy[--n] = '\0';
    return copy;
}

/* The file name of a map_Kd line: all of it, or the last word when options come first. */
static const char *file_name(lt_arena *scratch, const char *rest)
{
    const char *name = trimmed(scratch, rest);
    const char *blank = name && name[0] == '-' ? strrchr(name, ' ') : NULL;

    return blank ? blank + 1 : name;
}

/* map_Kd of the material wanted; of the first one that has any when none is. */
static const char *find_map(lt_arena *scratch, char *text, size_t n, const char *material)
{
    lt_text_lines lines = lt_lines_of(text, n);
    bool wanted = !material;
    char *line;

    while ((line = lt_next_line(&lines)) != NULL) {
        const char *rest;

        if (lt_line_is(line, "newmtl", &rest) && material) {
            const char *name = trimmed(scratch, rest);

            wanted = name && strcmp(name, material) == 0;
        } else if (wanted && lt_line_is(line, "map_Kd", &rest)) {
            return file_name(scratch, rest);
        }
    }
    return NULL;
}

lt_status lt_obj_texture(lt_arena *arena, lt_arena *scratch, const char *obj_path, const char *library,
                         const char *material, const char **texture)
{
    const char *folder = lt_path_folder(scratch, obj_path), *name, *path;
    uint8_t *bytes;
    size_t n;

    *texture = NULL;
    library = library ? trimmed(scratch, library) : NULL;
    material = material ? trimmed(scratch, material) : NULL;
    if (!folder || !library || !lt_path_is_inside(library))
        return LT_OK;
    path = lt_path_join(scratch, folder, library);
    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", obj_path);
    if (lt_read_file(scratch, path, LIBRARY_BYTES_MAX, &bytes, &n) || memchr(bytes, '\0', n))
        return LT_OK;
    name = find_map(scratch, (char *)bytes, n, material);
    if (!name || !lt_path_is_inside(name))
        return LT_OK;
    *texture = lt_path_join(arena, folder, name);
    return *texture ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", obj_path);
}
