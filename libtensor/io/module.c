/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/module.h"

#include "libtensor/io/file.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static void *load(const char *folder, const char *name, const char *symbol)
{
    char path[2 * PATH_MAX];
    void *module;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    module = access(path, R_OK) == 0 ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
    return module ? dlsym(module, symbol) : NULL;
}

void *lt_module_symbol(const char *module, const char *symbol)
{
    const char *named = getenv("PALMAR_MODULES");
    char folder[PATH_MAX];
    void *found = named ? load(named, module, symbol) : NULL;

    if (!found && lt_program_folder(folder, sizeof(folder)))
        found = load(folder, module, symbol);
    if (found)
        return found;
    lt_installed(PALMAR_LIBDIR, folder, sizeof(folder));
    return load(folder, module, symbol);
}
