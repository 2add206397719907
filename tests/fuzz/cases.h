// Which targets a test program runs, and how long.
#pragma once

#include <vector>

#include "fuzz/target.h"

namespace tessera::fuzz {

struct Case {
  const Target* target;
  int mutations;  // together they take some seconds on one core
};

std::vector<Case> cases();

}  // namespace tessera::fuzz
