/* SPDX-License-Identifier: Apache-2.0 */
#include "train/signals.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t stop, save;
static struct sigaction before[3];
static const int number[3] = { SIGINT, SIGTERM, SIGUSR1 };

static void on_stop(int sig)
{
    if (stop) {
        signal(sig, SIG_DFL);
        raise(sig);
    }
    stop = sig;
}

static void on_save(int sig)
{
    (void)sig;
    save = 1;
}

void signals_install(void)
{
    stop = save = 0;
    for (int i = 0; i < 3; i++) {
        struct sigaction a = { .sa_handler = number[i] == SIGUSR1 ? on_save : on_stop, .sa_flags = SA_RESTART };

        sigemptyset(&a.sa_mask);
        sigaction(number[i], &a, &before[i]);
    }
}

void signals_restore(void)
{
    for (int i = 0; i < 3; i++)
        sigaction(number[i], &before[i], NULL);
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
