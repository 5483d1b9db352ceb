#pragma once
#include <stop_token>
#include <thread>

namespace anyrate {

/// Turns the first Ctrl-C (SIGINT, or SIGTERM) into a stop request, and the second into the end of the process. At most
/// one at a time, made before the program starts any thread: every thread inherits the blocked signals.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    std::stop_token token() const { return stop_.get_token(); }

private:
    std::stop_source stop_;
    std::thread waiter_;
};

}  // namespace anyrate
