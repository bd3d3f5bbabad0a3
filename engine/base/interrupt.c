#define _POSIX_C_SOURCE 200809L // sigaction
#include "base/interrupt.h"

#include "base/file.h"
#include "base/result.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>

static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

static atomic_bool holding;
static atomic_int noted; // a signal

static void end_by(int number)
{
    ng_file_abandon();
    signal(number, SIG_DFL);
    raise(number); // at the handler's end, if this is one
}

static void on_signal(int number)
{
    int e = errno;
    if (atomic_exchange(&holding, false))
        atomic_store(&noted, number);
    else
        end_by(number);
    errno = e;
}

void ng_interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART}, old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < NG_COUNT(ending); i++)
        if (sigaction(ending[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(ending[i], &action, NULL);
    signal(SIGXFSZ, SIG_IGN);
}

void ng_interrupt_hold(void)
{
    atomic_store(&holding, true);
}

bool ng_interrupt_came(void)
{
    return atomic_load(&noted) != 0;
}

void ng_interrupt_release(void)
{
    atomic_store(&holding, false);
    if (ng_interrupt_came())
        end_by(atomic_load(&noted));
}
