/* SPDX-License-Identifier: Apache-2.0 */
/*
 * palmar gradcheck: hand over to palmar-gradcheck, which is linked with the library in double precision.
 */
#include "cli/cli.h"

#include "libtensor/io/file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Beside this program in a build folder, else where it was installed. */
static void find_checker(char path[PATH_MAX])
{
    char folder[PATH_MAX];

    if (lt_program_folder(folder, sizeof(folder))
        && snprintf(path, PATH_MAX, "%s/palmar-gradcheck", folder) < PATH_MAX && access(path, X_OK) == 0)
        return;
    lt_installed(PALMAR_LIBEXECDIR, folder, sizeof(folder));
    if (snprintf(path, PATH_MAX, "%s/palmar-gradcheck", folder) >= PATH_MAX)
        path[0] = '\0';
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
