// A network of two machines on this one, that loses packets on command.
#pragma once

#include <string>
#include <vector>

namespace tessera::support {

/// A network namespace of the kernel's, joined to the test's own by a pair of virtual interfaces; nobody else
/// can reach either. Needs root and `ip`.
class NetworkNamespace {
 public:
  /// Throws std::runtime_error, with what `ip` said, when it cannot be made.
  NetworkNamespace();
  ~NetworkNamespace();
  NetworkNamespace(const NetworkNamespace&) = delete;
  NetworkNamespace& operator=(const NetworkNamespace&) = delete;

  /// The test's own address in this network.
  std::string outer_address() const { return network_ + ".1"; }
  /// A command that runs another one inside.
  std::vector<std::string> wrapper() const;

  /// Packets that go in, or come out, are lost from now on, or not any more. Both sides see a network that is
  /// up.
  void lose(bool going_in, bool coming_out);

 private:
  void remove() const;

  const std::string name_, outer_, inner_, network_;
};

}  // namespace tessera::support
