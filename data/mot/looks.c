/* SPDX-License-Identifier: Apache-2.0 */
/* Who looks like whom, of sets that `palmar synth` made. */
#include "data/mot/mot.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <string.h>
#include <unistd.h>

static const char heading[] = "person,split,shape,clothes,left_hand,right_hand";

enum { PERSON, SPLIT, SHAPE, CLOTHES, LEFT, RIGHT, COLUMNS };

static lt_status take_person(const char *path, size_t number, const char *line, mot_person *out)
{
    int64_t v[COLUMNS] = { 0 };

    for (int c = 0; c < COLUMNS; c++) {
        const size_t n = strcspn(line, ",");
        const char *end;
        const double x = c == SPLIT ? 0 : lt_strtod(line, &end);

        if (c != SPLIT && (end != line + n || !(x >= 1 && x <= MOT_MAX_ID) || x != (double)(int64_t)x))
            return lt_error(LT_EFORMAT, "%s:%zu: column %d is \"%.*s\", expected a whole number from 1 on", path,
                            number, c + 1, (int)(n < 20 ? n : 20), line);
        v[c] = (int64_t)x;
        if ((line[n] == ',') != (c + 1 < COLUMNS))
            return lt_error(LT_EFORMAT, "%s:%zu: expected %d columns: %s", path, number, (int)COLUMNS, heading);
        line += n + 1;
    }
    *out = (mot_person){ v[PERSON], lt_min_i64(v[SHAPE], v[CLOTHES]), { v[LEFT], v[RIGHT] } };
    return LT_OK;
}

lt_status mot_parse_looks(lt_arena *arena, const char *path, char *text, size_t n, mot_looks *out)
{
    lt_text_lines lines;
    mot_person *all = NULL;
    size_t count = 0, room = 0;
    lt_status st = LT_OK;

    *out = (mot_looks){ 0 };
    if (memchr(text, 0, n))
        return lt_error(LT_EFORMAT, "%s: has a NUL character: no file of persons", path);
    lines = lt_lines_of(text, n);
    for (char *line = lt_next_line(&lines); line && !st; line = lt_next_line(&lines)) {
        line[strcspn(line, "\r")] = '\0';
        if (lines.number == 1 && strcmp(line, heading) != 0)
            return lt_error(LT_EFORMAT, "%s:1: \"%.30s\", expected %s", path, line, heading);
        if (lines.number == 1 || !*line)
            continue;
        all = lt_arena_grow(arena, all, count, &room, sizeof(*all));
        st = all ? take_person(path, lines.number, line, &all[count++])
                 : lt_error(LT_ENOMEM, "%s: no memory for its persons", path);
    }
    if (!st)
        *out = (mot_looks){ all, (int)count };
    return st;
}

lt_status mot_read_looks(lt_arena *arena, const char *root, mot_looks *out)
{
    const char *path = lt_path_join(arena, root, "identities.csv");
    uint8_t *text;
    size_t n;
    lt_status st;

    *out = (mot_looks){ 0 };
    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory for its persons", root);
    if (access(path, F_OK) != 0)
        return LT_OK;
    st = lt_read_file(arena, path, LT_FILE_MAX, &text, &n);
    return st ? st : mot_parse_looks(arena, path, (char *)text, n, out);
}

static bool ends_in(const char *name, const char *end)
{
    const size_t n = strlen(name), m = strlen(end);

    return n >= m && strcmp(name + n - m, end) == 0;
}

int64_t mot_look(const mot_looks *looks, const char *name, int64_t id)
{
    const bool hand = ends_in(name, "_hand");

    for (int i = 0; i < looks->n && (hand || ends_in(name, "_person")); i++) {
        const mot_person *p = &looks->person[i];

        if (hand ? p->hand[0] == id || p->hand[1] == id : p->id == id)
            return p->look;
    }
    return hand ? -id : id;
}
