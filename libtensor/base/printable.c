/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/printable.h"

#include <string.h>

bool lt_is_control(uint32_t code)
{
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x061c || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

/* The character at s, of *n bytes; where it is no UTF-8, one byte and a control code. */
static uint32_t character(const uint8_t *s, int *n)
{
    static const struct { uint8_t mask, lead; uint32_t least; } form[] = {
        { 0x80, 0x00, 0 }, { 0xe0, 0xc0, 0x80 }, { 0xf0, 0xe0, 0x800 }, { 0xf8, 0xf0, 0x10000 },
    };

    for (int extra = 0; extra < 4; extra++) {
        uint32_t code = *s & (uint8_t)~form[extra].mask;
        int have = 0;

        if ((*s & form[extra].mask) != form[extra].lead)
            continue;
        for (; have < extra && (s[have + 1] & 0xc0) == 0x80; have++)
            code = code << 6 | (s[have + 1] & 0x3f);
        if (have < extra || code < form[extra].least || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
            break;
        *n = extra + 1;
        return code;
    }
    *n = 1;
    return 0;
}

char *lt_printable(char *text)
{
    uint8_t *s = (uint8_t *)text;

    while (*s) {
        int n;

        if (lt_is_control(character(s, &n)))
            memset(s, '?', (size_t)n);
        s += n;
    }
    return text;
}

void lt_vsay(FILE *f, const char *fmt, va_list args)
{
    char line[8192];

    vsnprintf(line, sizeof(line), fmt, args);
    fprintf(f, "%s\n", lt_printable(line));
}

void lt_say(FILE *f, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    lt_vsay(f, fmt, args);
    va_end(args);
}
