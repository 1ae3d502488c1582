/* SPDX-License-Identifier: Apache-2.0 */
/*
 * palmar gradcheck: hand over to palmar-gradcheck, which is linked with the library in double precision.
 */
#include "cli/cli.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Beside this program in a build folder, else where it was installed. */
static void find_checker(char path[PATH_MAX])
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof(self) - 1);

    if (n > 0) {
        self[n] = '\0';
        if (snprintf(path, PATH_MAX, "%s/palmar-gradcheck", dirname(self)) < PATH_MAX && access(path, X_OK) == 0)
            return;
    }
    snprintf(path, PATH_MAX, "%s/palmar-gradcheck", PALMAR_LIBEXECDIR);
}

int cmd_gradcheck(int argc, char **argv)
{
    char path[PATH_MAX];

    (void)argc;
    find_checker(path);
    execv(path, argv);
    lt_error(LT_EIO, "%s: %s; make builds it, make install puts it there", path, strerror(errno));
    return cli_fail(LT_EIO);
}
