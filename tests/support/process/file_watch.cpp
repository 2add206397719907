#include "support/process/file_watch.h"

#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tessera::support {

FileWatch::FileWatch(const std::filesystem::path& path)
    : descriptor_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
  if (descriptor_ >= 0 && ::inotify_add_watch(descriptor_, path.c_str(), IN_MODIFY) >= 0) return;
  const std::system_error error{errno, std::generic_category(), "watch " + path.string()};
  if (descriptor_ >= 0) ::close(descriptor_);
  throw error;
}

FileWatch::~FileWatch() { ::close(descriptor_); }

bool FileWatch::wait(std::chrono::milliseconds patience) {
  char events[4096];
  pollfd ready{descriptor_, POLLIN, 0};
  if (::poll(&ready, 1, static_cast<int>(patience.count())) <= 0) return false;
  while (::read(descriptor_, events, sizeof(events)) > 0) {
  }
  return true;
}

}  // namespace tessera::support
