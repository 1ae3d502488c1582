/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of palmar that need libraries of their own, loaded when they are first wanted. */
#ifndef LT_IO_MODULE_H
#define LT_IO_MODULE_H

#include "libtensor/base/common.h"

/* LT_MODULE_HINT - for lines that miss one */
#define LT_MODULE_HINT ", its module where it was installed or where PALMAR_MODULES says"

/* lt_module_symbol - what a module, "images-opencv.so", has under this name: looked for where PALMAR_MODULES says,
 * beside the program as in a build folder, and where palmar was installed. NULL where there is none; it stays
 * loaded. */
void *lt_module_symbol(const char *module, const char *symbol);

#endif
