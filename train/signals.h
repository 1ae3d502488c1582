/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Asked from outside to stop or to save. The handlers only set flags, which the trainer polls; a second
 * SIGINT, SIGTERM or SIGHUP ends the process at once, as if there were no handler. A pipe that nobody reads any more
 * (SIGPIPE) stops as well. A SIGHUP that is ignored, as nohup has it, stays so.
 */
#ifndef TRAIN_SIGNALS_H
#define TRAIN_SIGNALS_H

#include <stdbool.h>

void signals_install(void);
void signals_restore(void);         /* what was there before signals_install */

/* signals_stop - the first signal to stop that came since signals_install; 0: none */
int signals_stop(void);

/* signals_take_save - whether SIGUSR1 came since the last call */
bool signals_take_save(void);

#endif
