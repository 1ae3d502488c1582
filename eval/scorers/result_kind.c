/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/result_kind.h"

#include "libtensor/base/common.h"
#include "libtensor/io/kind.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEAD = 8192, MANY = 20 };      /* MANY fields are more than BOP's line ever has */

static const char scored[] = "a result file: HO3D's pred.json or pred.zip, DexYCB's text of hand joints (HPE) and csv "
                             "of object poses (BOP) are scored";

const char *result_kind_name(result_kind kind)
{
    static const char *const name[] = {
        [RESULT_HO3D] = "HO3D's pred.json", [RESULT_HPE] = "DexYCB's text of hand joints (HPE)",
        [RESULT_BOP] = "BOP's csv of object poses", [RESULT_COCO] = "COCO's JSON of detections",
    };

    return name[kind];
}

/* O_NONBLOCK: opening a pipe must not wait for somebody to write into it. */
static lt_status read_head(const char *path, char head[HEAD + 1], size_t *n)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    ssize_t got = 0;
    lt_status st = LT_OK;

    *n = 0;
    if (fd < 0 || fstat(fd, &info) != 0)
        st = lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    else if (!S_ISREG(info.st_mode))
        st = lt_error(LT_EIO, "%s: not a regular file", path);
    while (!st && *n < HEAD && (got = read(fd, head + *n, HEAD - *n)) > 0)
        *n += (size_t)got;
    if (!st && got < 0)
        st = lt_error(lt_errno_status(errno), "%s: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    head[*n] = '\0';
    return st;
}

static const char *skip_space(const char *s)
{
    if (!strncmp(s, "\xef\xbb\xbf", 3))
        s += 3;
    while (isspace((unsigned char)*s))
        s++;
    return s;
}

/* Lists of lists are points; lists of objects, detections. */
static bool json_kind(const char *text, result_kind *out)
{
    const char *s = skip_space(text);

    if (*s != '[')
        return false;
    s = skip_space(s + 1);
    *out = *s == '{' ? RESULT_COCO : RESULT_HO3D;
    return *s == '{' || *s == '[' || *s == ']';
}

/* By the number of fields of the first line that is not blank; a number, or the names of BOP's, begin it. */
static bool table_kind(const char *text, result_kind *out)
{
    const char *s = skip_space(text);
    const size_t n = strcspn(s, "\r\n");
    int fields = 1;

    for (size_t i = 0; i < n; i++)
        fields += s[i] == ',';
    *out = fields < MANY ? RESULT_BOP : RESULT_HPE;
    return !strncasecmp(s, "scene_id", 8) || (fields > 1 && (isdigit((unsigned char)*s) || *s == '-' || *s == '+'));
}

lt_status result_kind_of(const char *path, result_kind *out)
{
    char head[HEAD + 1];
    size_t n;
    lt_kind kind;
    const lt_status st = read_head(path, head, &n);

    if (st)
        return st;
    kind = lt_kind_of((const uint8_t *)head, n);
    if (kind == LT_KIND_ZIP) {
        *out = RESULT_HO3D;
        return LT_OK;
    }
    if ((!kind || kind == LT_KIND_JSON) && (json_kind(head, out) || table_kind(head, out)))
        return LT_OK;
    return lt_refuse(path, (const uint8_t *)head, n, scored);
}
