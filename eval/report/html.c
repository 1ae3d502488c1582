/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/report/internal.h"

#include "libtensor/io/text/utf8.h"

#include <string.h>
#include <unistd.h>

static void put_character(FILE *f, uint32_t code)
{
    char bytes[LT_UTF8_MAX];

    switch (code) {
    case '&': fputs("&amp;", f); break;
    case '<': fputs("&lt;", f); break;
    case '>': fputs("&gt;", f); break;
    case '"': fputs("&quot;", f); break;
    case '\'': fputs("&#39;", f); break;
    case '\n': case '\t': fputc((int)code, f); break;
    default:
        if (code < 0x20 || (code >= 0x7f && code < 0xa0))
            code = 0xfffd;
        fwrite(bytes, 1, lt_utf8_put(bytes, code), f);
    }
}

static void put_text(FILE *f, const char *text, const char *end)
{
    while (text < end)
        put_character(f, lt_utf8_next(&text, end));
}

void html_text(FILE *f, const char *text)
{
    put_text(f, text, text + strlen(text));
}

/* ---- our tables ------------------------------------------------------------------------------------------------- */

static const char *line_end(const char *line)
{
    const char *end = strchr(line, '\n');

    return end ? end : line + strlen(line);
}

/* "| --- | --: |" */
static bool is_ruler(const char *line)
{
    return strspn(line, "|-: ") == (size_t)(line_end(line) - line) && strstr(line, "--");
}

/* Whether the ruler aligns a column at its right: "--:" */
static bool is_right(const char *ruler, int column)
{
    const char *end = line_end(ruler), *bar = ruler;

    for (int i = 0; bar && end - bar > 1 && i <= column; i++)
        bar = memchr(bar + 1, '|', (size_t)(end - bar - 1));
    while (bar && bar > ruler && bar[-1] == ' ')
        bar--;
    return bar && bar > ruler && bar[-1] == ':';
}

static void put_row(FILE *f, const char *line, const char *ruler, const char *cell)
{
    const char *end = line_end(line), *at = line + 1, *bar;

    fputs("<tr>", f);
    for (int column = 0; (bar = memchr(at, '|', (size_t)(end - at))); column++) {
        const char *a = at + strspn(at, " "), *b = bar;

        while (b > a && b[-1] == ' ')
            b--;
        fprintf(f, "<%s%s>", cell, is_right(ruler, column) ? " class=n" : "");
        put_text(f, a, b > a ? b : a);
        fprintf(f, "</%s>", cell);
        at = bar + 1;
    }
    fputs("</tr>\n", f);
}

static const char *next_line(const char *line)
{
    const char *end = line_end(line);

    return *end ? end + 1 : end;
}

static const char *put_table(FILE *f, const char *line)
{
    const char *ruler = next_line(line);
    const bool headed = is_ruler(ruler);

    fputs("<div class=wide><table>\n", f);
    put_row(f, line, headed ? ruler : "", headed ? "th" : "td");
    line = headed ? next_line(ruler) : ruler;
    for (; *line == '|'; line = next_line(line))
        put_row(f, line, headed ? ruler : "", "td");
    fputs("</table></div>\n", f);
    return line;
}

void html_markdown(FILE *f, const char *text)
{
    while (*text) {
        const char *end = line_end(text);

        if (*text == '|') {
            text = put_table(f, text);
            continue;
        }
        if (*text == '#') {
            fputs("<h3>", f);
            put_text(f, text + strspn(text, "# "), end);
            fputs("</h3>\n", f);
        } else if (end > text) {
            fputs("<p>", f);
            put_text(f, text, end);
            fputs("</p>\n", f);
        }
        text = *end ? end + 1 : end;
    }
}

/* ---- scripts ---------------------------------------------------------------------------------------------------- */

/* What ends strings, or a script's element, is escaped. */
void html_script_string(FILE *f, const char *text)
{
    const char *end = text + strlen(text);

    fputc('"', f);
    while (text < end) {
        const uint32_t code = lt_utf8_next(&text, end);
        char bytes[LT_UTF8_MAX];

        if (code < 0x20 || code == '"' || code == '\\' || code == '<' || code == '>' || code == '&')
            fprintf(f, "\\u%04x", code);
        else
            fwrite(bytes, 1, lt_utf8_put(bytes, code), f);
    }
    fputc('"', f);
}

/* ---- pictures --------------------------------------------------------------------------------------------------- */

void html_base64(FILE *f, const uint8_t *bytes, size_t n)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

    for (size_t i = 0; i < n; i += 3) {
        const uint32_t x = (uint32_t)bytes[i] << 16 | (i + 1 < n ? (uint32_t)bytes[i + 1] << 8 : 0)
            | (i + 2 < n ? bytes[i + 2] : 0);
        const char four[4] = { digit[x >> 18], digit[x >> 12 & 63], i + 1 < n ? digit[x >> 6 & 63] : '=',
                               i + 2 < n ? digit[x & 63] : '=' };

        fwrite(four, 1, 4, f);
    }
}

static void put_image(FILE *f, const char *kind, const uint8_t *bytes, size_t n, const char *what)
{
    fputs("<img alt=\"", f);
    html_text(f, what);
    fprintf(f, "\" src=\"data:image/%s;base64,", kind);
    html_base64(f, bytes, n);
    fputs("\">\n", f);
}

void html_picture(FILE *f, const uint8_t *png, size_t n, const char *what)
{
    put_image(f, "png", png, n, what);
}

void html_jpeg(FILE *f, const uint8_t *jpeg, size_t n, const char *what)
{
    put_image(f, "jpeg", jpeg, n, what);
}

/* ---- the page's beginning --------------------------------------------------------------------------------------- */

lt_status html_draw_nonce(html_nonce out)
{
    uint8_t bytes[16];

    if (getentropy(bytes, sizeof(bytes)))
        return lt_error(LT_EIO, "the system has no random number for the page's script");
    for (size_t i = 0; i < sizeof(bytes); i++)
        snprintf(out + 2 * i, 3, "%02x", bytes[i]);
    return LT_OK;
}

static const char policy[] =
    "<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8>\n"
    "<meta http-equiv=Content-Security-Policy content=\"default-src 'none'; style-src 'unsafe-inline'; "
    "img-src data:";

static const char head[] =
    "\">\n<meta name=viewport content=\"width=device-width\">\n<style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#222}\n"
    "h1,h2{font-weight:600}h2{border-bottom:1px solid #ccc;margin-top:2.5rem}\n"
    ".wide{overflow-x:auto}table{border-collapse:collapse}th,td{padding:.2rem .6rem;border-bottom:1px solid #e4e4e4;"
    "text-align:left}.n{text-align:right;font-variant-numeric:tabular-nums}\n"
    ".label{background:#b45309;color:#fff;border-radius:3px;padding:.1rem .5rem;font-size:14px}\n"
    "svg{margin:.3rem}svg text{font-size:10px;fill:#555}svg .t{font-size:12px;fill:#222}\n"
    ".a{fill:none;stroke:#999}.c{fill:none;stroke:#1d4ed8;stroke-width:1.5}rect{fill:#1d4ed8}\n"
    "circle{fill:#1d4ed8;opacity:0}circle:hover{opacity:1}img{max-width:100%}pre{overflow-x:auto;background:#f6f6f6;"
    "padding:.8rem}\n#view canvas{display:block;width:min(100%,40rem);touch-action:none;cursor:grab}"
    "#view input[type=range]{width:16rem;vertical-align:middle}#view label{margin-right:1rem}"
    "#view [hidden]{display:none}#view figure{margin:.5rem 0}\n"
    ".row{display:flex;align-items:center;font-size:12px;line-height:1.3}.row span{flex:0 0 11rem;text-align:right;"
    "overflow:hidden;white-space:nowrap;text-overflow:ellipsis}.row svg{margin:0 0 0 .5rem;background:#f6f6f6;"
    "flex:none}\n#sets input{width:100%}#sets figure{margin:.5rem 0}\n</style>\n<title>";

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');

    return slash && slash[1] ? slash + 1 : path;
}

void html_begin(FILE *f, const char *folder, const char *nonce)
{
    fputs(policy, f);
    if (*nonce)
        fprintf(f, "; script-src 'nonce-%s'", nonce);
    fputs(head, f);
    html_text(f, last_part(folder));
    fputs("</title></head><body>\n<h1>", f);
    html_text(f, last_part(folder));
    fputs("</h1>\n", f);
}
