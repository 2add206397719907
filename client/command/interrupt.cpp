#include "command/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "command/exit_code.h"

namespace tessera::client {
namespace {

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

}  // namespace

Interrupt::Interrupt() {
  // Every thread inherits this; only the one below takes the signals.
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  thread_ = std::jthread{[this](std::stop_token done) { wait(done); }};
}

std::stop_token Interrupt::token() {
  in_charge_ = true;
  return stop_.get_token();
}

void Interrupt::wait(std::stop_token done) {
  const sigset_t signals = stop_signals();
  // Destroying the object wakes the thread with a signal of its own.
  std::stop_callback wake{done, [this] { pthread_kill(thread_.native_handle(), SIGTERM); }};
  while (true) {
    int signal = 0;
    sigwait(&signals, &signal);
    if (done.stop_requested()) return;
    if (!in_charge_ || at_once_ > 0 || stop_.stop_requested()) _exit(kInterrupted);
    stop_.request_stop();
  }
}

}  // namespace tessera::client
