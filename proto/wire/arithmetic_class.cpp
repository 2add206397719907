#include "wire/arithmetic_class.h"

#include <cstdio>

namespace tessera::wire {

std::string arithmetic_class(std::string_view isa, std::string_view embree_version, std::uint32_t checksum) {
  char digits[9];
  std::snprintf(digits, sizeof(digits), "%08x", checksum);
  return std::string(isa) + "/embree-" + std::string(embree_version) + "/" + digits;
}

}  // namespace tessera::wire
