#include "net/probe.h"

#include <netdb.h>
#include <openssl/bio.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <string>

namespace tessera::net {
namespace {

using Clock = std::chrono::steady_clock;

/// A socket that is closed.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  const int descriptor_;
};

bool wait_for(int descriptor, short events, Clock::time_point end) {
  pollfd waiting{descriptor, events, 0};
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
  return left > 0 && ::poll(&waiting, 1, static_cast<int>(left)) == 1;
}

/// The first message of a TLS handshake.
std::string client_hello() {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context{SSL_CTX_new(TLS_client_method()),
                                                                  &SSL_CTX_free};
  const std::unique_ptr<SSL, decltype(&SSL_free)> tls{SSL_new(context.get()), &SSL_free};
  BIO* const in = BIO_new(BIO_s_mem());
  BIO* const out = BIO_new(BIO_s_mem());
  SSL_set_bio(tls.get(), in, out);  // it takes them over
  constexpr std::array<unsigned char, 3> kHttp2{2, 'h', '2'};
  SSL_set_alpn_protos(tls.get(), kHttp2.data(), kHttp2.size());
  SSL_set_connect_state(tls.get());
  SSL_do_handshake(tls.get());
  std::string hello(static_cast<std::size_t>(BIO_pending(out)), '\0');
  BIO_read(out, hello.data(), static_cast<int>(hello.size()));
  return hello;
}

Speaks ask(int descriptor, Clock::time_point end) {
  const std::string hello = client_hello();
  if (::send(descriptor, hello.data(), hello.size(), MSG_NOSIGNAL) < 0) return Speaks::kUnclear;
  unsigned char first = 0;
  if (!wait_for(descriptor, POLLIN, end) || ::recv(descriptor, &first, 1, 0) != 1) return Speaks::kUnclear;
  // The type of a TLS record, alert or handshake [RFC 8446, section 5.1]; or the length of the settings that
  // HTTP/2 begins with, of three bytes [RFC 9113, section 3.4].
  constexpr unsigned char kAlert = 21, kHandshake = 22;
  return first == kAlert || first == kHandshake ? Speaks::kTls
         : first == 0                           ? Speaks::kPlain
                                                : Speaks::kUnclear;
}

}  // namespace

Speaks probe(const base::HostPort& address, std::chrono::milliseconds patience) {
  const Clock::time_point end = Clock::now() + patience;
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &wanted, &found) != 0) {
    return Speaks::kNobody;
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses{found, &freeaddrinfo};
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const Socket socket{::socket(one->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
    if (socket.descriptor() < 0) continue;
    if (::connect(socket.descriptor(), one->ai_addr, one->ai_addrlen) != 0) {
      int error = errno;
      socklen_t size = sizeof error;
      if (error != EINPROGRESS || !wait_for(socket.descriptor(), POLLOUT, end) ||
          ::getsockopt(socket.descriptor(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0) {
        continue;
      }
    }
    return ask(socket.descriptor(), end);
  }
  return Speaks::kNobody;
}

}  // namespace tessera::net
