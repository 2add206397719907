#include "support/process/network_namespace.h"

#include <unistd.h>

#include <chrono>
#include <stdexcept>

#include "support/process/process.h"

namespace tessera::support {
namespace {

// Address of no machine: frames for it are dropped where they arrive.
constexpr const char* kNobody = "02:00:00:00:00:01";

Finished ip(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"/usr/bin/env", "ip"});
  return run_program(std::move(arguments), std::chrono::seconds{20});
}

void must(std::vector<std::string> arguments) {
  if (const Finished done = ip(std::move(arguments)); done.status.code != 0) {
    throw std::runtime_error{"ip: " + done.err};
  }
}

/// The first three numbers of an address for benchmarks on closed networks (RFC 2544), by process.
std::string own_network() {
  const auto id = static_cast<unsigned>(getpid());
  return "198." + std::to_string(18 + (id >> 8 & 1)) + '.' + std::to_string(id & 255);
}

}  // namespace

NetworkNamespace::NetworkNamespace()
    : name_("tessera-" + std::to_string(getpid())),
      outer_("tsr" + std::to_string(getpid())),
      inner_(outer_ + "i"),
      network_(own_network()) {
  must({"netns", "add", name_});
  try {
    must({"link", "add", outer_, "type", "veth", "peer", "name", inner_, "netns", name_});
    must({"address", "add", network_ + ".1/24", "dev", outer_});
    must({"link", "set", outer_, "up"});
    must({"-n", name_, "address", "add", network_ + ".2/24", "dev", inner_});
    must({"-n", name_, "link", "set", inner_, "up"});
    must({"-n", name_, "link", "set", "lo", "up"});
  } catch (...) {
    remove();
    throw;
  }
}

NetworkNamespace::~NetworkNamespace() { remove(); }

// The interfaces go with the namespace.
void NetworkNamespace::remove() const { ip({"netns", "delete", name_}); }

std::vector<std::string> NetworkNamespace::wrapper() const {
  return {"/usr/bin/env", "ip", "netns", "exec", name_};
}

void NetworkNamespace::lose(bool going_in, bool coming_out) {
  const auto misdirect = [](std::vector<std::string> where, const std::string& to, const std::string& device,
                            bool lost) {
    where.insert(where.end(), {"neighbour", lost ? "replace" : "delete", to, "dev", device});
    if (!lost)
      return static_cast<void>(ip(where));  // there may be none; the next packet asks for the true one
    where.insert(where.end(), {"lladdr", kNobody, "nud", "permanent"});
    must(where);
  };
  misdirect({}, network_ + ".2", outer_, going_in);
  misdirect({"-n", name_}, network_ + ".1", inner_, coming_out);
}

}  // namespace tessera::support
