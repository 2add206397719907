#include "connections/connections.h"

#include <arpa/inet.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

#include "absl/strings/str_cat.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

// So many records are looked at before calls have their turn at the lock.
constexpr std::size_t kSweepStep = 256;
constexpr std::size_t kMostSilent = 8192, kMostSilentOfAddress = 4096;
constexpr std::size_t kOwnerBytes = 8;  // of an IPv6 address: its network

/// The socket that a descriptor is; nothing for one that is closed, or something else.
std::optional<ino_t> inode_of(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISSOCK(status.st_mode)) return std::nullopt;
  return status.st_ino;
}

double seconds(Connections::Clock::duration time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

// ---------------------------------------------------------------- peers

Peer Peer::of(const sockaddr_storage& socket_address) {
  Peer peer;
  if (socket_address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(socket_address);
    peer.address.s6_addr[10] = peer.address.s6_addr[11] = 0xff;
    std::memcpy(&peer.address.s6_addr[12], &v4.sin_addr, sizeof(v4.sin_addr));
    peer.port = ntohs(v4.sin_port);
  } else if (socket_address.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(socket_address);
    peer.address = v6.sin6_addr;
    peer.port = ntohs(v6.sin6_port);
  }
  return peer;
}

Peer Peer::of(std::string_view text) {
  const bool v4 = text.starts_with("ipv4:"), v6 = text.starts_with("ipv6:%5B");
  const std::size_t colon = text.rfind(':');
  if ((!v4 && !v6) || colon == std::string_view::npos) return {};
  const std::size_t begin = v4 ? 5 : 8;
  std::string host{text.substr(begin, colon - begin)};
  if (v6)
    host.resize(host.find('%') == std::string::npos ? host.size() : host.find('%'));  // "%5D", or a scope
  Peer peer;
  if (v4) peer.address.s6_addr[10] = peer.address.s6_addr[11] = 0xff;
  void* const bytes = v4 ? &peer.address.s6_addr[12] : peer.address.s6_addr;
  if (::inet_pton(v4 ? AF_INET : AF_INET6, host.c_str(), bytes) != 1) return {};
  const char* const end = text.data() + text.size();
  if (std::from_chars(text.data() + colon + 1, end, peer.port).ptr != end) return {};
  return peer;
}

Peer Peer::owner() const {
  Peer owner{.address = address, .port = 0};
  if (!IN6_IS_ADDR_V4MAPPED(&address)) std::memset(&owner.address.s6_addr[kOwnerBytes], 0, kOwnerBytes);
  return owner;
}

std::string Peer::to_string() const {
  char text[INET6_ADDRSTRLEN] = "?";
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    ::inet_ntop(AF_INET, &address.s6_addr[12], text, sizeof(text));
    return absl::StrCat(text, ":", port);
  }
  ::inet_ntop(AF_INET6, &address, text, sizeof(text));
  return absl::StrCat("[", text, "]:", port);
}

bool operator==(const Peer& a, const Peer& b) {
  return a.port == b.port && std::memcmp(&a.address, &b.address, sizeof(a.address)) == 0;
}

std::size_t Connections::Hash::operator()(const Peer& peer) const {
  const std::string_view bytes{reinterpret_cast<const char*>(&peer.address), sizeof(peer.address)};
  return std::hash<std::string_view>{}(bytes)*31 + peer.port;
}

// ---------------------------------------------------------------- limits

ConnectionLimits ConnectionLimits::within(std::size_t connections) {
  return {.all = connections,
          .of_address = connections - connections / 4,
          .silent = std::min(kMostSilent, connections / 2),
          .silent_of_address = std::min(kMostSilentOfAddress, connections / 4)};
}

bool Connections::admit(int descriptor, const Peer& peer, Port port, Clock::time_point now) {
  const std::optional<ino_t> inode = inode_of(descriptor);
  if (!inode) return false;
  const std::lock_guard lock(mutex_);
  const Peer owner = peer.owner();
  if (!make_room(owner, now)) {
    refuse(peer, open_ >= limits_.all ? "there are as many connections as the coordinator takes"
                                      : "too many connections from this address");
    return false;
  }
  const auto record = records_.insert(
      records_.end(),
      Record{.descriptor = descriptor, .inode = *inode, .peer = peer, .port = port, .since = now});
  ++owners_[owner].open;
  mark_silent(record);
  by_peer_.emplace(peer, record);
  open_ = records_.size();
  ++taken_;
  return true;
}

bool Connections::make_room(const Peer& owner, Clock::time_point now) {
  const auto count = [&] {
    const auto found = owners_.find(owner);
    return found == owners_.end() ? 0 : found->second.open;
  };
  // Perhaps gRPC has closed some since.
  if (records_.size() >= limits_.all || count() >= limits_.of_address) sweep_some(kSweepStep, now);
  if (records_.size() >= limits_.all) close_oldest(silent_, now);
  if (records_.size() >= limits_.all || count() >= limits_.of_address) return false;
  if (count() > 0) {
    const auto& silent = owners_.find(owner)->second.silent;
    if (silent.size() >= limits_.silent_of_address && !close_oldest(silent, now)) return false;
  }
  return silent_.size() < limits_.silent || close_oldest(silent_, now);
}

bool Connections::close_oldest(const std::list<Records::iterator>& silent, Clock::time_point now) {
  if (silent.empty()) return false;
  const Records::iterator oldest = silent.front();
  if (inode_of(oldest->descriptor) != oldest->inode) {
    forget(oldest);
    return true;
  }
  if (now - oldest->since < limits_.handshake) return false;
  close(*oldest);
  return true;
}

void Connections::close(Record& record) {
  unmark_silent(record);
  record.is_closed_here = true;
  ++closed_;
  // The number may be another descriptor's by now: a copy of it is what is looked at, and what is shut down.
  const int copy = ::dup(record.descriptor);
  if (copy < 0) return;
  if (inode_of(copy) == record.inode) ::shutdown(copy, SHUT_RDWR);
  ::close(copy);
}

void Connections::mark_silent(Records::iterator record) {
  record->is_silent = true;
  Owner& owner = owners_[record->peer.owner()];
  record->silent_of_owner = owner.silent.insert(owner.silent.end(), record);
  record->silent_place = silent_.insert(silent_.end(), record);
  silent_count_ = silent_.size();
}

void Connections::unmark_silent(Record& record) {
  if (!record.is_silent) return;
  record.is_silent = false;
  silent_.erase(record.silent_place);
  owners_.find(record.peer.owner())->second.silent.erase(record.silent_of_owner);
  silent_count_ = silent_.size();
}

void Connections::refuse(const Peer& peer, const char* why) {
  ++refused_;
  const auto [write, left_out] = refusals_.count();
  if (!write) return;
  const std::string from = peer.to_string();
  telemetry::log(spdlog::level::warn, {.peer = from},
                 "a connection of {} is refused: {}; {} are open ({} such lines left out before)", from, why,
                 records_.size(), left_out);
}

// ---------------------------------------------------------------- what becomes of them

void Connections::spoke(const Peer& peer) {
  const std::lock_guard lock(mutex_);
  const auto [first, last] = by_peer_.equal_range(peer);
  for (auto it = first; it != last; ++it) {
    if (it->second->port != Port::kStrangers) unmark_silent(*it->second);
  }
}

void Connections::fell_silent(const Peer& peer, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto [first, last] = by_peer_.equal_range(peer);
  for (auto it = first; it != last; ++it) {
    if (it->second->is_silent || it->second->is_closed_here) continue;
    it->second->since = now;
    mark_silent(it->second);
  }
}

void Connections::sweep(Clock::time_point now) {
  for (std::size_t left = open_; left > 0; left -= std::min(left, kSweepStep)) {
    const std::lock_guard lock(mutex_);
    sweep_some(kSweepStep, now);
  }
}

void Connections::sweep_some(std::size_t count, Clock::time_point now) {
  for (; count > 0 && !records_.empty(); --count) {
    if (next_to_sweep_ == records_.end()) next_to_sweep_ = records_.begin();
    const auto record = next_to_sweep_++;
    if (inode_of(record->descriptor) != record->inode) {
      forget(record);
    } else if (record->is_silent && now - record->since >= limits_.silence) {
      const auto [write, left_out] = endings_.count();
      const std::string from = record->peer.to_string();
      if (write) {
        telemetry::log(
            spdlog::level::warn, {.peer = from},
            "a connection of {} is closed: no call came in {:.0f} s ({} such lines left out before)", from,
            seconds(now - record->since), left_out);
      }
      close(*record);
    }
  }
}

void Connections::forget(Records::iterator record) {
  if (record->is_silent && record->port == Port::kMembers) {
    // gRPC has said what was wrong with its handshake, if it was that, but not whose it was.
    const auto [write, left_out] = endings_.count();
    const std::string from = record->peer.to_string();
    if (write) {
      telemetry::log(
          spdlog::level::info, {.peer = from},
          "a connection of {} ended before any call: a failed handshake, or no program of Tessera's ({} such "
          "lines left out before)",
          from, left_out);
    }
  }
  unmark_silent(*record);
  if (next_to_sweep_ == record) ++next_to_sweep_;
  const auto owner = owners_.find(record->peer.owner());
  if (--owner->second.open == 0) owners_.erase(owner);
  const auto [first, last] = by_peer_.equal_range(record->peer);
  by_peer_.erase(std::find_if(first, last, [&](const auto& entry) { return entry.second == record; }));
  records_.erase(record);
  open_ = records_.size();
}

}  // namespace tessera::server
