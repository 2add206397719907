// The things that `tessera doctor` looks at on this machine and at the coordinator.
#pragma once

#include <string>
#include <vector>

#include "command/interrupt.h"
#include "command/server_option.h"

namespace tessera::client {

enum class Health { kWell, kNote, kFault };

struct Finding {
  Health health;
  std::string subject;  // "certificates"
  std::string text;     // the state found
  std::string advice;   // recommended action; empty: none
};

/// This machine: kernels that its processor can run, memory, room on the disks of caches and data.
std::vector<Finding> examine_machine();

/// The certificates of a folder, whose dates are told; those that end within 30 days are a note.
std::vector<Finding> examine_certificates(const std::string& folder);

/// Who answers at the address; versions, the clocks' difference, workers.
std::vector<Finding> examine_farm(const ServerOption& server, std::stop_token stop);

}  // namespace tessera::client
