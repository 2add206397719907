// How much memory a program may still take.
#pragma once

#include <cstdint>
#include <string>

namespace tessera::base {

/// Bytes that the system calls available, or fewer where a control group (version 2) of this process leaves
/// fewer; UINT64_MAX where nothing is known. Files of the system are looked for below `root`.
std::uint64_t available_memory(const std::string& root = "");

}  // namespace tessera::base
