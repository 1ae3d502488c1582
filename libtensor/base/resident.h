/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that this process has at hand. */
#ifndef LT_BASE_RESIDENT_H
#define LT_BASE_RESIDENT_H

#include <stddef.h>
#include <stdio.h>
#include <unistd.h>

/* lt_resident - bytes; 0 where the system does not tell */
static inline size_t lt_resident(void)
{
    FILE *f = fopen("/proc/self/statm", "r");
    unsigned long pages = 0;

    if (f && fscanf(f, "%*u %lu", &pages) != 1)
        pages = 0;
    if (f)
        fclose(f);
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

#endif
