// One number for a course of events, to compare schedulers of two builds: equal seeds, equal numbers.
#pragma once

#include <cstdint>
#include <string_view>

#include "scheduler/scheduler_types.h"
#include "store/journal.h"

namespace tessera::server {

/// FNV-1a over what is added, in order.
class Trace {
 public:
  void add(std::uint64_t number);
  void add(std::string_view text);
  void add(const JournalEntry& entry);
  void add(const LeaseDecision& decision);
  void add(const HeartbeatDecision& decision);
  std::uint64_t digest() const { return digest_; }

 private:
  void add(const v1::LeaseToken& token);

  std::uint64_t digest_ = 0xcbf29ce484222325;
};

}  // namespace tessera::server
