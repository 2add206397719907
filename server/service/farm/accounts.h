// Accounts of what everybody who was let in makes the coordinator hold, counted and bounded together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"

namespace tessera::server {

/// Amounts of memory, and of what takes memory.
struct Holding {
  std::uint64_t registrations = 0;  // registered workers
  std::uint64_t calls = 0;          // calls that wait for work, or for the disk
  std::uint64_t streams = 0;        // uploads, downloads and watches, each with a message of a MiB or so
  std::uint64_t bytes = 0;          // bytes of registrations, and of calls that wait
};

/// Whose account a caller's is: the name in its certificate, which the farm's authority vouches for, or,
/// where there are none, its address (as gRPC writes it) without the port. So machines behind one router
/// share one, and so do all programs of one machine.
std::string holder_of(const std::string& certificate, const std::string& peer);

/// Thread-safe.
class Accounts : public std::enable_shared_from_this<Accounts> {
 public:
  /// Enough for a farm whose workers share one certificate, or one address.
  static constexpr Holding kLimits{
      .registrations = 16'384, .calls = 32'768, .streams = 1'024, .bytes = std::uint64_t{512} << 20};

  static std::shared_ptr<Accounts> make(const Holding& limits = kLimits) {
    return std::shared_ptr<Accounts>{new Accounts{limits}};
  }

  /// Gives back what was taken when it goes away.
  class Hold {
   public:
    Hold(std::shared_ptr<Accounts> accounts, std::string holder, const Holding& amount);
    ~Hold();
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;

   private:
    const std::shared_ptr<Accounts> accounts_;
    const std::string holder_;
    const Holding amount_;
  };
  /// ResourceExhausted, with what there is too much of, where this would be more than one holder may have.
  absl::StatusOr<std::shared_ptr<const Hold>> take(const std::string& holder, const Holding& amount);

  Holding held_by(const std::string& holder) const;
  std::size_t holders() const;

 private:
  explicit Accounts(const Holding& limits) : limits_(limits) {}
  void give_back(const std::string& holder, const Holding& amount);

  const Holding limits_;
  mutable std::mutex mutex_;
  absl::flat_hash_map<std::string, Holding> held_;
};

}  // namespace tessera::server
