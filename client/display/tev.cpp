#include "display/tev.h"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "base/address.h"

namespace tessera::client {
namespace {

// Kinds of messages (tev's Ipc.h).
constexpr char kCreateImage = 4, kUpdateImageV2 = 5;

/// Little endian, as tev's machines are.
template <class T>
void append(T value, std::string& bytes) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.append(raw.data(), raw.size());
}

std::string begin(char kind, const std::string& name) {
  std::string message(sizeof(std::int32_t), '\0');
  message.push_back(kind);
  message.push_back(0);  // it does not take the focus
  message.append(name.c_str(), name.size() + 1);
  return message;
}

void append_channels(std::string& message) {
  append(std::int32_t{3}, message);
  for (const char* channel : {"R", "G", "B"}) message.append(channel, 2);
}

std::string finish(std::string message) {
  std::string length;
  append(static_cast<std::int32_t>(message.size()), length);
  return message.replace(0, length.size(), length);
}

}  // namespace

std::string tev_create_image(const std::string& name, std::int32_t width, std::int32_t height) {
  std::string message = begin(kCreateImage, name);
  append(width, message);
  append(height, message);
  append_channels(message);
  return finish(std::move(message));
}

std::string tev_update_image(const std::string& name, const Window& part, const std::vector<float>& planes) {
  std::string message = begin(kUpdateImageV2, name);
  append_channels(message);
  for (const std::int32_t number : {part.x0, part.y0, part.width(), part.height()}) append(number, message);
  for (const float value : planes) append(value, message);
  return finish(std::move(message));
}

absl::StatusOr<Tev> Tev::connect(const std::string& address) {
  const absl::StatusOr<base::HostPort> parsed = base::parse_host_port(address);
  if (!parsed.ok()) return parsed.status();
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(parsed->port);
  if (const int error = ::getaddrinfo(parsed->host.c_str(), port.c_str(), &hints, &found); error != 0)
    return absl::UnavailableError(absl::StrCat("tev at ", address, ": ", ::gai_strerror(error)));
  int error = EADDRNOTAVAIL, connected = -1;
  for (const addrinfo* at = found; at != nullptr && connected < 0; at = at->ai_next) {
    connected = ::socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, at->ai_protocol);
    if (connected < 0 || ::connect(connected, at->ai_addr, at->ai_addrlen) == 0) continue;
    error = errno;
    ::close(std::exchange(connected, -1));
  }
  ::freeaddrinfo(found);
  if (connected >= 0) {
    // A viewer that hangs does not hold up rendering for longer.
    const timeval patience{.tv_sec = 5, .tv_usec = 0};
    ::setsockopt(connected, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
    return Tev{connected};
  }
  return absl::UnavailableError(absl::StrCat("tev does not listen at ", address, ": ", std::strerror(error)));
}

Tev::~Tev() {
  if (socket_ >= 0) ::close(socket_);
}

absl::Status Tev::send(const std::string& message) {
  std::size_t sent = 0;
  while (sent < message.size()) {
    const ssize_t count = ::send(socket_, message.data() + sent, message.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return absl::UnavailableError(absl::StrCat("tev is gone: ", std::strerror(errno)));
    sent += static_cast<std::size_t>(count);
  }
  return absl::OkStatus();
}

absl::StatusOr<TevPicture> TevPicture::open(const std::string& address, std::string name,
                                            const Window& crop) {
  absl::StatusOr<Tev> tev = Tev::connect(address);
  if (!tev.ok()) return tev.status();
  if (absl::Status s = tev->send(tev_create_image(name, crop.width(), crop.height())); !s.ok()) return s;
  return TevPicture{*std::move(tev), std::move(name), crop};
}

absl::Status TevPicture::add(const wire::TileResult& result) {
  const absl::StatusOr<Window> part = image_.add(result);
  if (!part.ok()) return part.status();
  std::vector<float> planes;
  planes.reserve(3 * static_cast<std::size_t>(part->width()) * static_cast<std::size_t>(part->height()));
  for (std::size_t band = 0; band < 3; ++band) {
    for (std::int32_t y = part->y0; y < part->y1; ++y) {
      for (std::int32_t x = part->x0; x < part->x1; ++x)
        planes.push_back(image_.color(x, y).value_or(std::array<float, 3>{})[band]);
    }
  }
  return tev_.send(tev_update_image(name_, *part, planes));
}

}  // namespace tessera::client
