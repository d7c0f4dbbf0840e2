#include "app/stop_signals.hpp"

#include <csignal>
#include <initializer_list>

namespace moraine {
namespace {

volatile std::sig_atomic_t came = 0;

extern "C" void note_signal(int) {
    came = 1;
}

}  // namespace

void catch_stop_signals() {
    for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) std::signal(signal, note_signal);
}

bool stop_requested() {
    return came != 0;
}

}  // namespace moraine
