/* SPDX-License-Identifier: Apache-2.0 */
#include "train/signals.h"

#include "libtensor/base/common.h"
#include "libtensor/io/atomic_file.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t stop, save;

static void on_stop(int sig)
{
    if (stop) {
        lt_atomic_unlink_all();
        signal(sig, SIG_DFL);
        raise(sig);
    }
    stop = sig;
}

/* Nobody reads what is printed; more of it comes before the run has saved. */
static void on_broken_pipe(int sig)
{
    stop = stop ? stop : sig;
}

static void on_save(int sig)
{
    (void)sig;
    save = 1;
}

static const struct { int number; void (*handler)(int); } caught[] = {
    { SIGINT, on_stop }, { SIGTERM, on_stop }, { SIGHUP, on_stop }, { SIGPIPE, on_broken_pipe }, { SIGUSR1, on_save },
};
static struct sigaction before[LT_COUNT(caught)];

void signals_install(void)
{
    stop = save = 0;
    for (size_t i = 0; i < LT_COUNT(caught); i++) {
        struct sigaction a = { .sa_handler = caught[i].handler, .sa_flags = SA_RESTART };

        sigemptyset(&a.sa_mask);
        sigaction(caught[i].number, &a, &before[i]);
        if (caught[i].number == SIGHUP && before[i].sa_handler == SIG_IGN)         /* as nohup has it */
            sigaction(caught[i].number, &before[i], NULL);
    }
}

void signals_restore(void)
{
    for (size_t i = 0; i < LT_COUNT(caught); i++)
        sigaction(caught[i].number, &before[i], NULL);
}

int signals_stop(void)
{
    return stop;
}

bool signals_take_save(void)
{
    const bool came = save;

    save = 0;
    return came;
}
