#include "server/cli/interrupt.h"

#include <pthread.h>

#include <csignal>
#include <cstdlib>

namespace anyrate {
namespace {

constexpr int wake_signal = SIGUSR1;  // ends the waiter without a stop request

sigset_t awaited_signals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, wake_signal}) sigaddset(&signals, signal);
    return signals;
}

// Waits for signals instead of handling them: a handler may not take the locks of a stop source.
void wait_for_signals(std::stop_source stop) {
    const sigset_t signals = awaited_signals();
    int signal = 0;
    while (sigwait(&signals, &signal) == 0 && signal != wake_signal) {
        if (!stop.request_stop()) std::_Exit(1);
    }
}

}  // namespace

Interrupt::Interrupt() {
    const sigset_t signals = awaited_signals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    waiter_ = std::thread(wait_for_signals, stop_);
}

Interrupt::~Interrupt() {
    pthread_kill(waiter_.native_handle(), wake_signal);
    waiter_.join();
    const sigset_t signals = awaited_signals();
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

}  // namespace anyrate
