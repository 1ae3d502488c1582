/* SPDX-License-Identifier: Apache-2.0 */
/*
 * UTF-8, one character at a time.
 */
#include "libtensor/io/text/utf8.h"

size_t lt_utf8_put(char out[LT_UTF8_MAX], uint32_t code)
{
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        out[0] = (char)(0xc0 | code >> 6);
        out[1] = (char)(0x80 | (code & 63));
        return 2;
    }
    if (code < 0x10000) {
        out[0] = (char)(0xe0 | code >> 12);
        out[1] = (char)(0x80 | (code >> 6 & 63));
        out[2] = (char)(0x80 | (code & 63));
        return code < 0xd800 || code > 0xdfff ? 3 : 0;
    }
    out[0] = (char)(0xf0 | (code >> 18 & 7));
    out[1] = (char)(0x80 | (code >> 12 & 63));
    out[2] = (char)(0x80 | (code >> 6 & 63));
    out[3] = (char)(0x80 | (code & 63));
    return code <= 0x10ffff ? 4 : 0;
}

/* How many bytes follow a first byte; -1 for one that cannot be first. */
static int followers(uint8_t first)
{
    if (first < 0x80)
        return 0;
    if (first < 0xc2 || first > 0xf4)
        return -1;
    return first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
}

uint32_t lt_utf8_next(const char **p, const char *end)
{
    static const uint32_t least[4] = { 0, 0x80, 0x800, 0x10000 };
    const uint8_t *s = (const uint8_t *)*p;
    const int n = followers(s[0]);
    uint32_t code = n <= 0 ? s[0] : s[0] & (0x3fu >> n);

    (*p)++;
    if (n < 0 || n >= end - (const char *)s)
        return 0xfffd;
    for (int i = 1; i <= n; i++) {
        if ((s[i] & 0xc0) != 0x80)
            return 0xfffd;
        code = code << 6 | (s[i] & 0x3f);
    }
    if (code < least[n] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff))
        return 0xfffd;
    *p += n;
    return code;
}
