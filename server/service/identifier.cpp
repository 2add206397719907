#include "service/identifier.h"

#include <random>

namespace tessera::server {

std::string random_identifier(int digits) {
  std::random_device device;
  std::string text;
  for (int i = 0; i < digits; ++i) text.push_back("0123456789abcdef"[device() & 15]);
  return text;
}

}  // namespace tessera::server
